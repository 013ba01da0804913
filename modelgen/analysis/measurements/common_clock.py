"""One clock for a measurement and a run: which base frequency they share, which shift lays one over the other, which window.

Below ``compare``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.measurements.measurement import FEWEST, Measurement
from modelgen.analysis.measurements.signals import best_shift, correlation, interpolant
from modelgen.errors import CaseError, nearest
from modelgen.model.values import plain_number
from modelgen.solvers.crosscheck import without_line
from modelgen.solvers.solution import Solution
from modelgen.units import finite

Array = NDArray[np.float64]


def treatment(unit: str) -> str:
    """In words, what is taken out of a signal in this unit before it is compared."""
    return "best straight line taken out" if unit == "rad" else "as it is"


def treated(unit: str, times: Array, values: Array) -> Array:
    """A signal as it is compared: an angle without its best straight line, anything else as it is."""
    return without_line(times, values) if unit == "rad" else values


def base_frequency(solution: Solution, base: str | float | None) -> tuple[str, float]:
    """Name and value [Hz] of the base frequency; 0 where the model is unknown or has none and no value is given."""
    where = "comparison, base"
    if base is not None and not isinstance(base, str):
        value = finite(plain_number(base, where, "Hz"), where)
        if value <= 0:
            raise CaseError(where, f"is {value:g} Hz", "give a positive frequency")
        return f"{value:g} Hz", value
    model = solution.case.model
    if model is None:
        if base is not None:
            raise CaseError(where, f"is {base!r}, but a loaded solution does not know its model", "give the base frequency in Hz")
        return "", 0.0
    p = model.parameters.unbalanced(solution.case.parameters)
    values = model.mean_model.frequencies_at(p) / (2 * np.pi)
    known = {clock.name: float(value) for clock, value in zip(model.equations.clocks, values, strict=True) if value > 0}
    if base is not None:
        if base not in known:
            raise CaseError(where, f"there is no base frequency {base!r}", nearest(base, known))
        return base, known[base]
    return min(known.items(), key=lambda item: item[1]) if known else ("", 0.0)


def reference_turns(solution: Solution) -> float:
    """Turns per second of the reference shaft at the operating speed; 0 where none is known."""
    model = solution.case.model
    if model is None or model.equations.speed is None:
        return 0.0
    return model.parameters.value(model.parameters.unbalanced(solution.case.parameters), "speed") / (2 * np.pi)


def shaft_speed(solution: Solution, shaft: str | None, data: Measurement) -> float:
    """Mean speed [rad/s] of the shaft whose angle the measurement counts."""
    model = solution.case.model
    if model is None or model.equations.speed is None:
        what = "is over an angle, but the solution knows no operating speed"
        raise CaseError(data.source, what, "give the measurement over time, or the driveline a speed")
    eq, p = model.equations, model.parameters.unbalanced(solution.case.parameters)
    nodes = {instance.name: next(iter(instance.nodes.values())) for instance in eq.instances if len(instance.nodes) == 1}
    shaft = shaft or eq.reference or eq.groups[0]
    if shaft not in nodes:
        raise CaseError("comparison, shaft", f"there is no {shaft!r}", nearest(shaft, nodes))
    of_groups, of_nodes = model.mean_model.ratios_at(p).speed, model.mean_model.nodes_at(p)
    return float(of_nodes[nodes[shaft]] @ of_groups)


def aligned(
    solution: Solution, data: Measurement, times: Array, pairs: list[tuple[str, str]], start: float, reach: float, free: bool
) -> float:
    """The shift of the measured clock that lays all channels best over the computed ones."""
    first, last = float(solution.times[0]), float(solution.times[-1])
    if free and (times[-1] + start < first + 2 * reach or times[0] + start > last - 2 * reach):
        start = first - times[0] + reach
    if reach <= 0:
        raise CaseError("comparison, longest_lag", f"is {reach:g} s", "give a positive time")
    # Samples that the solution covers at every lag, so that all lags are judged by the same ones.
    kept = (times + start - reach >= first) & (times + start + reach <= last)
    if np.count_nonzero(kept) < FEWEST:
        what = f"cover {first:.6g} to {last:.6g} s and {times[0]:.6g} to {times[-1]:.6g} s, too little for a lag of {reach:.4g} s"
        raise CaseError("comparison", f"solution and measurement {what}", "record longer, or give a shorter longest_lag")
    clock = times[kept]
    signals = []
    for channel, column in pairs:
        unit = solution.unit(channel)
        computed = interpolant(solution.times, treated(unit, solution.times, solution[channel]))
        signals.append((computed, treated(unit, clock, data.channels[column][kept])))

    def score(shift: float) -> float:
        return sum(correlation(measured, computed(clock + shift)) for computed, measured in signals)

    step = min(float(np.median(np.diff(times))), float(np.median(np.diff(solution.times))))
    return best_shift(score, start - reach, start + reach, step)


def common_window(solution: Solution, data: Measurement, clock: Array, frequency: float) -> tuple[tuple[float, float], bool]:
    """The common span, cut to its last whole periods where there is at least one; and whether there is."""
    first, last = max(float(solution.times[0]), float(clock[0])), min(float(solution.times[-1]), float(clock[-1]))
    inside = [np.count_nonzero((each >= first) & (each <= last)) for each in (solution.times, clock)]
    if last <= first or min(inside) < FEWEST:
        what = f"the solution covers {solution.times[0]:.6g} to {solution.times[-1]:.6g} s"
        what += f", the measurement {clock[0]:.6g} to {clock[-1]:.6g} s: too little in common"
        raise CaseError(data.source, what, "set start (time of the solution at the measured zero), or align=True")
    periods = int((last - first) * frequency + 1e-9)
    return ((last - periods / frequency, last), True) if periods else ((first, last), False)
