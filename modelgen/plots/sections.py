"""Figure of a Poincaré section: phase portrait of each channel with the points that the section leaves in it.

Draws ``SectionResult`` of ``modelgen.analysis``. One point where the motion repeats with the excitation, n for period n, a curve
or a cloud otherwise; points that did not come to stand still are drawn open.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from modelgen.analysis.classification.verdict import Verdict
from modelgen.analysis.nonlinear.sections import SectionResult
from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import axis_label, definition, display, number, words
from modelgen.plots.style import INK, SKY, VERMILION, name_panel, panels, sheet, styled

PANEL = 6.6  # cm high
FEW = 16  # points that are drawn large


@plot.register
@styled
def plot_section(result: SectionResult, /, *, verdict: Verdict | None = None) -> Figure:
    """Phase planes of all channels, two in a row: the motion as a line, the section's points on it.

    ``verdict``: the classification, said below the heading. Raises CaseError for a result without points or channels.
    """
    if not result.channels or not len(result.times):
        why = f"holds no points: {result.failure}" if result.failure else "holds no points"
        raise CaseError(f"section of {result.model!r}", why, "give a run that passes its transient")
    count = len(result.channels)
    columns = min(2, count)
    rows = -(-count // columns)
    figure = sheet(result.model, "Poincaré section", _detail(result, verdict), height=PANEL * rows + 0.9)
    every = [axes for row in panels(figure, rows, columns, share_x=False) for axes in row]
    for k, axes in enumerate(every):
        if k < count:
            _phase_plane(axes, result, k)
        else:
            axes.set_axis_off()
    figure.legend(handles=_legend(result), loc="outside lower center", ncols=3)
    return figure


def _phase_plane(axes: Axes, result: SectionResult, k: int) -> None:
    name, unit = result.channels[k], result.units[k]
    values, rates = result.values[:, k], result.rates[:, k]
    line_x, line_y = result.orbit_values[:, k], result.orbit_rates[:, k]
    across = display(unit, float(np.abs([*values, *line_x]).max()))
    rate_unit = f"{unit}/s" if unit != "1" else "1/s"
    up = display(rate_unit, float(np.abs([*rates, *line_y]).max())) if unit != "rad" else display(unit, 1.0)
    axes.plot(across(line_x), up(line_y), color=SKY, linewidth=0.5 if result.period else 0.25, zorder=2)
    axes.plot(across(values), up(rates), zorder=4, **_marks(result))
    axes.set_xlabel(axis_label(name, across.unit))
    axes.set_ylabel(f"rate [{up.unit}/s]" if unit == "rad" else f"rate [{up.unit}]")
    name_panel(axes, words(name.rpartition(".")[0]), definition(name))


def _marks(result: SectionResult) -> dict[str, Any]:
    """How points look: filled where they stand still, open where they do not; large where they are few."""
    few = 0 < result.period <= FEW
    size = 5.0 if few else 2.2
    face = VERMILION if result.settled else "white"
    edge = INK if few else VERMILION
    return {
        "linestyle": "none",
        "marker": "o",
        "markersize": size,
        "color": face,
        "markeredgecolor": edge,
        "markeredgewidth": 0.5,
    }


def _legend(result: SectionResult) -> list[Line2D]:
    periods = f"{result.orbit_periods} common periods" if result.orbit_periods > 1 else "one common period"
    motion = f"motion over {periods}" if result.orbit_periods else "motion"
    still = "points of the section" if result.settled else "points of the section, not at rest"
    return [
        Line2D([], [], color=SKY, linewidth=1.0, label=motion),
        Line2D([], [], label=f"{still} ({len(result.times)})", **_marks(result)),
    ]


def _detail(result: SectionResult, verdict: Verdict | None) -> str:
    given = ", ".join(f"{name} = {number(value)}" for name, value in result.parameters.items())
    waited = f"{len(result.times)} points after {result.transient} of transient"
    if result.period:
        found = f"they come back after {result.period}, within {number(result.residual, 1)} of the states' scales"
    else:
        found = f"they do not come back (nearest {number(result.residual, 2)} of the states' scales)"
    said = f" Verdict: {verdict.name}." if verdict is not None else ""
    if verdict is not None and verdict.conservative:
        said += " Without damping: the motion from this start, no attractor."
    failed = f" The run failed: {result.failure}." if result.failure else ""
    return f"{f'{given}. ' if given else ''}Strobe: {result.section}; {waited}; {found}.{said}{failed}"
