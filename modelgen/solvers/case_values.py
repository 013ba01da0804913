"""What may stand in a case, read when it is made: numbers, times, names and options. Anything else is one sentence.

Part of ``solvers``, below ``case``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from numbers import Integral, Real
from types import MappingProxyType
from typing import Any

import numpy as np

from modelgen.errors import CaseError, nearest
from modelgen.lowering import Compiled
from modelgen.units import finite, read_quantity

MOST_SAMPLES = 50_000_000


def read_number(name: str, value: Any, unit: str = "") -> float:
    """A finite real number, or with a ``unit`` a text such as "20 ms". Raises CaseError; UnitError where it is not finite."""
    where = f"case, {name}"
    if isinstance(value, str) and unit:
        return read_quantity(value, unit, where)
    return finite(_plain_number(name, value, unit), where)


def _plain_number(name: str, value: Any, unit: str = "") -> float:
    """A real number, be it finite or not. Raises CaseError."""
    where, value = f"case, {name}", _scalar(value)
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Real):
        raise CaseError(where, f"is {value!r:.60}", f'give a number, or a text such as "1 {unit}"' if unit else "give a number")
    try:
        return float(value)
    except (OverflowError, ValueError):
        return math.inf


def read_positive(name: str, value: Any) -> float:
    """A finite number above zero. Raises CaseError."""
    number = read_number(name, value)
    if number <= 0:
        raise CaseError(f"case, {name}", f"is {value!r:.60}", "give a positive number")
    return number


def read_whole(name: str, value: Any, least: float = -math.inf, most: float = math.inf) -> int:
    """A whole number within its range. Raises CaseError."""
    value = _scalar(value)
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Integral) or not least <= int(value) <= most:
        within = f" from {least:.0f} up, {most:.0f} at most" if math.isfinite(least) else ""
        raise CaseError(f"case, {name}", f"is {value!r:.60}", f"give a whole number{within}")
    return int(value)


def read_table(name: str, value: Any) -> Mapping[str, Any]:
    """A mapping from names. Raises CaseError."""
    if not isinstance(value, Mapping):
        raise CaseError(f"case, {name}", f"are {type(value).__name__}", 'give a mapping such as {"zeta": 0.02}')
    for key in value:
        if not isinstance(key, str):
            raise CaseError(f"case, {name}", f"have the key {key!r:.60}", "give names as text")
    return MappingProxyType(dict(value))


def read_rows(name: str, value: Any, example: str) -> tuple[Any, ...]:
    """A sequence, but no text. Raises CaseError."""
    if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, Iterable) or getattr(value, "ndim", 1) == 0:
        raise CaseError(f"case, {name}", f"are {value!r:.60}", f"give a sequence such as {example}")
    return tuple(value)


def read_start(model: Compiled, start: Mapping[str, Any]) -> dict[str, float]:
    """Values [SI] of states and channels by name, from numbers and texts with units. Raises CaseError with the nearest name."""
    found = {}
    units = {**dict(zip(model.outputs, model.units, strict=True)), **{s.name: s.unit for s in model.equations.states}}
    for name, value in start.items():
        where = f"case, start of {name!r}"
        if name not in units:
            problem = f"names {name!r}, which is no state and no channel"
            raise CaseError(f"case of {model.name!r}, start", problem, nearest(str(name), units))
        if isinstance(value, str):
            value = read_quantity(value, units[name], where)
        remedy = f"give a finite number in {units[name]}, or a text with a unit"
        if isinstance(value, bool) or not isinstance(value, (int, float, np.floating, np.integer)):
            raise CaseError(where, f"is {value!r:.40}", remedy)
        if not np.isfinite(value):
            raise CaseError(where, f"holds a number that is not finite, {value}", remedy)
        found[name] = float(value)
    return found


def _scalar(value: Any) -> Any:
    """An array without dimensions as its number."""
    return value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value
