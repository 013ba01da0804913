"""Question: where does the motion stand each time that a channel passes a level?

A Poincaré section by a surface, for a driveline of any clocks, or of none: ``sections`` strobes instead. The motion is sampled
densely, every change of sign is bracketed, and the crossing is closed in on by integrating from the sample before it, so points
are as exact as the integration.
Source: M. Henon, Physica D 5 (1982) 412-414, for the section as a point of the flow, not of an interpolation.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.sections import SectionResult, section_channels
from modelgen.analysis.sections_motion import motion_of, vibrating_states
from modelgen.analysis.strobes import Patience
from modelgen.analysis.strobes_recurrence import nearest_return, recurrence
from modelgen.analysis.strobes_runs import Setting, compiled_model, options_of, restarted, run_one, setting
from modelgen.errors import CaseError
from modelgen.solvers.case import Case
from modelgen.solvers.outcome import Outcome

Array = NDArray[np.float64]
CHUNK = 4096  # samples that are held at once
NEWTON = 6
EXACT = 1e-12  # of the channel's size: a level that is met


def surface_section(
    case: Case,
    surface: tuple[str, float],
    channels: Sequence[str] | None = None,
    *,
    direction: int = 1,
    count: int = 150,
) -> SectionResult:
    """Points where a channel passes a level, ``surface`` = (channel, level in its unit), upward (+1), downward (-1) or both (0).

    The case says from when on points count (``record_from``) and how long is looked for them (``end``); its ``samples`` are those
    of the search over that time, and must resolve the fastest vibration. Raises CaseError where fewer than 2 points are found.
    """
    model = compiled_model(case, "section")
    if not isinstance(surface, tuple) or len(surface) != 2:
        raise CaseError("section, surface", f"is {surface!r:.40}", "give (channel, level)")
    guard, level = section_channels(model, [surface[0]])[0], float(surface[1])
    if direction not in (-1, 0, 1):
        raise CaseError("section, direction", f"is {direction!r}", "give 1 (upward), -1 (downward) or 0 (both)")
    patience, names, made = Patience(count), section_channels(model, channels), setting(case)
    times, states, outcome, message = _crossings(case, made, guard, level, direction, count)
    if len(times) < 2:
        ways = {1: "upward", -1: "downward", 0: "in either direction"}
        found = f"passes {level:.6g} {model.unit(guard)} {ways[direction]} {len(times)} times up to {case.end:g} s"
        raise CaseError(f"section, channel {guard!r}", found, "choose a level within its range, or a later end")
    values, rates = motion_of(model, times, states, made.point.p, names)
    kept, still = vibrating_states(model, made.point), patience.within(case.tolerance)
    sequence = states[:, kept] / made.problem.scale[kept]
    back = recurrence(sequence, still)
    settled = back.period > 0 and back.first == 0
    inside = np.linspace(times[0], times[-1], CHUNK)
    orbit = run_one(case, restarted(made.problem, states[0], inside, float(times[0])), options_of(case))
    orbit_values, orbit_rates = motion_of(model, orbit.times, orbit.states, made.point.p, names)
    return SectionResult(
        model=model.name,
        parameters={name: float(model.parameters.value(made.point.p, name)) for name in case.parameters},
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
        outcome=outcome,
        message=message,
    )


def _crossings(
    case: Case, made: Setting, guard: str, level: float, direction: int, count: int
) -> tuple[Array, Array, Outcome, str]:
    """Times and states of the first ``count`` crossings after ``record_from``."""
    options, problem = options_of(case), made.problem
    grid = case.times()
    found: list[tuple[float, Array]] = []
    begin, state = problem.t0, problem.x0
    outcome, message = Outcome.SUCCESS, ""
    for first in range(0, len(grid), CHUNK):
        times = grid[first : first + CHUNK]
        # The last sample again, so that nothing between two chunks is missed.
        times = np.concatenate([[begin], times]) if first else times
        run = run_one(case, restarted(problem, state, times, begin), options)
        outcome, message = run.outcome, run.message
        if not len(run.times):
            break
        found += _in_chunk(case, made, run.times, run.states, guard, level, direction)
        begin, state = float(run.times[-1]), run.states[-1].copy()
        if len(found) >= count or not outcome.is_good:
            break
    times = np.array([each for each, _ in found[:count]])
    return times, np.array([each for _, each in found[:count]]).reshape(len(times), len(problem.x0)), outcome, message


def _in_chunk(
    case: Case, made: Setting, times: Array, states: Array, guard: str, level: float, direction: int
) -> list[tuple[float, Array]]:
    model, p = case.model, made.point.p
    values = motion_of(model, times, states, p, [guard])[0][:, 0]
    above = values - level > 0
    turns = np.flatnonzero(above[1:] != above[:-1])
    size, options = max(float(np.ptp(values)), abs(level), 1e-300), options_of(case)
    found = []
    for k in turns[(direction == 0) | (above[turns + 1] == (direction > 0))]:
        low, high = float(times[k]), float(times[k + 1])
        # Secant, then Newton from the flow itself, kept in the bracket.
        t = low + (high - low) * (level - values[k]) / (values[k + 1] - values[k])
        state = states[k]
        for _ in range(NEWTON):
            if not low < t < high:
                break
            state = run_one(case, restarted(made.problem, states[k], np.array([t]), low), options).states[-1]
            value, rate = (float(each[0, 0]) for each in motion_of(model, np.array([t]), state[None], p, [guard]))
            if abs(value - level) <= EXACT * size or rate == 0:
                break
            t = float(np.clip(t - (value - level) / rate, low, high))
        found.append((t, state))
    return found
