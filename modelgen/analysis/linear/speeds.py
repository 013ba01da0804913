"""Operating speeds that a question is asked at, and the parameters that hold at each.

Below ``campbell`` and ``forced``. Gas pressure, drag and inertia torques change with speed, so parameters may be a function of
it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.excitation import operating_speed
from modelgen.errors import CaseError
from modelgen.lowering import Compiled
from modelgen.solvers.bound_model import operating_point
from modelgen.solvers.operating_point import OperatingPoint
from modelgen.units import read_quantity

Array = NDArray[np.float64]
Parameters = Mapping[str, Any] | Callable[[float], Mapping[str, Any]] | None
"""Values by name that differ from the model's own, or a function of the speed [rad/s] that returns them."""


def read_speeds(model: Compiled, speeds: Any) -> Array:
    """Operating speeds [rad/s], rising, from numbers in rad/s or texts such as "1500 rpm"; None for the model's own speed.

    Raises CaseError unless they are positive and rising.
    """
    where = f"driveline {model.name!r}, speeds"
    if speeds is None:
        return np.array([operating_speed(model, model.parameters.unbalanced())])
    listed = [speeds] if isinstance(speeds, (str, float, int)) or not isinstance(speeds, Iterable) else list(speeds)
    try:
        found = np.array([read_quantity(each, "rad/s", where) if isinstance(each, str) else float(each) for each in listed])
    except (TypeError, ValueError):
        raise CaseError(where, f"are {speeds!r:.60}", 'give numbers in rad/s or texts such as "1500 rpm"') from None
    if not found.size or not np.all(np.isfinite(found)) or found[0] <= 0 or np.any(np.diff(found) <= 0):
        raise CaseError(where, f"are {speeds!r:.60}", "give positive speeds, the lowest first")
    operating_speed(model, model.parameters.unbalanced())
    return found


def point_at(model: Compiled, speed: float, parameters: Parameters) -> OperatingPoint:
    """The operating point at a speed [rad/s]. Raises what ``operating_point`` raises."""
    values = parameters(speed) if callable(parameters) else parameters
    return operating_point(model, {**(values or {}), "speed": speed})
