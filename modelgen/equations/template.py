"""From an element class to a template: its laws once, in the form that the compiler needs.

Part of the grammar; it knows no element by name. The laws an element wrote are read (``element_symbols``), put in order of use,
checked for their units and, for inertias that depend on angle, derived after Lagrange. Then every sum of flange angles becomes
a relative angle (``relative_angles``), and what depends on time alone is set apart (``time_parts``).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import sympy

from modelgen.equations.dimensions import DimensionCheck
from modelgen.equations.discrete_modes import ModeReader, WrittenModes, case_by_case
from modelgen.equations.element_symbols import ElementSymbols
from modelgen.equations.python_in_laws import law_refused
from modelgen.equations.records import Template
from modelgen.equations.relative_angles import Key, combination_of_angles, constant_definitions, relate
from modelgen.equations.time_parts import set_time_apart, share_harmonics
from modelgen.errors import ModelError
from modelgen.model import Element
from modelgen.model.declarations import TIME, UNIT_CONSTANTS

Expressions = dict[str, sympy.Expr]
POWERS = {"stored_energy": "J", "dissipated_power": "W", "supplied_power": "W"}


def template_key(element: Element) -> tuple[Any, ...]:
    """What two elements must share to share a template: class, switches, orders, lengths of series, sense."""
    lengths = tuple(sorted(element.lengths.items()))
    return type(element), tuple(element.choices.items()), tuple(element.harmonics.items()), lengths, tuple(element.clocks)


def build_template(element: Element) -> Template:
    """The template of an element; raises ModelError or UnitError where its laws are not lawful."""
    symbols = ElementSymbols(element)
    try:
        written = _written_laws(symbols)
    except TypeError as error:
        raise law_refused(symbols.where, error) or error from None
    _check_units(symbols, written)
    laws = {**written.by_key(), **written.modes.by_key()}
    fixed = constant_definitions(symbols, laws)
    laws, relatives, absolute_angles = relate(symbols, laws, fixed)
    laws, harmonics = share_harmonics(symbols, laws)
    laws, definitions = set_time_apart(symbols, laws)
    switching = written.modes.rewritten(laws, fixed)
    return Template(
        kind=element.kind,
        title=type(element).__name__,
        flanges=tuple(symbols.flanges),
        clocks=tuple(symbols.clocks),
        modal_ratio=_modal_ratio(symbols),
        parameters=tuple(symbols.parameters.items()),
        harmonics=harmonics,
        states=tuple((name, s.symbol, s.unit, s.start, s.scale) for name, s in symbols.states.items()),
        definitions=definitions,
        relatives=relatives,
        absolute_angles=absolute_angles,
        torques={flange: laws["torque", flange] for flange in written.torques},
        mass={(f, g): laws["mass", f, g] for f, g in written.mass},
        constraints=tuple(combination_of_angles(symbols, each, fixed) for each in written.constraints),
        rates={symbol: laws["rate", symbol.name] for symbol in written.rates},
        **{power: laws[power,] for power in POWERS},
        guards=switching.guards,
        sense=element.sense,
        law=written.printed,
        modes=switching.modes,
        multipliers=tuple(each.symbol for each in symbols.multipliers.values()),
        holds=switching.holds,
    )


@dataclass(frozen=True)
class _WrittenLaws:
    """The laws in flange angles and speeds, read and in order; ``printed`` is what the element itself wrote."""

    definitions: Expressions
    torques: Expressions
    mass: dict[tuple[str, str], sympy.Expr]
    constraints: list[sympy.Expr]
    rates: dict[sympy.Symbol, sympy.Expr]
    powers: Expressions
    modes: WrittenModes
    printed: dict[str, Any]

    def by_key(self) -> dict[Key, sympy.Expr]:
        """All laws that are rewritten for the compiler; ones with a unit are 1 from here on."""
        laws: dict[Key, sympy.Expr] = {("definition", name): law for name, law in self.definitions.items()}
        laws |= {("torque", flange): law for flange, law in self.torques.items()}
        laws |= {("rate", symbol.name): law for symbol, law in self.rates.items()}
        laws |= {("mass", f, g): law for (f, g), law in self.mass.items()}
        laws |= {(power,): law for power, law in self.powers.items()}
        ones = dict.fromkeys(UNIT_CONSTANTS, sympy.Integer(1))
        return {key: law.xreplace(ones) for key, law in laws.items()}


def _written_laws(symbols: ElementSymbols) -> _WrittenLaws:
    """Asks the element for its laws. Raises ModelError where they are not lawful."""
    element, read = symbols.element, symbols.read
    definitions = _in_order_of_use(symbols, {name: read(q.law(element), name) for name, q in symbols.quantities.items()})
    torques = {symbols.flange_name(f, "torques"): read(x, f"torque on {f.name}") for f, x in _table(symbols, "torques").items()}
    given = _table(symbols, "inertias")
    inertias = {symbols.flange_name(f, "inertias"): read(x, f"inertia on {f.name}") for f, x in given.items()}
    mass = {
        (name, name): _constant(symbols, symbols.written_out(inertia, definitions), f"inertia on {name}")
        for name, inertia in inertias.items()
    }
    kinetic = element.kinetic_energy()
    if kinetic is not None:
        _derive_after_lagrange(symbols, symbols.written_out(read(kinetic, "kinetic energy"), definitions), mass, torques)
    constraints = [symbols.written_out(read(each, "constraint"), definitions) for each in _list(symbols, "constraints")]
    rates = {symbol: read(rate, f"rate of {symbol}") for symbol, rate in _table(symbols, "rates").items()}
    if set(rates) != {state.symbol for state in symbols.states.values()}:
        raise ModelError(symbols.where, "has own states without a rate, or rates without a state", "give one rate per State")
    powers = {power: read(getattr(element, power)(), power) for power in POWERS}
    modes = ModeReader(symbols, definitions).read()
    cases = {
        kind: {key: case_by_case(law, modes.modes, symbols.constants) for key, law in laws.items()}
        for kind, laws in (("definitions", definitions), ("torques", torques), ("rates", rates), ("powers", powers))
    }
    printed = {**cases, **cases.pop("powers"), "inertias": inertias, "kinetic_energy": kinetic, "modes": modes}
    return _WrittenLaws(definitions, torques, mass, constraints, rates, powers, modes, printed)


def _table(symbols: ElementSymbols, method: str) -> Mapping[Any, Any]:
    """What a method of the element answers, by flange or state. Raises ModelError for anything but a mapping."""
    answer = getattr(symbols.element, method)()
    if not isinstance(answer, Mapping):
        example = "{self.state: law}" if method == "rates" else "{self.flange: law}"
        raise ModelError(symbols.where, f"{method} answers {type(answer).__name__}", f"return a dict such as {example}")
    return answer


def _list(symbols: ElementSymbols, method: str) -> list[Any]:
    """What a method of the element answers, one after the other. Raises ModelError for anything but a list."""
    answer = getattr(symbols.element, method)()
    if not isinstance(answer, Iterable) or isinstance(answer, (str, Mapping)):
        raise ModelError(symbols.where, f"{method} answers {type(answer).__name__}", "return a list, such as [law]")
    return list(answer)


def _in_order_of_use(symbols: ElementSymbols, definitions: Expressions) -> Expressions:
    """Quantities in order of use. Raises ModelError where they define each other."""
    name_of = {symbols.quantities[name].symbol: name for name in definitions}
    waiting = {name: {name_of[s] for s in law.free_symbols if s in name_of} for name, law in definitions.items()}
    ordered: Expressions = {}
    while waiting:
        ready = [name for name, needs in waiting.items() if needs <= set(ordered)]
        if not ready:
            raise ModelError(symbols.where, f"quantities {', '.join(waiting)} define each other", "break the circle")
        for name in ready:
            ordered[name] = definitions[name]
            del waiting[name]
    return ordered


def _constant(symbols: ElementSymbols, expression: sympy.Expr, what: str) -> sympy.Expr:
    varying = expression.free_symbols - symbols.constants - set(UNIT_CONSTANTS)
    if varying:
        remedy = "an inertia that depends on angle belongs in kinetic_energy()"
        raise ModelError(symbols.where, f"{what} depends on {', '.join(sorted(map(str, varying)))}", remedy)
    return expression


def _derive_after_lagrange(
    symbols: ElementSymbols, energy: sympy.Expr, mass: dict[tuple[str, str], sympy.Expr], torques: Expressions
) -> None:
    """Adds the mass terms and velocity torques of a kinetic energy quadratic in the flange speeds."""
    speeds = set(symbols.speeds)
    varying = energy.free_symbols - symbols.constants - symbols.motion
    if varying:
        what = f"kinetic energy depends on {', '.join(sorted(map(str, varying)))}"
        raise ModelError(symbols.where, what, "write it with parameters, flange angles and speeds")
    for f, flange in symbols.flanges.items():
        momentum = energy.diff(flange.speed)
        extra = energy.diff(flange.angle)
        for g, other in symbols.flanges.items():
            term = momentum.diff(other.speed)
            if term.free_symbols & speeds:
                term = sympy.simplify(term)  # slow, and most energies are plainly quadratic
            if term.free_symbols & speeds:
                what = "kinetic energy is not quadratic in the speeds"
                raise ModelError(symbols.where, what, "write T = sum of J(angle) speed^2 / 2")
            if term != 0:
                mass[f, g] = mass.get((f, g), sympy.Integer(0)) + term
            extra -= momentum.diff(other.angle) * other.speed
        if extra != 0:
            torques[f] = torques.get(f, sympy.Integer(0)) + extra


def _check_units(symbols: ElementSymbols, written: _WrittenLaws) -> None:
    """Raises UnitError where a law has not the dimension of what it stands for."""
    check = DimensionCheck(symbols.dimensions, symbols.where)
    for name, expression in written.definitions.items():
        named = symbols.quantities[name]
        check.require(expression, named.unit, name)
        if named.mean is not None:
            check.require(symbols.read(named.mean(symbols.element), f"mean of {name}"), named.unit, f"mean of {name}")
    for flange, expression in written.torques.items():
        check.require(expression, "N*m", f"torque on {flange}")
    for (flange, _), expression in written.mass.items():
        check.require(expression, "kg*m^2", f"inertia on {flange}")
    for expression in written.constraints:
        check.of(expression, "constraint")
    units = {state.symbol: state.unit for state in symbols.states.values()}
    for symbol, expression in written.rates.items():
        check.require(expression * TIME, units[symbol], f"rate of {symbol} times a second")
    for power, expression in written.powers.items():
        check.require(expression, POWERS[power], power)


def _modal_ratio(symbols: ElementSymbols) -> str | None:
    """Name of the parameter that is the element's modal damping ratio."""
    ratio = symbols.element.modal_damping()
    if ratio is None:
        return None
    if ratio not in symbols.single_parameters:
        raise ModelError(symbols.where, f"modal damping is {ratio}", "return one of the element's own parameters, or None")
    return str(ratio.name)
