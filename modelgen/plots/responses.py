"""Figure of responses: the vibration angle of chosen inertias over time, in degrees. The paper's Fig. 7 and 8.

Draws a ``Solution`` over a ``Window``. The straight line is taken out over the whole window, as in ``analysis.angles``, so that
the peaks are the same numbers; what is shown may be its last revolutions.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from modelgen.analysis import Window
from modelgen.errors import CaseError
from modelgen.plots.quantities import DEGREES, number, words
from modelgen.plots.style import BLUE, GRAY, VERMILION, mark_value, name_panel, panels, sheet, styled
from modelgen.plots.time_axis import part_of, set_time
from modelgen.solvers import Solution
from modelgen.solvers.crosscheck import without_line


@styled
def responses(
    solution: Solution, window: Window, names: Sequence[str], *, last: int | None = 2, limit: float | None = None
) -> Figure:
    """Vibration angle of each named inertia over the window, or over its ``last`` revolutions; ``limit`` [degrees] as lines.

    Raises CaseError for an unknown name and where the solution does not cover the window.
    """
    if not names or (last is not None and last < 1):
        raise CaseError("responses", "there is nothing to show", "name at least one inertia and one revolution")
    whole = part_of(solution, window, None, "responses")
    shown = part_of(solution, window, last, "responses")
    detail = (
        f"Vibration angle: θ less its best straight line over the window {window.first:.4g} to {window.last:.4g} s, physical. "
        f"Shown: {'all' if last is None else f'the last {min(last, window.revolutions)}'} of its {window.revolutions} periods of "
        f"{words(window.base)} ({window.period:.4g} s). {solution.case.solver}, tolerance {number(solution.case.tolerance)}."
    )
    title = f"response of {', '.join(map(words, names))}" if len(names) <= 3 else "responses"
    figure = sheet(solution.model_name, title, detail, height=0.8 + 4.3 * len(names))
    rows = [axes for (axes,) in panels(figure, len(names))]
    for name, axes in zip(names, rows, strict=True):
        angle = DEGREES * without_line(whole.times, whole[f"{name}.angle_deviation"])
        visible = whole.times >= shown.times[0]
        axes.plot(whole.times[visible], angle[visible], color=BLUE, linewidth=0.9)
        axes.axhline(0.0, color=GRAY, linewidth=0.5)
        peak, half_pp = float(np.abs(angle).max()), float(np.ptp(angle)) / 2
        name_panel(axes, words(name), f"over the whole window: peak {peak:.4g}°, half peak-to-peak {half_pp:.4g}°")
        axes.set_ylabel("vibration angle [°]")
        if limit is not None and peak > 0.35 * limit:  # a line far off the data would only flatten them
            for side in (-limit, limit):
                axes.axhline(side, color=VERMILION, linewidth=0.9, linestyle=(0, (5, 2)))
                mark_value(axes, side, f"{number(side)}°")
            axes.margins(y=0.12)
    set_time(rows[-1], shown)
    return figure
