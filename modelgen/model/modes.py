"""Discrete modes of an element: their names, what leads from one to another, and the torques that hold a speed meanwhile.

First stage of the flow, beside ``declarations``. A mode is a flag in the laws, 1 where it holds and 0 elsewhere. Which one holds
is said in one of two ways: by *regions* of the state, which need no memory and are borders that a law may be crossed at without
noticing, or by *guards*, where a mode remembers how it was entered (stick and slip, hysteresis).
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy

from modelgen.errors import ModelError, nearest
from modelgen.model.declarations import Condition, Declaration, Switched
from modelgen.model.names import identifier
from modelgen.units import dimension_of

if TYPE_CHECKING:
    from modelgen.model.element import Element


class ModeSymbols:
    """What a law sees of a variable of modes: one flag per mode, as in ``self.flank.drive``; 1 where it holds, else 0."""

    def __init__(self, name: str, values: tuple[str, ...]) -> None:
        self.name, self.values = name, values
        self.symbols = {value: sympy.Symbol(f"{name}.{value}", real=True) for value in values}

    def __getattr__(self, value: str) -> sympy.Symbol:
        symbols: dict[str, sympy.Symbol] = self.__dict__.get("symbols", {})
        if value in symbols:
            return symbols[value]
        if value.startswith("_"):
            raise AttributeError(value)
        raise ModelError(f"modes {self.__dict__.get('name')!r}", f"have no mode {value!r}", nearest(value, symbols))

    def __iter__(self) -> Iterator[sympy.Symbol]:
        return iter(self.symbols.values())


class Modes(Switched):
    """Modes that exclude each other, such as ``Modes("free", "drive", "coast")``; the first is the one at rest.

    In a law ``self.flank.drive`` is a symbol, the flag of that mode. ``regions()`` or ``guards()`` of the element say when a mode
    holds; where a run starts, ``start`` (else the first) is assumed and left at once if a guard says so. ``continuous``: whether
    the laws pass from one mode to the next without a jump, or the switches for which they do, as in ``when``; laws that jump are
    never crossed unseen.
    """

    def __init__(
        self,
        *values: str,
        start: str | None = None,
        continuous: bool | Condition = True,
        when: Condition | None = None,
        doc: str = "",
    ) -> None:
        where = f"modes {values}"
        if len(values) < 2 or len(set(values)) != len(values):
            raise ModelError(where, "are not two or more different names", 'write Modes("free", "drive", "coast")')
        for value in values:
            identifier(value, where, "mode")
        if start is not None and start not in values:
            raise ModelError(where, f"start in {start!r}", nearest(start, values))
        self.values, self.start, self.when, self.doc = values, start or values[0], dict(when or {}), doc
        self._continuous = continuous

    def continuous(self, choices: Mapping[str, Any]) -> bool:
        """Whether the laws are continuous for these settings of the switches."""
        if isinstance(self._continuous, bool):
            return self._continuous
        return all(choices[key] in (v if isinstance(v, tuple) else (v,)) for key, v in self._continuous.items())

    @functools.cached_property
    def symbols(self) -> ModeSymbols:
        return ModeSymbols(self.name, self.values)

    def __get__(self, instance: Element | None, owner: type) -> Any:
        return self if instance is None else self.symbols


class Multiplier(Declaration):
    """What holds a speed while a mode lasts, such as the torque of a brake that sticks; ``holds()`` says which speed.

    In the laws it is a symbol; its value follows from the equations of motion, and is zero in all other modes.
    """

    def __init__(self, unit: str = "N*m", doc: str = "") -> None:
        dimension_of(unit)
        self.unit, self.doc = unit, doc

    @functools.cached_property
    def symbol(self) -> sympy.Symbol:
        return sympy.Symbol(self.name, real=True)

    def __get__(self, instance: Element | None, owner: type) -> Any:
        return self if instance is None else self.symbol


@dataclass(frozen=True)
class Guard:
    """What happens where ``expression`` crosses zero: a change of mode, a jump of the state, the end of the run.

    ``direction`` is +1 for rising, -1 for falling, 0 for both. It is watched in the mode ``leave`` and leads to ``enter``: names
    of modes, or their symbols; without them it is watched always. ``reset`` maps own states, and flange speeds or linear
    combinations of them, to their values after the event. A speed is set by one impulse on the flanges of the combination, with
    the lever arms that the combination has, so that momentum is kept. With ``stops`` the run ends there. A ``barrier`` has
    nothing behind it, beyond zero in its direction: no run can start there.
    """

    name: str
    expression: Any
    direction: int = 0
    leave: Any = None
    enter: Any = None
    reset: Any = ()
    stops: bool = False
    barrier: bool = False

    def resets(self) -> tuple[tuple[Any, Any], ...]:
        """What is set and its value, in pairs."""
        return tuple(self.reset.items()) if isinstance(self.reset, Mapping) else tuple(self.reset)
