"""Figure of the torsional angles: every inertia in every definition, physical and referred, with the limit. The paper's Fig. 6.

Draws ``AnglesResult`` of ``modelgen.analysis``, in degrees.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelgen.analysis import AnglesResult
from modelgen.analysis.time_domain.angles import InertiaAngles
from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import DEGREES, MINUS, words
from modelgen.plots.style import BLUE, FAINT, INK, ORANGE, SKY, SMALL, VERMILION, mark_value, name_panel, panels, sheet, styled

MEASURES = (
    ("vibration, peak", BLUE, lambda each: each.vibration.peak),
    ("vibration, half peak-to-peak", SKY, lambda each: each.vibration.half_pp),
    ("elastic, peak", ORANGE, lambda each: each.elastic.peak),
    ("elastic, half peak-to-peak", "#F5D79A", lambda each: each.elastic.half_pp),
)


@plot.register
@styled
def plot_angles(result: AnglesResult, /, *, limit: float | None = None) -> Figure:
    """Bars per inertia: vibration and elastic angle, peak and half peak-to-peak; above physical, below referred, in degrees.

    ``limit`` [degrees] of the physical vibration angle is drawn as a line among the physical ones. Raises CaseError for a result
    without inertias.
    """
    if not result.inertias:
        raise CaseError(f"angles of {result.model!r}", "there are no inertias in it", "keep the angle channels of the run")
    window = result.window
    settled = "" if window.settled else " (the run is not settled by then)"
    detail = (
        f"Window {window.first:.4g} to {window.last:.4g} s, {window.revolutions} periods of {words(window.base)}{settled}. "
        f"Vibration angle: θ less its best straight line in time. Elastic angle: θ {MINUS} rΣ(Jrθ)/Σ(Jr²) less its mean. "
        "Peak: largest absolute value. Referred: physical / r, r the speed of the shaft per speed of the reference shaft."
    )
    figure = sheet(result.model, "torsional angles", detail, height=11.6)
    rows = [axes for (axes,) in panels(figure, 2)]
    verdict = "" if limit is None else _verdict(result, limit)
    for axes, referred in zip(rows, (False, True), strict=True):
        _bars(axes, result.inertias, referred)
        _shafts(axes, result.inertias, with_ratio=referred)
        if limit is not None and not referred:  # a physical limit says nothing of referred angles
            axes.axhline(limit, color=VERMILION, linewidth=1.2, linestyle=(0, (5, 2)), zorder=5)
            mark_value(axes, limit, f"{limit:g}°")
        axes.set_ylabel(f"{'referred' if referred else 'physical'} angle [°]")
    name_panel(rows[0], "physical, each shaft its own", verdict)
    name_panel(rows[1], "referred to the reference shaft", " ")
    names = [words(name) for name in result.inertias]
    rows[1].set_xticks(range(len(names)), names, rotation=55, ha="right", rotation_mode="anchor")
    handles, labels = rows[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _verdict(result: AnglesResult, limit: float) -> str:
    worst = max(result.inertias, key=lambda name: result.inertias[name].vibration.peak)
    value = result.inertias[worst].vibration.peak * DEGREES
    side = "above" if value > limit else "within"
    return f"vibration peak at most {value:.3g}° ({words(worst)}), {side} the limit of {limit:g}° (0-peak), the dashed line"


def _bars(axes: Axes, inertias: Mapping[str, InertiaAngles], referred: bool) -> None:
    places = np.arange(len(inertias))
    width = 0.8 / len(MEASURES)
    for index, (name, color, measure) in enumerate(MEASURES):
        # What stands still in the mean has no referred value.
        ratios = [(each.referred_ratio or np.nan) if referred else 1.0 for each in inertias.values()]
        heights = [DEGREES * measure(each) / ratio for each, ratio in zip(inertias.values(), ratios, strict=True)]
        left = places + (index - (len(MEASURES) - 1) / 2) * width
        axes.bar(left, heights, width, color=color, edgecolor=INK, linewidth=0.3, label=name, zorder=3)
    axes.set_xlim(-0.6, len(inertias) - 0.4)
    axes.tick_params(axis="x", length=0)
    axes.grid(axis="x", visible=False)


def _shafts(axes: Axes, inertias: Mapping[str, InertiaAngles], with_ratio: bool) -> None:
    """Bands behind the inertias of one speed, with the ratio r."""
    start = 0
    for index, (ratio, group) in enumerate(groupby(round(each.referred_ratio, 9) for each in inertias.values())):
        end = start + len(list(group))
        if index % 2:
            axes.axvspan(start - 0.5, end - 0.5, color=FAINT, zorder=0, linewidth=0)
        if with_ratio:
            axes.annotate(
                f"r = {ratio:.4g}", ((start + end - 1) / 2, 1), xycoords=("data", "axes fraction"), xytext=(0, 2),
                textcoords="offset points", ha="center", va="bottom", fontsize=SMALL,
            )  # fmt: skip
        start = end
