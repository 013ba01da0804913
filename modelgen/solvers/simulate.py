"""simulate(case): from a case to a solution, whatever the solver. The floor's main sentence.

``Compiled + Case -> Solution``. The rigid angle that no law sees is integrated from zero and added back, so a driveline that has
turned a million radians vibrates exactly like one that has not.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from modelgen.errors import CaseError, nearest
from modelgen.lowering import Compiled
from modelgen.solvers.case import Case
from modelgen.solvers.equilibrium import Array
from modelgen.solvers.operating_point import OperatingPoint, operating_point
from modelgen.solvers.problem import InitialValueProblem, SolverOptions
from modelgen.solvers.registry import solve
from modelgen.solvers.scales import state_scales
from modelgen.solvers.solution import Solution

_OPTIONS = tuple(name for name in SolverOptions.__dataclass_fields__ if name != "tolerance")


def simulate(case: Case) -> Solution:
    """Runs a case. A run that fails is a solution with a named outcome and what was computed until then.

    Raises CaseError, ModelError or BalanceError for a case that cannot be started.

    >>> from modelgen import Driveline, Inertia, Shaft
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])
    >>> solution = simulate(Case(line, end=0.1, start={"shaft.twist": 0.01}))
    >>> round(float(solution["shaft.torque"].max()), 6)
    100.0
    """
    if case.model is None:
        raise CaseError("case", "has no compiled model", "a loaded case cites its model only; give it the driveline again")
    point = operating_point(case.model, case.parameters)
    problem, offset = initial_value_problem(case, point)
    trajectory = solve(problem, case.solver, solver_options(case.tolerance, case.options))
    states = trajectory.states + offset
    model = case.model
    channels = model.channels(trajectory.times, states, point.p, case.channels)
    units = {name: model.unit(name) for name in channels}
    units.update({state.name: state.unit for state in model.equations.states})
    return Solution(
        case=case,
        times=trajectory.times,
        states=states,
        state_names=model.states,
        channels=channels,
        units=units,
        outcome=trajectory.outcome,
        message=trajectory.message,
        statistics=trajectory.statistics,
    )


def initial_value_problem(case: Case, point: OperatingPoint) -> tuple[InitialValueProblem, Array]:
    """What a solver sees of a case, and what to add to its states: the neutral rigid angles are taken out."""
    model = case.model
    start = starting_state(model, point, case.start)
    offset = np.zeros_like(start)
    rigid = list(model.equations.rigid)
    offset[rigid] = start[rigid]
    start = start - offset
    problem = InitialValueProblem(
        model.rhs_function, model.states, start, point.p, state_scales(model, point, start), case.begin, case.times()
    )
    return problem, offset


def starting_state(model: Compiled, point: OperatingPoint, start: str | Mapping[str, float]) -> Array:
    """The state that a run starts from."""
    if isinstance(start, str):
        own = [state.start if state.kind == "own" else 0.0 for state in model.equations.states]
        return point.start.copy() if start == "static" else np.array(own)
    state = point.start.copy()
    for name, value in start.items():
        state[model.state_index(name)] = float(value)
    return state


def solver_options(tolerance: float, options: Mapping[str, Any]) -> SolverOptions:
    """Options of a solver from plain names; an unknown one is refused with the nearest."""
    for name in options:
        if name not in _OPTIONS:
            raise CaseError("case, options", f"has {name!r}", nearest(name, _OPTIONS))
    return SolverOptions(tolerance=tolerance, **options)
