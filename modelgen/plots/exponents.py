"""Figure of Lyapunov exponents: how the largest estimates settle over time, and the whole spectrum with its intervals.

Draws ``ExponentsResult`` of ``modelgen.analysis``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from modelgen.analysis.stability.exponents import ExponentsResult
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import number
from modelgen.plots.style import BLUE, GRAY, INK, SERIES, SMALL, VERMILION, mark_value, name_panel, sheet, styled

COLORS = {"positive": VERMILION, "negative": BLUE, "undecided": GRAY}


@plot.register
@styled
def plot_exponents(result: ExponentsResult, /, *, count: int = 2) -> Figure:
    """Above: the first ``count`` estimates against the time that they are means over, with the final 95 % intervals as bands.
    Below, where there is more than one: all exponents with their intervals."""
    several = len(result.exponents) > 1
    shown = min(max(count, 1), len(result.exponents))
    figure = sheet(result.model, "Lyapunov exponents", _detail(result), height=11.5 if several else 6.5)
    every = figure.subplots(2 if several else 1, 1, squeeze=False, height_ratios=[6, 5][: 1 + several])[:, 0]
    _settling(every[0], result, shown)
    if several:
        _spectrum(every[1], result)
    return figure


def _detail(result: ExponentsResult) -> str:
    said = [f"Means over {number(result.duration)} s, in steps of {number(result.stretch, 3)} s."]
    said.append(f"The largest is {result.sign} at 95 %." if result.sign != "undecided" else "Its interval decides no sign.")
    said += [f"{remark[:1].upper()}{remark[1:]}." for remark in result.remarks]
    if result.flow is not None:
        said.append(f"Number {result.flow + 1} is along the motion, 0 in theory.")
    if result.neutral:
        said.append(f"Apart, exactly 0: the rigid rotation ({', '.join(result.neutral)}).")
    if result.complete:
        gap = f"Their sum misses the mean divergence by {number(result.trace_gap, 2)} 1/s;"
        said.append(f"{gap} Kaplan-Yorke dimension {number(result.dimension)}.")
    return " ".join(said)


def _settling(axes: Axes, result: ExponentsResult, shown: int) -> None:
    for k in range(shown):
        color = SERIES[k % len(SERIES)]
        value, half = float(result.exponents[k]), float(result.half_width[k])
        axes.axhspan(value - half, value + half, color=color, alpha=0.15, linewidth=0)
        axes.plot(result.times, result.running[:, k], color=color, label=f"{k + 1}: {number(value)} ± {number(half, 2)} 1/s")
    axes.axhline(0.0, color=INK, linewidth=0.6)
    # The first estimates swing too far to be worth the room.
    late = result.running[len(result.running) // 5 :, :shown]
    lowest, highest = ((result.exponents + side * result.half_width)[:shown] for side in (-1, 1))
    low, high = min(late.min(), lowest.min(), 0.0), max(late.max(), highest.max(), 0.0)
    room = 0.08 * (high - low) or 1.0
    axes.set(xlim=(0, float(result.times[-1])), ylim=(low - room, high + room))
    if 0 < result.transient < result.times[-1]:
        axes.axvline(result.transient, color=INK, linewidth=0.9, linestyle=(0, (5, 2)))
        axes.annotate("transient until here", (result.transient, 1), xycoords=("data", "axes fraction"), xytext=(3, -3), va="top",
                      textcoords="offset points", fontsize=SMALL, color=INK)  # fmt: skip
    axes.set(xlabel="time averaged over from the beginning [s]", ylabel="exponent [1/s]")
    axes.legend(loc="center left", bbox_to_anchor=(1.005, 0.5), title="95 % interval")
    name_panel(axes, "estimates so far" if len(result.exponents) == shown else f"the largest {shown}, estimates so far")


def _spectrum(axes: Axes, result: ExponentsResult) -> None:
    numbers = np.arange(1, len(result.exponents) + 1)
    colors = COLORS[result.sign], BLUE
    first = next((k for k in range(len(numbers)) if k != result.flow), 0)  # the sign is that of the largest but the flow's
    axes.vlines(numbers, 0.0, result.exponents, color=[colors[k != first] for k in range(len(numbers))], linewidth=1.0)
    dots: dict[str, Any] = {"fmt": "o", "color": INK, "markersize": 2.5, "elinewidth": 0.8, "capsize": 2}
    axes.errorbar(numbers, result.exponents, yerr=result.half_width, **dots)
    if result.flow is not None:
        axes.plot(numbers[result.flow], result.exponents[result.flow], "o", color=VERMILION, markersize=6, fillstyle="none")
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set(xlabel="number of the exponent [-]", ylabel="exponent [1/s]")
    if result.complete:
        axes.axhline(result.divergence / len(numbers), color=GRAY, linewidth=0.9, linestyle=(0, (5, 2)))
        mark_value(axes, result.divergence / len(numbers), "mean\ndivergence\nper state", GRAY)
    name_panel(axes, "all exponents" if result.complete else "those computed")
