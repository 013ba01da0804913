"""Figure of the limits: how much of each limit is used, passed or failed, and which rules were taken on trust.

Draws ``LimitsResult`` of ``modelgen.analysis.limits``. Utilization is value / limit, for a least value limit / value; 100 % is
the limit. Rows whose rule's own text was not seen are hatched, and the rules named.
"""

from __future__ import annotations

import re
from math import inf

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from modelgen.analysis.limits.check import LimitRow, LimitsResult
from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import display, number, words
from modelgen.plots.speed_axis import TIMES
from modelgen.plots.style import BLUE, GRAY, INK, SMALL, TEXT, VERMILION, filled, sheet, styled, width_of

ROW, DOUBLE = 0.52, 0.86  # cm
BETWEEN = " / "  # a mode and its order
WIDEST = 200.0  # percent; longer bars are cut and say so by an arrow
NAME = 5.0  # cm for the name of a row
HATCH = "/////"
SIGNS = {"at most": "(\N{LESS-THAN OR EQUAL TO}", "at least": "(\N{GREATER-THAN OR EQUAL TO}", "outside": "(outside"}


@plot.register
@styled
def plot_limits(result: LimitsResult, /, *, count: int = 16) -> Figure:
    """Utilization of every limit, a panel per rule, the ``count`` most used rows of each.

    Raises CaseError for a result without rows.
    """
    where = f"limits of {result.model!r}"
    if not result.rows or count < 1:
        raise CaseError(where, f"{count} of {len(result.rows)} rows are to be drawn", "there must be at least one")
    rules: dict[str, list[LimitRow]] = {}
    for row in result.rows:
        rules.setdefault(row.rule, []).append(row)
    shown = {name: sorted(rows, key=lambda row: -_used(row))[:count] for name, rows in rules.items()}
    heights = [_row(rows) * len(rows) + 0.3 for rows in shown.values()]
    figure = sheet(result.model, "limits", _detail(result, shown), height=sum(heights) + 1.15 * len(heights) + 1.5)
    every = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    longest = max([100.0, *(min(_used(row), WIDEST) for rows in shown.values() for row in rows)])
    for axes, rows in zip(every, shown.values(), strict=True):
        _bars(axes, rows)
        mark = "" if rows[0].verified else ", rule not verified"
        title = "\n".join(filled(f"{rows[0].title} [{rows[0].rule}]{mark}", TEXT, 10.5))
        axes.set_title(title, fontsize=TEXT, fontweight="bold", color=INK)
        axes.set_xlim(0, 1.02 * longest)
    every[-1].set_xlabel("part of the limit that is used [%]")
    figure.legend(handles=_legend(result), loc="outside lower center", ncols=4)
    return figure


def _detail(result: LimitsResult, shown: dict[str, list[LimitRow]]) -> str:
    verdicts = {verdict: len(result.with_verdict(verdict)) for verdict in ("pass", "fail", "not judged")}
    counts = ", ".join(f"{count} {verdict}" for verdict, count in verdicts.items() if count)
    hidden = len(result.rows) - sum(map(len, shown.values()))
    parts = [f"{counts[:1].upper()}{counts[1:]}."]
    if hidden:
        parts.append(f"{hidden} rows with more left are not shown.")
    if any(_used(row) > WIDEST for rows in shown.values() for row in rows):
        parts.append(f"Arrow: the bar ends at {WIDEST:g} %, the value beyond.")
    if result.unverified:
        parts.append(f"Hatched: the text of the rule itself was not seen ({', '.join(result.unverified)}).")
    return " ".join([*parts, *(f"{remark[:1].upper()}{remark[1:]}." for remark in result.remarks)])


def _used(row: LimitRow) -> float:
    """Utilization in percent; below zero where the rule does not judge."""
    if row.margin is None:
        return -1.0
    if row.comparison == "at least":
        return 100 / (1 + row.margin) if row.margin > -1 else inf
    return 100 * (1 - row.margin)


def _bars(axes: Axes, rows: list[LimitRow]) -> None:
    for index, row in enumerate(rows):
        used = _used(row)
        drawn = min(max(used, 0.0), WIDEST)
        axes.barh(index, drawn, 0.62, color=VERMILION if row.verdict == "fail" else BLUE, hatch=None if row.verified else HATCH,
                  edgecolor="white", linewidth=0, zorder=3)  # fmt: skip
        cut = " \N{RIGHTWARDS ARROW}" if used > WIDEST else ""
        axes.annotate(f"{_said(row)}{cut}", (1.0, index), xycoords=("axes fraction", "data"), xytext=(4, 0), va="center",
                      textcoords="offset points", fontsize=6.5, color=VERMILION if row.verdict == "fail" else INK,
                      annotation_clip=False)  # fmt: skip
    axes.axvline(100, color=INK, linewidth=1.2, linestyle=(0, (5, 2)), zorder=5)
    axes.set_yticks(range(len(rows)), [_label(row.element) for row in rows])
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)


def _row(rows: list[LimitRow]) -> float:
    """Height of a row [cm]; a mode and its order take two lines."""
    return DOUBLE if any(BETWEEN in row.element for row in rows) else ROW


def _label(element: str) -> str:
    """The name of a row: an element, or a mode above the order that comes near it, with its base."""
    told = re.sub(r"(?:\.\w+)? x (\d+)", f" {TIMES}\\1", element)
    return "\n".join(_fitted(words(part)) for part in told.split(BETWEEN))


def _fitted(name: str) -> str:
    """A name cut to the room that it has."""
    if width_of(name, SMALL) <= NAME:
        return name
    while width_of(f"{name}\N{HORIZONTAL ELLIPSIS}", SMALL) > NAME:
        name = name[:-1]
    return f"{name}\N{HORIZONTAL ELLIPSIS}"


def _said(row: LimitRow) -> str:
    shown = display(row.unit, max(abs(row.value), *row.limits, 0.0))
    unit = {"-": "", "deg": "°", "percent": " %"}.get(shown.unit, f" {shown.unit}")
    value = f"{number(float(shown(row.value)), 3)}{unit}"
    if row.margin is None:
        return f"{value}: not judged"
    limit = " and ".join(f"{number(float(shown(each)), 3)}{unit}" for each in row.limits)
    return f"{value} {SIGNS[row.comparison]} {limit}), {row.verdict}"


def _legend(result: LimitsResult) -> list[Patch]:
    entries = [Patch(color=color, linewidth=0, label=verdict) for verdict, color in (("pass", BLUE), ("fail", VERMILION))
               if result.with_verdict(verdict)]  # fmt: skip
    if result.unverified:
        entries.append(Patch(facecolor=GRAY, edgecolor="white", hatch=HATCH, linewidth=0, label="rule not verified"))
    return entries
