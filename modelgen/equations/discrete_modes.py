"""Modes, guards and held speeds of an element, read and checked: when a mode holds, and what leads from one to another.

Part of the grammar, beside the laws in ``modelgen.equations.template``. Regions need no memory: a mode holds where its expression
is zero or positive, and the guards follow. A variable that guards name has memory; regions of it, if any, only say which mode
is meant where a law is looked at by itself, without a motion that led there.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import sympy

from modelgen.equations.dimensions import DimensionCheck
from modelgen.equations.element_symbols import ElementSymbols
from modelgen.equations.mode_records import DiscreteModes, Hold, Reset, Transition
from modelgen.errors import ModelError, NamingError, nearest
from modelgen.model import Guard
from modelgen.model.names import identifier

if TYPE_CHECKING:
    from modelgen.equations.plain_modes import PlainSymbols

Expressions = Mapping[str, sympy.Expr]
Keyed = dict[tuple[str, ...], sympy.Expr]


@dataclass(frozen=True)
class WrittenModes:
    """What an element says of its modes, in its own symbols."""

    modes: tuple[DiscreteModes, ...]
    guards: tuple[Transition, ...]
    holds: tuple[Hold, ...]

    def by_key(self) -> Keyed:
        """Every expression that is rewritten for the compiler."""
        laws: Keyed = {("region", m.name, value): x for m in self.modes for value, x in m.regions.items()}
        for guard in self.guards:
            laws["guard", guard.name] = guard.expression
            for row, reset in enumerate(guard.resets):
                laws["present", guard.name, str(row)] = reset.present
                laws["reset", guard.name, str(row)] = reset.value
        laws |= {("hold", hold.multiplier.name): hold.speed for hold in self.holds}
        return laws

    def symbols(self) -> set[sympy.Symbol]:
        """All symbols in them."""
        return {symbol for law in self.by_key().values() for symbol in law.free_symbols}

    def rewritten(self, laws: Keyed, fixed: Mapping[sympy.Symbol, sympy.Expr]) -> WrittenModes:
        """The same with the expressions of ``by_key`` after rewriting; the guards of regions come first."""
        modes = tuple(replace(m, regions={v: laws["region", m.name, v] for v in m.regions}) for m in self.modes)
        guards = []
        for guard in self.guards:
            resets = tuple(
                Reset(
                    each.state,
                    {flange: c.xreplace(dict(fixed)) for flange, c in each.coefficients.items()},
                    laws["present", guard.name, str(row)],
                    laws["reset", guard.name, str(row)],
                )
                for row, each in enumerate(guard.resets)
            )
            guards.append(replace(guard, expression=laws["guard", guard.name], resets=resets))
        holds = tuple(replace(hold, speed=laws["hold", hold.multiplier.name]) for hold in self.holds)
        borders = tuple(border for m in modes if not m.memory for border in border_guards(m))
        return WrittenModes(modes, (*borders, *guards), holds)


def border_guards(modes: DiscreteModes) -> Iterator[Transition]:
    """The guards that regions imply: into each from rest and from every later one, and back to rest."""
    rest, regions = modes.values[0], list(modes.regions)
    for place, value in enumerate(regions):
        inside = modes.regions[value]

        def guard(direction: int, leave: str, enter: str, inside: sympy.Expr = inside) -> Transition:
            return Transition(f"{modes.name}.{leave}-{enter}", inside, direction, modes.name, leave, enter)

        yield guard(1, rest, value)
        yield guard(-1, value, rest)
        for later in regions[place + 1 :]:
            yield guard(1, later, value)


def case_by_case(expression: sympy.Basic, modes: tuple[DiscreteModes, ...], constants: Collection[sympy.Symbol]) -> sympy.Basic:
    """A law with its flags turned into cases, for reading and proofs; a mode with memory becomes a condition by its name."""
    for m in modes:
        if not expression.free_symbols & set(m.symbols):
            continue
        order = [*m.regions, *(value for value in m.values[1:] if value not in m.regions)]
        pieces: list[Any] = [(_held(expression, m, value), held_where(m, value, constants)) for value in order]
        expression = sympy.Piecewise(*pieces, (_held(expression, m, m.values[0]), True))
    return expression


def _held(expression: sympy.Basic, modes: DiscreteModes, held: str) -> sympy.Basic:
    """The expression in one mode."""
    flags = zip(modes.symbols, modes.values, strict=True)
    return expression.xreplace({flag: sympy.Integer(value == held) for flag, value in flags})


def held_where(modes: DiscreteModes, value: str, constants: Collection[sympy.Symbol]) -> sympy.Basic:
    """The condition under which a mode holds: a comparison, or the mode itself where it has memory."""
    if modes.memory:
        return modes.symbols[modes.values.index(value)]
    # What stands still goes to the other side: "delta >= b", "-delta >= b".
    inside = modes.regions[value]
    still = sympy.Add(*(term for term in sympy.Add.make_args(inside) if term.free_symbols <= set(constants)))
    return sympy.Ge(inside - still, -still)


class ModeReader:
    """Reads the modes of one element, or of a plain system, which has no ``units`` to check."""

    def __init__(self, symbols: ElementSymbols | PlainSymbols, definitions: Expressions, units: bool = True) -> None:
        self.symbols: Any = symbols
        self.where, self.definitions, self.units = symbols.where, definitions, units
        self.element: Any = symbols.element

    def read(self) -> WrittenModes:
        """Everything, checked. Raises ModelError, NamingError or UnitError."""
        guards = tuple(self._guard(guard) for guard in self.element.guards())
        names = [guard.name for guard in guards]
        if twice := next((name for name in names if names.count(name) > 1), None):
            raise NamingError(self.where, f"has two guards named {twice!r}", "rename one of them")
        regions = self._regions()
        modes = []
        for name, declared in self.symbols.modes.items():
            memory = any(guard.variable == name for guard in guards)
            if not memory and not regions[name]:
                raise self._refuse(f"nothing leads into its modes {name!r}", "answer regions() or guards()")
            reached = {guard.enter for guard in guards if guard.variable == name} | {declared.start} if memory else regions[name]
            lost = [value for value in declared.values[0 if memory else 1 :] if value not in reached]
            if lost:
                raise self._refuse(f"nothing leads into its mode {name}.{lost[0]}", "give it a guard or a region, or drop it")
            modes.append(
                DiscreteModes(
                    name=name,
                    values=declared.values,
                    symbols=tuple(declared.symbols),
                    start=declared.values.index(declared.start),
                    continuous=declared.continuous(self.element.choices),
                    regions=regions[name],
                    memory=memory,
                )
            )
        found = WrittenModes(tuple(modes), guards, self._holds())
        if self.units:
            self._check_units(found)
        return found

    def _refuse(self, problem: str, remedy: str) -> ModelError:
        return ModelError(self.where, problem, remedy)

    def _flag(self, key: Any, what: str) -> tuple[str, str]:
        """Variable and mode of a flag, given as its symbol or by its name."""
        flags = self.symbols.flags
        if isinstance(key, sympy.Symbol) and key in flags:
            return flags[key]
        by_name: dict[str, list[tuple[str, str]]] = {}
        for variable, value in flags.values():
            by_name.setdefault(value, []).append((variable, value))
            by_name[f"{variable}.{value}"] = [(variable, value)]
        name = str(key)
        if name not in by_name:
            raise NamingError(self.where, f"{what} names the mode {name!r:.60}", nearest(name, by_name))
        if len(by_name[name]) > 1:
            raise NamingError(self.where, f"{what} names the mode {name!r}, which two variables have", "give its symbol")
        return by_name[name][0]

    def _regions(self) -> dict[str, dict[str, sympy.Expr]]:
        found: dict[str, dict[str, sympy.Expr]] = {name: {} for name in self.symbols.modes}
        for key, written in self.element.regions().items():
            variable, value = self._flag(key, "a region")
            what = f"region of {variable}.{value}"
            if value == self.symbols.modes[variable].values[0]:
                raise self._refuse(f"{what} is given, the mode at rest", "leave it out: it holds outside all regions")
            expression = self.symbols.read(written, what)
            if self._written_out(expression) & self.symbols.switched:
                raise self._refuse(f"{what} depends on modes itself", "write it with what moves, or give guards()")
            found[variable][value] = expression
        return found

    def _written_out(self, expression: sympy.Expr) -> set[sympy.Symbol]:
        return set(self.symbols.written_out(expression, self.definitions).free_symbols)

    def _guard(self, guard: Guard) -> Transition:
        if not isinstance(guard, Guard):
            raise self._refuse(f"guards() gives {guard!r:.60}", "give Guard(name, expression, ...)")
        name = identifier(guard.name, self.where, "guard")
        what = f"guard {name!r}"
        if isinstance(guard.direction, bool) or guard.direction not in (-1, 0, 1):
            raise self._refuse(f"{what} has the direction {guard.direction!r:.60}", "give 1 (rising), -1 (falling) or 0 (both)")
        variable = leave = enter = None
        if (guard.leave is None) != (guard.enter is None):
            raise self._refuse(f"{what} names one mode only", "name the mode it leaves and the one it enters, or none")
        if guard.leave is not None:
            (variable, leave), (other, enter) = self._flag(guard.leave, what), self._flag(guard.enter, what)
            if variable != other:
                raise self._refuse(f"{what} leads from modes {variable!r} to modes {other!r}", "stay with one of them")
            if leave == enter:
                raise self._refuse(f"{what} leaves and enters {leave!r}", "leave both out: it is then watched in all modes")
        expression = self.symbols.read(guard.expression, what)
        if not self._written_out(expression) - self.symbols.constants:
            raise self._refuse(f"{what} never changes: {expression}", "write it with time, angles, speeds or states")
        resets = tuple(self._reset(target, value, what) for target, value in guard.resets())
        return Transition(
            name, expression, guard.direction, variable, leave, enter, resets, bool(guard.stops), bool(guard.barrier)
        )

    def _reset(self, target: Any, value: Any, what: str) -> Reset:
        value = self.symbols.read(value, f"reset of {what}")
        states = {state.symbol for state in self.symbols.states.values()}
        if target in states:
            return Reset(target, {}, target, value)
        present = self.symbols.read(target, f"reset of {what}")
        written = self.symbols.written_out(present, self.definitions)
        coefficients = {name: written.diff(flange.speed) for name, flange in self.symbols.flanges.items()}
        coefficients = {name: c for name, c in coefficients.items() if c != 0}
        rest = written.xreplace(dict.fromkeys(self.symbols.speeds, sympy.Integer(0)))
        constant = all(c.free_symbols <= self.symbols.constants for c in coefficients.values())
        if not coefficients or not constant or sympy.simplify(rest) != 0:
            remedy = "set own states, flange speeds, or linear combinations of flange speeds"
            raise self._refuse(f"{what} resets {target}", remedy)
        return Reset(None, coefficients, present, value)

    def _holds(self) -> tuple[Hold, ...]:
        found = []
        for key, (speed, multiplier) in self.element.holds().items():
            variable, value = self._flag(key, "holds()")
            what = f"what {variable}.{value} holds"
            if multiplier not in {each.symbol for each in self.symbols.multipliers.values()}:
                raise self._refuse(f"{what} has the multiplier {multiplier!r:.60}", "declare it: torque = Multiplier()")
            expression = self.symbols.read(speed, what)
            moving = self._written_out(expression)
            if moving & self.symbols.switched or not moving & {*self.symbols.speeds, *self._own_states()}:
                raise self._refuse(f"{what} is {expression}", "write it with flange speeds or own states, without modes")
            found.append(Hold(self.symbols.modes[variable].symbols.symbols[value], expression, multiplier))
        held = [hold.multiplier.name for hold in found]
        for name in self.symbols.multipliers:
            if held.count(name) != 1:
                raise self._refuse(f"the multiplier {name!r} holds {held.count(name)} speeds", "let holds() use it once")
        return tuple(found)

    def _own_states(self) -> set[sympy.Symbol]:
        return {state.symbol for state in self.symbols.states.values()}

    def _check_units(self, found: WrittenModes) -> None:
        check = DimensionCheck(self.symbols.dimensions, self.where)
        for m in found.modes:
            for value, expression in m.regions.items():
                check.of(expression, f"region of {m.name}.{value}")
        for guard in found.guards:
            check.of(guard.expression, f"guard {guard.name!r}")
            for reset in guard.resets:
                check.of(reset.value - reset.present, f"reset of guard {guard.name!r}")
        for hold in found.holds:
            check.of(hold.speed, f"what holds {hold.multiplier}")
