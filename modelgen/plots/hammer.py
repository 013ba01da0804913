"""Figure of gear hammer: the vibratory load of every gear against the mean load that keeps its flanks together, over speed.

Draws ``HammerResult`` of ``modelgen.analysis``.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from modelgen.analysis.gear_hammer import GearLoad, HammerResult
from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import axis_label, display, words
from modelgen.plots.speed_axis import RPM, set_speed
from modelgen.plots.style import BLUE, INK, ORANGE, name_panel, panels, sheet, styled


@plot.register
@styled
def plot_hammer(result: HammerResult, /) -> Figure:
    """Mean load and vibration of each gear over speed; shaded where the vibration takes the whole load off the flanks.

    Raises CaseError where the result holds no gear.
    """
    if not result.gears:
        raise CaseError(f"gear hammer of {result.model!r}", "holds no gear", "ask gear_hammer() of a driveline with gears")
    exact = all(load.exact for load in result.gears.values())
    summed = "" if exact else " Sources that do not repeat together are added as a bound."
    detail = (
        "Vibration of the load over the cycle, all orders with their phases: its largest departure from the mean, and that toward "
        f"zero. Shaded: the departure toward zero reaches the mean, the flanks part and hammer.{summed}"
    )
    figure = sheet(result.model, "vibratory and mean load of the gears", detail, height=1.8 + 5.2 * len(result.gears))
    rows = [axes for (axes,) in panels(figure, len(result.gears))]
    speeds = result.speeds * RPM
    dot = {"marker": "o"} if len(speeds) < 3 else {}
    for axes, (name, load) in zip(rows, result.gears.items(), strict=True):
        mean = np.abs(load.mean)
        shown = display(load.unit, float(max(mean.max(), load.alternating.max())))
        axes.fill_between(speeds, 0, 1, where=load.hammer, transform=axes.get_xaxis_transform(), color="#F6D3BF", linewidth=0,
                          label="gears hammer", zorder=0)  # fmt: skip
        for lonely in speeds[_lonely(load)]:
            axes.axvline(lonely, color="#F6D3BF", linewidth=2.0, zorder=0)
        axes.plot(speeds, shown(mean), color=INK, linewidth=1.6, label="mean load", **dot)
        axes.plot(speeds, shown(load.alternating), color=ORANGE, linestyle=(0, (5, 1.5)), label="largest departure from the mean", **dot)
        axes.plot(speeds, shown(mean - load.least), color=BLUE, label="departure toward zero", **dot)
        axes.set_ylim(bottom=0)
        axes.set_ylabel(axis_label(load.channel, shown.unit))
        name_panel(axes, f"{words(name)}: {_verdict(load, speeds)}")
    handles, labels = rows[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    set_speed(rows[-1], result.speeds)
    return figure


def _lonely(load: GearLoad) -> np.ndarray:
    """Speeds that hammer while both neighbors do not: no area is left to be filled there."""
    beaten = np.concatenate([[False], load.hammer, [False]])
    return np.asarray(load.hammer & ~beaten[:-2] & ~beaten[2:])


def _verdict(load: GearLoad, speeds: np.ndarray) -> str:
    worst = int(load.ratio.argmax())
    size = f"vibration at most {load.ratio[worst]:.3g} of the mean, at {speeds[worst]:.5g} rpm"
    if not np.isfinite(load.ratio[worst]):
        size = f"no mean load at {speeds[worst]:.5g} rpm"
    return f"{'hammers' if load.hammer.any() else 'does not hammer'}; {size}"
