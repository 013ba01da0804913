"""Base frequencies: every clock as an exact multiple of the operating speed.

Part of the grammar, after the speed ratios are known (``modelgen.equations.coordinates``). A clock bound to a flange, such as a
gear mesh, follows the mean speed there; an unbound one runs on a base frequency that the driveline names.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

import sympy

from modelgen.equations.conditions import Condition
from modelgen.equations.parts import Part
from modelgen.equations.records import BaseClock
from modelgen.equations.topology import shaft_node
from modelgen.errors import ModelError
from modelgen.model import Clock, Driveline, Param

STANDS_STILL = ("varies with a base frequency at these values, but there is no operating speed",
                'give speed="1500 rpm" and a reference, and assemble anew')  # fmt: skip


def assign_clocks(
    line: Driveline,
    parts: Sequence[Part],
    node_of: Mapping[str, int],
    ratio: Callable[[int], sympy.Expr],
    values: Mapping[sympy.Symbol, float],
) -> tuple[list[BaseClock], list[dict[str, int]], list[Condition]]:
    """All base frequencies and, for each part, the one of each of its clocks; ``ratio`` is the speed ratio of a node.

    Without an operating speed a clock may stand still where nothing varies with it at the ``values`` at hand, as in a mesh of
    constant stiffness without error; the conditions say what must then stay zero.

    Raises ModelError where a law runs on a base frequency and the driveline has no operating speed.
    """
    clocks: list[BaseClock] = []
    index: dict[str, int] = {}
    for name, base in line.bases.items():
        multiple = sympy.Integer(1)
        if base.shaft is not None:
            multiple = ratio(shaft_node(line, base.shaft, node_of, f"base frequency {name!r}, shaft"))
        index[name] = len(clocks)
        clocks.append(BaseClock(name, multiple * _rational(base.order)))
    found: list[dict[str, int]] = []
    conditions: list[Condition] = []
    used: set[str] = set()
    for part in parts:
        element, mine = part.element, dict[str, int]()
        for key, clock in element.declared(Clock).items():
            runs = bool(part.names_in_laws & {f"{key}.angle", f"{key}.frequency"})
            if runs and line.speed is None and (zeros := _still(part, key, values)) is not None:
                conditions += [Condition(part.where, (symbol,), (sympy.Integer(1),), words=STANDS_STILL) for symbol in zeros]
                runs = False
            if clock.flange is not None:
                mine[key] = len(clocks)
                clocks.append(BaseClock(f"{element.name}.{key}", _order(part, clock) * ratio(part.nodes[clock.flange])))
            elif runs or key in element.clocks:
                mine[key] = index[line.clock_base(element, key)]
            if runs:
                used.add(clocks[mine[key]].name)
        found.append(mine)
    if used and line.speed is None:
        first = ", ".join(repr(name) for name in sorted(used)[:3])
        what = f"has base frequencies ({first}) but no operating speed"
        raise ModelError(f"driveline {line.name!r}", what, 'give speed="1500 rpm" and a reference')
    return clocks, found, conditions


def _still(part: Part, key: str, values: Mapping[sympy.Symbol, float]) -> list[sympy.Symbol] | None:
    """Parameters whose zeros keep the laws from seeing a clock; None where they see it."""
    template = part.template
    zeros = {local for local, symbol in part.symbols.items() if values.get(symbol) == 0}
    gone = {symbol: sympy.Integer(0) for symbol in zeros}
    clock = {sympy.Symbol(f"{key}.{name}", real=True) for name in ("angle", "frequency")}
    clock |= {each.symbol for each in template.harmonics if each.clock == key}
    laws = [*template.torques.values(), *template.rates.values(), template.supplied_power, template.dissipated_power]
    laws += [region for modes in template.modes for region in modes.regions.values()]
    laws += [guard.expression for guard in template.guards]
    used = set[sympy.Symbol]()
    for symbol, law in [*((each.symbol, each.expression) for each in template.definitions), *((None, law) for law in laws)]:
        used |= law.free_symbols & zeros if law.free_symbols & clock else set()
        reduced = law.xreplace(gone)
        if reduced.free_symbols & clock:
            return None
        if symbol is not None and reduced == 0:
            gone[symbol] = reduced
    return [part.symbols[symbol] for symbol in used]


def _order(part: Part, clock: Clock) -> sympy.Expr:
    """Cycles per turn of the flange: a number, or a parameter such as a number of teeth."""
    if isinstance(clock.order, str):
        return part.symbols[part.element.declared(Param)[clock.order].symbol()]
    return _rational(Fraction(clock.order))


def _rational(value: Fraction) -> sympy.Rational:
    return sympy.Rational(value.numerator, value.denominator)
