"""The smallest step that a run may take: below it, the tolerance cannot be held, and the run ends by name.

Part of ``solvers``, for ``march`` and ``chunks``. An explicit method gives up at a share of the horizon. A stiff problem moves
fastest at its start, however far its horizon, so a stiff method counts from there.
"""

from __future__ import annotations

import math

from modelgen.solvers.problem import InitialValueProblem

EARLIEST = 1e-10  # of the horizon: the time from which a stiff method counts


def time_since_start(problem: InitialValueProblem, t: float) -> float:
    """Seconds since the start, not less than a small share of the horizon."""
    return max(t - problem.t0, EARLIEST * problem.horizon)


def smallest_step(problem: InitialValueProblem, share: float, t: float, stiff: bool) -> float:
    """The smallest step [s] at a time, as a ``share`` of the horizon, or of the time since the start for a stiff method."""
    if stiff:
        return max(share * time_since_start(problem, t), 4 * math.ulp(abs(t)))
    return max(share * problem.horizon, 4 * math.ulp(max(abs(t), abs(float(problem.times[-1])))))
