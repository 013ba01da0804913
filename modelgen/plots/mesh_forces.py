"""Figure of mesh forces and deflections over time, with the contact of the flanks marked.

Draws a ``Solution``. White: driving flank; gray: the teeth are apart; red: the back flank carries.
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
from modelgen.plots.style import BLUE, GRAY, INK, mark_value, name_panel, panels, sheet, styled
from modelgen.plots.time_axis import part_of, set_time
from modelgen.solvers import Solution

Array = NDArray[np.float64]
FREE, BACK = "#D0D0D0", "#F3B79B"


@styled
def mesh_forces(
    solution: Solution, window: Window | None = None, names: Sequence[str] | None = None, *, last: int | None = None
) -> Figure:
    """Force and deflection of the named gear pairs (all by default) over the window or its ``last`` revolutions.

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
    detail = (
        f"Force along the line of action, positive on the driving flank; deflection δ = r₁θ₁ {MINUS} r₂θ₂ {MINUS} e, contact "
        "beyond ±b. "
        f"{solution.case.solver}, tolerance {number(solution.case.tolerance)}."
    )
    figure = sheet(solution.model_name, "mesh forces and contact", detail, height=0.8 + 6.4 * len(chosen))
    rows = [axes for (axes,) in panels(figure, 2 * len(chosen))]
    for name, force_axes, deflection_axes in zip(chosen, rows[::2], rows[1::2], strict=True):
        _pair(force_axes, deflection_axes, part, name)
    figure.align_ylabels(rows)
    set_time(rows[-1], part)
    signs = [Patch(facecolor=color, edgecolor=GRAY, linewidth=0.5, label=text) for color, text in _STATES]
    figure.legend(handles=signs, loc="outside lower center", ncols=3)
    return figure


_STATES = (("white", "driving flank"), (FREE, "free, within the backlash"), (BACK, "back flank"))


def _pair(force_axes: Axes, deflection_axes: Axes, part: Solution, name: str) -> None:
    force, delta, depth = (part[f"{name}.{last}"] for last in ("force", "deflection", "penetration"))
    for axes in (force_axes, deflection_axes):
        for color, inside in ((FREE, depth == 0), (BACK, depth < 0)):
            # Half a sample to both sides, so that a contact that lasts one sample is seen.
            over_all: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "linewidth": 0, "zorder": 0}
            axes.fill_between(part.times, 0, 1, where=_widened(inside), step="mid", color=color, **over_all)
    shares = [100 * float(np.mean(side)) for side in (depth > 0, depth == 0, depth < 0)]
    shown = display("N", float(np.abs(force).max()))
    force_axes.plot(part.times, shown(force), color=BLUE, linewidth=0.8)
    force_axes.axhline(0.0, color=GRAY, linewidth=0.5)
    force_axes.set_ylabel(f"mesh force\n$F$ [{shown.unit}]")
    note = f"driving flank {shares[0]:.3g} %, free {shares[1]:.3g} %, back flank {shares[2]:.3g} % of the time"
    least, largest = (number(float(shown(value))) for value in (force.min(), force.max()))
    name_panel(force_axes, words(name), f"{least} to {largest} {shown.unit}; {note}")
    shown = display("m", float(np.abs(delta).max()))
    deflection_axes.plot(part.times, shown(delta), color=INK, linewidth=0.8)
    gap = np.abs(delta - depth)[depth != 0]
    if len(gap):
        # The far flank is shown where the teeth come near it.
        for side in (1, -1) if delta.min() < 0 else (1,):
            deflection_axes.axhline(side * float(shown(gap[0])), color=GRAY, linewidth=0.8, linestyle="--")
            mark_value(deflection_axes, side * float(shown(gap[0])), "+b" if side > 0 else f"{MINUS}b", INK)
    deflection_axes.set_ylabel(f"deflection\n$\\delta$ [{shown.unit}]")


def _widened(inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    before, after = np.roll(inside, 1), np.roll(inside, -1)
    before[0] = after[-1] = False
    return np.asarray(inside | after)
