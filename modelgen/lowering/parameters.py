"""Parameters by name: one flat vector inside, names, units and limits outside.

Part of the compiler. A parameter is changed by its name (``zeta``, ``coupling.stiffness``, ``firing.cosine[3]``), never by an
index; a change never compiles anything. Expressions and derived parameters follow the ones they depend on.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import sympy

from modelgen.equations.conditions import Exact
from modelgen.equations.records import DerivedParameter, Equations, Parameter
from modelgen.errors import CaseError, ModelError, NamingError, nearest
from modelgen.lowering.visitor import Visitor
from modelgen.units import read_quantity

Values = Mapping[str, Any]
_ROW = re.compile(r"(.+)\[(\d+)\]")
MODAL = "modal.damping"


class ParameterTable:
    """Where each parameter stands in the vector p, and how a vector is made from values by name."""

    def __init__(self, equations: Equations) -> None:
        self.parameters = {parameter.name: parameter for parameter in equations.parameters}
        self.derived = {each.name: each for each in equations.derived}
        self.slices: dict[str, slice] = {}
        self.symbols: list[sympy.Symbol] = []
        entries: list[Parameter | DerivedParameter] = [*equations.parameters, *equations.derived]
        for each in entries:
            self.slices[each.name] = slice(len(self.symbols), len(self.symbols) + len(each.symbols))
            self.symbols += each.symbols
        modal = len(equations.groups) ** 2 if equations.modal_ratio else 0
        self.slices[MODAL] = slice(len(self.symbols), len(self.symbols) + modal)
        self.size = len(self.symbols) + modal
        self.vector_symbol = ca.SX.sym("p", self.size)
        self.table = {symbol: self.vector_symbol[index] for index, symbol in enumerate(self.symbols)}
        self._expressions = self._compile_expressions()
        self._last: dict[str, tuple[Any, np.ndarray]] = {}
        self.conditions = equations.conditions
        deciding = set().union(*(condition.symbols for condition in self.conditions))
        self._deciding = [row for row, symbol in enumerate(self.symbols) if symbol in deciding]
        self._kept: set[bytes] = set()
        self.given: Mapping[str, Any] = {}
        self.balance: Callable[[np.ndarray, Collection[str]], None] | None = None

    def with_values(self, values: Values) -> ParameterTable:
        """The table with other values of its own; ``given`` holds them. Raises what ``vector`` raises for a name or a value."""
        table = copy.copy(self)
        table.given = {**self.given, **values}
        p = np.zeros(self.size)
        for name, parameter in self.parameters.items():
            p[self.slices[name]] = parameter.values
        for name, value in values.items():
            self._put(p, name, value)
        named = {self.place(name)[0].name for name in values}
        table.parameters = {
            name: replace(each, values=tuple(p[self.slices[name]].tolist())) if name in named else each
            for name, each in self.parameters.items()
        }
        return table

    def _compile_expressions(self) -> dict[str, ca.Function]:
        visitor = Visitor(self.table, "parameters")
        found = {}
        for name, parameter in self.parameters.items():
            if parameter.expression is not None:
                found[name] = ca.Function("expression", [self.vector_symbol], [visitor(parameter.expression)])
        return found

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters that can be set."""
        return tuple(self.parameters)

    def labels(self) -> list[str]:
        """A name for every entry of p."""
        names = []
        for name, where in self.slices.items():
            count = where.stop - where.start
            series = name == MODAL or name in self.derived or self.parameters[name].series
            names += [f"{name}[{row}]" for row in range(1, count + 1)] if series else [name]
        return names

    def vector(self, values: Values | None = None) -> np.ndarray:
        """The vector p for the model's own values with some changed by name; SI numbers or texts with units.

        Loads that ``Driveline.balance`` names stand in it scaled, but for those whose scale is among the values. Raises
        NamingError for an unknown name, ModelError or UnitError for an unlawful value, BalanceError where the loads cannot
        balance the mean torques.
        """
        p = self.unbalanced(values)
        if self.balance is not None:
            self.balance(p, {*self.given, *(values or ())})
        return p

    def unbalanced(self, values: Values | None = None) -> np.ndarray:
        """The vector p with the loads as they were given; raises what ``vector`` raises, but no BalanceError."""
        p = np.zeros(self.size)
        for name, parameter in self.parameters.items():
            p[self.slices[name]] = parameter.values
        changed = {**self.given, **(values or {})}
        for name, value in changed.items():
            self._put(p, name, value)
        for name, function in self._expressions.items():
            if name not in changed:
                self._put(p, name, float(function(p)))
        for name, derived in self.derived.items():
            arguments = {key: self._argument(p, source) for key, source in derived.arguments.items()}
            result = self._derive(derived, arguments)
            if result.shape != (len(derived.symbols),) or not np.all(np.isfinite(result)):
                raise ModelError(f"derived parameter {name!r}", f"came out as {result[:4]}", "check the parameters it depends on")
            p[self.slices[name]] = result
        self._check_conditions(p)
        return p

    def _check_conditions(self, p: np.ndarray) -> None:
        """Raises ModelError for values at which the coordinates, chosen when the driveline was assembled, are wrong."""
        deciding = p[self._deciding].tobytes()
        if deciding not in self._kept:
            exact = Exact({self.symbols[row]: float(p[row]) for row in self._deciding})
            for condition in self.conditions:
                condition.check(exact)
            self._kept = {deciding}

    def _derive(self, derived: DerivedParameter, arguments: dict[str, Any]) -> np.ndarray:
        """The value of a derived parameter; that for the arguments of the last time is remembered, as in a sweep of others."""
        given = tuple(value.tobytes() if isinstance(value, np.ndarray) else value for value in arguments.values())
        known, result = self._last.get(derived.name, (None, np.empty(0)))
        if known != given:
            try:
                result = np.asarray(derived.function(**arguments), dtype=float).ravel()
            except ModelError as error:
                element = derived.name.rpartition(".")[0]
                raise ModelError(f"element {element!r}, {error.where}", error.problem, error.remedy) from None
            self._last[derived.name] = given, result
        return result

    def _argument(self, p: np.ndarray, source: str | tuple[int, ...] | float) -> Any:
        if not isinstance(source, str):
            return source
        values = p[self.slices[source]]
        return values.copy() if self.parameters[source].series else float(values[0])

    def place(self, name: str) -> tuple[Parameter, slice]:
        """The parameter that a name means, such as ``zeta`` or the row ``mesh.stiffness_cosine[1]``, and its entries of p.

        Raises NamingError with the nearest name.
        """
        row = _ROW.fullmatch(name)
        base = row[1] if row else name
        if base not in self.parameters:
            if base in self.derived:
                sources = [source for source in self.derived[base].arguments.values() if isinstance(source, str)]
                raise NamingError(f"parameter {base!r}", "is derived from others", f"set {' or '.join(sources)}")
            raise NamingError(f"parameter {name!r}", "is not known", nearest(base, self.parameters))
        parameter, where = self.parameters[base], self.slices[base]
        if row:
            index = int(row[2]) - 1
            if not parameter.series or not 0 <= index < len(parameter.symbols):
                raise NamingError(f"parameter {name!r}", f"has no such row; it has {len(parameter.symbols)}", "rows count from 1")
            where = slice(where.start + index, where.start + index + 1)
        return parameter, where

    def unit_of_number(self, name: str, asked: str) -> str:
        """The unit of a single number, a parameter or a row of a series. Raises NamingError, CaseError for a whole series."""
        parameter, where = self.place(name)
        if parameter.series and not _ROW.fullmatch(name):
            what = f"is a series of {where.stop - where.start} numbers"
            raise CaseError(f"{asked} {name!r}", what, f"sweep a row of it, such as {name}[1]")
        return parameter.unit

    def _put(self, p: np.ndarray, name: str, value: Any) -> None:
        parameter, where = self.place(name)
        p[where] = self._read(parameter, name, value, where.stop - where.start)

    def _read(self, parameter: Parameter, name: str, value: Any, count: int) -> np.ndarray:
        where = f"parameter {name!r}"
        if isinstance(value, str):
            value = read_quantity(value, parameter.unit, where)
        unit = "" if parameter.unit == "1" else f" in {parameter.unit}"
        if isinstance(value, (bool, np.bool_)):
            raise CaseError(where, f"{value!r} is not a number", f"give a number{unit}")
        try:
            numbers = np.asarray(value, dtype=float)
        except (TypeError, ValueError, OverflowError):
            raise CaseError(where, f"{value!r:.60} is not a number", f"give a number{unit}") from None
        if numbers.shape not in ((count,), () if count == 1 else (count,)):
            raise CaseError(where, f"got {numbers.size} values", f"it has {count}")
        numbers = numbers.ravel()
        if not np.all(np.isfinite(numbers)):
            raise CaseError(where, f"{value!r:.60} is not finite", f"give finite numbers{unit}")
        for limit, wrong, advice in (
            (parameter.positive, np.any(numbers <= 0), "give a positive value"),
            (parameter.nonnegative, np.any(numbers < 0), "give zero or a positive value"),
            (parameter.integer, np.any(numbers != np.floor(numbers)), "give a whole number"),
            (parameter.least is not None, np.any(numbers < (parameter.least or 0)), f"give {parameter.least} or more"),
            (parameter.largest is not None, np.any(numbers > (parameter.largest or 0)), f"give {parameter.largest} or less"),
        ):
            if limit and wrong:
                raise ModelError(where, f"is {value!r:.60}{unit.replace(' in', '')}", advice)
        return numbers

    def value(self, p: np.ndarray, name: str) -> float:
        """The value of one parameter, or of a row or the first row of a series, in a vector p. Raises NamingError."""
        where = self.slices.get(name) or self.place(name)[1]
        return float(p[where][0])
