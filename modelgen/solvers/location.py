"""Where in a step a guard passes zero: brackets closed on the dense output to the last digits of time.

Part of ``solvers``, under ``events``. A bracket keeps a point on the old side and one on the new; the event is at the new one, so
that what holds after it finds itself on its lawful side. Method: regula falsi (Illinois) with a push toward the middle, so that
both ends close in, and bisection where that is slow (after Oliveira and Takahashi, ACM TOMS 47, 2021: never much worse than
bisection).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from modelgen.solvers.guards import BoundGuards

PLACES = (0.0, 0.5, 1.0)


def close_in(function: Callable[[float], float], a: float, b: float, fa: float, fb: float, width: float) -> float:
    """The right end of a bracket no wider than ``width``, in which a function goes over to the sign that it has at b.

    The value at a counts as being on the other side, whatever it is; so does zero.

    >>> root = close_in(lambda x: x * x - 2, 1.0, 2.0, -1.0, 2.0, 1e-15)
    >>> 0 <= root - 2**0.5 <= 1e-15
    True
    """
    new = math.copysign(1.0, fb)
    fa = -new * max(abs(fa), 1e-300)
    side = slow = 0
    while (span := b - a) > width:
        x = a + span / 2
        if slow < 2:
            guess = a + span * (fa / (fa - fb))
            x = guess + math.copysign(min(width / 2, span / 4), x - guess)
        if not a < x < b:
            x = a + span / 2
            if not a < x < b:
                break
        value = function(x)
        if value * new > 0:
            b, fb = x, value
            fa *= 0.5 if side > 0 else 1.0
            side = 1
        else:
            a, fa = x, min(value * new, -1e-300) * new
            fb *= 0.5 if side < 0 else 1.0
            side = -1
        slow = 0 if b - a <= span / 2 else (slow + 1) % 3
    return b


def crossings(guards: BoundGuards, index: int, sign: float, width: float, zero: float) -> Iterator[tuple[float, int]]:
    """The places (fractions of the step) where a guard passes zero, with its sign after each, from its sign at the start.

    A sign of 0 stands for a guard that starts at zero: the first sign that it takes is not a passing. At the ends of the halves
    values up to ``zero``, the guard's rounding, have no sign. In each half a turn toward zero and back is followed to its deepest
    point, so that a guard that dips below zero is found twice.
    """
    count = guards.start.size // 2
    values = (guards.start, guards.values[0], guards.values[1])
    g = [float(each[index]) for each in values]
    rate = [float(each[count + index]) for each in values]

    def value_at(theta: float) -> float:
        return float(guards.at(theta)[1][index])

    def rate_at(theta: float) -> float:
        return float(guards.at(theta)[1][count + index])

    left, at_left = 0.0, g[0]
    for k in (0, 1):
        points = [(PLACES[k + 1], g[k + 1], zero)]
        if sign * g[k + 1] > 0 and sign * rate[k] < 0 < sign * rate[k + 1]:
            deepest = close_in(rate_at, PLACES[k], PLACES[k + 1], rate[k], rate[k + 1], max(width, 1e-12))
            points.insert(0, (deepest, value_at(deepest), 0.0))
        for right, at_right, rounding in points:
            new = float(np.sign(at_right)) if abs(at_right) > rounding else 0.0
            if sign * new < 0 and sign * at_left <= 0 and sign * rate[k] > 0 > sign * rate[k + 1]:
                # Right after its event a guard stands a little beyond zero: its way back is no event, its return from there is.
                left = close_in(rate_at, left, right, rate[k], rate[k + 1], width)
                at_left = value_at(left)
            if sign * new < 0:
                yield close_in(value_at, left, right, at_left, at_right, width), int(new)
            if new:
                sign = new
            left, at_left = right, at_right
