"""Many short runs with tangents: the propagators of the stretches of a motion, side by side.

Below ``exponents`` and ``orbits``. Once the motion itself is known where the stretches end, how deviations cross one no longer
depends on the others; so stretches and groups of columns fill the lanes of generated C, or, without a compiler, run one after the
other on the virtual machine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.stability.course import modes_at
from modelgen.analysis.stability.variational import parts, with_tangents
from modelgen.errors import CaseError, LoweringError
from modelgen.lowering.switching import Crossing, Switching
from modelgen.solvers.event_log import EventLog
from modelgen.solvers.guards import guard_floors
from modelgen.solvers.lanes import solve_lanes
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.registry import solve

Array = NDArray[np.float64]
WIDEST = 16
"""Tangent vectors that ride with one state: more would save little time and cost much in building."""

METHOD = "dop853"
"""Of eighth order: nothing but the ends of stretches is wanted, and sums of exponents come nearer to tr J for less work."""
JUMP = 1e-3
"""Distance, in scales, between the end of a stretch and the start of the next that only an event at the joint makes."""
NEAR = 1e-6
"""Of the scales: how near to zero a guard must be for an event of its own."""


class Propagators(NamedTuple):
    """Over each stretch: ``ends`` (stretches, n) of the state, integrals of tr J (stretches,), ``matrices`` (stretches, n, n).

    The matrices are in scales of the states. ``modes``: parameters with the flags of the modes at the end of each stretch.
    """

    ends: Array
    volumes: Array
    matrices: Array
    modes: list[Array]


def propagators(
    stretches: Sequence[InitialValueProblem],
    length: float,
    options: SolverOptions,
    before: tuple[Array, Array] | None = None,
    method: str = METHOD,
) -> Propagators:
    """How every deviation crosses each of the stretches of ``length`` [s], which follow each other.

    ``before``: state and parameters at the end of the stretch that came before the first. Raises CaseError where a stretch cannot
    be crossed.
    """
    found = crossed(stretches, length, options, method)
    if stretches[0].switching is None:
        return found
    for k, stretch in enumerate(stretches):
        # An event near a joint may fall on one side of it in the motion and on the other in the stretch: take each just once.
        if k:
            before = found.ends[k - 1], found.modes[k - 1]
        if before is None:
            continue
        far = np.abs((before[0] - stretch.x0) / stretch.scale).max() > JUMP
        if far or not np.array_equal(before[1], stretch.p):
            again = crossed([replace(stretch, x0=before[0], p=before[1])], length, options, method)
            found.ends[k], found.volumes[k], found.matrices[k] = again.ends[0], again.volumes[0], again.matrices[0]
            found.modes[k] = again.modes[0]
    return found


def crossed(stretches: Sequence[InitialValueProblem], length: float, options: SolverOptions, method: str = METHOD) -> Propagators:
    """The propagators of stretches, each from its own start."""
    n = stretches[0].x0.size
    groups = -(-n // WIDEST)
    columns = -(-n // groups)
    unit = np.zeros((n, groups * columns))
    unit[:, :n] = np.eye(n)
    starts = np.split(unit, groups, axis=1)
    runs = complete_runs([with_tangents(stretch, start, length) for stretch in stretches for start in starts], options, method)
    found = [parts(stretches[job // groups], run.states[-1]) for job, run in enumerate(runs)]
    matrices = [np.hstack([each.tangents for each in found[job : job + groups]])[:, :n] for job in range(0, len(found), groups)]
    first = found[::groups]
    modes = [modes_at(each, run, run.times[-1:])[0] for each, run in zip(stretches, runs[::groups], strict=True)]
    states, volumes = np.array([each.state for each in first]), np.array([each.volume for each in first])
    return Propagators(states, volumes, np.array(matrices), modes)


def complete_runs(problems: Sequence[InitialValueProblem], options: SolverOptions, method: str = METHOD) -> Sequence[Trajectory]:
    """Run all problems to their ends. Raises CaseError for one that does not get there, or has events that set off each other."""
    runs = _runs(problems, options, method)
    for run in runs:
        if not run.outcome.is_good or not len(run.times):
            raise CaseError("variational equations", run.message, "start elsewhere, or change the tolerance")
    for problem, run in zip(problems, runs, strict=True):
        if run.events is not None and len(run.events):
            _refuse_chains(problem, run.events)
    return runs


def _refuse_chains(problem: InitialValueProblem, log: EventLog) -> None:
    """An event that sets off another whose guard lies beyond zero already: the jump of a deviation there is not that of either.

    Raises CaseError, unless nothing jumps at either.
    """
    switching = log.switching
    changing = np.array([_jumps(switching, each) for each in switching.crossings])
    for k in np.flatnonzero(np.diff(log.times) == 0) + 1:
        first, second = log.which[k - 1], log.which[k]
        if not (changing[first] or changing[second]):
            continue
        guard = float(np.asarray(switching.guards(log.times[k], log.states[k], problem.p)).ravel()[second])
        size = guard_floors(switching, problem, NEAR)[0][second]
        if abs(guard) > size:
            names = switching.crossings[first].name, switching.crossings[second].name
            found = f"{names[0]!r} sets off {names[1]!r}, which lies beyond zero already: how deviations jump there is not known"
            where = f"variational equations, t = {log.times[k] + problem.p[-1]:.6g} s"
            raise CaseError(where, found, "choose parameters that keep the two apart")


def _runs(problems: Sequence[InitialValueProblem], options: SolverOptions, method: str) -> Sequence[Trajectory]:
    """In lanes where there is a compiler, else one after the other."""
    if options.backend != "vm" and problems[0].rhs.is_a("SXFunction"):
        try:
            return solve_lanes(problems, options, method=method).trajectories
        except LoweringError:
            if options.backend == "c":
                raise
    return [solve(each, method, replace(options, backend="vm")) for each in problems]


def _jumps(switching: Switching, crossing: Crossing) -> bool:
    """Whether the state or its rate may jump at a crossing; a change of mode always resets deviations, if only to themselves."""
    if crossing.variable is None:
        return crossing.reset is not None
    return not switching.modes[crossing.variable].continuous
