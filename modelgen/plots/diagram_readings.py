"""Figure of bifurcation diagrams side by side: the same sweep under several readings of what is swept. The paper's Fig. 9.

Draws ``BifurcationResult`` of ``modelgen.analysis`` over one parameter: a column for each reading, a row for each channel, the
residuals below. Points are colored by their period as in ``bifurcation``; gray did not come to stand still.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from modelgen.analysis.nonlinear.bifurcation import BifurcationResult, Column
from modelgen.errors import CaseError
from modelgen.plots.bifurcation import HIGHER, PERIODS, UNSETTLED
from modelgen.plots.quantities import axis_label, definition, display, words, written
from modelgen.plots.style import INK, name_panel, sheet, styled

PANEL, RESIDUAL = 4.8, 2.6  # cm high
TINY = 1e-14


@styled
def diagram_readings(results: Mapping[str, BifurcationResult]) -> Figure:
    """Diagrams by the name of their reading, beside each other.

    Raises CaseError for no diagrams, and for those of different parameters or channels.
    """
    if not results:
        raise CaseError("bifurcation diagrams", "there are none", "give at least one")
    first = next(iter(results.values()))
    for each in results.values():
        if (each.parameter, each.channels) != (first.parameter, first.channels) or len(each.values) < 2:
            raise CaseError("bifurcation diagrams", "differ in parameter or channels", "sweep the same, two values or more")
    heights = [PANEL] * len(first.channels) + [RESIDUAL]
    figure = sheet(first.model, f"bifurcation diagrams over {words(first.parameter)}", _detail(first), height=sum(heights) + 1.6)
    grid = figure.subplots(len(heights), len(results), sharex=True, sharey="row", squeeze=False, height_ratios=heights)
    for k, (name, result) in enumerate(results.items()):
        for row in range(len(first.channels)):
            _points(grid[row, k], result, row)
        _residuals(grid[-1, k], result)
        loose = sum(not column.settled for column in result.columns)
        name_panel(grid[0, k], name, f"{loose} of {len(result.columns)} columns did not come to stand still")
        grid[-1, k].set_xlabel(f"{words(first.parameter)} [{written(first.unit)}]")
    for row, (channel, unit) in enumerate(zip(first.channels, first.units, strict=True)):
        shown = display(unit, 1.0)
        grid[row, 0].set_ylabel(f"{words(channel.rpartition('.')[0])}\n{axis_label(channel, shown.unit)}")
    grid[-1, 0].set_ylabel("residual [-]")
    low, high = float(first.values[0]), float(first.values[-1])
    room = 0.02 * (high - low)  # columns at the ends are seen whole
    grid[-1, 0].set_xlim(low - room, high + room)
    grid[-1, 0].locator_params(axis="x", nbins=4)
    figure.align_ylabels(list(grid[:, 0]))
    figure.legend(handles=_legend(list(results.values())), loc="outside lower center", ncols=5)
    return figure


def _detail(first: BifurcationResult) -> str:
    count = max((len(column.points) for column in first.columns), default=0)
    return (
        f"{len(first.values)} values, {count} strobes each after the transient. Strobe: {first.strobe.partition(':')[0]}. "
        f"{definition(first.channels[0])[0].upper()}{definition(first.channels[0])[1:]}, physical. Residual: how far strobes are "
        "from coming back, per scale of the states; dashed: standing still. Gray: no attractor is claimed there."
    )


def _points(axes: Axes, result: BifurcationResult, k: int) -> None:
    shown = display(result.units[k], 1.0)
    for loose in (True, False):
        for column in (each for each in result.columns if (each.period == 0) == loose and len(each.points)):
            values = column.points[-column.period :, k] if column.period else column.points[:, k]
            look: dict[str, Any] = {"marker": ".", "markersize": 1.3} if loose else {"marker": "o", "markersize": 1.6}
            axes.plot(
                np.full(len(values), column.value), shown(values), linestyle="none", color=_color(column), markeredgewidth=0,
                zorder=2 if loose else 4, **look,
            )  # fmt: skip


def _color(column: Column) -> str:
    return PERIODS.get(column.period, HIGHER) if column.period else UNSETTLED


def _residuals(axes: Axes, result: BifurcationResult) -> None:
    for settled, color in ((True, INK), (False, UNSETTLED)):
        mine = [column for column in result.columns if column.settled == settled and np.isfinite(column.residual)]
        places, sizes = [column.value for column in mine], [max(column.residual, TINY) for column in mine]
        axes.plot(places, sizes, color=color, linestyle="none", marker="o", markersize=2.0, markeredgewidth=0, zorder=3)
    axes.axhline(result.still, color=INK, linewidth=0.6, linestyle=(0, (4, 2)))
    axes.set_yscale("log")


def _legend(results: list[BifurcationResult]) -> list[Line2D]:
    columns = [column for result in results for column in result.columns]
    dot: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 3.5, "markeredgewidth": 0}
    periods = sorted({column.period for column in columns if column.period})
    entries = [Line2D([], [], color=PERIODS.get(each, HIGHER), label=f"period {each}", **dot) for each in periods]
    if any(not column.period for column in columns):
        entries.append(Line2D([], [], color=UNSETTLED, label="did not come to stand still", **dot))
    return entries
