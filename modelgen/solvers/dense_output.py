"""Outputs between steps: a polynomial in the fraction of a step, in terms of values and slopes that the step knows.

Part of ``solvers``; filled by ``march``. A step-doubling step knows y and y' at three points, which fix a polynomial of degree
five (Hermite interpolation, error of sixth order in the step); other methods bring weights for their stages. So output times
never limit a step. Steps that hold output times are collected and evaluated many at once, which keeps the cost per output and per
step below the cost of a step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.lowering import tableau
from modelgen.solvers.problem import Vector

BLOCK = 256  # steps collected before they are evaluated
CHUNK = 4096  # output times evaluated at once: bounds the memory


@dataclass(frozen=True, eq=False)
class Interpolant:
    """How y between the ends of a step follows from its nodes: y = y0 + sum_k w_k(theta) (value_k - y0, or h slope_k).

    The nodes are the rows [y0, y0', ...]: the state at the start, then what the step hands on, of which the last two are y and y'
    at the end. ``coefficients`` (nodes, degree + 1) are those of w_k in powers of theta; ``slopes`` (nodes,) says which nodes are
    slopes. The weight of y0 itself is never used, so that no digits are lost to a large y.
    """

    coefficients: NDArray[np.float64]
    slopes: NDArray[np.bool_]

    def weights(self, theta: Any) -> Any:
        """w (nodes, n) at the fractions theta (n,) of a step.

        >>> HERMITE.weights(np.array([0.0, 0.5, 1.0]))[[2, 4]]
        array([[0., 1., 0.],
               [0., 0., 1.]])
        """
        total = np.zeros((len(self.coefficients), np.size(theta)))
        for column in self.coefficients.T[::-1]:
            total = total * theta + column[:, None]
        return total

    def between(self, theta: Any, h: Any, nodes: Any) -> tuple[Any, Any]:
        """y and y' at one theta, of nodes given as a list of (nx,) vectors; numbers or symbols."""
        y, speed = nodes[0], 0.0
        for row, slope, node in zip(self.coefficients, self.slopes, nodes, strict=True):
            if node is nodes[0]:
                continue
            weight, rate = _polynomial(row, theta), _polynomial(row[1:] * np.arange(1, row.size), theta)
            gain = h * node if slope else node - nodes[0]
            y, speed = _plus(y, weight, gain), _plus(speed, rate, gain)
        return y, speed / h


def _polynomial(coefficients: Any, theta: Any) -> Any:
    total: Any = 0.0
    for coefficient in reversed(coefficients.tolist()):
        total = total * theta + coefficient
    return total


def _plus(total: Any, weight: Any, gain: Any) -> Any:
    """total + weight gain, without a trace of what weighs nothing."""
    return total if isinstance(weight, float) and weight == 0.0 else total + weight * gain


HERMITE = Interpolant(np.array(tableau.QUINTIC, dtype=float), np.array([False, True] * 3))
"""Through start, middle and end of a step-doubling step, whose nodes are [y0, y0', ym, ym', y1, y1']."""


class DenseOutput:
    """Values at given increasing times, gathered while a run passes over them.

    ``next_time`` is the first output time not yet passed (infinite when all are); a step that ends before it is not needed.
    """

    def __init__(self, times: Vector, t0: float, size: int, interpolant: Interpolant = HERMITE) -> None:
        self.times, self.interpolant = times, interpolant
        self.values = np.zeros((times.size, size))
        self.next_time = float(times[0])
        self._passed = 0  # output times that lie in recorded steps
        self._evaluated = 0
        self._steps = 0
        self._start, self._width = np.zeros(BLOCK), np.zeros(BLOCK)
        self._nodes = np.zeros((BLOCK, interpolant.slopes.size, size))
        if times[0] == t0:
            self._advance(t0)
            self._evaluated = self._passed  # the start itself is zero in coordinates that count from it

    def record(self, t: float, h: float, until: float, start: Vector, rest: Vector) -> None:
        """Note the step of h from t, which holds ``until`` its end or an event: [y0, y0'] (2, nx), and its other nodes."""
        index = self._steps
        self._start[index], self._width[index] = t, h
        self._nodes[index, :2], self._nodes[index, 2:] = start, rest
        self._steps += 1
        self._advance(until)
        if self._steps == BLOCK:
            self._evaluate()

    def reached(self) -> Vector:
        """The values (n, nx) at all output times that were passed."""
        self._evaluate()
        return self.values[: self._evaluated]

    def _advance(self, t: float) -> None:
        self._passed = int(np.searchsorted(self.times, t, side="right"))
        self.next_time = float(self.times[self._passed]) if self._passed < self.times.size else np.inf

    def _evaluate(self) -> None:
        starts = self._start[: self._steps]
        for first in range(self._evaluated, self._passed, CHUNK):
            last = min(first + CHUNK, self._passed)
            # The step that ends at an output time holds it, hence "left".
            step: NDArray[np.intp] = np.searchsorted(starts, self.times[first:last], side="left") - 1
            width = self._width[step]
            weights = self.interpolant.weights((self.times[first:last] - starts[step]) / width)
            weights[self.interpolant.slopes] *= width
            nodes = self._nodes[step]
            origin = nodes[:, 0]
            self.values[first:last] = origin + sum(
                weights[k, :, None] * (nodes[:, k] if self.interpolant.slopes[k] else nodes[:, k] - origin)
                for k in range(1, len(weights))
            )
        self._evaluated, self._steps = self._passed, 0
