"""Numbers within their bounds: one sentence of refusal for every length, modulus and ratio of this package.

Stands first in ``gears``; only ``modelgen.errors`` is above it. The bounds are wide, but narrow enough to notice millimeters,
gigapascals and degrees where meters, pascals and radians are asked for.
"""

from __future__ import annotations

import math
from numbers import Real

from modelgen.errors import ModelError, ModelgenError


def bounded(
    value: object,
    name: str,
    where: str,
    unit: str = "1",
    *,
    above: float = -math.inf,
    at_least: float = -math.inf,
    at_most: float = math.inf,
    below: float = math.inf,
) -> float:
    """The value as a float, refused unless it is a finite number within the bounds. Raises ModelError.

    >>> bounded(0.1, "face_width", "gear mesh 26/46", "m", above=0)
    0.1
    >>> bounded(-1, "face_width", "gear mesh 26/46", "m", above=0)
    Traceback (most recent call last):
    ...
    modelgen.errors.ModelError: gear mesh 26/46: face_width is -1 m; give a finite value > 0 m
    """
    number = _number(value)
    if math.isfinite(number) and above < number < below and at_least <= number <= at_most:
        return number
    suffix = "" if unit == "1" else f" {unit}"
    limits = [(">", above), (">=", at_least), ("<=", at_most), ("<", below)]
    wanted = " and ".join(f"{sign} {limit:g}{suffix}" for sign, limit in limits if math.isfinite(limit))
    shown = f"{value}{suffix}" if math.isfinite(number) else repr(value)[:60]
    raise ModelError(where, f"{name} is {shown}", f"give a finite value {wanted}".rstrip())


def whole(value: object, name: str, where: str, at_least: int, at_most: int, refusal: type[ModelgenError] = ModelError) -> int:
    """The value as an int, refused unless it is a whole number within the limits; 26.0 counts as 26.

    >>> whole(26.0, "teeth", "gear", 3, 1000)
    26
    >>> whole(26.5, "teeth", "gear", 3, 1000)
    Traceback (most recent call last):
    ...
    modelgen.errors.ModelError: gear: teeth is 26.5; give a whole number from 3 to 1000
    """
    number = _number(value)
    if number.is_integer() and at_least <= number <= at_most:
        return int(number)
    raise refusal(where, f"{name} is {repr(value)[:60]}", f"give a whole number from {at_least} to {at_most}")


def _number(value: object) -> float:
    """The value as a float; nan for anything that is not a real number of ordinary size."""
    if not isinstance(value, Real) or isinstance(value, bool):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.nan
