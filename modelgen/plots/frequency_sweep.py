"""Figure of a frequency sweep: rms dynamic transmission error over mesh frequency, upward and downward, with its jumps.

Draws ``FrequencySweepResult`` of ``modelgen.analysis``; below it the share of time that the flanks are apart.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelgen.analysis.nonlinear.frequency_sweep import FrequencySweepResult, SweepPoint
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import definition, display, number, words
from modelgen.plots.style import BLUE, INK, PALE, SMALL, VERMILION, name_panel, sheet, styled

PANEL, SHARE = 6.2, 3.2  # cm high
WAYS: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("forward", "upward", {"color": BLUE, "marker": "^", "linestyle": "-"}),
    ("backward", "downward", {"color": VERMILION, "marker": "v", "linestyle": (0, (5, 1.5))}),
)


@plot.register
@styled
def plot_frequency_sweep(result: FrequencySweepResult, /) -> Figure:
    """Both branches of every channel over mesh frequency, and the share of time without contact."""
    heights = [PANEL] * len(result.channels) + [SHARE]
    figure = sheet(result.model, f"frequency sweep of {words(result.mesh)}", _detail(result), height=sum(heights) + 1.5)
    every = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    across = display("Hz", result.forward[-1].frequency)
    for k, name in enumerate(result.channels):
        axes = every[k]
        sizes = [point.rms[k] for way, _, _ in WAYS for point in getattr(result, way) if not point.failure]
        largest = max(sizes, default=0.0) or 1.0
        shown = display(result.units[k], largest)
        for way, label, look in WAYS:
            _branch(axes, result, way, k, across, shown, look, label)
        if k == 0:
            _changes(axes, result, across, shown)
        axes.set_ylim(0, 1.08 * float(shown(largest)))
        axes.set_ylabel(f"rms [{shown.unit}]")
        name_panel(
            axes, "dynamic transmission error, rms about its mean" if k == 0 else f"{words(name)}: {definition(name)}, rms"
        )
    for way, label, look in WAYS:
        points: tuple[SweepPoint, ...] = getattr(result, way)
        shares = [100 * (point.separated + point.back) for point in points]
        every[-1].plot(
            [float(across(point.frequency)) for point in points], shares, label=label, markersize=2.6, linewidth=0.9, **look
        )
    every[-1].set(ylim=(0, None), ylabel="share [%]", xlabel=f"mesh frequency [{across.unit}]")
    every[-1].set_xlim(float(across(result.forward[0].frequency)), float(across(result.forward[-1].frequency)))
    name_panel(every[-1], "time off the driving flank")
    figure.align_ylabels(list(every))
    handles, labels = every[-1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def _branch(
    axes: Axes, result: FrequencySweepResult, way: str, k: int, across: Any, shown: Any, look: dict[str, Any], label: str
) -> None:
    """A branch as a line, broken at its jumps (whose ends are known of the first channel); points not at rest are open."""
    points: tuple[SweepPoint, ...] = getattr(result, way)
    x = np.array([float(across(point.frequency)) for point in points])
    y = np.array([float(shown(point.rms[k])) for point in points])
    still = np.array([point.settled for point in points])
    line = [(float(a), float(b)) for a, b in zip(x, y, strict=True)]
    for each in result.jumps:
        if each.direction == way:
            low, high = sorted([(each.stays, each.before), (each.changes, each.after)])
            if k == 0:
                line += [(float(across(f)), float(shown(r))) for f, r in (low, high)]
            line.append((float(across(each.frequency)), np.nan))
    path = np.array(sorted(line, key=lambda place: place[0]))
    axes.plot(path[:, 0], path[:, 1], color=look["color"], linestyle=look["linestyle"], linewidth=0.9, label=label, zorder=3)
    axes.plot(x[still], y[still], color=look["color"], marker=look["marker"], markersize=2.6, linestyle="none", zorder=4)
    failed = np.array([bool(point.failure) for point in points])
    foot: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "clip_on": False, "zorder": 5}
    if failed.any():
        axes.plot(x[failed], np.full(int(failed.sum()), 0.03), color=VERMILION, marker="x", markersize=4, ls="none", **foot)
    axes.plot(x[~still], y[~still], marker=look["marker"], markersize=3.4, color="white", markeredgecolor=look["color"],
              markeredgewidth=0.6, linestyle="none", zorder=4)  # fmt: skip


def _changes(axes: Axes, result: FrequencySweepResult, across: Any, shown: Any) -> None:
    """An arrow at every jump, and a tick where flanks begin to part."""
    for each in result.changes:
        x = float(across(each.frequency))
        if each.kind != "jump":
            if each.direction == "forward":
                axes.axvline(x, color=PALE, linewidth=0.7, linestyle=(0, (1, 1.5)), zorder=1)
            continue
        ends = float(shown(each.before)), float(shown(each.after))
        axes.annotate("", (x, ends[1]), xytext=(x, ends[0]), zorder=5,
                      arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0})  # fmt: skip
        ahead = each.direction == "forward"
        # Outside of the branches: a jump to more on the way up has room below its foot, any other beside its middle.
        foot = ahead and ends[1] > ends[0]
        place = ends[0] if foot else sum(ends) / 2
        look: dict[str, Any] = {"ha": "left" if ahead else "right", "va": "top" if foot else "center"}
        text = f"{number(x, 4)} {across.unit}"
        shift = (4 if ahead else -4, -2 if foot else 0)
        axes.annotate(text, (x, place), xytext=shift, textcoords="offset points", fontsize=SMALL, zorder=6, **look)


def _detail(result: FrequencySweepResult) -> str:
    loose = sum(not point.settled for way, _, _ in WAYS for point in getattr(result, way))
    said = f" {loose} points did not come to stand still (open)." if loose else ""
    if failed := result.failed:
        why = failed[0].failure
        said += f" {len(failed)} runs failed (crosses at the foot), the first at {failed[0].frequency:.6g} Hz: {why}."
    return (
        f"{len(result.forward)} mesh frequencies; every point starts from the last state of its neighbor. Arrows: jumps, closed "
        f"in on along their branch; dotted: flanks begin or cease to part on the way up.{said}"
    )
