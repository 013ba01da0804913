"""The signs of a driveline drawing, seen from the side: disk, shaft, meshing wheels, torque, ground. Lengths in cm.

Part of ``drawing``. Where a sign takes room, a function of its place gives the box, so that room can be made before drawing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, Rectangle

from modelgen.plots.labels import Box
from modelgen.plots.style import BLUE, GRAY, INK, VERMILION

DISK, WHEEL, TOOTH = 0.30, 0.20, 0.13  # widths of a disk and a wheel, height of a tooth
ARROW = (0.30, 0.25)  # half width and rise of the arrow of a torque
ARROW_STEP = 0.37  # between one arrow and the next on the same node, for its name
GROUND = 0.62  # from a node down to ground
STEEL, BRASS, BRONZE = "#D5E0EA", "#F4E6D0", "#7A5310"  # disks, wheels, what is written about wheels


def disk_box(x: float, y: float, half_height: float) -> Box:
    """What a disk takes."""
    return x - DISK / 2, y - half_height, x + DISK / 2, y + half_height


def disk(axes: Axes, x: float, y: float, half_height: float, count: int = 1) -> None:
    """An inertia, or several side by side."""
    width = DISK / count
    for index in range(count):
        corner = (x - DISK / 2 + index * width, y - half_height)
        axes.add_patch(Rectangle(corner, width, 2 * half_height, facecolor=STEEL, edgecolor=INK, linewidth=0.8, zorder=4))


def bare_node(axes: Axes, x: float, y: float) -> None:
    """A node without an inertia of its own."""
    axes.plot([x], [y], marker="o", markersize=3.0, color=INK, zorder=5)


def shaft(axes: Axes, *points: tuple[float, float]) -> None:
    """A shaft along points."""
    x, y = zip(*points, strict=True)
    axes.plot(x, y, color=INK, linewidth=1.8, solid_capstyle="butt", solid_joinstyle="miter", zorder=3)


def distant_gear(axes: Axes, *points: tuple[float, float]) -> None:
    """A gear pair whose wheels stand too far from each other to be drawn in mesh."""
    x, y = zip(*points, strict=True)
    axes.plot(x, y, color=GRAY, linewidth=0.9, linestyle=(0, (4, 2)), zorder=2)


def wheel_box(x: float, y: float, radius: float) -> Box:
    """What a wheel takes."""
    return x - WHEEL / 2, y - radius, x + WHEEL / 2, y + radius


def wheel(axes: Axes, x: float, y: float, radius: float) -> None:
    """A wheel, with its teeth as bands at the rim."""
    left, low, right, _ = wheel_box(x, y, radius)
    axes.add_patch(Rectangle((left, low), WHEEL, 2 * radius, facecolor=BRASS, edgecolor=INK, linewidth=0.8, zorder=4))
    for rim in (y - radius, y + radius - TOOTH):
        for share in (0.0, 1 / 3, 2 / 3, 1.0):
            axes.plot([left, right], [rim + share * TOOTH] * 2, color=INK, linewidth=0.5, zorder=5)


def torque_color(drives: bool) -> str:
    """Blue where it drives, vermilion where it loads."""
    return BLUE if drives else VERMILION


def torque_box(x: float, y: float) -> Box:
    """What the arrow of a torque takes."""
    return x - ARROW[0] - 0.06, y - 0.05, x + ARROW[0] + 0.06, y + ARROW[1]


def torque(axes: Axes, x: float, y: float, drives: bool) -> None:
    """A torque, turning over the top of its disk: to the right where it drives, to the left where it loads."""
    side = 1 if drives else -1
    arrow = FancyArrowPatch(
        (x - side * ARROW[0], y), (x + side * ARROW[0], y), connectionstyle=f"arc3,rad={-side * 0.75}", arrowstyle="-|>",
        mutation_scale=6, shrinkA=0, shrinkB=0, color=torque_color(drives), linewidth=1.2, zorder=6,
    )  # fmt: skip
    axes.add_patch(arrow)


def anchor_box(x: float, y: float) -> Box:
    """What a spring or damper to ground takes."""
    return x - 0.22, y - GROUND - 0.12, x + 0.22, y


def anchor(axes: Axes, x: float, y: float, springs: bool) -> None:
    """A spring or a damper down to ground, from a point."""
    half, low = 0.11, y - GROUND
    thin: dict[str, Any] = {"color": INK, "linewidth": 0.8, "zorder": 3}
    if springs:
        turns = np.linspace(y - 0.08, low + 0.08, 9)
        axes.plot([x, *(x + half * np.array([0, 1, -1, 1, -1, 1, -1, 1, 0])), x], [y, *turns, low], **thin)
    else:
        middle = y - GROUND / 2
        axes.plot([x, x], [y, middle], **thin)
        axes.plot([x - half + 0.03, x + half - 0.03], [middle, middle], **thin)
        axes.plot([x - half, x - half, x + half, x + half], middle + np.array([0.12, -0.08, -0.08, 0.12]), **thin)
        axes.plot([x, x], [middle - 0.08, low], **thin)
    axes.plot([x - 0.2, x + 0.2], [low, low], **thin)
    for left in np.linspace(x - 0.2, x + 0.1, 4):
        axes.plot([left, left + 0.1], [low - 0.1, low], **thin)
