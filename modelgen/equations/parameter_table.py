"""The driveline's parameters: shared, the elements' own, and derived ones, with units, values and lawful limits.

Part of the grammar, first step from a driveline to its equations (``modelgen.equations.assembly``). A template speaks of
"stiffness"; the table gives every element the driveline's symbol that this is, such as "shaft.stiffness" or a shared "k".
"""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from typing import Any

import numpy as np
import sympy

from modelgen.equations.dimensions import DimensionCheck
from modelgen.equations.records import DerivedParameter, Parameter
from modelgen.errors import ModelError, UnitError
from modelgen.model import Derived, Driveline, Element, NamedParameter, Orders, Param, Shared
from modelgen.model.expressions import read_expression
from modelgen.model.values import check_value
from modelgen.units import dimension_of

SPEED = "speed"
SPEEDS = "speeds"
"""The operating speed of the reference shaft, and the head of the names of further mean speeds, such as ``speeds.ring``."""
Symbols = dict[sympy.Symbol, sympy.Symbol]


def with_lengths(line: Driveline, element: Element) -> Element:
    """A copy that knows the lengths of series given by the driveline's parameters, so that its law can be written out."""
    element = copy.copy(element)
    element.lengths = dict(element.lengths)
    for key, value in element.values.items():
        named = line.parameter_of(element, key)
        if named is None:
            continue
        param = element.declared(Param)[key]
        series = isinstance(named.value, tuple)
        assert isinstance(value, Shared)
        if series != param.series:
            shape = ("a series", "one number") if series else ("one number", "a series")
            raise ModelError(f"{element.where}, {key}", f"parameter {value.name!r} is {shape[0]}", f"{shape[1]} is asked for")
        if isinstance(named.value, tuple):
            element.lengths[key] = len(named.value)
    return element


