"""Many runs of one model in generated C: side by side in SIMD lanes, on all cores, from one queue.

Part of ``solvers``; the memory and the watch are those of ``native``. The result of a run does not depend on its neighbors, on
their number, on their order, or on the threads.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

from modelgen.errors import CaseError
from modelgen.lowering.native import native_solver
from modelgen.solvers.native import NativeRuns
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory, Vector
from modelgen.solvers.watch import Watch


@dataclass(frozen=True, eq=False)
class Lanes:
    """The runs in the order in which they were asked for.

    ``lowest``, ``highest`` (runs, nx): extremes of each state over ends and middles of the steps from the first output time on
    (not finite where a run did not get there).
    """

    trajectories: tuple[Trajectory, ...]
    lowest: Vector
    highest: Vector


def solve_lanes(problems: Sequence[InitialValueProblem], options: SolverOptions, threads: int | None = None) -> Lanes:
    """Integrate many problems that differ in parameters, start, scale and output times (their number and ``t0`` are shared).

    ``threads``: workers, by default as many as there are cores. Each keeps its own lanes filled from one queue. The budgets hold
    for each run, ``max_seconds`` for all together. Raises CaseError for problems that do not fit together, NoCompilerError.
    """
    if not problems:
        raise CaseError("lanes", "there are no problems", "give at least one")
    count = _cores() if threads is None else threads
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise CaseError("lanes, threads", f"is {threads!r}", "give a whole number from 1 up")
    watch = Watch(options)
    solver = native_solver(problems[0].rhs, lanes=True)
    runs = NativeRuns(solver, problems, options, watch)
    runs.go(threads=min(count, -(-len(problems) // solver.lanes)))
    trajectories = tuple(runs.trajectory(job) for job in range(len(problems)))
    return Lanes(trajectories, runs.x0 + runs.extrema[:, 0], runs.x0 + runs.extrema[:, 1])


def _cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
