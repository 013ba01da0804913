"""Figure of a bifurcation diagram: the section's points of every channel over the parameter, colored by their period.

Draws ``BifurcationResult`` of ``modelgen.analysis``. Columns that did not come to stand still are drawn in gray, and their
residual has a panel of its own. Branches of a sweep up and down, or of several starts, differ by their marks.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from modelgen.analysis.nonlinear.bifurcation import BifurcationResult, Column
from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import axis_label, definition, display, words
from modelgen.plots.style import (
    BLUE,
    GREEN,
    INK,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    name_panel,
    sheet,
    styled,
)

PANEL, RESIDUAL = 5.4, 2.6  # cm high
PERIODS = {1: BLUE, 2: VERMILION, 3: GREEN, 4: ORANGE, 5: PURPLE, 6: SKY}
HIGHER = INK
UNSETTLED = "#8A8A8A"
BRANCHES = (("o", 1.5), ("^", 2.4), ("v", 2.4), ("s", 2.0), ("D", 2.0))
TINY = 1e-14
MARGIN = 0.012  # of the width: the first and last column are seen beside the axes


@plot.register
@styled
def plot_bifurcation(result: BifurcationResult, /) -> Figure:
    """One panel per channel, and one of the residuals that the columns were left with.

    Raises CaseError for a diagram of one value.
    """
    if len(result.values) < 2:
        raise CaseError(f"bifurcation diagram of {result.model!r}", "has one value", "give it more to draw")
    count = len(result.channels)
    heights = [PANEL] * count + [RESIDUAL]
    figure = sheet(
        result.model, f"bifurcation diagram over {words(result.parameter)}", _detail(result), height=sum(heights) + 1.6
    )
    every = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    across = _parameter(result)
    for k in range(count):
        _channel(every[k], result, k, across.factor)
    _residuals(every[-1], result, across.factor)
    every[-1].set_xlabel(f"{words(result.parameter)} [{across.unit}]")
    low, high = float(across(result.values[0])), float(across(result.values[-1]))
    every[-1].set_xlim(low - MARGIN * (high - low), high + MARGIN * (high - low))
    figure.align_ylabels(list(every))
    figure.legend(handles=_legend(result), loc="outside lower center", ncols=5)
    return figure


def _parameter(result: BifurcationResult) -> Any:
    if result.unit == "rad/s":  # speeds are read per minute
        return type(display("1", 1.0))(30 / np.pi, "rpm")
    return display(result.unit, float(np.abs(result.values).max()))


def _channel(axes: Axes, result: BifurcationResult, k: int, factor: float) -> None:
    points = [column.points[:, k] for column in result.columns if len(column.points)]
    shown = display(result.units[k], max((float(np.abs(each).max()) for each in points), default=0.0))
    for name, (marker, size) in zip(result.branches, _marks(result), strict=True):
        groups: dict[str, tuple[list[np.ndarray], list[np.ndarray]]] = {}
        for column in result.branch(name):
            values = column.points[-column.period :, k] if column.period else column.points[:, k]
            xs, ys = groups.setdefault(_color(column), ([], []))
            xs.append(np.full(len(values), column.value * factor))
            ys.append(shown(values))
        # Clouds below points that repeat.
        for color, (xs, ys) in sorted(groups.items(), key=lambda item: item[0] != UNSETTLED):
            loose = color == UNSETTLED
            axes.plot(np.concatenate(xs), np.concatenate(ys), linestyle="none", marker="." if loose else marker, color=color,
                      markersize=1.6 if loose else size, markeredgewidth=0, zorder=2 if loose else 4)  # fmt: skip
    name = result.channels[k]
    axes.set_ylabel(axis_label(name, shown.unit))
    name_panel(axes, f"{words(name.rpartition('.')[0])}: {definition(name)}")


def _marks(result: BifurcationResult) -> list[tuple[str, float]]:
    return [BRANCHES[k % len(BRANCHES)] for k in range(len(result.branches))]


def _color(column: Column) -> str:
    return PERIODS.get(column.period, HIGHER) if column.period else UNSETTLED


def _residuals(axes: Axes, result: BifurcationResult, factor: float) -> None:
    for name, (marker, size) in zip(result.branches, _marks(result), strict=True):
        columns = result.branch(name)
        for settled, face in ((True, INK), (False, UNSETTLED)):
            mine = [column for column in columns if column.settled == settled and np.isfinite(column.residual)]
            axes.plot([column.value * factor for column in mine], [max(column.residual, TINY) for column in mine], color=face,
                      linestyle="none", marker=marker, markersize=size + 0.6, markeredgewidth=0, zorder=3)  # fmt: skip
    if failed := [column.value * factor for column in result.failed]:
        foot = axes.get_xaxis_transform()
        axes.plot(failed, [0.04] * len(failed), transform=foot, color=VERMILION, linestyle="none", marker="x",
                  markersize=4, clip_on=False, zorder=5)  # fmt: skip
    axes.axhline(result.still, color=INK, linewidth=0.6, linestyle=(0, (4, 2)))
    axes.set_yscale("log")
    axes.set_ylabel("residual [-]")
    found = [column.residual for column in result.columns if 0 < column.residual < np.inf] or [result.still]
    axes.set_ylim(min(*found, result.still) / 10, max(*found, result.still) * 10)
    name_panel(axes, "how far strobes are from coming back, per scale of the states; dashed: standing still")


def _legend(result: BifurcationResult) -> list[Line2D]:
    periods = sorted({column.period for column in result.columns if column.period})
    dot: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 3.5, "markeredgewidth": 0}
    entries = [Line2D([], [], color=PERIODS[each], label=f"period {each}", **dot) for each in periods if each in PERIODS]
    if any(each not in PERIODS for each in periods):
        higher = ", ".join(str(each) for each in periods if each not in PERIODS)
        entries.append(Line2D([], [], color=HIGHER, label=f"period {higher}", **dot))
    if any(not column.settled for column in result.columns):
        entries.append(Line2D([], [], color=UNSETTLED, label="did not come to stand still", **dot))
    if result.failed:
        entries.append(Line2D([], [], color=VERMILION, linestyle="none", marker="x", markersize=4, label="the run failed"))
    if len(result.branches) > 1:
        for name, (marker, _) in zip(result.branches, _marks(result), strict=True):
            entries.append(Line2D([], [], color=INK, label=name, **{**dot, "marker": marker}))
    return entries


def _detail(result: BifurcationResult) -> str:
    count = max((len(column.points) for column in result.columns), default=0)
    longest = max((column.transient for column in result.columns), default=0)
    unsettled = [column for column in result.columns if not column.settled]
    said = ""
    if unsettled:
        places = (
            f"{len(unsettled)} of {len(result.columns)} columns did not come to stand still (gray): no attractor is claimed there"
        )
        said = f" {places}."
    if failed := result.failed:
        first = f"{failed[0].value:.6g} {result.unit}: {failed[0].failure}"
        said += f" {len(failed)} runs failed (crosses below), the first at {first}."
    return (
        f"{len(result.values)} values, {count} strobes each after up to {longest} of transient. Strobe: {result.strobe}. "
        f"Physical values; the rolling of the whole train is left out.{said}"
    )
