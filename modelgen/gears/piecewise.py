"""Nodes for periodic functions that are smooth between known breaks.

Mesh stiffness jumps where a tooth pair enters or leaves contact and is analytic in between, so Gauss-Legendre panels that end at
the breaks converge to rounding, where equidistant samples would miss each jump by half a step. Phases count in periods.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

PeriodicFunction = Callable[[NDArray[np.float64]], NDArray[np.float64]]

_POINTS = 16
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(_POINTS)
# On [0, 1], as one panel of unit length.
_NODES, _WEIGHTS = (_NODES + 1) / 2, _WEIGHTS / 2
_SHORTEST = 1e-13


def pieces(breaks: Sequence[float]) -> list[tuple[float, float]]:
    """The intervals of one period [0, 1] between breaks (taken modulo 1), those of rounding length left out.

    >>> pieces([0.0, 0.75])
    [(0.0, 0.75), (0.75, 1.0)]
    """
    ends = [0.0, *sorted(phase % 1.0 for phase in breaks), 1.0]
    return [(start, end) for start, end in pairwise(ends) if end - start > _SHORTEST]


def gauss_nodes(breaks: Sequence[float], waves: int = 1) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Phases and weights of one period; ``waves`` is the highest harmonic that shall still be integrated to rounding."""
    phases, weights = [], []
    for start, end in pieces(breaks):
        # 16 nodes see half a wave, and a sixteenth of a base pitch even of nearly pointed teeth, to rounding.
        count = math.ceil((end - start) * max(2 * waves, 16))
        length = (end - start) / count
        panels = start + length * np.arange(count)
        phases.append((panels[:, None] + length * _NODES).ravel())
        weights.append(np.tile(length * _WEIGHTS, count))
    return np.concatenate(phases), np.concatenate(weights)


def sample_phases(breaks: Sequence[float], per_period: int) -> NDArray[np.float64]:
    """Phases for looking at a function, both sides of every break included (a rounding away from it)."""
    sets = [
        np.linspace(start + _SHORTEST / 4, end - _SHORTEST / 4, max(3, math.ceil(per_period * (end - start)) + 1))
        for start, end in pieces(breaks)
    ]
    return np.concatenate(sets)


def window_average(
    function: PeriodicFunction, breaks: Sequence[float], width: float, phase: NDArray[np.float64] | float
) -> NDArray[np.float64]:
    """(1/width) times the integral of a function of period 1 from phase - width to phase; ``width`` > 0 in periods.

    >>> float(window_average(lambda phase: phase % 1.0, [0.0], 0.5, 0.25))  # half of 0 ... 0.25, half of 0.75 ... 1
    0.5
    """
    turns, remainder = divmod(width, 1.0)
    last = np.asarray(phase, dtype=float) % 1.0
    first = last - remainder
    integral, covered = np.zeros(last.shape), np.zeros(last.shape)
    for start, end in _panels(breaks):
        left, right = np.clip(first, start, end), np.clip(last, start, end)
        inside = right > left
        length = (right - left)[inside]
        covered[inside] += length
        integral[inside] += length * (function(left[inside][:, None] + length[:, None] * _NODES) @ _WEIGHTS)
    if turns == 0:
        # Dividing by what was covered instead of the width keeps narrow windows free of rounding.
        return integral / covered
    phases, weights = gauss_nodes(breaks)
    return (integral + turns * (weights @ function(phases))) / width


def _panels(breaks: Sequence[float]) -> list[tuple[float, float]]:
    """The period before and this one, cut at the breaks and into panels of an eighth of a period."""
    panels = []
    for start, end in pieces(breaks):
        ends = np.linspace(start, end, math.ceil(8 * (end - start)) + 1)
        panels += [(float(left) + turn, float(right) + turn) for turn in (-1.0, 0.0) for left, right in pairwise(ends)]
    return panels
