"""Modes and guards of plain systems: named as in drivelines, written as texts or with SymPy, without units.

Part of the grammar, under ``modelgen.equations.plain``: what ``discrete_modes`` asks of an element, answered for a plain system.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import sympy

from modelgen.equations.discrete_modes import ModeReader, WrittenModes
from modelgen.errors import ModelError, NamingError, nearest
from modelgen.model import Guard, Modes
from modelgen.model.names import identifier


def declared_modes(modes: Any, where: str) -> dict[str, Modes]:
    """Modes by name, given as ``Modes(...)`` or as the row of their names. Raises ModelError or NamingError."""
    if not isinstance(modes, Mapping):
        raise ModelError(where, f"its modes are {type(modes).__name__}", 'give a mapping such as {"phase": ("rest", "slip")}')
    found = {}
    for key, given in modes.items():
        name = identifier(key.name if isinstance(key, sympy.Symbol) else key, where, "modes")
        if not isinstance(given, Modes):
            if isinstance(given, str) or not isinstance(given, Iterable):
                raise ModelError(f"{where}, modes {name!r}", f"are {given!r:.60}", 'give their names, such as ("rest", "slip")')
            given = Modes(*given)
        found[name] = copy.copy(given)
        found[name].__set_name__(Modes, name)
    return found


@dataclass(frozen=True)
class PlainState:
    """A state by its symbol, as ``ModeReader`` sees it."""

    symbol: sympy.Symbol


class PlainSymbols:
    """What ``ModeReader`` asks of an element, for a plain system; ``expression`` reads a text or SymPy expression."""

    def __init__(
        self,
        where: str,
        modes: Mapping[str, Modes],
        states: Mapping[str, sympy.Symbol],
        constants: Iterable[sympy.Symbol],
        expression: Callable[[Any, str], sympy.Expr],
        regions: Any,
        guards: Any,
    ) -> None:
        self.where, self.modes, self.constants, self.read = where, modes, set(constants), expression
        self.states = {name: PlainState(symbol) for name, symbol in states.items()}
        self.flanges: dict[str, Any] = {}
        self.speeds: dict[sympy.Symbol, str] = {}
        self.multipliers: dict[str, Any] = {}
        self.choices: dict[str, Any] = {}
        self.flags = {
            symbol: (name, value) for name, declared in modes.items() for value, symbol in declared.symbols.symbols.items()
        }
        self._regions, self._guards = regions, guards

    @property
    def element(self) -> PlainSymbols:
        """The one who answers the questions."""
        return self

    @property
    def switched(self) -> set[sympy.Symbol]:
        return set(self.flags)

    def written_out(self, expression: sympy.Expr, definitions: Mapping[str, sympy.Expr]) -> sympy.Expr:
        return expression

    def regions(self) -> Mapping[Any, Any]:
        if not isinstance(self._regions, Mapping):
            raise ModelError(self.where, f"its regions are {type(self._regions).__name__}", "give a mapping from modes")
        return self._regions

    def holds(self) -> Mapping[Any, Any]:
        return {}

    def guards(self) -> list[Any]:
        """The guards, with the states that they reset as symbols of the system."""
        if isinstance(self._guards, (str, Guard, Mapping)) or not isinstance(self._guards, Iterable):
            raise ModelError(self.where, f"its guards are {type(self._guards).__name__}", "give a list of Guard(...)")
        return [self._named(guard) if isinstance(guard, Guard) else guard for guard in self._guards]

    def _named(self, guard: Guard) -> Guard:
        resets = []
        for key, value in guard.resets():
            name = key.name if isinstance(key, sympy.Symbol) else key
            if name not in self.states:
                raise NamingError(self.where, f"guard {guard.name!r} resets {name!r:.60}", nearest(str(name), self.states))
            resets.append((self.states[name].symbol, value))
        return replace(guard, reset=tuple(resets))


def read_plain_modes(symbols: PlainSymbols) -> WrittenModes:
    """Modes, guards and resets of a plain system, checked; the guards of regions come first."""
    found = ModeReader(symbols, {}, units=False).read()
    return found.rewritten(found.by_key(), {})
