"""Many runs of one model in generated C: side by side in SIMD lanes, on all cores, from one queue.

Part of ``solvers``; the memory and the watch are those of ``native``. The result of a run does not depend on its neighbors, on
their number, on their order, or on the threads.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modelgen.errors import CaseError
from modelgen.lowering.native import native_solver
from modelgen.lowering.native.task import COUNTS
from modelgen.solvers.gather import Gather
from modelgen.solvers.native import NativeRuns
from modelgen.solvers.native_memory import watched_guards
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory, Vector
from modelgen.solvers.watch import Watch


@dataclass(frozen=True, eq=False)
class Lanes:
    """The runs in the order in which they were asked for.

    ``final`` (runs, nx): the state where each ended.
    ``channels`` (runs, samples, nc): at the output times, if kept; NaN beyond those that were reached.
    ``channel_...`` (runs, nc): over the output times that were reached; not finite where there were none.
    """

    trajectories: tuple[Trajectory, ...]
    final: Vector
    channels: Vector | None = None
    channel_lowest: Vector | None = None
    channel_highest: Vector | None = None
    channel_mean: Vector | None = None
    channel_mean_square: Vector | None = None


def solve_lanes(
    problems: Sequence[InitialValueProblem],
    options: SolverOptions,
    threads: int | None = None,
    gather: Gather | None = None,
    method: str = "rk4",
) -> Lanes:
    """Integrate many problems that differ in parameters, start, scale and output times (their number and ``t0`` are shared).

    ``threads``: workers, by default as many as there are cores. Each keeps its own lanes filled from one queue. ``gather``: what
    is kept of every run. The budgets hold for each run, ``max_seconds`` for all together. Raises CaseError for problems that do
    not fit together, NoCompilerError.
    """
    if not problems:
        raise CaseError("lanes", "there are no problems", "give at least one")
    count = cores() if threads is None else threads
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise CaseError("lanes, threads", f"is {threads!r}", "give a whole number from 1 up")
    watch = Watch(options)
    solver = native_solver(problems[0].rhs, lanes=True, method=method, guards=watched_guards(problems[0].switching))
    runs = NativeRuns(solver, problems, options, watch, gather, method)
    runs.go(threads=min(count, -(-len(problems) // solver.lanes)))
    trajectories = tuple(runs.trajectory(job) for job in range(len(problems)))
    memory = runs.memory
    final = memory.x0 + memory.last[:, 0]
    if memory.reduced is None:
        return Lanes(trajectories, final)
    reached = np.maximum(memory.counts[:, COUNTS.index("reached")], 0)[:, None, None]
    sums = memory.reduced[:, 2:]
    means = np.divide(sums, reached, out=np.full_like(sums, np.nan), where=reached > 0)
    low, high = memory.reduced[:, 0], memory.reduced[:, 1]
    return Lanes(trajectories, final, memory.kept, low, high, means[:, 0], means[:, 1])


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
