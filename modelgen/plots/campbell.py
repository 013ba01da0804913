"""Figure of the Campbell diagram: natural frequencies over speed, lines of the orders, their crossings, and the operating range.

Draws ``CampbellResult`` of ``modelgen.analysis``. Orders of shafts and of gear meshes lie far apart in frequency: each kind has
its panel. The lowest panel names the critical speeds that the margin does not keep away.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from modelgen.analysis.linear.campbell import CampbellResult, CriticalSpeed, OrderLine
from modelgen.analysis.linear.mode_numbers import mode_name
from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import MINUS
from modelgen.plots.speed_axis import RPM, TIMES, line_of, order_text, set_speed, source_text, spread
from modelgen.plots.style import FAINT, GRAY, INK, PALE, TEXT, VERMILION, sheet, styled

PANEL = 6.4  # cm high
ROW = 0.42  # cm for a critical speed
LETTER = 0.3  # cm from label to label
ABOVE = 1.05  # of the highest natural frequency
MOST = 14  # critical speeds that are listed
FEW = 8  # natural frequencies that are all named; of more, those that an order meets


@plot.register
@styled
def plot_campbell(result: CampbellResult, /, *, margin: float = 0.1, count: int = 9) -> Figure:
    """Campbell diagram with the ``count`` strongest orders of the shafts, and as many of the gear meshes.

    Critical speeds within ``margin`` of the operating speed or range (a share of it) are filled dots, and listed by strength.
    Raises CaseError where there is one speed only, no vibrating mode or no order.
    """
    where = f"Campbell diagram of {result.model!r}"
    if len(result.speeds) < 2:
        raise CaseError(where, "is asked at one speed", "give campbell() a range of speeds")
    if not np.any(result.frequencies[:, result.rigid :] > 0) or not result.lines:
        raise CaseError(where, "has no vibrating mode or no order", "ask a driveline with shafts and with a base frequency")
    if not (0 <= margin < 1 and count >= 1):
        raise CaseError(where, f"margin is {margin!r}, count {count!r}", "give a margin such as 0.1 and a count of 1 or more")
    top = ABOVE * float(result.frequencies.max())
    kinds = (("orders of the shafts", False), ("orders of the gear meshes", True))
    chosen = {title: _strongest(result, meshes, top, count) for title, meshes in kinds}
    chosen = {title: lines for title, lines in chosen.items() if lines}
    shown = {line for lines in chosen.values() for line in lines}
    near = sorted((each for each in result.within(margin) if each.line in shown), key=lambda each: _weakness(each.line))
    listed = near[:MOST]
    heights = [PANEL] * len(chosen) + ([ROW * len(listed) + 0.9] if listed else [])
    left_out = len(result.lines) - len(shown)
    figure = sheet(result.model, "Campbell diagram", _detail(result, margin, left_out, len(near)), height=sum(heights) + 2.6)
    every = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    bases = list(dict.fromkeys(line.sources[0][0] for lines in chosen.values() for line in lines))
    for axes, (title, lines) in zip(every, chosen.items(), strict=False):
        _range(axes, result.operating, margin)
        _diagram(axes, result, lines, bases, margin, title)
    if listed:
        _list(every[-1], result, listed, margin)
    set_speed(every[-1], result.speeds)
    figure.legend(handles=_legend(result, bases, margin), loc="outside lower center", ncols=3)
    return figure


def _strongest(result: CampbellResult, meshes: bool, top: float, count: int) -> list[OrderLine]:
    """The strongest orders of a kind that reach below the highest natural frequency, by order."""
    slowest = float(result.speeds[0]) / (2 * np.pi)
    mine = [line for line in result.lines if ("." in line.sources[0][0]) == meshes and float(line.order) * slowest < top]
    return sorted(sorted(mine, key=_weakness)[:count], key=lambda line: line.order)


def _weakness(line: OrderLine) -> tuple[float, float, float]:
    """By this orders rank, the strongest first: what all sources of an order do together."""
    return -line.vector_sum, -line.torque, float(line.order)


def _detail(result: CampbellResult, margin: float, left_out: int, near: int) -> str:
    low, high = (each * RPM for each in result.operating)
    at = f"Operating speed {low:.5g} rpm" if low == high else f"Operating range {low:.5g} to {high:.5g} rpm"
    rest = f" {left_out} orders that excite less, or lie higher, are left out." if left_out else ""
    met = f"{near or 'no'} critical speed{'s' * (near != 1)}"
    return (
        f"{at}: {met} of the orders shown within {100 * margin:.3g} % of it. At each line: order per turn of the reference "
        f"shaft, and in brackets the multiple of its base.{rest}"
    )


def _range(axes: Axes, operating: tuple[float, float], margin: float) -> None:
    """The operating speed or range, and the margins on both sides of it."""
    low, high = (each * RPM for each in operating)
    for ends in ((low * (1 - margin), low), (high, high * (1 + margin))):
        axes.axvspan(*ends, facecolor="none", edgecolor=PALE, hatch="////", linewidth=0, zorder=0)
    if high > low:
        axes.axvspan(low, high, color=FAINT, linewidth=0, zorder=0)
    else:
        axes.axvline(low, color=INK, linewidth=0.9, linestyle=(0, (7, 2, 1, 2)), zorder=2)


def _diagram(
    axes: Axes, result: CampbellResult, lines: Sequence[OrderLine], bases: Sequence[str], margin: float, title: str
) -> None:
    speeds, turns = result.speeds * RPM, result.speeds / (2 * np.pi)
    highest = float(lines[-1].order) * turns[-1]
    top = float(min(ABOVE * result.frequencies.max(), max(1.06 * highest, 1.15 * result.frequencies[:, result.rigid].max())))
    modes = [mode for mode in range(result.rigid, result.frequencies.shape[1]) if result.frequencies[:, mode].min() < top]
    for mode in modes:
        axes.plot(speeds, result.frequencies[:, mode], color=INK, linewidth=1.2, zorder=3)
    met = {each.mode for each in result.critical if each.line in lines}
    named = [mode for mode in modes if len(modes) <= FEW or mode in met]
    starts = [float(result.frequencies[0, mode]) for mode in named]
    names = [mode_name(mode, result.rigid) for mode in named]
    per_cm = top / (PANEL - 1.2)
    for name, start, place in zip(names, starts, spread(starts, LETTER * per_cm, 0.02 * top, 0.98 * top), strict=True):
        axes.annotate(
            f"{name}: {start:.4g} Hz", (0, place), xycoords=("axes fraction", "data"), xytext=(1, 0), textcoords="offset points",
            va="center", fontsize=6.5, color=INK, zorder=7, bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
        )  # fmt: skip
    for line in lines:
        color, dashes = line_of(bases.index(line.sources[0][0]))
        axes.plot(speeds, float(line.order) * turns, color=color, linestyle=dashes, linewidth=0.9, zorder=2)
    outer = _name_lines(axes, lines, bases, speeds, top, per_cm)
    for each in result.critical:
        if each.line in lines and each.frequency <= top:
            face = VERMILION if abs(each.margin) <= margin else "white"
            axes.plot(each.speed * RPM, each.frequency, marker="o", markersize=3.6, color=face, markeredgecolor=INK,
                      markeredgewidth=0.6, linestyle="none", zorder=5)  # fmt: skip
    axes.set(ylim=(0, top), ylabel="frequency [Hz]")
    axes.set_title(title, fontsize=TEXT, fontweight="bold", color=INK, pad=40 if outer else 4)


def _name_lines(
    axes: Axes, lines: Sequence[OrderLine], bases: Sequence[str], speeds: np.ndarray, top: float, per_cm: float
) -> bool:
    """Multiple and order where each line leaves the panel: at its right end, or above it; whether any stands above."""
    ends = [float(line.order) * float(speeds[-1]) / 60 for line in lines]
    right = [k for k, end in enumerate(ends) if end <= top]
    above = [k for k, end in enumerate(ends) if end > top]
    exits = [float(speeds[-1]) * top / ends[k] for k in above]
    rpm_per_cm = float(speeds[-1] - speeds[0]) / 11.5
    upright = spread(exits, LETTER * rpm_per_cm, float(speeds[0]), float(speeds[-1]))
    level = spread([ends[k] for k in right], LETTER * per_cm, 0.0, top)
    style: dict[str, Any] = {"fontsize": 6.5, "annotation_clip": False, "textcoords": "offset points"}
    for k, place in zip(right, level, strict=True):
        color = line_of(bases.index(lines[k].sources[0][0]))[0]
        axes.annotate(_name(lines[k]), (1, place), xycoords=("axes fraction", "data"), xytext=(3, 0), va="center", color=color,
                      **style)  # fmt: skip
    for k, place in zip(above, upright, strict=True):
        color = line_of(bases.index(lines[k].sources[0][0]))[0]
        axes.annotate(_name(lines[k]), (place, 1), xycoords=("data", "axes fraction"), xytext=(0, 3), ha="center", va="bottom",
                      rotation=90, color=color, **style)  # fmt: skip
    return bool(above)


def _name(line: OrderLine) -> str:
    return f"{order_text(line.order)} ({TIMES}{line.sources[0][1]})"


def _list(axes: Axes, result: CampbellResult, listed: Sequence[CriticalSpeed], margin: float) -> None:
    """Critical speeds near the operating range, the strongest order first."""
    _range(axes, result.operating, margin)
    middle = float(result.speeds[0] + result.speeds[-1]) / 2
    for row, each in enumerate(listed):
        rpm, left = each.speed * RPM, each.speed > middle
        axes.plot(rpm, row, marker="o", markersize=3.6, color=VERMILION, markeredgecolor=INK, markeredgewidth=0.6, zorder=5)
        away = f" ({100 * each.margin:+.2g} %)".replace("-", MINUS) if each.margin else ""
        met = f"mode {each.number}, {order_text(each.line.order, each.line.sources)}"
        axes.annotate(
            f"{rpm:.4g} rpm{away}: {met}", (rpm, row),
            xytext=(-5 if left else 5, 0), textcoords="offset points", ha="right" if left else "left", va="center", fontsize=6.5,
            zorder=6, bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4},
        )  # fmt: skip
    axes.set_yticks([])
    axes.set_ylim(len(listed) - 0.5, -0.5)
    axes.set_title("critical speeds within the margin, the strongest order first", fontsize=TEXT, fontweight="bold", color=INK)


def _legend(result: CampbellResult, bases: Sequence[str], margin: float) -> list[Line2D | Patch]:
    entries: list[Line2D | Patch] = []
    for index, base in enumerate(bases):
        color, dashes = line_of(index)
        entries.append(Line2D([], [], color=color, linestyle=dashes, linewidth=0.9, label=source_text(base)))
    entries.append(Line2D([], [], color=INK, linewidth=1.2, label="natural frequency"))
    dot: dict[str, Any] = {"marker": "o", "markersize": 3.6, "markeredgecolor": INK, "markeredgewidth": 0.6, "linestyle": "none"}
    entries.append(Line2D([], [], color=VERMILION, label=f"critical speed within {100 * margin:.3g} %", **dot))
    entries.append(Line2D([], [], color="white", label="critical speed beyond", **dot))
    low, high = result.operating
    single = Line2D([], [], color=INK, linewidth=0.9, linestyle=(0, (7, 2, 1, 2)), label="operating speed")
    entries.append(single if low == high else Patch(facecolor=FAINT, edgecolor=GRAY, linewidth=0.3, label="operating range"))
    entries.append(Patch(facecolor="none", edgecolor=PALE, hatch="////", linewidth=0, label=f"margin of {100 * margin:.3g} %"))
    return entries
