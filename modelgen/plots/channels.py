"""Figure of a solution: named channels over time in stacked panels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import axis_label, definition, display, number
from modelgen.plots.style import BLUE, name_panel, panels, sheet, styled
from modelgen.plots.time_axis import set_time
from modelgen.solvers import Solution

MOST = 12


@plot.register
@styled
def plot_solution(solution: Solution, /, *, names: Sequence[str] | None = None) -> Figure:
    """The named channels (all where there are at most 12) over time, each in its own panel with its unit.

    Raises CaseError for an unknown name, for more than 12 of them, and for a solution that holds no times.
    """
    where = f"plot of solution of {solution.model_name!r}"
    names = list(solution.channels) if names is None else list(names)
    if not 0 < len(names) <= MOST:
        example = next(iter(solution.channels), "element.channel")
        raise CaseError(where, f"{len(names)} channels are to be shown", f"name 1 to {MOST}, as in names=[{example!r}]")
    if not len(solution.times):
        raise CaseError(where, "it holds no times", "see its message for how the run ended")
    detail = f"{solution.message}. {solution.case.solver}, tolerance {number(solution.case.tolerance)}."
    title = "channels over time" if len(names) > 1 else names[0]
    figure = sheet(solution.model_name, title, detail, height=0.8 + 3.4 * len(names))
    rows = [axes for (axes,) in panels(figure, len(names))]
    for name, axes in zip(names, rows, strict=True):
        values = solution[name]
        shown = display(solution.unit(name), float(np.abs(values).max()))
        axes.plot(solution.times, shown(values), color=BLUE, linewidth=0.9)
        name_panel(axes, name, definition(name))
        axes.set_ylabel(axis_label(name, shown.unit))
    figure.align_ylabels(rows)
    set_time(rows[-1], solution)
    return figure
