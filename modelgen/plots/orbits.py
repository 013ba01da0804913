"""Figure of a periodic orbit: its Floquet multipliers on the unit circle, and their sizes.

Draws ``PeriodicOrbit`` of ``modelgen.analysis``.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from modelgen.analysis.stability.orbits import PeriodicOrbit
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import number
from modelgen.plots.style import BLUE, FAINT, GRAY, INK, VERMILION, name_panel, sheet, styled

LEAST = 1e-12
"""Size below which a multiplier is rounding, and not shown."""
MOST = 1.3


@plot.register
@styled
def plot_orbits(result: PeriodicOrbit, /) -> Figure:
    """Left: multipliers in the complex plane with the unit circle. Right: their sizes, largest first, on a logarithmic axis."""
    verdict = result.verdict[0].upper() + result.verdict[1:] + "."
    detail = f"{verdict} Period {result.period:.9g} s."
    if result.flow is not None:
        detail += " Open circle: the multiplier along the motion, 1 in theory."
    if result.neutral:
        detail += f" Apart, exactly 1: the rigid rotation ({', '.join(result.neutral)})."
    hidden = int(np.count_nonzero(np.abs(result.multipliers) <= LEAST))
    if hidden:
        detail += f" {hidden} multipliers below {number(LEAST)} are rounding and left out."
    figure = sheet(result.model, "Floquet multipliers", detail, height=8.2)
    plane, sizes = figure.subplots(1, 2, width_ratios=[1, 1])
    _plane(plane, result)
    _sizes(sizes, result)
    return figure


def _plane(axes: Axes, result: PeriodicOrbit) -> None:
    turn = np.linspace(0, 2 * np.pi, 361)
    axes.fill(np.cos(turn), np.sin(turn), color=FAINT, linewidth=0)
    axes.plot(np.cos(turn), np.sin(turn), color=INK, linewidth=0.9)
    inside = np.abs(result.multipliers) < 1
    for which, color, marker in ((inside, BLUE, "o"), (~inside, VERMILION, "D")):
        axes.plot(result.multipliers.real[which], result.multipliers.imag[which], marker, color=color, markersize=4, zorder=3)
    if result.flow is not None:
        axes.plot(result.flow.real, result.flow.imag, "o", color=GRAY, fillstyle="none", markersize=6, zorder=3)
    reach = max(MOST, 1.1 * result.largest)
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", xlabel="real part [-]", ylabel="imaginary part [-]")
    name_panel(axes, "in the complex plane", "shaded: where a deviation dies out")


def _sizes(axes: Axes, result: PeriodicOrbit) -> None:
    sizes = np.abs(result.multipliers)
    seen, numbers = sizes > LEAST, np.arange(1, len(sizes) + 1)
    low = max(LEAST, sizes[seen].min(initial=1.0)) / 10
    axes.axhspan(low, 1.0, color=FAINT, linewidth=0)
    axes.axhline(1.0, color=INK, linewidth=0.9)
    for which, color, marker in ((seen & (sizes < 1), BLUE, "o"), (seen & (sizes >= 1), VERMILION, "D")):
        axes.plot(numbers[which], sizes[which], marker, color=color, markersize=4)
    axes.set_yscale("log")
    axes.set(xlim=(0.4, max(int(seen.sum()), 3) + 0.6), ylim=(low, max(3.0, 3 * result.largest)))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set(xlabel="number, largest first [-]", ylabel="size |μ| [-]")
    name_panel(axes, "sizes", f"largest {number(result.largest, 6)}")
