"""Question: how does a measured channel lie over the computed one: peaks, half peak to peak, and orders with their phases?

A measurement (``measurement``) against a ``Solution``. Angles are compared without their best straight line, as a torsiograph
reads them; torques and everything else as they are. Amplitudes and phases follow x = sum |X_h| cos(2 pi h f t + arg X_h), with
t on the clock of the solution, on which every base frequency stands at zero at t = 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.excitation import exact_multiple
from modelgen.analysis.linear.orders import order_name
from modelgen.analysis.measurements.common_clock import (
    aligned,
    base_frequency,
    common_window,
    reference_turns,
    shaft_speed,
    treated,
    treatment,
)
from modelgen.analysis.measurements.measurement import FEWEST, Measurement, read_measurement
from modelgen.analysis.measurements.signals import correlation, interpolant, order_amplitudes
from modelgen.errors import CaseError, nearest
from modelgen.model.values import plain_number
from modelgen.solvers.solution import Solution
from modelgen.units import finite

Array = NDArray[np.float64]
DEFAULT_ORDERS = 12
NEGLIGIBLE = 1e-6  # of the largest order: below it a phase means nothing


@dataclass(frozen=True)
class Extent:
    """Size of a signal in its window: largest absolute value, half peak to peak, mean and root mean square about the mean."""

    peak: float
    half_pp: float
    mean: float
    rms: float


@dataclass(frozen=True)
class OrderDifference:
    """Amplitudes at ``order`` times the base frequency [Hz]; differences are simulated less measured.

    ``per_turn``: the order per turn of the reference shaft, None where the model has no operating speed; ``name``: in words.
    Phases [rad]; ``phase_difference`` is None where either amplitude is negligible.
    """

    order: int
    frequency: float
    measured: float
    simulated: float
    difference: float
    measured_phase: float
    simulated_phase: float
    phase_difference: float | None
    per_turn: float | None = None
    name: str = ""


@dataclass(frozen=True, eq=False)
class ChannelComparison:
    """One measured column over one channel, both in ``unit``, over the common window.

    ``times`` [s] are the measured samples on the clock of the solution, with ``measured`` and ``simulated`` (resampled there);
    the extents are those of the signals on their own samples. ``treatment`` says what was taken out of both.
    """

    channel: str
    column: str
    unit: str
    treatment: str
    times: Array
    measured: Array
    simulated: Array
    measured_extent: Extent
    simulated_extent: Extent
    rms_difference: float
    correlation: float
    orders: tuple[OrderDifference, ...]

    @property
    def peak_difference(self) -> float:
        """Peak of the simulated less that of the measured signal."""
        return self.simulated_extent.peak - self.measured_extent.peak

    @property
    def half_pp_difference(self) -> float:
        """Half peak to peak of the simulated less that of the measured signal."""
        return self.simulated_extent.half_pp - self.measured_extent.half_pp

    def __str__(self) -> str:
        m, s, unit = self.measured_extent, self.simulated_extent, self.unit
        rows = [
            f"{self.channel} over {self.column!r} ({self.treatment}), correlation {self.correlation:.4f}",
            f"  peak          {_both(m.peak, s.peak, unit)}",
            f"  half p-p      {_both(m.half_pp, s.half_pp, unit)}",
        ]
        width = max((len(each.name) for each in self.orders), default=0)
        for each in self.orders:
            if each.phase_difference is None:
                found = f"negligible in one of them: measured {each.measured:.3g}, simulated {each.simulated:.3g} {unit}"
            else:
                found = f"{_both(each.measured, each.simulated, unit)}, phase {np.degrees(each.phase_difference):+.1f} deg"
            rows.append(f"  {each.name:<{width}} {each.frequency:8.3f} Hz: {found}")
        return "\n".join(rows)


@dataclass(frozen=True, eq=False)
class ComparisonResult:
    """A measurement over a solution. ``window`` [s] on the solution's clock; ``shift`` [s] was added to the measured clock.

    ``base`` names the base frequency, ``frequency`` [Hz] is its value (0 where none is known, and then there are no orders).
    """

    model: str
    source: str
    base: str
    frequency: float
    window: tuple[float, float]
    shift: float
    aligned: bool
    channels: tuple[ChannelComparison, ...]
    remarks: tuple[str, ...] = ()

    def __str__(self) -> str:
        how = "best lag" if self.aligned else "clocks as given"
        span = f"{self.window[0]:.6g} to {self.window[1]:.6g} s"
        head = f"{self.source} over {self.model!r}, {span}, shifted by {self.shift:.6g} s ({how})"
        return "\n".join([head, *map(str, self.channels), *self.remarks])


def compare(
    solution: Solution,
    measurement: Measurement | str | Path,
    channels: Mapping[str, str] | None = None,
    *,
    base: str | float | None = None,
    orders: Iterable[int] | None = None,
    start: float | None = None,
    align: bool = False,
    longest_lag: float | None = None,
    shaft: str | None = None,
) -> ComparisonResult:
    """A measurement laid over a solution.

    ``channels`` pairs channels of the solution with measured columns; without it, columns are named like their channels.
    ``base``: a base frequency by name, or in Hz; the slowest one of the model if left out. ``orders``: whole multiples of it.
    ``start`` [s]: time of the solution at which the measured clock stands at zero. ``align``: look for the best lag, up to
    ``longest_lag`` [s] (half a period of the base if left out) to either side; clocks that do not meet are first put together.
    ``shaft``: whose angle a measurement over angle counts (the reference shaft if left out), at its mean speed.

    Raises CaseError or UnitError for channels, units and spans that do not go together.
    """
    data = measurement if isinstance(measurement, Measurement) else read_measurement(measurement)
    pairs = _pairs(solution, data, channels)
    name, frequency = base_frequency(solution, base)
    times = data.abscissa if data.kind == "time" else data.abscissa / shaft_speed(solution, shaft, data)
    if len(solution.times) < FEWEST:
        raise CaseError(f"solution of {solution.model_name!r}", f"has {len(solution.times)} samples", f"record {FEWEST} or more")
    remarks = [] if solution.succeeded else [f"the run did not reach its end: {solution.message}"]
    shift = 0.0 if start is None else finite(plain_number(start, "comparison, start", "s"), "comparison, start")
    if align:
        if longest_lag is None and not frequency:
            raise CaseError("comparison", "no base frequency bounds the lag", "give longest_lag in seconds, or base in Hz")
        where = "comparison, longest_lag"
        reach = 0.5 / frequency if longest_lag is None else finite(plain_number(longest_lag, where, "s"), where)
        shift = aligned(solution, data, times, pairs, shift, reach, start is None)
        remarks.append("of lags that differ by whole periods of the signals one is as good as another")
    window, covered = common_window(solution, data, times + shift, frequency)
    wanted: tuple[int, ...] = ()
    highest = 0
    if frequency and covered:
        wanted, highest = _orders(orders, frequency, solution, times, window)
    elif orders is not None or base is not None:
        what = "is known" if not frequency else f"fits into the common span {window[0]:.6g} to {window[1]:.6g} s"
        raise CaseError("comparison, orders", f"no period of a base frequency {what}", "give base in Hz, or longer signals")
    else:
        remarks.append("no orders: no base frequency is known, or the common span is shorter than its period")
    turns = reference_turns(solution)
    told = [told_order(order, name, frequency, turns) for order in wanted]
    found = [_channel(solution, data, times + shift, window, pair, frequency, wanted, highest) for pair in pairs]
    found = [
        replace(each, orders=tuple(replace(o, per_turn=t[0], name=t[1]) for o, t in zip(each.orders, told, strict=True)))
        for each in found
    ]
    return ComparisonResult(solution.model_name, data.source, name, frequency, window, shift, align, tuple(found), tuple(remarks))


def _pairs(solution: Solution, data: Measurement, channels: Mapping[str, str] | None) -> list[tuple[str, str]]:
    if channels is None:
        known = [*solution.channels, *solution.state_names]
        for column in data.channels:
            if column not in known:
                remedy = f'{nearest(column, known)}; pair them with channels={{"channel": "column"}}'
                raise CaseError(f"{data.source}, column {column!r}", "is no channel of the solution", remedy)
        channels = {column: column for column in data.channels}
    if not channels:
        raise CaseError("comparison, channels", "are none", 'pair them as {"channel": "column"}')
    for channel, column in channels.items():
        data.channel(column, solution.unit(channel), channel)
    return list(channels.items())


def _orders(
    orders: Iterable[int] | None, frequency: float, solution: Solution, times: Array, window: tuple[float, float]
) -> tuple[tuple[int, ...], int]:
    """The orders to look at, whole and slow enough for the samples of both; and up to which one they are fitted together."""
    sampling = max(float(np.median(np.diff(each))) for each in (times, solution.times))
    fewest = int((window[1] - window[0]) / sampling) // 2 - 2
    highest = min(int(0.5 / sampling / frequency * (1 - 1e-9)), fewest)
    if orders is None:
        return tuple(range(1, min(DEFAULT_ORDERS, highest) + 1)), min(DEFAULT_ORDERS, highest)
    wanted = tuple(orders)
    for order in wanted:
        if isinstance(order, bool) or not isinstance(order, (int, np.integer)) or order < 1:
            advice = "give whole numbers from 1 up; take a slower base for half orders"
            raise CaseError("comparison, orders", f"hold {order!r}", advice)
        if order > highest:
            seen = f"samples {sampling:.4g} s apart over the common span see up to order {highest}"
            raise CaseError("comparison, orders", f"order {order} is {order * frequency:.6g} Hz, {seen}", "sample faster")
    return tuple(int(order) for order in wanted), min(max((DEFAULT_ORDERS, *wanted)), highest)


def _channel(
    solution: Solution,
    data: Measurement,
    clock: Array,
    window: tuple[float, float],
    pair: tuple[str, str],
    frequency: float,
    orders: tuple[int, ...],
    highest: int,
) -> ChannelComparison:
    channel, column = pair
    unit = solution.unit(channel)
    slack = 1e-9 * (window[1] - window[0])
    kept, own = ((each >= window[0] - slack) & (each <= window[1] + slack) for each in (clock, solution.times))
    at, when = clock[kept], solution.times[own]
    measured, computed = treated(unit, at, data.channels[column][kept]), treated(unit, when, solution[channel][own])
    resampled = treated(unit, at, interpolant(solution.times, solution[channel])(at))
    differences: tuple[OrderDifference, ...] = ()
    if orders:
        line = unit == "rad"
        sets = ((at, data.channels[column][kept]), (when, solution[channel][own]))
        amplitudes = [order_amplitudes(t, x, frequency, highest, line) for t, x in sets]
        differences = tuple(_order(order, frequency, *amplitudes) for order in orders)
    return ChannelComparison(
        channel=channel,
        column=column,
        unit=unit,
        treatment=treatment(unit),
        times=at,
        measured=measured,
        simulated=resampled,
        measured_extent=_extent(measured),
        simulated_extent=_extent(computed),
        rms_difference=float(np.sqrt(np.mean((resampled - measured) ** 2))),
        correlation=correlation(measured, resampled),
        orders=differences,
    )


def told_order(order: int, base: str, frequency: float, turns: float) -> tuple[float | None, str]:
    """The order per turn of the reference shaft (``turns`` per second, 0 if unknown), and in words."""
    if not turns:
        return None, f"{order} x {base}"
    per_turn = exact_multiple(frequency / turns) * order
    return float(per_turn), order_name(per_turn, [(base, order)])


def _order(order: int, frequency: float, measured: NDArray[np.complex128], simulated: NDArray[np.complex128]) -> OrderDifference:
    m, s = measured[order - 1], simulated[order - 1]
    clear = all(abs(x) > NEGLIGIBLE * np.abs(all_of).max() for x, all_of in ((m, measured), (s, simulated)))
    phases = float(np.angle(m)), float(np.angle(s))
    turn = float(np.angle(s * np.conj(m))) if clear else None
    return OrderDifference(order, order * frequency, float(abs(m)), float(abs(s)), float(abs(s) - abs(m)), *phases, turn)


def _extent(values: Array) -> Extent:
    return Extent(float(np.abs(values).max()), float(np.ptp(values)) / 2, float(values.mean()), float(values.std()))


def _both(measured: float, simulated: float, unit: str) -> str:
    share = f" ({100 * (simulated / measured - 1):+.2f} %)" if measured else ""
    return f"measured {measured:.5g}, simulated {simulated:.5g} {unit}{share}"
