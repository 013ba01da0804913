"""Question: where does the motion stand each time that a channel passes a level?

A Poincaré section by a surface, for a driveline of any clocks, or of none: ``sections`` strobes instead. The surface is a guard
of the run, so every crossing is located on the dense output to some ulp of time, however close two of them are; no grid of
samples has to resolve them.
Source: F. C. Moon, Chaotic Vibrations (1987), ch. 2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.nonlinear.motion import motion_of, vibrating_states
from modelgen.analysis.nonlinear.recurrence import nearest_return, recurrence
from modelgen.analysis.nonlinear.runs import Setting, options_of, restarted, run_one, setting
from modelgen.analysis.nonlinear.sections import SectionResult, section_channels
from modelgen.analysis.nonlinear.strobes import Patience
from modelgen.errors import CaseError
from modelgen.lowering import Section
from modelgen.solvers.asked_case import asked_case
from modelgen.solvers.problem import Trajectory

Array = NDArray[np.float64]
DRAWN = 4096  # samples of the motion between the first point and the last
WAYS = {1: "upward", -1: "downward", 0: "in either direction"}


def surface_section(
    case: Any,
    surface: tuple[str, float],
    channels: Sequence[str] | None = None,
    *,
    direction: int = 1,
    count: int = 150,
) -> SectionResult:
    """Points where a channel passes a level, ``surface`` = (channel, level in its unit), upward (+1), downward (-1) or both (0).

    The case says from when on points count (``record_from``) and how long is looked for them (``end``); its samples are not used.
    The first ``count`` points are kept. Raises CaseError where fewer than 2 points are found, and for a solver without events.
    """
    case = asked_case(case, "section")
    model = case.model
    if not isinstance(surface, tuple) or len(surface) != 2:
        raise CaseError("section, surface", f"is {surface!r:.40}", "give (channel, level)")
    guard, level = section_channels(model, [surface[0]])[0], _level(surface[1])
    if isinstance(direction, bool) or direction not in WAYS:
        raise CaseError("section, direction", f"is {direction!r}", "give 1 (upward), -1 (downward) or 0 (both)")
    patience, names = Patience(count), section_channels(model, channels)
    made = setting(case.change(sections=(*case.sections, Section(guard, level, direction))))
    first = float(case.record_from or 0.0)
    run = _run(made, np.array([first, case.end]))
    times, states = _points(run, first, count)
    if len(times) < 2:
        found = f"passes {level:.6g} {model.unit(guard)} {WAYS[direction]} {len(times)} times up to {case.end:g} s"
        if not run.outcome.is_good:
            raise CaseError(f"section, channel {guard!r}", f"{found}: {run.message}", "mend what stopped the run")
        raise CaseError(f"section, channel {guard!r}", found, "choose a level within its range, or a later end")
    p = made.point.p
    values, rates = motion_of(model, times, states, p, names)
    kept, still = vibrating_states(model, made.point), patience.within(case.tolerance)
    sequence = states[:, kept] / made.problem.scale[kept]
    back = recurrence(sequence, still)
    settled = back.period > 0 and back.first == 0
    orbit = _run(made, np.linspace(times[0], times[-1], DRAWN))
    orbit_values, orbit_rates = motion_of(model, orbit.times, orbit.states, p, names)
    return SectionResult(
        model=model.name,
        parameters={name: float(model.parameters.value(p, name)) for name in case.parameters},
        section=f"surface {guard} = {level:.6g} {model.unit(guard)}",
        channels=names,
        units=tuple(model.unit(name) for name in names),
        times=times,
        values=values,
        rates=rates,
        orbit_values=orbit_values,
        orbit_rates=orbit_rates,
        orbit_periods=0,
        sequence=sequence,
        complete=True,
        transient=0,
        period=back.period if settled else 0,
        residual=back.residual if settled else nearest_return(sequence),
        still=still,
        settled=settled,
        outcome=run.outcome,
        message=run.message,
    )


def _level(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not math.isfinite(value):
        raise CaseError("section, surface", f"has the level {value!r:.40}", "give a finite number in the unit of the channel")
    return float(value)


def _run(made: Setting, times: Array) -> Trajectory:
    """The motion from the start of the case, without the turning that a free driveline begins with."""
    state = np.array(made.problem.x0)
    state[list(made.case.model.equations.rigid)] = 0.0
    return run_one(made.case, restarted(made.problem, state, times), options_of(made.case))


def _points(run: Trajectory, first: float, count: int) -> tuple[Array, Array]:
    """Times and states of the first crossings of the surface, which is the last of all guards, from ``first`` on."""
    assert run.events is not None
    last = len(run.events.switching.crossings) - 1
    taken = np.flatnonzero((run.events.which == last) & (run.events.times >= first))[:count]
    return run.events.times[taken], run.events.states[taken]
