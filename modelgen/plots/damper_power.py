"""Figure of the power that vibration turns into heat: every damper at one speed, and the hottest of them over speed.

Draws the dampers of a ``ForcedResult`` of ``modelgen.analysis``.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from modelgen.analysis.linear.forced import ForcedResult
from modelgen.errors import CaseError
from modelgen.plots.quantities import display, number, words
from modelgen.plots.speed_axis import RPM, line_of, set_speed, source_text
from modelgen.plots.style import INK, SMALL, name_panel, sheet, styled
from modelgen.units import read_quantity

HATCHES = ("", "////", "....", "\\\\\\\\", "xxxx", "----", "||||")
MOST, CURVES = 20, 5
VISIBLE = 1e-3  # of the longest bar


@styled
def damper_power(result: ForcedResult, /, *, speed: float | str | None = None) -> Figure:
    """Mean power lost in each damper at a speed [rad/s, or "1900 rpm"], by the source of the vibration; with several speeds, over
    speed as well.

    The computed speed nearest to ``speed`` is taken; by default that of the largest loss. Raises CaseError where nothing is lost.
    """
    where = f"power lost by {result.model!r}"
    total = result.power.sum(axis=2)
    if not result.dampers or not total.max(initial=0.0) > 0:
        raise CaseError(where, "is none: it has no damper that works", "give shafts or meshes a damping")
    at = int(total.sum(axis=1).argmax())
    if speed is not None:
        asked = read_quantity(speed, "rad/s", where) if isinstance(speed, str) else float(speed)
        slack = 1e-6 * result.speeds[-1]
        if not result.speeds[0] - slack <= asked <= result.speeds[-1] + slack:
            span = f"{result.speeds[0] * RPM:.5g} to {result.speeds[-1] * RPM:.5g} rpm"
            raise CaseError(where, f"is computed from {span}, not at {asked * RPM:.5g} rpm", "give a speed within")
        at = int(np.abs(result.speeds - asked).argmin())
    order = [int(k) for k in np.argsort(-total[at], kind="stable")][:MOST]
    several = len(result.speeds) > 1
    heights = [0.48 * len(order) + 1.2, *([5.0] if several else [])]
    chosen = f"{result.speeds[at] * RPM:.5g} rpm"
    largest = " (where most is lost)" if speed is None and several else ""
    hidden = len(result.dampers) - len(order)
    left_out = f" {hidden} dampers that lose less are left out." if hidden else ""
    detail = (
        f"Mean power that vibration turns into heat, at {chosen}{largest}: {_watts(float(total[at].sum()))} in all. "
        f"What the mean rotation loses is not in it.{left_out}"
    )
    figure = sheet(result.model, "power lost in the dampers", detail, height=sum(heights) + 1.0)
    every = figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
    bars, shown = every[0], display("W", float(total[at].max()))
    left = np.zeros(len(order))
    for index, bases in enumerate(dict.fromkeys(result.bases)):
        mine = [k for k, each in enumerate(result.bases) if each == bases]
        part = shown(result.power[at][:, mine].sum(axis=1)[order])
        bars.barh(range(len(order)), part, 0.65, left=left, color=line_of(index)[0], hatch=HATCHES[index % len(HATCHES)],
                  edgecolor="white", linewidth=0, zorder=3,
                  label=", ".join(map(source_text, bases)) if part.max() > VISIBLE * shown(total[at].max()) else "_")  # fmt: skip
        left += part
    for row, k in enumerate(order):
        bars.annotate(_watts(float(total[at, k])), (left[row], row), xytext=(3, 0), textcoords="offset points", va="center",
                      fontsize=SMALL)  # fmt: skip
    bars.set_yticks(range(len(order)), [words(result.dampers[k]) for k in order])
    bars.set(ylim=(len(order) - 0.4, -0.6), xlabel=f"mean power lost [{shown.unit}]", xlim=(0, 1.16 * left.max()))
    bars.grid(axis="y", visible=False)
    bars.legend(loc="lower right", title="vibration by", title_fontsize=SMALL)
    name_panel(bars, f"by damper at {chosen}")
    if several:
        axes, whole = every[1], total.sum(axis=1)
        shown = display("W", float(whole.max()))
        axes.plot(result.speeds * RPM, shown(whole), color=INK, linewidth=1.6, label="all dampers")
        for index, k in enumerate(np.argsort(-total.max(axis=0), kind="stable")[:CURVES]):
            color, dashes = line_of(index)
            axes.plot(result.speeds * RPM, shown(total[:, k]), color=color, linestyle=dashes, label=words(result.dampers[k]))
        axes.axvline(result.speeds[at] * RPM, color=INK, linewidth=0.6, linestyle=(0, (2, 2)))
        axes.set(ylabel=f"mean power lost [{shown.unit}]", ylim=(0, None))
        axes.legend(loc="center left", bbox_to_anchor=(1.005, 0.5))
        set_speed(axes, result.speeds)
        name_panel(axes, "over speed")
    return figure


def _watts(power: float) -> str:
    shown = display("W", power)
    return f"{number(float(shown(power)), 3)} {shown.unit}"
