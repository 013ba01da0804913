"""simulate(case): from a case to a solution, whatever the solver. The floor's main sentence.

``Compiled + Case -> Solution``. The rigid angle that no law sees is integrated from zero and added back, so a driveline that has
turned a million radians vibrates exactly like one that has not.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from modelgen.errors import CaseError, refuse_unless
from modelgen.lowering.switched import SwitchedModel
from modelgen.solvers.bound_model import operating_point
from modelgen.solvers.case import Case
from modelgen.solvers.equilibrium import Array
from modelgen.solvers.first_modes import with_first_modes
from modelgen.solvers.guards import guard_floors
from modelgen.solvers.operating_point import OperatingPoint
from modelgen.solvers.problem import InitialValueProblem
from modelgen.solvers.recording import check_memory, recorded
from modelgen.solvers.registry import every_solver, solve, solver_options
from modelgen.solvers.scales import state_scales
from modelgen.solvers.solution import Solution
from modelgen.solvers.start import starting_state


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
    refuse_unless(case, Case, "simulate")
    if case.model is None:
        raise CaseError("case", "has no compiled model", "a loaded case cites its model only; give it the driveline again")
    model = case.model
    began = time.perf_counter()
    names = model.outputs if case.channels is None else case.channels
    check_memory(case.samples, len(model.states) + len(names))
    point = operating_point(model, case.parameters, must_rest=case.start == "static")
    options = solver_options(case.tolerance, case.options)
    problem, offset = initial_value_problem(case, point)
    trajectory = solve(problem, case.solver, options)
    states, events = trajectory.states + offset, trajectory.events
    switched = model.switched(case.sections) if problem.switching is not None else None
    if switched is None or events is None:

        def channels(part: slice) -> dict[str, Array]:
            return model.channels(trajectory.times[part], states[part], point.p, case.channels)

    else:
        modes = events.modes(trajectory.times)

        def channels(part: slice) -> dict[str, Array]:
            return switched.channels(trajectory.times[part], states[part], modes[part], point.p, case.channels)

        events = replace(events, states=events.states + offset)
    found = recorded(trajectory, states, names, channels, began, options.budget.max_seconds)
    units = {name: model.unit(name) for name in names}
    units.update({state.name: state.unit for state in model.equations.states})
    return Solution(
        case=case,
        times=found.times,
        states=found.states,
        state_names=model.states,
        channels=found.channels,
        units=units,
        outcome=found.outcome,
        message=found.message,
        statistics=trajectory.statistics,
        events=events,
    )


def initial_value_problem(case: Case, point: OperatingPoint) -> tuple[InitialValueProblem, Array]:
    """What a solver sees of a case, and what to add to its states: the neutral rigid angles are taken out.

    (Not where sections are asked for: a channel on which one lies may show these angles.)
    """
    model = case.model
    start = starting_state(model, point, case.start, case.begin)
    offset = np.zeros_like(start)
    if not case.sections:
        rigid = list(model.equations.rigid)
        offset[rigid] = start[rigid]
        start = start - offset
    switched = events_of(case)
    rhs, p = (model.rhs_function, point.p) if switched is None else (switched.rhs_function, switched.extended(point.p))
    switching = None if switched is None else switched.switching
    scales = state_scales(model, point, start)
    problem = with_first_modes(InitialValueProblem(rhs, model.states, start, p, scales, case.begin, case.times(), switching))
    _refuse_beyond_barriers(problem, f"case of {model.name!r}, start")
    return problem, offset


def _refuse_beyond_barriers(problem: InitialValueProblem, where: str) -> None:
    """Raises CaseError where a run would start behind a guard that has nothing behind it."""
    switching = problem.switching
    if switching is None or not any(each.barrier for each in switching.crossings):
        return
    values = np.asarray(switching.guards(problem.t0, problem.x0, problem.p)).ravel()
    rounding = guard_floors(switching, problem, tolerance=0.0)[1]
    for crossing, value, zero in zip(switching.crossings, values.tolist(), rounding.tolist(), strict=True):
        if crossing.barrier and (beyond := crossing.direction * value) > zero:
            raise CaseError(where, f"lies {beyond:.6g} beyond {crossing.name!r}", "start on the near side of it")


def events_of(case: Case) -> SwitchedModel | None:
    """The model with its modes as flags where the case is run with events; None where its modes are found by comparison.

    "auto" locates events where a law jumps or has memory, and where sections are asked for. Raises CaseError for events that
    cannot be left out: switched off, or by a solver that does not locate them.
    """
    model, wanted = case.model, solver_options(case.tolerance, case.options).events
    switched = model.switched(case.sections)
    if switched is None:
        return None
    where = f"case of {model.name!r}"
    able = [name for name, each in every_solver().items() if each.locates_events]
    needed = "which the sections of the case need" if case.sections else ""
    if switched.switching.required:
        needed = "which the model needs (modes with memory, jumps of the state or stops)"
    if needed and wanted == "off":
        raise CaseError(where, f"has events switched off, {needed}", 'leave events "auto"')
    if case.solver not in able:
        if needed or wanted == "on":
            found = f"solver '{case.solver}' does not locate events{needed and ', ' + needed}"
            raise CaseError(where, found, f"take {', '.join(able)}")
        return None
    return switched if wanted == "on" or (wanted == "auto" and (needed or switched.switching.jumps)) else None


