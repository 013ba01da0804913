"""The side door: plain ordinary differential equations as the same record that drivelines give.

Part of the grammar. Solvers and analyses are tested on equations whose answers are known (van der Pol, Lorenz, HIRES, the
dimensionless gear pair), and those are no drivelines. ``system`` makes one template of own states of them, without nodes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NoReturn, TypeAlias

import sympy
from sympy.core.function import AppliedUndef

from modelgen.equations.discrete_modes import WrittenModes, case_by_case
from modelgen.equations.plain_modes import PlainSymbols, declared_modes, read_plain_modes
from modelgen.equations.records import Definition, Equations, Instance, Output, Parameter, StateVariable, Template
from modelgen.errors import ModelError, NamingError, UnitError, nearest
from modelgen.model import Guard, Modes
from modelgen.model.declarations import TIME
from modelgen.model.expressions import read_expression
from modelgen.model.names import identifier, model_name
from modelgen.units import dimension_of, finite, read_any, read_quantity

Name: TypeAlias = "str | sympy.Symbol"
KIND = "system"


def system(
    states: Mapping[Name, Any],
    rates: Mapping[Name, Any],
    parameters: Mapping[Name, Any] | None = None,
    outputs: Mapping[Name, Any] | None = None,
    name: str = "system",
    *,
    units: Mapping[Name, str] | None = None,
    scales: Mapping[Name, float] | None = None,
    modes: Mapping[Name, Modes | Sequence[str]] | None = None,
    regions: Mapping[Name, Any] | None = None,
    guards: Sequence[Guard] = (),
    description: str = "",
) -> Equations:
    """Equations of x' = f(t, x, p), with plain names.

    ``states`` gives each state's start, ``rates`` its time derivative, ``parameters`` their values, ``outputs`` further channels
    (every state is one). Things are named by SymPy symbols or by text; in expressions a symbol counts by its name, and ``t`` is
    time. Rates and outputs are SymPy expressions, numbers, or texts as in model files. Numbers are SI; a text such as ``"2 mm"``
    brings its unit. ``units`` (SI, "1" unless given) are labels: rates are not checked for their dimensions, so that
    dimensionless equations need none. ``scales`` are the sizes that tolerances refer to, else they are worked out per case. A
    parameter whose symbol is declared positive, nonnegative or an integer stays so.

    ``modes`` name discrete modes, as in ``{"phase": ("rest", "slip")}``; in expressions ``phase.slip`` is 1 where that mode holds
    and 0 elsewhere. ``regions`` say where one holds, ``{"phase.slip": "x - 1"}`` where x >= 1, or ``guards`` what leads from one
    to another. A guard without modes may reset states, end the run, or only be noted.

    Raises NamingError, UnitError or ModelError for what cannot be a system.

    >>> from modelgen import lower
    >>> x, v, mu = sympy.symbols("x v mu")
    >>> van_der_pol = system({x: 2.0, v: 0.0}, {x: v, v: mu * (1 - x**2) * v - x}, {mu: 5.0}, name="van_der_pol")
    >>> model = lower(van_der_pol)
    >>> model.rhs(0.0, [2.0, 1.0], model.parameters.vector()).tolist()
    [1.0, -17.0]
    >>> bounce = Guard("bounce", "h", direction=-1, reset={"v": "-0.9*v"})
    >>> ball = lower(system({"h": 1.0, "v": 0.0}, {"h": "v", "v": -9.81}, guards=[bounce], name="ball"))
    >>> ball.switching.resets(0.0, [0.0, -2.0], []).full().ravel().tolist()
    [0.0, 1.8]
    """
    whole = _System(name, states, rates, parameters or {}, outputs or {}, units or {}, scales or {}, modes or {})
    return whole.equations(description, {} if regions is None else regions, guards)


class _System:
    def __init__(
        self, name: str, states: Any, rates: Any, parameters: Any, outputs: Any, units: Any, scales: Any, modes: Any
    ) -> None:
        self.name, self.where = model_name(name, KIND), f"system {name!r}"
        self.states = self._named(states, "state")
        self.rates = self._named(rates, "rate")
        self.given = self._named(parameters, "parameter")
        self.formulas = self._named(outputs, "output")
        self.units = self._named(units, "unit")
        self.scales = self._named(scales, "scale")
        self.modes = declared_modes(modes, self.where)
        self._check_names()
        symbols = [key for table in (states, rates, parameters) for key in table if isinstance(key, sympy.Symbol)]
        written = [each for each in (*self.rates.values(), *self.formulas.values()) if isinstance(each, sympy.Basic)]
        self.met = [*symbols, *(symbol for each in written for symbol in each.free_symbols)]
        self.symbols = {name: sympy.Symbol(name, real=True) for name in (*self.states, *self.given)}
        self.flags = {flag.name: flag for declared in self.modes.values() for flag in declared.symbols}

    def _refuse(self, problem: str, remedy: str) -> NoReturn:
        raise ModelError(self.where, problem, remedy)

    def _named(self, table: Any, kind: str) -> dict[str, Any]:
        """The table with texts as keys."""
        if not isinstance(table, Mapping):
            self._refuse(f"its {kind}s are {type(table).__name__}", f"give a mapping from names to {kind}s")
        found: dict[str, Any] = {}
        for key, value in table.items():
            name = identifier(key.name if isinstance(key, sympy.Symbol) else key, self.where, kind)
            if name in found:
                raise NamingError(self.where, f"{kind} {name!r} is given twice", "give it once, by its symbol or by its name")
            found[name] = value
        return found

    def _check_names(self) -> None:
        if not self.states:
            self._refuse("has no states", "give at least one state with its start")
        taken: dict[str, str] = {TIME.name: "time", "time": "time"}
        for kind, table in (("state", self.states), ("parameter", self.given), ("output", self.formulas), ("mode", self.modes)):
            for name in table:
                if name in taken:
                    what = "stands for time" if taken[name] == "time" else f"is a {taken[name]} already"
                    raise NamingError(self.where, f"{kind} {name!r} {what}", "rename it")
                taken[name] = kind
        for name in self.states:
            if name not in self.rates:
                self._refuse(f"state {name!r} has no rate", f"give rates[{name!r}], its time derivative")
        everything = [*self.states, *self.given, *self.formulas]
        for kind, table, known in (
            ("rate", self.rates, list(self.states)),
            ("unit", self.units, everything),
            ("scale", self.scales, list(self.states)),
        ):
            for name in table:
                if name not in known:
                    raise NamingError(self.where, f"{kind} of {name!r}, which is not known", nearest(name, known))

    # -- numbers and expressions ---------------------------------------------------------------------------------------------

    def _number(self, name: str, value: Any, what: str) -> tuple[float, str]:
        """SI value and unit."""
        where, unit = f"{self.where}, {what} {name!r}", self.units.get(name)
        if unit is not None and not isinstance(unit, str):
            raise UnitError(where, f"its unit is {unit!r}", 'give an SI unit text such as "rad/s"')
        if unit is not None:
            dimension_of(unit)
        if isinstance(value, str):
            return read_any(value, where) if unit is None else (read_quantity(value, unit, where), unit)
        if isinstance(value, bool) or not hasattr(value, "__float__"):
            raise UnitError(where, f"{value!r} is not a number", "give a number or a text with a unit")
        try:
            return finite(float(value), where), unit or "1"
        except TypeError:
            raise UnitError(where, f"{value!r} is not a number", "give a number or a text with a unit") from None

    def _expression(self, value: Any, what: str) -> sympy.Expr:
        known = {**self.symbols, **self.flags, TIME.name: TIME}
        where = f"{self.where}, {what}"
        if isinstance(value, str):
            return read_expression(value, known, where)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return sympy.Float(finite(value, where)) if isinstance(value, float) else sympy.Integer(value)
        if not isinstance(value, sympy.Expr):
            raise ModelError(where, f"is {value!r}", 'give a SymPy expression, a number, or a text such as "-k*x/m"')
        functions = sorted(str(each) for each in value.atoms(AppliedUndef, sympy.Derivative))
        if functions:
            raise ModelError(where, f"uses {functions[0]}", "write states as symbols, and their time derivatives in rates")
        unknown = sorted(symbol.name for symbol in value.free_symbols if symbol.name not in known)
        if unknown:
            raise NamingError(where, f"uses {unknown[0]!r}, which is no state or parameter", nearest(unknown[0], known))
        return value.xreplace({symbol: known[symbol.name] for symbol in value.free_symbols})

    def _limits(self, name: str, value: float) -> list[bool]:
        """Whether the symbol of a parameter is declared positive, nonnegative, an integer; the value must agree."""
        found = []
        for limit, kept in (("positive", value > 0), ("nonnegative", value >= 0), ("integer", value == int(value))):
            declared = any(symbol.name == name and getattr(symbol, f"is_{limit}") for symbol in self.met)
            if declared and not kept:
                problem = f"parameter {name!r} is {value:g}, but its symbol is declared {limit}"
                self._refuse(problem, "change the value or the symbol")
            found.append(declared)
        return found

    # -- the record ------------------------------------------------------------------------------------------------------------

    def equations(self, description: str, regions: Any, guards: Any) -> Equations:
        parameters, variables, outputs, definitions = [], [], [], []
        for key, value in self.given.items():
            number, unit = self._number(key, value, "parameter")
            positive, nonnegative, integer = self._limits(key, number)
            symbol = (self.symbols[key],)
            parameters.append(
                Parameter(key, unit, symbol, (number,), positive=positive, nonnegative=nonnegative, integer=integer)
            )
        for key, value in self.states.items():
            start, unit = self._number(key, value, "start of state")
            variables.append(StateVariable(key, unit, "own", start=start, scale=self._scale(key)))
        rates = {self.symbols[key]: self._expression(self.rates[key], f"rate of {key!r}") for key in self.states}
        for variable in variables:
            # A channel of its own beside the state: the two have one name, so the symbols must differ.
            symbol = sympy.Dummy(variable.name, real=True)
            definitions.append(Definition(variable.name, symbol, self.symbols[variable.name], variable.unit, "state"))
        for key, value in self.formulas.items():
            unit = self.units.get(key, "1")
            dimension_of(unit)
            symbol = sympy.Symbol(key, real=True)
            definitions.append(Definition(key, symbol, self._expression(value, f"output {key!r}"), unit, "state"))
        outputs = [Output(each.name, each.unit) for each in definitions] + [Output(name, "1") for name in self.modes]
        own, constants = ({key: self.symbols[key] for key in table} for table in (self.states, self.given))
        speaker = PlainSymbols(self.where, self.modes, own, constants.values(), self._expression, regions, guards)
        template = self._template(parameters, variables, rates, definitions, read_plain_modes(speaker))
        instance = Instance("", 0, {s: s for s in self.symbols.values()}, {}, {}, (), tuple(range(len(variables))))
        return Equations(
            name=self.name, description=description, templates=(template,), instances=(instance,), parameters=tuple(parameters),
            derived=(), nodes=(), groups=(), grounded=(), ratios=(), mean_speeds=(), by_speed=(), forms=(), steps=(),
            rotations=(), clocks=(),
            states=tuple(variables), outputs=tuple(outputs), rigid=(), reference=None, speed=None, modal_ratio=None,
            balanced=(), drifts=False, modes={m.name: m.values for m in template.modes},
            guards=tuple(("", guard) for guard in template.guards), assemblies={},
        )  # fmt: skip

    def _scale(self, name: str) -> float | None:
        if name not in self.scales:
            return None
        value = self.scales[name]
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < float("inf"):
            self._refuse(f"the scale of {name!r} is {value!r}", "give a positive number in the unit of the state")
        return float(value)

    def _template(
        self,
        parameters: Iterable[Parameter],
        states: Iterable[StateVariable],
        rates: Mapping[sympy.Symbol, sympy.Expr],
        definitions: Iterable[Definition],
        switching: WrittenModes,
    ) -> Template:
        zero, constants = sympy.Integer(0), [self.symbols[key] for key in self.given]

        def cases(expression: sympy.Expr) -> sympy.Basic:
            return case_by_case(expression, switching.modes, constants)

        law: dict[str, Any] = {
            "definitions": {d.name: cases(d.expression) for d in definitions if d.name in self.formulas},
            "torques": {},
            "inertias": {},
            "rates": {symbol: cases(rate) for symbol, rate in rates.items()},
            "kinetic_energy": None,
            "modes": switching,
        }
        law.update(stored_energy=zero, dissipated_power=zero, supplied_power=zero)
        return Template(
            kind=KIND,
            title="System",
            flanges=(),
            parameters=tuple((p.name, p.symbols) for p in parameters),
            clocks=(),
            harmonics=(),
            states=tuple((s.name, self.symbols[s.name], s.unit, s.start, s.scale) for s in states),
            definitions=tuple(definitions),
            relatives=(),
            absolute_angles=(),
            torques={},
            mass={},
            constraints=(),
            rates=dict(rates),
            stored_energy=zero,
            dissipated_power=zero,
            supplied_power=zero,
            modal_ratio=None,
            guards=switching.guards,
            sense=1,
            law=law,
            modes=switching.modes,
        )
