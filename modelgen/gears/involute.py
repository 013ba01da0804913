"""The involute function and its inverse.

Used by the tooth (thickness at a radius) and by the mesh (working pressure angle from the profile shifts).
Source: ISO 21771:2007, 4.2; any text on involute gearing.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def involute(angle: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """inv(angle) = tan(angle) - angle [rad].

    >>> round(float(involute(math.radians(20))), 9)
    0.014904384
    """
    return np.tan(angle) - angle


def angle_of_involute(value: float) -> float:
    """The angle [rad] in [0, pi/2) whose involute function is ``value`` >= 0, to rounding.

    Newton's method: inv is convex and increasing, so every step after the first comes down on the root from above.

    >>> round(math.degrees(angle_of_involute(0.014904383867336446)), 12)
    20.0
    """
    root = value ** (1 / 3)
    # Between the two limits of inv: angle**3 / 3 near zero, and pi/2 for large values.
    angle = min(3 ** (1 / 3) * root, math.atan(value + math.pi / 2))
    for _ in range(60):
        if angle <= 0:
            break
        step = (math.tan(angle) - angle - value) / math.tan(angle) ** 2
        angle -= step
        if abs(step) <= 1e-15 * angle:
            break
    return angle
