"""The smallest step that a run may take: below it, the tolerance cannot be held, and the run ends by name.

Part of ``solvers``, for ``march`` and ``chunks``. An explicit method gives up at a share of the horizon. A stiff problem may move
fastest at its start, however far its horizon, so a stiff method counts from the time in which the start moves by its own size.
"""

from __future__ import annotations

import math

import numpy as np

from modelgen.solvers.coordinates import ScaledProblem


def time_of_start(scaled: ScaledProblem) -> float:
    """Time [s] in which the fastest state moves by its scale, at the pace of the start; at most the horizon."""
    problem = scaled.problem
    fastest = float(np.abs(scaled.rates(problem.t0, np.zeros(scaled.size))).max(initial=0.0))
    return min(problem.horizon, 1 / fastest) if math.isfinite(fastest) and fastest * problem.horizon > 1 else problem.horizon


def smallest_step(scaled: ScaledProblem, share: float, t: float, start: float | None = None) -> float:
    """The smallest step [s] at a time, as a ``share`` of the horizon; with ``start`` (a stiff method), of the time since then."""
    problem = scaled.problem
    if start is not None:
        return max(share * max(t - problem.t0, start), 4 * math.ulp(abs(t)))
    return max(share * problem.horizon, 4 * math.ulp(max(abs(t), abs(float(problem.times[-1])))))
