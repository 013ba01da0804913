"""Figure of a cross-check: differences of the solvers against tolerance, and channel by channel.

Draws ``CrosscheckResult`` of ``modelgen.solvers``; a difference is relative to half the peak-to-peak of its channel's fluctuating
part.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import number
from modelgen.plots.style import DASHES, SERIES, VERMILION, mark_value, name_panel, sheet, styled
from modelgen.solvers import CrosscheckResult

AIM = 1e-6
MOST = 48  # channels that can be read on a page; of more, those that differ most
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
LEAST = 1e-16  # what a logarithmic axis shows of a difference that is zero


@plot.register
@styled
def plot_crosscheck(result: CrosscheckResult, /, *, aim: float | None = AIM) -> Figure:
    """Above: largest difference of each solver against its tolerance; below: every channel, each solver at its best tolerance.

    ``aim`` is drawn as a line. Raises CaseError for a result in which no run reached its end.
    """
    finished = [run for run in result.runs if math.isfinite(run.worst)]
    if not finished:
        raise CaseError(f"cross-check of {result.model!r}", "no run reached its end", "see the messages of its runs")
    solvers = [name for name in dict.fromkeys(run.solver for run in result.runs) if any(run.solver == name for run in finished)]
    best = {name: result.best(name) for name in solvers}
    channels = list(dict.fromkeys(name for run in best.values() for name in run.differences))
    if len(channels) > MOST:
        worst = sorted(channels, key=lambda name: -max(run.differences.get(name, 0.0) for run in best.values()))[:MOST]
        channels = [name for name in channels if name in worst]
    failed = [f"{run.solver} at {number(run.tolerance)}: {run.message}" for run in result.runs if not math.isfinite(run.worst)]
    solver, tolerance = result.reference
    detail = (
        f"Against {solver} at {number(tolerance)}, over {number(result.horizon)} s. Differences are relative to half the "
        f"peak-to-peak of each channel's fluctuating part. {result.sentence()}"
    )
    detail += "".join(f"\nNot shown: {text}." for text in failed)
    figure = sheet(result.model, "cross-check of the solvers", detail, height=7.6 + 0.34 * len(channels))
    above, below = figure.subplots(2, 1, height_ratios=[5.2, 0.34 * len(channels) + 0.8])
    _against_tolerance(above, result, solvers)
    _by_channel(below, result, solvers, channels)
    if aim is not None:
        above.axhline(aim, color=VERMILION, linewidth=0.9, linestyle=(0, (5, 2)))
        mark_value(above, aim, number(aim))
        below.axvline(aim, color=VERMILION, linewidth=0.9, linestyle=(0, (5, 2)))
        below.set_xlim(right=max(below.get_xlim()[1], 3 * aim))
    handles, labels = above.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 6))
    return figure


def _against_tolerance(axes: Axes, result: CrosscheckResult, solvers: list[str]) -> None:
    for index, name in enumerate(solvers):
        runs = [run for run in result.runs if run.solver == name and math.isfinite(run.worst)]
        tolerance, worst = np.array(sorted((run.tolerance, max(run.worst, LEAST)) for run in runs)).T
        axes.loglog(tolerance, worst, label=name, linestyle=DASHES[index // len(SERIES) % len(DASHES)], **_sign(index))
    axes.set(xlabel="tolerance, relative to the scale of each state [-]", ylabel="largest relative difference [-]")
    name_panel(axes, "largest difference of any channel")


def _by_channel(axes: Axes, result: CrosscheckResult, solvers: list[str], channels: list[str]) -> None:
    rows = np.arange(len(channels))[::-1]
    for index, name in enumerate(solvers):
        differences = result.best(name).differences
        values = [max(differences.get(channel, math.nan), LEAST) for channel in channels]
        axes.semilogx(values, rows, linestyle="none", **_sign(index))
    axes.set_yticks(rows, channels, fontsize=6.5)
    axes.set(ylim=(-0.7, len(channels) - 0.3), xlabel="relative difference [-]")
    name_panel(axes, "by channel, each solver at its best tolerance")


def _sign(index: int) -> dict[str, Any]:
    """Color and marker of a solver; open markers, so that equal differences stay visible."""
    return {"color": SERIES[index % len(SERIES)], "marker": MARKERS[index % len(MARKERS)], "markersize": 4.5, "fillstyle": "none"}
