"""Figure of a referee's comparison: both engines over each other in time, and the largest difference of every channel.

Draws ``RefereeResult`` of ``modelgen.analysis.referee``.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelgen.analysis.referee.comparison import RefereeResult
from modelgen.errors import CaseError, nearest
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import MINUS, axis_label, definition, display, number, words
from modelgen.plots.style import BLUE, INK, PALE, SMALL, VERMILION, name_panel, sheet, styled

SHOWN = 4
LAST = 0.05  # s, of a longer run


@plot.register
@styled
def plot_referee(result: RefereeResult, /, *, channels: tuple[str, ...] | None = None, last: float = LAST) -> Figure:
    """Overlay of up to four channels over the ``last`` seconds, and the largest relative difference of each channel.

    ``channels``: by default two mesh forces, the largest twist and the largest angle. Raises CaseError for others.
    """
    where = f"referee of {result.model}"
    for name in channels or ():
        if name not in result.difference:
            raise CaseError(where, f"has no channel {name!r}", nearest(name, result.difference))
    worst = sorted(result.difference, key=lambda name: -result.difference[name])
    forces = [name for name in worst if name.endswith(".force")]
    largest = sorted(result.difference, key=lambda name: -float(np.ptp(result.ours[name])))
    motions = [name for kind in (".twist", ".angle_deviation") for name in [n for n in largest if n.endswith(kind)][:1]]
    names = list(channels or [*forces[: SHOWN - len(motions)], *motions] or worst)[:SHOWN]
    span = f"the last {last:g} s of {result.times[-1]:g} s" if result.times[-1] > last else f"all {result.times[-1]:g} s"
    detail = (
        f"Blue: modelgen; dashed: {result.engine}, fixed steps of {number(result.step)} s; shown: {span}. Differences: "
        "largest in the whole run, per half the peak-to-peak of the channel's fluctuating part."
    )
    figure = sheet(result.model, "against an independent multibody engine", detail, height=3.6 * len(names) + 5.2)
    grid = figure.subplots(len(names) + 1, 1, height_ratios=[1.0] * len(names) + [1.5])
    kept = result.times >= result.times[-1] - last
    kept[-2:] = True  # a line needs two samples, however few there are
    for axes, name in zip(grid, names, strict=False):
        _overlay(axes, result, name, kept)
    grid[len(names) - 1].set_xlabel("time $t$ [s]")
    _differences(grid[-1], result)
    return figure


def _overlay(axes: Axes, result: RefereeResult, name: str, kept: np.ndarray) -> None:
    unit = display(result.units[name], float(np.abs(result.ours[name]).max()))
    axes.plot(result.times[kept], unit(result.ours[name][kept]), color=BLUE, linewidth=1.6)
    axes.plot(result.times[kept], unit(result.theirs[name][kept]), color=INK, linewidth=0.8, linestyle=(0, (4, 2)))
    axes.set_xlim(result.times[kept][0], result.times[-1])
    axes.set_ylabel(axis_label(name, unit.unit))
    share = f"{100 * result.peak_difference[name]:+.1e}".replace("e-0", "e-").replace("-", MINUS)
    size = number(result.difference[name], 2)
    note = f"largest difference {size} of half the peak-to-peak; peak-to-peak {share} %"
    name_panel(axes, f"{words(name.rpartition('.')[0])}: {definition(name)}", note)


def _differences(axes: Axes, result: RefereeResult) -> None:
    """One mark per channel, grouped by the quantity."""
    kinds: dict[str, list[float]] = {}
    for name, value in result.difference.items():
        kinds.setdefault(name.rpartition(".")[2], []).append(max(value, 1e-16))
    order = sorted(kinds)
    axes.axhline(1e-6, color=PALE, linewidth=0.8)
    for place, kind in enumerate(order):
        values = np.array(sorted(kinds[kind]))
        spread = place + np.linspace(-0.25, 0.25, len(values)) if len(values) > 1 else np.array([float(place)])
        axes.semilogy(spread, values, "o", color=VERMILION, markersize=3, markeredgecolor=INK, markeredgewidth=0.3)
    axes.set_xticks(range(len(order)), [words(kind) for kind in order], fontsize=SMALL)
    axes.set_xlim(-0.5, len(order) - 0.5)
    axes.grid(axis="x", visible=False)
    axes.set_ylabel("relative difference [-]")
    name_panel(axes, "largest difference of every channel", "gray line: one millionth")
