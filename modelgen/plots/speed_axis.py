"""Parts shared by the figures over speed: the speed axis, names of orders, ranges of operation, and labels that keep apart.

Used by ``campbell``, ``forced``, ``damper_power`` and ``hammer``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from math import pi
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from modelgen.analysis.linear.orders import order_name, order_number
from modelgen.plots.quantities import words
from modelgen.plots.style import BLUE, GRAY, GREEN, ORANGE, PURPLE, SKY

Array = NDArray[np.float64]
RPM = 30 / pi
TIMES = "\N{MULTIPLICATION SIGN}"
DIGITS = 4  # of an order in a figure
BROWN = "#8A5A00"
LINES: tuple[tuple[str, Any], ...] = (
    (BLUE, "-"), (GREEN, (0, (5, 1.5))), (BROWN, (0, (5, 1.5, 1, 1.5))), (PURPLE, (0, (1.5, 1))), (ORANGE, (0, (9, 2))),
    (SKY, (0, (5, 1.5, 1, 1.5, 1, 1.5))), (GRAY, (0, (1, 2))),
)  # fmt: skip
"""Color and dashes of one line after the other: told apart in gray as well. Red is left to what exceeds or endangers."""


def set_speed(axes: Axes, speeds: Array) -> None:
    """The horizontal axis in revolutions per minute; a single speed stands in the middle."""
    low, high = float(speeds[0]) * RPM, float(speeds[-1]) * RPM
    axes.set_xlabel("speed of the reference shaft [rpm]")
    axes.set_xlim((low, high) if high > low else (0.95 * low, 1.05 * high))


def line_of(index: int) -> tuple[str, Any]:
    """Color and dashes of the line of a number."""
    return LINES[index % len(LINES)]


def order_text(order: Fraction | float, sources: Iterable[tuple[str, int]] | None = None) -> str:
    """An order per turn of the reference shaft; with its ``sources`` in brackets.

    >>> order_text(Fraction(3, 2)), order_text(Fraction(221, 2484))
    ('1.5', '0.08897')
    >>> order_text(Fraction(3), [("engine_half_order", 6)])
    'order 3 (engine half order × 6)'
    """
    if sources is None:
        return order_number(order, DIGITS)
    return order_name(order, sources, source_text, TIMES, DIGITS)


def source_text(base: str) -> str:
    """A base frequency in words: the clock of an element by the element.

    >>> source_text("pump_mesh.contact"), source_text("pump_crank")
    ('pump mesh', 'pump crank')
    """
    return words(base.partition(".")[0])


def spread(places: Sequence[float], gap: float, low: float, high: float) -> list[float]:
    """Places at least a gap apart between two ends, in the same order, each near its own; closer where they do not all fit.

    >>> spread([1.0, 1.2, 5.0], 1.0, 0.0, 6.0)
    [0.6, 1.6, 5.0]
    """
    if not places:
        return []
    gap = min(gap, (high - low) / max(len(places) - 1, 1))
    order = sorted(range(len(places)), key=lambda k: places[k])
    groups: list[list[float]] = []  # wanted places of labels that touch each other, less what stands before them

    def first(group: list[float]) -> float:
        return min(max(sum(group) / len(group), low), high - gap * (len(group) - 1))

    for k in order:
        groups.append([places[k]])
        while len(groups) > 1 and first(groups[-2]) + gap * len(groups[-2]) > first(groups[-1]):
            before = groups[-2]
            groups[-2:] = [before + [each - gap * len(before) for each in groups[-1]]]
    found = [first(group) + gap * index for group in groups for index in range(len(group))]
    return [round(place, 9) for _, place in sorted(zip(order, found, strict=True))]
