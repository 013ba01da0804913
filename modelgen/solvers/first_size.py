"""The size of the first step of a run.

Part of ``solvers``; used by ``march``. Source: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.4, with
time measured in units in which a state moves by a hundredth of its scale.
"""

from __future__ import annotations

import math

import numpy as np

from modelgen.lowering.step_control import FIRST_GROWTH, FIRST_MOVE, FIRST_SHARE
from modelgen.solvers.coordinates import ScaledProblem
from modelgen.solvers.problem import Vector


def first_size(scaled: ScaledProblem, t: float, state: Vector, wanted: float, power: float, ceiling: float) -> float:
    """A step [s] from [y, y'] whose error is about ``wanted``, for an error that grows with a power of the step.

    It takes one evaluation. Zero where a rate or its change is no number.
    """
    y, slope = state
    speed, horizon = float(np.abs(slope).max()), scaled.problem.horizon
    unit = min(FIRST_MOVE / speed if speed > 0 else FIRST_SHARE * horizon, horizon, ceiling)
    bend = scaled.rates(t + unit, y + unit * slope) - slope
    size = max(unit * speed, unit * float(np.abs(bend).max()))
    if not math.isfinite(size):
        return 0.0
    factor = (wanted / size) ** (1 / power) if size > 0 else FIRST_GROWTH
    return unit * min(FIRST_GROWTH, factor)
