"""Outputs between steps: the quintic through start, middle and end of a step, with the slopes there.

Part of ``solvers``; filled by ``march``. A step-doubling step knows y and y' at three points, which fix a polynomial of degree
five (Hermite interpolation, error of sixth order in the step), so that output times never limit a step. Steps that hold output
times are collected and evaluated many at once, which keeps the cost per output and per step below the cost of a step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modelgen.solvers.problem import Vector

BLOCK = 256  # steps collected before they are evaluated
CHUNK = 4096  # output times evaluated at once: bounds the memory


def quintic_weights(theta: Vector) -> Vector:
    """Weights (6, n) of [y0, h y0', ym, h ym', y1, h y1'] at the fractions theta (n,) of a step.

    >>> quintic_weights(np.array([0.0, 0.5, 1.0]))[[0, 2, 4]]
    array([[1., 0., 0.],
           [0., 1., 0.],
           [0., 0., 1.]])
    """
    start, middle, end = 2 * (theta - 0.5) * (theta - 1), -4 * theta * (theta - 1), 2 * theta * (theta - 0.5)  # Lagrange's basis
    start, middle, end = start**2, middle**2, end**2
    return np.array(
        [(1 + 6 * theta) * start, theta * start, middle, (theta - 0.5) * middle, (7 - 6 * theta) * end, (theta - 1) * end]
    )


class DenseOutput:
    """Values at given increasing times, gathered while a run passes over them.

    ``next_time`` is the first output time not yet passed (infinite when all are); a step that ends before it is not needed.
    """

    def __init__(self, times: Vector, t0: float, size: int) -> None:
        self.times = times
        self.values = np.zeros((times.size, size))
        self.next_time = float(times[0])
        self._passed = 0  # output times that lie in recorded steps
        self._evaluated = 0
        self._steps = 0
        self._start, self._width = np.zeros(BLOCK), np.zeros(BLOCK)
        self._nodes = np.zeros((BLOCK, 6, size))
        if times[0] == t0:
            self._advance(t0)
            self._evaluated = self._passed  # the start itself is zero in coordinates that count from it

    def record(self, t: float, t_end: float, start: Vector, rest: Vector) -> None:
        """Note the step from t to t_end: ``start`` holds [y0, y0'] (2, nx), ``rest`` [ym, ym', y1, y1'] (4, nx)."""
        index = self._steps
        self._start[index], self._width[index] = t, t_end - t
        self._nodes[index, :2], self._nodes[index, 2:] = start, rest
        self._steps += 1
        self._advance(t_end)
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
            weights = quintic_weights((self.times[first:last] - starts[step]) / width)
            weights[1::2] *= width
            nodes = self._nodes[step]
            # The weights of values add up to one: taken from y0, no digits are lost to a large y.
            origin = nodes[:, 0]
            self.values[first:last] = origin + sum(
                weights[k, :, None] * (nodes[:, k] - origin if k in (2, 4) else nodes[:, k]) for k in range(1, 6)
            )
        self._evaluated, self._steps = self._passed, 0