class ParameterTable:
    """All parameters by name, in order: operating speed, those of the driveline, then those that elements add."""

    def __init__(self, line: Driveline) -> None:
        self.by_name: dict[str, Parameter] = {}
        self.derived: list[DerivedParameter] = []
        if line.speed is not None:
            symbol = sympy.Symbol(SPEED, positive=True)
            self._add(Parameter(SPEED, "rad/s", (symbol,), (line.speed,), positive=True))
        self.speeds: dict[str, sympy.Symbol] = {}
        for name, value in line.speeds.items():
            self.speeds[name] = sympy.Symbol(f"{SPEEDS}.{name}", real=True)
            self._add(Parameter(f"{SPEEDS}.{name}", "rad/s", (self.speeds[name],), (value,)))
        for name, named in line.parameters.items():
            values, series = _row(named.value)
            self._add(Parameter(name, named.unit, _symbols(name, len(values), series), values, series, note=named.note))
        self._evaluate({name: named for name, named in line.parameters.items() if named.expression is not None})

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(self.by_name.values())

    @property
    def values(self) -> dict[sympy.Symbol, float]:
        """SI value of every symbol that is not derived."""
        return {s: value for each in self.parameters for s, value in zip(each.symbols, each.values, strict=True)}

    def derived_values(self) -> dict[sympy.Symbol, float]:
        """SI value of every derived parameter at the values at hand."""
        known = {name: np.array(each.values) if each.series else each.values[0] for name, each in self.by_name.items()}
        found: dict[sympy.Symbol, float] = {}
        for each in self.derived:
            arguments = {key: known[of] if isinstance(of, str) else of for key, of in each.arguments.items()}
            found.update(zip(each.symbols, np.asarray(each.function(**arguments), dtype=float).ravel().tolist(), strict=True))
        return found

    @property
    def speed(self) -> sympy.Symbol | None:
        """Symbol of the operating speed."""
        return self.by_name[SPEED].symbols[0] if SPEED in self.by_name else None

    def _add(self, parameter: Parameter) -> None:
        self.by_name[parameter.name] = parameter

    def _evaluate(self, written: dict[str, NamedParameter]) -> None:
        """Reads the parameters given as expressions of others, which are plain numbers."""
        scalars = {each.name: each.symbols[0] for each in self.parameters if not each.series}
        units = {each.symbols[0]: dimension_of(each.unit) for each in self.parameters if not each.series}
        dependent = {self.by_name[name].symbols[0] for name in written}
        for name, named in written.items():
            where, parameter = f"parameter {name!r}", self.by_name[name]
            expression = read_expression(str(named.expression), scalars, where)
            circular = dependent & expression.free_symbols
            if circular:
                what = f"its expression uses {next(iter(circular))}, which is an expression too"
                raise ModelError(where, what, "use plain parameters in it")
            found, unit = DimensionCheck(units, where).of(expression, "its expression"), parameter.unit
            value = self._number(expression, where)
            if found is not None and found != dimension_of(unit):
                if unit != "1":
                    what = f"its expression has the dimension {found}"
                    raise UnitError(where, what, f"its unit is {unit} [{dimension_of(unit)}]")
                unit = str(found)
            self._add(Parameter(name, unit, parameter.symbols, (value,), expression=expression, note=parameter.note))

    def _number(self, expression: sympy.Expr, where: str) -> float:
        known = self.values
        try:
            value = float(expression.xreplace({s: sympy.Float(known[s]) for s in expression.free_symbols}))
        except (TypeError, ValueError, ArithmeticError):
            value = math.nan
        if not math.isfinite(value):
            raise ModelError(where, "its expression has no finite real value", "check the parameters it uses")
        return value

    def add_element(self, element: Element) -> Symbols:
        """Adds the element's own and derived parameters; returns template symbol -> driveline symbol."""
        table: Symbols = {}
        names: dict[str, str] = {}
        for key, value in element.values.items():
            param = element.declared(Param)[key]
            parameter = self._shared(element, key, value) if isinstance(value, Shared) else self._own(element, key, value)
            local = param.symbols(element.lengths.get(key) if param.series else None)
            table.update(zip(local, parameter.symbols, strict=True))
            names[key] = parameter.name
        for key, derived in element.declared(Derived).items():
            if derived.exists(element.choices):
                table.update(self._derived(element, key, derived, names))
        return table

    def _shared(self, element: Element, key: str, value: Shared) -> Parameter:
        """A shared parameter, which must stay lawful for every element that uses it."""
        param, shared, where = element.declared(Param)[key], self.by_name[value.name], f"{element.where}, {key}"
        in_hertz = ("Hz" in shared.unit) != ("Hz" in param.unit)  # their numbers differ by 2 pi
        if dimension_of(shared.unit) != dimension_of(param.unit) or in_hertz:
            raise UnitError(where, f"parameter {value.name!r} is in {shared.unit}", f"{param.unit} is asked for")
        for entry in shared.values:
            check_value(entry, param, f"{where}, parameter {value.name!r}")
        self._add(replace(shared, **_tighter(shared, param)))
        return shared

    def _own(self, element: Element, key: str, value: float | tuple[float, ...]) -> Parameter:
        param, name = element.declared(Param)[key], f"{element.name}.{key}"
        values, _ = _row(value)
        symbols = _symbols(name, len(values), param.series, integer=param.integer or None, positive=param.positive or None)
        self._add(Parameter(name, param.unit, symbols, values, param.series, **_limits(param)))
        return self.by_name[name]

    def _derived(self, element: Element, key: str, derived: Derived, names: dict[str, str]) -> Symbols:
        """Adds a derived parameter of an element whose parameters have these names in the driveline."""
        local, name = derived.symbols(element), f"{element.name}.{key}"
        symbols = _symbols(name, len(local), series=True)
        missing = [of for of in derived.of if of not in names and of not in element.declared(Orders)]
        if missing:
            what = f"{key} follows from {missing[0]}, which its switches leave out"
            raise ModelError(element.where, what, "change the switches")
        arguments = {of: names[of] if of in names else getattr(element, of) for of in derived.of}
        self.derived.append(DerivedParameter(name, derived.unit, symbols, derived.function, arguments))
        return dict(zip(local, symbols, strict=True))


def _row(value: float | tuple[float, ...]) -> tuple[tuple[float, ...], bool]:
    """Values as a row, and whether they are a series."""
    return (value, True) if isinstance(value, tuple) else ((value,), False)


def _limits(param: Param) -> dict[str, Any]:
    return {key: getattr(param, key) for key in ("positive", "nonnegative", "integer", "least", "largest")}


def _tighter(shared: Parameter, param: Param) -> dict[str, Any]:
    """The limits of a shared parameter and of one that refers to it, both kept."""
    bounds = {"least": max, "largest": min}
    limits = {key: getattr(shared, key) or limit for key, limit in _limits(param).items() if key not in bounds}
    for key, choose in bounds.items():
        given = [limit for limit in (getattr(shared, key), getattr(param, key)) if limit is not None]
        limits[key] = choose(given) if given else None
    return limits


def _symbols(name: str, count: int, series: bool, **assumptions: Any) -> tuple[sympy.Symbol, ...]:
    rows = [f"{name}[{row}]" for row in range(1, count + 1)] if series else [name]
    return tuple(sympy.Symbol(row, real=True, **assumptions) for row in rows)
