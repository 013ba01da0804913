"""Mean speeds of a driveline: that of the reference shaft, and further ones where its constraints leave more than one free.

Part of ``model``, below ``driveline``.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from modelgen.errors import ModelError
from modelgen.model.values import plain_number
from modelgen.units import finite, read_quantity


def read_speed(value: Any, where: str) -> float:
    """A mean speed [rad/s] from a text with a unit or a number in SI."""
    return read_quantity(value, "rad/s", where) if isinstance(value, str) else finite(plain_number(value, where, "rad/s"), where)


def mean_speeds(where: str, speed: Any, reference: str | None, speeds: Any) -> dict[str, Any]:
    """``speed`` of the reference shaft, ``reference``, and the further ``speeds`` by shaft.

    The reference shaft's may stand among the others; without a reference the first that turns forward is it. Raises ModelError.
    """
    if not isinstance(speeds, Mapping):
        raise ModelError(where, f"speeds is {speeds!r:.60}", 'give {"sun": "1500 rpm", "ring": 0}')
    values = {name: read_speed(value, f"{where}, speed of {name!r}") for name, value in speeds.items()}
    if values and reference is None:
        reference = next((name for name, value in values.items() if value > 0), next(iter(values)))
    if reference in values:
        speed = values.pop(reference)
    if values and speed is None:
        raise ModelError(where, f"gives no speed to its reference shaft {reference!r}", "add it to speeds")
    return {"speed": speed, "reference": reference, "speeds": MappingProxyType(values)}
