"""The records of discrete modes in a template: modes with their regions, guards with their resets, held speeds.

Part of the grammar, below ``modelgen.equations.records``. They speak in the symbols of the template.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sympy


@dataclass(frozen=True)
class DiscreteModes:
    """Modes of an element that exclude each other, their flags, and the regions where they hold (in order; else the first)."""

    name: str
    values: tuple[str, ...]
    symbols: tuple[sympy.Symbol, ...]
    start: int
    continuous: bool
    regions: Mapping[str, sympy.Expr]
    memory: bool


@dataclass(frozen=True)
class Reset:
    """What an event sets: an own state, or the combination ``coefficients`` of flange speeds, which is ``present`` before."""

    state: sympy.Symbol | None
    coefficients: Mapping[str, sympy.Expr]
    present: sympy.Expr
    value: sympy.Expr


@dataclass(frozen=True)
class Transition:
    """A guard: where its expression crosses zero, ``variable`` (if any) goes from ``leave`` to ``enter``; states are reset."""

    name: str
    expression: sympy.Expr
    direction: int
    variable: str | None = None
    leave: str | None = None
    enter: str | None = None
    resets: tuple[Reset, ...] = ()
    stops: bool = False
    barrier: bool = False


@dataclass(frozen=True)
class Hold:
    """A speed that does not change while the flag is 1, and the multiplier that keeps it so."""

    flag: sympy.Symbol
    speed: sympy.Expr
    multiplier: sympy.Symbol
