"""Figure of motions at one place: response, phase plane and Poincaré section beside each other. The paper's Fig. 10 to 13.

Draws a channel of one or several ``SectionResult`` of ``modelgen.analysis``, a row each; the section has the extent of the phase
plane, so that one point is seen as one point.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelgen.analysis.nonlinear.sections import SectionResult
from modelgen.errors import CaseError, nearest
from modelgen.plots.quantities import Display, axis_label, definition, display, number, words
from modelgen.plots.style import BLUE, FAINT, INK, SKY, VERMILION, name_panel, panels, sheet, styled

ROW = 5.6  # cm high


@styled
def portraits(
    sections: Mapping[str, SectionResult], channel: str, period: float, *, notes: Mapping[str, str] | None = None
) -> Figure:
    """Response over time, phase plane and section of one channel, a row for each named section; ``notes`` below the rows' names.

    ``period`` [s] of the strobe. Raises CaseError for no sections, an unknown channel, or a section without points.
    """
    if not sections:
        raise CaseError("portraits", "there are no sections", "give at least one")
    for section in sections.values():
        if channel not in section.channels:
            where = f"portraits of {section.model!r}"
            raise CaseError(where, f"there is no channel {channel!r}", nearest(channel, section.channels))
        if not len(section.times) or len(section.orbit_values) < 2:
            raise CaseError(f"portraits of {section.model!r}", "the section holds no points", "give a run that goes on longer")
    first = next(iter(sections.values()))
    place = words(channel.rpartition(".")[0])
    detail = (
        f"{definition(channel)[0].upper()}{definition(channel)[1:]}, physical; its rate from the equations of motion. Strobed "
        f"every {number(period)} s. Left and middle: the motion after the last strobe; right: all strobes after the transient, "
        "residual per scale of the states."
    )
    figure = sheet(first.model, f"motion at {place}", detail, height=ROW * len(sections) + 0.3)
    grid = panels(figure, len(sections), 3, share_x=False)
    for row, (name, section) in zip(grid, sections.items(), strict=True):
        _row(row, name, section, channel, period, (notes or {}).get(name, ""))
    return figure


def _row(row: list[Axes], name: str, section: SectionResult, channel: str, period: float, note: str) -> None:
    k = section.channels.index(channel)
    unit = section.units[k]
    values, rates = section.orbit_values[:, k], section.orbit_rates[:, k]
    shown = display(unit, float(np.abs(values).max()))
    rated = display(unit, 1.0) if unit == "rad" else Display(shown.factor, shown.unit)
    times = np.linspace(0.0, section.orbit_periods * period, len(values))
    response, plane, cut = row
    response.plot(times, shown(values), color=BLUE, linewidth=0.9 if section.period else 0.4)
    response.set(xlim=(0, times[-1]), xlabel=r"time $t$ [s]", ylabel=axis_label(channel, shown.unit))
    name_panel(response, name, note)
    thin = 0.8 if section.period else 0.2
    plane.plot(shown(values), rated(rates), color=SKY if not section.period else BLUE, linewidth=thin)
    periods = f"{section.orbit_periods} common periods" if section.orbit_periods != 1 else "one common period"
    name_panel(plane, "phase plane", periods)
    cut.plot(shown(values), rated(rates), color=FAINT if not section.period else SKY, linewidth=thin, zorder=1)
    few = section.period > 0
    look = {"markersize": 5.0, "markeredgecolor": INK} if few else {"markersize": 1.8, "markeredgecolor": VERMILION}
    points = (shown(section.values[:, k]), rated(section.rates[:, k]))
    cut.plot(*points, linestyle="none", marker="o", color=VERMILION, markeredgewidth=0.4, zorder=3, **look)  # type: ignore[arg-type]
    found = f"period {section.period}" if few else f"residual {number(section.residual, 2)}"
    name_panel(cut, "section", f"{len(section.times)} strobes, {found}")
    xs, ys = (np.concatenate([shown(values), points[0]]), np.concatenate([rated(rates), points[1]]))
    for axes in (plane, cut):
        axes.set(xlim=_room(xs), ylim=_room(ys), xlabel=axis_label(channel, shown.unit))
        axes.locator_params(axis="x", nbins=5)
    plane.set_ylabel(f"rate [{rated.unit}/s]")


def _room(values: np.ndarray) -> tuple[float, float]:
    """Limits of an axis with a little room on both sides."""
    low, high = float(values.min()), float(values.max())
    room = 0.06 * (high - low) or 1e-9
    return low - room, high + room
