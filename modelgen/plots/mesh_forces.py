"""Figure of mesh forces and deflections: their envelope over the window, and the flanks at work where the force is largest.

Draws a ``Solution``. White: driving flank; gray: the teeth are apart; red: the back flank carries. Least and largest force are
those of the whole window, the same numbers as in ``analysis.angles``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from modelgen.analysis import Window
from modelgen.errors import CaseError, nearest
from modelgen.plots.quantities import MINUS, display, number, words
from modelgen.plots.style import BLUE, GRAY, INK, SKY, VERMILION, mark_value, name_panel, sheet, styled
from modelgen.plots.time_axis import part_of, set_time
from modelgen.solvers import Solution

Array = NDArray[np.float64]
FREE, BACK = "#D0D0D0", "#F3B79B"
READABLE = 40  # mesh periods in one panel, of more their envelope is drawn
ZOOMED = 6  # mesh periods around the largest force
BINS = 600  # of an envelope


@styled
def mesh_forces(
    solution: Solution, window: Window | None = None, names: Sequence[str] | None = None, *, last: int | None = None
) -> Figure:
    """Force and deflection of the named gear pairs (all by default) over the window or its ``last`` revolutions.

    Of more than 40 mesh periods the envelope of the force, and force and deflection in six of them about the largest force.
    Raises CaseError for a solution without gear pairs, an unknown name, or a window that it does not cover.
    """
    pairs = [name.removesuffix(".penetration") for name in solution.channels if name.endswith(".penetration")]
    where = f"mesh forces of {solution.model_name!r}"
    if not pairs:
        raise CaseError(where, "the solution has no gear pair", "keep the channels force, deflection and penetration")
    for name in names or ():
        if name not in pairs:
            raise CaseError(where, f"there is no gear pair {name!r}", nearest(name, pairs))
    part = part_of(solution, window, last, "mesh forces")
    chosen = list(names or pairs)
    zooms = {name: _at_the_extreme(part, name) for name in chosen}
    panels = sum(2 if zoom is None else 3 for zoom in zooms.values())
    figure = sheet(solution.model_name, "mesh forces and contact", _detail(part), height=0.8 + 3.2 * panels)
    rows = list(figure.subplots(panels, 1, squeeze=False)[:, 0])
    left = iter(rows)
    for name, zoom in zooms.items():
        if zoom is not None:
            envelope = next(left)
            _envelope(envelope, part, name, zoom)
            set_time(envelope, part)
        _pair(next(left), next(left), part if zoom is None else zoom, name, zoom is not None)
    figure.align_ylabels(rows)
    signs = [Patch(facecolor=color, edgecolor=GRAY, linewidth=0.5, label=text) for color, text in _STATES]
    figure.legend(handles=signs, loc="outside lower center", ncols=3)
    return figure


def _detail(part: Solution) -> str:
    return (
        f"Window {part.times[0]:.4g} to {part.times[-1]:.4g} s: least and largest force and shares of time are over all of it. "
        f"Force along the line of action, positive on the driving flank; deflection δ = r₁θ₁ {MINUS} r₂θ₂ {MINUS} e, contact "
        f"beyond ±b. {part.case.solver}, tolerance {number(part.case.tolerance)}."
    )


def _at_the_extreme(part: Solution, name: str) -> Solution | None:
    """A few mesh periods about the largest force; None where all of them can be read, or the mesh period is unknown."""
    model = part.case.model
    names = [] if model is None else [clock.name for clock in model.equations.clocks]
    if model is None or f"{name}.contact" not in names:
        return None
    frequencies = model.mean_model.frequencies_at(model.parameters.unbalanced(part.case.parameters))
    frequency = float(frequencies[names.index(f"{name}.contact")]) / (2 * np.pi)
    first, last = float(part.times[0]), float(part.times[-1])
    if (last - first) * frequency <= READABLE:
        return None
    at, half = float(part.times[np.argmax(np.abs(part[f"{name}.force"]))]), ZOOMED / 2 / frequency
    middle = min(max(at, first + half), last - half)
    return part.between(middle - half, middle + half)


_STATES = (("white", "driving flank"), (FREE, "free, within the backlash"), (BACK, "back flank"))


def _envelope(axes: Axes, part: Solution, name: str, zoom: Solution) -> None:
    """Least and largest force in small steps of time over the whole part; where the zoom lies."""
    force, times = part[f"{name}.force"], part.times
    bins = np.linspace(0, len(times), min(BINS, len(times)) + 1).astype(int)[:-1]
    low, high = np.minimum.reduceat(force, bins), np.maximum.reduceat(force, bins)
    shown = display("N", float(np.abs(force).max()))
    axes.fill_between(times[bins], shown(low), shown(high), facecolor=SKY, edgecolor=BLUE, linewidth=0.5)
    for time in (zoom.times[0], zoom.times[-1]):
        axes.axvline(float(time), color=VERMILION, linewidth=0.9, linestyle=(0, (5, 2)), zorder=4)
    axes.axhline(0.0, color=GRAY, linewidth=0.5)
    axes.set_ylabel(f"mesh force\n$F$ [{shown.unit}]")
    name_panel(axes, f"{words(name)}: envelope over the window", _extremes(part, name))


def _extremes(part: Solution, name: str) -> str:
    force, depth = part[f"{name}.force"], part[f"{name}.penetration"]
    shares = [100 * float(np.mean(side)) for side in (depth > 0, depth == 0, depth < 0)]
    shown = display("N", float(np.abs(force).max()))
    least, largest = (number(float(shown(value))) for value in (force.min(), force.max()))
    times = f"driving flank {shares[0]:.3g} %, free {shares[1]:.3g} %, back flank {shares[2]:.3g} % of the time"
    return f"{least} to {largest} {shown.unit}; {times}"


def _pair(force_axes: Axes, deflection_axes: Axes, part: Solution, name: str, zoomed: bool) -> None:
    force, delta, depth = (part[f"{name}.{last}"] for last in ("force", "deflection", "penetration"))
    for axes in (force_axes, deflection_axes):
        for color, inside in ((FREE, depth == 0), (BACK, depth < 0)):
            # Half a sample to both sides, so that a contact that lasts one sample is seen.
            over_all: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "linewidth": 0, "zorder": 0}
            axes.fill_between(part.times, 0, 1, where=_widened(inside), step="mid", color=color, **over_all)
    shown = display("N", float(np.abs(force).max()))
    force_axes.plot(part.times, shown(force), color=BLUE, linewidth=0.8)
    force_axes.axhline(0.0, color=GRAY, linewidth=0.5)
    force_axes.set_ylabel(f"mesh force\n$F$ [{shown.unit}]")
    if zoomed:
        span = f"{part.times[0]:.6g} to {part.times[-1]:.6g} s: {ZOOMED} mesh periods about the largest force, dashed lines above"
        name_panel(force_axes, words(name), span)
    else:
        name_panel(force_axes, words(name), _extremes(part, name))
    shown = display("m", float(np.abs(delta).max()))
    deflection_axes.plot(part.times, shown(delta), color=INK, linewidth=0.8)
    gap = np.abs(delta - depth)[depth != 0]
    if len(gap):
        # The far flank is shown where the teeth come near it.
        for side in (1, -1) if delta.min() < 0 else (1,):
            deflection_axes.axhline(side * float(shown(gap[0])), color=GRAY, linewidth=0.8, linestyle="--")
            mark_value(deflection_axes, side * float(shown(gap[0])), "+b" if side > 0 else f"{MINUS}b", INK)
    deflection_axes.set_ylabel(f"deflection\n$\\delta$ [{shown.unit}]")
    force_axes.sharex(deflection_axes)
    force_axes.tick_params(axis="x", labelbottom=False)
    set_time(deflection_axes, part)
    deflection_axes.ticklabel_format(axis="x", useOffset=False)


def _widened(inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    before, after = np.roll(inside, 1), np.roll(inside, -1)
    before[0] = after[-1] = False
    return np.asarray(inside | after)
