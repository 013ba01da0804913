"""How many times a guard passes zero within a step, and between which places: each part of the step has no root or exactly one.

Part of ``solvers``, between ``guards`` and ``location``. A guard that is a polynomial over the step is taken apart by its
Bernstein coefficients: their sign variations bound the number of roots (Descartes' rule; Lane and Riesenfeld, Bounds on a
polynomial, BIT 21, 1981), de Casteljau's scheme halves. Any other guard is taken apart by enclosures of g and g' over parts of
the step, halved until each shows no root or a guard that goes one way. What neither decides is sampled, and said to be.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.lowering.guard_kinds import ENCLOSED, POLYNOMIAL
from modelgen.lowering.step_control import DEEPEST, MOST_PLACES, TOUCH
from modelgen.solvers.dense_output import Interpolant
from modelgen.solvers.guards import BoundGuards

HALVES = (0.0, 0.5, 1.0)

Coefficients = NDArray[np.float64]


@dataclass(frozen=True)
class Place:
    """A place in a step (a fraction of it), the guard there, and the size below which it has no sign.

    ``heading``: the sign of the rate with which the guard comes to a turning point; 0 at any other place.
    """

    theta: float
    value: float
    rounding: float
    heading: float = 0.0


@dataclass(frozen=True)
class Bounds:
    """Bounds of a guard over a part of a step, and of its rate; ``turns``: sign changes of the rate, if they are known."""

    low: float
    high: float
    rate_low: float
    rate_high: float
    turns: int | None = None


class RootCounting:
    """Finds the places of one guard in the step that was taken last, between which it passes zero at most once."""

    def __init__(self, guards: BoundGuards, index: int, way: str, enclosures: Enclosures, zero: float, width: float) -> None:
        self.guards, self.index, self.way, self.zero, self.width = guards, index, way, zero, width
        self.enclosures, self.count = enclosures, guards.start.size // 2
        self.near = TOUCH * zero
        self.places: list[Place] = []
        self.decided = True

    def value(self, theta: float) -> float:
        """The guard at a fraction of the step."""
        return float(self.guards.at(theta)[1][self.index])

    def rate(self, theta: float) -> float:
        """Its rate there."""
        return float(self.guards.at(theta)[1][self.count + self.index])

    def find(self) -> list[Place]:
        """The places, from the start of the step to its end. ``decided`` says whether every root between them was counted."""
        ends = [float(each[self.index]) for each in (self.guards.start, *self.guards.values)]
        self.places = [Place(0.0, ends[0], self.zero)]
        if self.way == POLYNOMIAL:
            self._polynomial(self.guards.polynomial(self.index), 0.0, 1.0, 0)
        elif self.way == ENCLOSED:
            self._enclosed(0.0, 1.0, 0)
        else:
            self._sampled(ends)
        self.places.append(Place(1.0, ends[2], self.zero))
        return self.places

    def _polynomial(self, coefficients: Coefficients, a: float, b: float, depth: int) -> None:
        steps = np.diff(coefficients)
        changes = int(np.count_nonzero(np.diff(np.sign(steps[steps != 0]))))
        bounds = Bounds(
            float(coefficients.min()), float(coefficients.max()), float(steps.min()), float(steps.max()), turns=changes
        )
        if not self._done(bounds, a, b, depth):
            left, right = halved(coefficients)
            middle = a + (b - a) / 2
            self._polynomial(left, a, middle, depth + 1)
            self._look_at(middle)
            self._polynomial(right, middle, b, depth + 1)

    def _enclosed(self, a: float, b: float, depth: int) -> None:
        if not self._done(self.enclosures.over(self.index, a, b), a, b, depth):
            middle = a + (b - a) / 2
            self._enclosed(a, middle, depth + 1)
            self._look_at(middle)
            self._enclosed(middle, b, depth + 1)

    def _look_at(self, theta: float) -> None:
        self.places.append(Place(theta, self.value(theta), self.zero))

    def _done(self, bounds: Bounds, a: float, b: float, depth: int) -> bool:
        """Whether a part needs no halving: there is no root, the guard goes one way, or it turns once."""
        if bounds.low > self.near or bounds.high < -self.near or bounds.rate_low >= 0 or bounds.rate_high <= 0:
            return True
        small = -self.near <= bounds.low and bounds.high <= self.near
        last = depth >= DEEPEST or len(self.places) >= MOST_PLACES
        if not (bounds.turns == 1 or small or last):
            return False
        self.decided &= bounds.turns == 1 or small
        self._turn(a, b)
        return True

    def _turn(self, a: float, b: float) -> None:
        """Look at the guard where it turns, if its rates at both ends say that it does."""
        at_a, at_b = self.rate(a), self.rate(b)
        if at_a * at_b < 0:
            place = close_in(self.rate, a, b, at_a, at_b, self.width)
            self.places.append(Place(place, self.value(place), 0.0, math.copysign(1.0, at_a)))

    def _sampled(self, ends: list[float]) -> None:
        for k in (0, 1):
            self._turn(HALVES[k], HALVES[k + 1])
            if k == 0:
                self.places.append(Place(0.5, ends[1], self.zero))


class Enclosures:
    """Bounds of all guards over parts of one step, by interval arithmetic on the ranges of the states there."""

    def __init__(self, bounds: ca.Function, interpolant: Interpolant, guards: BoundGuards, scales: NDArray[np.float64]) -> None:
        self.bounds, self.guards, self.interpolant = bounds, guards, interpolant
        self.n = guards.bound.state.shape[1]
        self.x0, self.scale, self.p = scales[: self.n], scales[self.n : 2 * self.n], scales[2 * self.n :]
        self.weights = bernstein_weights(interpolant)
        self.known: dict[tuple[float, float], NDArray[np.float64]] = {}
        self.coefficients: Coefficients | None = None

    def over(self, index: int, a: float, b: float) -> Bounds:
        """The bounds of one guard over the part of the step from a to b."""
        if (a, b) not in self.known:
            self.known[a, b] = self._evaluate(a, b)
        rows = self.known[a, b]
        count = len(rows) // 4
        low, rate_low, high, rate_high = (float(rows[place + index]) for place in (0, count, 2 * count, 3 * count))
        return Bounds(low, high, rate_low, rate_high)

    def _evaluate(self, a: float, b: float) -> NDArray[np.float64]:
        bound = self.guards.bound
        t, h = float(bound.time[0]), float(bound.size[0])
        if self.coefficients is None:
            nodes = np.concatenate([bound.state, bound.nodes])
            gains = np.where(self.interpolant.slopes[:, None], h * nodes, nodes - nodes[0])
            self.coefficients = nodes[0] + self.weights.T @ gains
        part = part_of(self.coefficients, a, b)
        speed = (len(part) - 1) / ((b - a) * h) * np.diff(part, axis=0)
        x = [self.x0 + self.scale * each for each in (part.min(axis=0), part.max(axis=0))]
        v = [self.scale * each for each in (speed.min(axis=0), speed.max(axis=0))]
        ends = np.concatenate([*v, [t + a * h, t + b * h]])
        found: NDArray[np.float64] = np.array(self.bounds(t, np.concatenate(x), ends, self.p)).ravel()
        return found


@functools.lru_cache(maxsize=16)
def bernstein_weights(interpolant: Interpolant) -> NDArray[np.float64]:
    """What the gain of each node weighs in each Bernstein coefficient of the dense output: (nodes, degree + 1)."""
    degree = interpolant.coefficients.shape[1] - 1
    turned = [[math.comb(i, j) / math.comb(degree, j) for j in range(degree + 1)] for i in range(degree + 1)]
    weights: NDArray[np.float64] = interpolant.coefficients @ np.array(turned).T
    return weights


def halved(coefficients: Coefficients) -> tuple[Coefficients, Coefficients]:
    """The Bernstein coefficients (degree + 1, ...) of both halves of a polynomial, by de Casteljau's scheme.

    >>> halved(np.array([0.0, 0.0, 1.0]))  # a square
    (array([0.  , 0.  , 0.25]), array([0.25, 0.5 , 1.  ]))
    """
    return _split(coefficients, 0.5)


def part_of(coefficients: Coefficients, a: float, b: float) -> Coefficients:
    """The Bernstein coefficients of a polynomial over the part from a to b."""
    right = _split(coefficients, a)[1] if a > 0 else coefficients
    return _split(right, (b - a) / (1 - a))[0] if b < 1 else right


def _split(coefficients: Coefficients, at: float) -> tuple[Coefficients, Coefficients]:
    row, left, right = coefficients, [coefficients[0]], [coefficients[-1]]
    while len(row) > 1:
        row = (1 - at) * row[:-1] + at * row[1:]
        left.append(row[0])
        right.append(row[-1])
    return np.array(left), np.array(right[::-1])


def close_in(function: Callable[[float], float], a: float, b: float, fa: float, fb: float, width: float) -> float:
    """The right end of a bracket no wider than ``width``, in which a function goes over to the sign that it has at b.

    The value at a counts as being on the other side, whatever it is; so does zero. Method: regula falsi (Illinois) with a push
    toward the middle, so that both ends close in, and bisection where that is slow (after Oliveira and Takahashi, ACM TOMS 47,
    2021: never much worse than bisection).

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
