"""Question: into how many separate groups do the points of a section fall?

Below ``motion_evidence``; knows points only. Two points belong together where a chain of points leads from one to the other with
no step longer than a tenth of the whole spread. Stragglers make no group.
Source: single-linkage clustering, R. Sibson, Computer Journal 16 (1973) 30-34.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEP = 0.1
"""Longest step within a group, as a part of the extent of all points."""
LEAST = 0.05
"""Part of the points that makes a group."""


def groups(points: Array, closeness: float | Array = 0.0, fewest: int = 3) -> int:
    """Number of groups of points (points, coordinates), each coordinate counted in its own extent.

    Points nearer than ``closeness`` in a coordinate (a number, or one for each coordinate) are one point there. ``fewest`` points
    make a group, or a twentieth of all if that is more.

    >>> turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    >>> circle = np.column_stack([np.cos(turn), np.sin(turn)])
    >>> groups(circle), groups(np.concatenate([circle, circle + 9.0])), groups(np.zeros((20, 2)))
    (1, 2, 1)
    """
    extent = np.ptp(points, axis=0)
    moving = extent > closeness
    if not np.any(moving):
        return 1
    placed = points[:, moving] / extent[moving]
    near = np.linalg.norm(placed[:, None] - placed[None], axis=2) <= STEP
    left, found = set(range(len(placed))), 0
    while left:
        reached = {left.pop()}
        edge = set(reached)
        while edge:
            edge = set(np.flatnonzero(near[list(edge)].any(axis=0)).tolist()) - reached
            reached |= edge
        left -= reached
        found += len(reached) >= max(fewest, LEAST * len(placed))
    return found
