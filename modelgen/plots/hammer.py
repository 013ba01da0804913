"""Figure of gear hammer: the vibratory load of every gear against the mean load that keeps its flanks together, over speed.

Draws ``HammerResult`` of ``modelgen.analysis``.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from modelgen.analysis.linear.gear_hammer import GearLoad, HammerResult
from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import axis_label, display, words
from modelgen.plots.speed_axis import RPM, set_speed
from modelgen.plots.style import BLUE, INK, ORANGE, VERMILION, name_panel, panels, sheet, styled

MOST = 300.0  # percent; a longer bar says no more
HAMMERING = "#F0B59A"


@plot.register
@styled
def plot_hammer(result: HammerResult, /) -> Figure:
    """Mean load and vibration of each gear over speed; shaded where the vibration takes the whole load off the flanks.

    Raises CaseError where the result holds no gear.
    """
    if not result.gears:
        raise CaseError(f"gear hammer of {result.model!r}", "holds no gear", "ask gear_hammer() of a driveline with gears")
    swing = "Vibration of the load over the cycle, orders with their phases: departure from the mean, largest and toward zero."
    if not all(load.exact for load in result.gears.values()):
        swing += " Sources that do not repeat together are added as a bound."
    if len(result.speeds) == 1:
        return _at_one_speed(result, swing)
    detail = f"{swing} Where the departure toward zero reaches the mean (shaded), the flanks part and hammer."
    figure = sheet(result.model, "vibratory and mean load of the gears", detail, height=1.8 + 5.2 * len(result.gears))
    rows = [axes for (axes,) in panels(figure, len(result.gears))]
    speeds = result.speeds * RPM
    for axes, (name, load) in zip(rows, result.gears.items(), strict=True):
        mean = np.abs(load.mean)
        shown = display(load.unit, float(max(mean.max(), load.alternating.max())))
        axes.plot(speeds, shown(mean), color=INK, linewidth=1.6, label="mean load")
        axes.plot(speeds, shown(load.alternating), color=ORANGE, linestyle=(0, (5, 1.5)), label="largest departure from the mean")
        axes.plot(speeds, shown(mean - load.least), color=BLUE, label="departure toward zero")
        axes.fill_between(speeds, shown(mean), shown(mean - load.least), where=load.least <= 0, interpolate=True, color=HAMMERING,
                          linewidth=0, label="gears hammer", zorder=1)  # fmt: skip
        axes.set_ylim(bottom=0)
        axes.set_ylabel(axis_label(load.channel, shown.unit))
        name_panel(axes, f"{words(name)}: {_verdict(load, speeds)}")
    handles, labels = rows[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    set_speed(rows[-1], result.speeds)
    return figure


def _at_one_speed(result: HammerResult, detail: str) -> Figure:
    """Bars of the departure toward zero per mean, which hammers at 100 %."""
    what = f"vibratory load of the gears at {result.speeds[0] * RPM:.5g} rpm"
    figure = sheet(result.model, what, detail, height=1.8 + 0.7 * len(result.gears))
    ((axes,),) = panels(figure, 1)
    for row, load in enumerate(result.gears.values()):
        mean, least = abs(float(load.mean[0])), float(load.least[0])
        share = 100 * (mean - least) / mean if np.isfinite(load.ratio[0]) and mean else MOST if load.hammer[0] else 0.0
        axes.barh(row, min(share, MOST), 0.6, color=VERMILION if load.hammer[0] else BLUE, edgecolor=INK, linewidth=0.3, zorder=3)
        said = "hammers" if load.hammer[0] else "does not hammer"
        axes.annotate(f"{share:.3g} %, {said}" if share < MOST else said, (1, row), xycoords=("axes fraction", "data"),
                      xytext=(4, 0), textcoords="offset points", va="center", annotation_clip=False)  # fmt: skip
    axes.axvline(100, color=INK, linewidth=1.2, linestyle=(0, (5, 2)), zorder=5)
    axes.set_yticks(range(len(result.gears)), [words(name) for name in result.gears])
    axes.set(xlim=(0, max(110.0, axes.get_xlim()[1])), ylim=(len(result.gears) - 0.4, -0.6))
    axes.set_xlabel("departure of the load toward zero, per mean load [%]")
    axes.grid(axis="y", visible=False)
    return figure


def _verdict(load: GearLoad, speeds: np.ndarray) -> str:
    worst = int(load.ratio.argmax())
    size = f"vibration at most {load.ratio[worst]:.3g} of the mean, at {speeds[worst]:.5g} rpm"
    if not np.isfinite(load.ratio[worst]):
        size = f"no mean load at {speeds[worst]:.5g} rpm"
    return f"{'hammers' if load.hammer.any() else 'does not hammer'}; {size}"
