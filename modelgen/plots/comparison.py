"""Figure of a comparison: a measured channel over the computed one in time, and both by order.

Draws ``ComparisonResult`` of ``modelgen.analysis.measurements``.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelgen.analysis.measurements.compare import ChannelComparison, ComparisonResult, OrderDifference
from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import MINUS, Display, axis_label, definition, display, number, words
from modelgen.plots.speed_axis import TIMES, order_text
from modelgen.plots.style import BLUE, INK, SMALL, name_panel, sheet, styled

MOST = 6
PERIODS = 3  # of the base frequency, shown of a longer window


@plot.register
@styled
def plot_comparison(result: ComparisonResult, /, *, last: int | None = PERIODS) -> Figure:
    """Measured and simulated signal over the ``last`` periods of the base frequency (None: over the whole window), and the
    amplitudes of the orders; a row per channel.

    Raises CaseError for more than 6 channels or none.
    """
    where = f"comparison with {result.source}"
    if not 0 < len(result.channels) <= MOST or (last is not None and last < 1):
        problem = f"{len(result.channels)} channels over {last} periods are to be shown"
        raise CaseError(where, problem, f"compare 1 to {MOST} channels, over one period or more")
    begin, end = result.window
    part = last is not None and result.frequency > 0 and (end - begin) * result.frequency > last * (1 + 1e-9)
    first = end - last / result.frequency if part and last is not None else begin
    shown = f"the last {last} periods of it" if part else "all of it"
    aligned = "by the best lag" if result.aligned else "as given"
    orders = any(channel.orders for channel in result.channels)
    base = f" Orders of {words(result.base)}, {number(result.frequency)} Hz: hatched measured, blue simulated." if orders else ""
    detail = (
        f"{result.source}. Common window {begin:.4g} to {end:.4g} s, shown: {shown}; measured clock shifted by "
        f"{number(result.shift)} s ({aligned}). Values in the titles are over the whole window.{base}"
    )
    figure = sheet(result.model, "measured and simulated", detail, height=1.6 + 5.2 * len(result.channels))
    grid = figure.subplots(len(result.channels), 1 + orders, squeeze=False, width_ratios=[1.7, 1.0] if orders else None)
    for row, channel in zip(grid, result.channels, strict=True):
        size = max(channel.measured_extent.peak, channel.simulated_extent.peak)
        unit = display(channel.unit, size)
        _signals(row[0], channel, unit, first)
        if orders:
            _orders(row[1], channel, unit)
    grid[-1][0].set_xlabel(r"time $t$ of the simulation [s]")
    if orders:
        told = any(order.per_turn is not None for channel in result.channels for order in channel.orders)
        what = "order [per turn of the reference]" if told else "multiple [-]"
        grid[-1][1].set_xlabel(f"{what}\n(base: {words(result.base)})")
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def _signals(axes: Axes, channel: ChannelComparison, unit: Display, first: float) -> None:
    kept = channel.times >= first
    times, dashes = channel.times[kept], (0, (4, 1.5))
    axes.plot(times, unit(channel.simulated[kept]), color=BLUE, linewidth=1.3, label="simulated")
    axes.plot(times, unit(channel.measured[kept]), color=INK, linewidth=0.9, linestyle=dashes, label="measured")
    axes.set_xlim(first, float(channel.times[-1]))
    axes.locator_params(axis="x", nbins=6)
    axes.set_ylabel(axis_label(channel.channel, unit.unit))
    measured, simulated = (float(unit(each.half_pp)) for each in (channel.measured_extent, channel.simulated_extent))
    share = f" ({100 * (simulated / measured - 1):+.2g} %)".replace("-", MINUS) if measured else ""
    note = f"half p-p: measured {number(measured, 3)}, simulated {number(simulated, 3)} {unit.unit}{share}".replace(" °", "°")
    name_panel(axes, f"{words(channel.channel.rpartition('.')[0])}: {definition(channel.channel)}", note)


def _orders(axes: Axes, channel: ChannelComparison, unit: Display) -> None:
    """Amplitudes by order, with the difference in phase of the largest."""
    places = np.arange(len(channel.orders))
    measured, simulated = (unit(np.array([getattr(each, side) for each in channel.orders])) for side in ("measured", "simulated"))
    axes.bar(places - 0.2, measured, 0.36, color="white", hatch="//////", edgecolor=INK, linewidth=0.6, zorder=3)
    axes.bar(places + 0.2, simulated, 0.36, color=BLUE, edgecolor=INK, linewidth=0.6, zorder=3)
    axes.set_xticks(places, [_tick(each) for each in channel.orders], fontsize=SMALL if len(places) <= 12 else 5.5)
    axes.grid(axis="x", visible=False)
    axes.set_ylabel(f"amplitude [{unit.unit}]")
    note = ""
    clear = [each for each in channel.orders if each.phase_difference is not None]
    if clear:
        largest = max(clear, key=lambda each: each.measured)
        turn = f"{np.degrees(largest.phase_difference or 0.0):+.1f}°".replace("-", MINUS)
        note = f"phase of order {_tick(largest)} ({TIMES}{largest.order}): {turn}"
    name_panel(axes, "by order", note or " ")


def _tick(order: OrderDifference) -> str:
    """An order per turn of the reference shaft, where that is known, else its multiple of the base."""
    return str(order.order) if order.per_turn is None else order_text(order.per_turn)
