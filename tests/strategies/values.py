"""Values of parameters within their declared limits, as texts with a unit of the declared dimension."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from modelgen import Param

USUAL = {
    "kg*m^2": (1e-3, 1e2),
    "N*m/rad": (1e2, 1e7),
    "N*m*s/rad": (1e-3, 1e2),
    "N/m": (1e6, 1e9),
    "N*s/m": (1e0, 1e4),
    "N*m": (1e-1, 1e4),
    "rad": (1e-4, 1.0),
    "rad/s": (1e0, 1e3),
    "m": (1e-3, 1e-1),
    "s": (1e-3, 1e0),
    "Pa": (1e9, 3e11),
    "1": (1e-3, 1e1),
}
"""Sizes that machines have, in SI; parameters of other units take those of a plain number."""

OTHERS = {
    "N*m/rad": {"kN*m/rad": 1e3, "N*m/deg": 57.29577951308232},
    "N*m": {"kN*m": 1e3},
    "rad": {"deg": 0.017453292519943295, "mrad": 1e-3},
    "rad/s": {"rpm": 0.10471975511965977},
    "m": {"mm": 1e-3, "um": 1e-6},
    "s": {"ms": 1e-3},
    "Pa": {"GPa": 1e9},
    "kg*m^2": {"g*m^2": 1e-3},
}
"""Other units of the same dimension and their sizes in SI."""


def numbers(param: Param) -> st.SearchStrategy[float]:
    """Lawful numbers in SI of the usual size: positive, whole or within limits as declared, of either sign elsewhere."""
    if param.integer:
        least = 1 if param.positive else 0
        return st.integers(int(param.least or least), int(param.largest or 90))
    if param.least is not None or param.largest is not None:
        low = 0.0 if param.least is None else param.least
        high = low + 10.0 if param.largest is None else param.largest
        inside = st.floats(low, high, exclude_min=param.positive and low == 0.0)
        return inside.map(lambda value: float(f"{value:.6g}"))
    low, high = USUAL.get(param.unit, USUAL["1"])
    if param.name == "damping_ratio":
        high = 0.5
    sizes = st.floats(0.0, 1.0).map(lambda share: float(f"{low * (high / low) ** share:.6g}"))
    if param.positive:
        return sizes
    if param.nonnegative:
        return st.one_of(sizes, st.just(0.0))
    return st.one_of(sizes, sizes.map(lambda value: -value), st.just(0.0))


def units(param: Param) -> st.SearchStrategy[tuple[str, float]]:
    """A unit of the parameter's dimension and its size in SI."""
    return st.sampled_from([(param.unit, 1.0), *OTHERS.get(param.unit, {}).items()])


@st.composite
def written(draw: st.DrawFn, param: Param, length: int | None = None) -> Any:
    """A lawful value as a model file writes it: a number, a text with a unit, or a table for a series of the given length."""
    if length is not None:
        values = draw(st.lists(numbers(param), min_size=length, max_size=length))
        unit, size = draw(units(param))
        return values if unit == "1" else {"unit": unit, "values": [value / size for value in values]}
    value, (unit, size) = draw(numbers(param)), draw(units(param))
    return value if unit == "1" else f"{value / size:.9g} {unit}"
