"""Labels that keep out of each other's way: blocks of text measured in cm, put to the first free place.

Part of ``drawing``. A label brings the places it would like, best first; what is taken already are boxes. Greedy, in the order
of importance, so the same drawing always gives the same labels.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from modelgen.plots.quantities import words
from modelgen.plots.style import GRAY, INK, POINT, width_of

LINE = 1.2  # height of a line of text per letter size
AIR = 0.04  # cm between things

ROUNDING = 1e-9  # cm^2

Point = tuple[float, float]
Box = tuple[float, float, float, float]
"""Left, bottom, right, top [cm]."""


def wrapped(name: str, size: float, width: float) -> list[str]:
    """A name in as few lines as fit a width [cm], of even lengths; a word is never broken.

    >>> wrapped("pump_crank_end_2", 6.5, 1.4)
    ['pump', 'crank end 2']
    """
    return _wrapped(tuple(words(name).split()) or (name,), size, width)


def _wrapped(parts: tuple[str, ...], size: float, width: float) -> list[str]:
    for count in range(1, len(parts) + 1):
        cuts = itertools.islice(itertools.combinations(range(1, len(parts)), count - 1), 2000)  # of long names not every way
        ways = [[" ".join(parts[a:b]) for a, b in pairwise((0, *cut, len(parts)))] for cut in cuts]
        best = min(ways, key=lambda lines: max(width_of(line, size) for line in lines))
        if count == len(parts) or max(width_of(line, size) for line in best) <= width:
            return best
    return list(parts)


@dataclass(frozen=True)
class Line:
    """One line of a label."""

    text: str
    size: float
    color: str = INK


@dataclass(frozen=True)
class Block:
    """Lines of text, centered below each other."""

    lines: tuple[Line, ...]

    @classmethod
    def of(cls, name: str, size: float, width: float, *notes: str, color: str = INK) -> Block:
        """A name, wrapped, and notes in gray below it."""
        named = [Line(text, size, color) for text in wrapped(name, size, width)]
        return cls((*named, *(Line(note, size - 0.7, GRAY) for note in notes if note)))

    @functools.cached_property
    def width(self) -> float:
        return max(width_of(line.text, line.size) for line in self.lines)

    @functools.cached_property
    def height(self) -> float:
        return sum(LINE * line.size * POINT for line in self.lines)

    def draw(self, axes: Axes, box: Box) -> None:
        x, y = (box[0] + box[2]) / 2, box[3]
        for line in self.lines:
            y -= LINE * line.size * POINT / 2
            axes.text(x, y, line.text, fontsize=line.size, color=line.color, ha="center", va="center")
            y -= LINE * line.size * POINT / 2


def overlap(one: Box, other: Box) -> float:
    """Area [cm^2] that two boxes share.

    >>> overlap((0, 0, 2, 2), (1, 1, 3, 3))
    1
    """
    return max(0, min(one[2], other[2]) - max(one[0], other[0])) * max(0, min(one[3], other[3]) - max(one[1], other[1]))


@dataclass
class Room:
    """The boxes taken so far; ``lost`` [cm^2] is what could not be kept apart, ``moved`` [cm] the farthest any label went."""

    taken: list[Box] = field(default_factory=list)
    labels: list[tuple[Block, Box]] = field(default_factory=list)
    lost: float = 0.0
    moved: float = 0.0

    def take(self, *boxes: Box) -> None:
        self.taken += boxes

    def put(self, *choices: tuple[Block, Iterable[Point]], tied: bool = True) -> None:
        """Puts a label, in one of its forms, around the first free center; where none is free, where it shares least.

        A label that is not ``tied`` says by itself what it belongs to, and may go far.
        """
        spots = [(block, center) for block, centers in choices for center in centers]
        boxes = np.array([_around(block, center) for block, center in spots])
        shared = _shared(boxes, np.array(self.taken).reshape(-1, 4))
        free = np.flatnonzero(shared <= ROUNDING)
        best = int(free[0]) if len(free) else int(np.argmin(shared))
        self.lost += 0.0 if len(free) else float(shared[best])
        (block, center), (_, wish) = spots[best], spots[0]
        self.moved = max(self.moved, math.dist(center, wish) if tied else 0.0)
        box = _around(block, center)
        self.labels.append((block, box))
        self.take(box)

    @property
    def bounds(self) -> Box:
        """The box around everything."""
        left, bottom, right, top = zip(*self.taken, strict=True)
        return min(left), min(bottom), max(right), max(top)


def _around(block: Block, center: Point) -> Box:
    half_width, half_height = block.width / 2 + AIR, block.height / 2 + AIR / 2
    return center[0] - half_width, center[1] - half_height, center[0] + half_width, center[1] + half_height


def _shared(boxes: NDArray[np.float64], taken: NDArray[np.float64]) -> NDArray[np.float64]:
    """Area [cm^2] that each box shares with those taken."""
    low = np.maximum(boxes[:, None, :2], taken[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], taken[None, :, 2:])
    return np.asarray(np.prod(np.maximum(high - low, 0.0), axis=2).sum(axis=1))
