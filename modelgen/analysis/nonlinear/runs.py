"""Many runs of one model as fast as the machine can: in lanes of generated C, or one after the other where there is no compiler.

Below ``strobes``, ``maps`` and ``frequency_sweep``: the one place where nonlinear questions meet the solvers.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError, LoweringError
from modelgen.lowering import Compiled
from modelgen.solvers.bound_model import operating_point
from modelgen.solvers.case import Case
from modelgen.solvers.gather import Gather
from modelgen.solvers.lanes import solve_lanes
from modelgen.solvers.operating_point import OperatingPoint
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.registry import solve, solver_named, solver_options
from modelgen.solvers.simulate import initial_value_problem

Array = NDArray[np.float64]
Values = dict[str, Any]
Also = Callable[[float], Values]
"""What else changes with a swept value: further parameters by name, such as a mesh damping that follows the shafts'."""


@dataclass(frozen=True, eq=False)
class Setting:
    """One set of parameters of a case: the case, its operating point, and the problem from its start."""

    case: Case
    point: OperatingPoint
    problem: InitialValueProblem


def setting(case: Case, **changes: Any) -> Setting:
    """A case with some parameters changed by name, ready to run. Raises what ``simulate`` raises before it starts."""
    case = case.change(parameters={**case.parameters, **changes})
    point = operating_point(case.model, case.parameters)
    return Setting(case, point, initial_value_problem(case, point)[0])


def parameter_values(model: Compiled, name: str, values: Sequence[Any], question: str) -> list[float]:
    """Values of a single-number parameter in its SI unit, from numbers or texts with units, in the order given.

    Raises NamingError for an unknown name, CaseError for a series or for no values, ModelError for an unlawful value.
    """
    where = f"{question}, {name!r}"
    listed = list(values) if not isinstance(values, str) else [values]
    if not listed:
        raise CaseError(where, "there are no values", "give at least one")
    model.parameters.unit_of_number(name, f"{question},")
    return [model.parameters.value(model.parameters.unbalanced({name: each}), name) for each in listed]


def options_of(case: Case) -> SolverOptions:
    """The solver options of a case; many runs take generated C unless the case says otherwise."""
    given = dict(case.options)
    if case.solver == "rk4" and "fixed_step" not in given and "rule" not in given:
        given.setdefault("backend", "auto")
    return solver_options(case.tolerance, given)


def run_all(case: Case, problems: Sequence[InitialValueProblem], options: SolverOptions) -> list[Trajectory]:
    """The trajectories of many problems of one model with equally many output times; a failed run is one with its outcome."""
    solver_named(case.solver)
    if case.solver == "rk4" and options.backend != "vm":
        try:
            return list(solve_lanes(problems, options).trajectories)
        except LoweringError:
            if options.backend == "c":
                raise
    return [solve(problem, case.solver, options) for problem in problems]


def run_channels(
    case: Case, problems: Sequence[InitialValueProblem], options: SolverOptions, names: Sequence[str]
) -> list[tuple[Trajectory, Array]]:
    """Like ``run_all``, with output channels (instants, channels) of each run at its output times, found in C where that runs."""
    solver_named(case.solver)
    rows = tuple(case.model.output_index(name) for name in names)
    if rows and case.solver == "rk4" and options.backend != "vm":
        observed = Gather(channels=_observed(case.model, rows, problems[0].p.size), keep=True)
        try:
            lanes = solve_lanes(problems, options, gather=observed)
        except LoweringError:
            if options.backend == "c":
                raise
        else:
            assert lanes.channels is not None
            return [(run, lanes.channels[k, : len(run.times)]) for k, run in enumerate(lanes.trajectories)]
    runs, size, found = run_all(case, problems, options), case.model.parameters.size, []
    for problem, run in zip(problems, runs, strict=True):
        values = case.model.channels(run.times, run.states, problem.p[:size], names)
        found.append((run, np.array([values[name] for name in names]).reshape(len(names), len(run.times)).T))
    return found


@functools.lru_cache(maxsize=16)
def _observed(model: Compiled, rows: tuple[int, ...], parameters: int) -> ca.Function:
    """(t, x, p) -> some channels, of a parameter vector at whose tail stand the flags of modes."""
    e = model.expressions
    tail = ca.SX.sym("tail", parameters - model.parameters.size)
    channels = ca.densify(e["outputs"][list(rows)])
    return ca.Function("observed", [e["t"], e["x"], ca.vertcat(e["p"], tail)], [channels], ["t", "x", "p"], ["channels"])


def run_one(case: Case, problem: InitialValueProblem, options: SolverOptions) -> Trajectory:
    """One trajectory."""
    return run_all(case, [problem], options)[0]


def restarted(
    problem: InitialValueProblem, state: Array, times: Array, t0: float | None = None, before: Trajectory | None = None
) -> InitialValueProblem:
    """The same problem from another state, at other output times, from its own t0 on or another.

    ``before``: the run that ended in this state, whose modes hold on.
    """
    p = problem.p
    if before is not None and before.events is not None and problem.switching is not None and len(before.times):
        p = np.array(problem.p)
        held = before.events.modes(before.times[-1:])[-1]
        for mode, value in zip(problem.switching.modes, held, strict=True):
            mode.put(p, int(value))
    return replace(problem, x0=state, p=p, times=times, t0=problem.t0 if t0 is None else t0)
