"""What the loop of ``march`` needs of a method: one step as a CasADi function, and how to read between its ends.

Part of ``solvers``; made by ``doubled_step``, ``collocation`` and ``tableau_step``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from modelgen.solvers.dense_output import HERMITE, Interpolant
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Vector


@dataclass(frozen=True)
class Method:
    """A step function (t, h, [y, y'], q) -> (nodes, measures, ...) as ``step_doubling`` makes it, and what is known about it.

    ``control``: the power of the step in the measured error (order + 1 where one order separates a result from its companion).
    ``evaluations`` of the right-hand side per step. ``interpolant``: its nodes are [y, y'], those of ``extra`` (t, h, [y, y'],
    nodes, q) -> more nodes, which are computed only where they are needed and cost ``extra_evaluations``, then those of the step.
    ``floor_outcome``: what it means when even the smallest step cannot be evaluated.
    """

    step: ca.Function
    control: int
    evaluations: int
    interpolant: Interpolant = HERMITE
    extra: ca.Function | None = None
    extra_evaluations: int = 0
    floor_outcome: Outcome = Outcome.STEP_TOO_SMALL


class BoundStep:
    """A step function bound to arrays: in a loop, no argument is converted or allocated.

    Set ``time[0]`` and ``size[0]``, call ``evaluate``, read ``measures`` (2); call ``complete`` before reading ``nodes`` other
    than the last two, y and y' at the end. ``state`` (2, nx) is shared.
    """

    def __init__(self, method: Method, state: Vector, parameters: Vector) -> None:
        self.method, self.state = method, state
        self.time, self.size = np.zeros(1), np.zeros(1)
        self.nodes, self.measures = np.zeros((method.interpolant.slopes.size - 2, state.shape[1])), np.zeros(2)
        extra = 0 if method.extra is None else method.extra.size2_out(0)
        own = self.nodes[extra:]
        self._arguments = (self.time, self.size, state, parameters)  # the buffer does not keep them alive
        self._buffer, self._evaluate = bind(method.step, self._arguments, (own, self.measures))
        self._complete = True
        if method.extra is not None:
            arguments = (self.time, self.size, state, own, parameters)
            self._extra_buffer, self._evaluate_extra = bind(method.extra, arguments, (self.nodes[:extra],))

    def evaluate(self) -> None:
        """Compute the step."""
        self._evaluate()
        self._complete = self.method.extra is None

    def complete(self) -> int:
        """Compute the nodes that only the interpolant needs; the evaluations of the right-hand side that it took."""
        if self._complete:
            return 0
        self._evaluate_extra()
        self._complete = True
        return self.method.extra_evaluations


def bind(function: ca.Function, arguments: tuple[Vector, ...], results: tuple[Vector, ...]) -> tuple[ca.FunctionBuffer, Any]:
    """A buffer of a function over arrays that the caller keeps alive, and the call that evaluates it."""
    buffer, evaluate = function.buffer()
    for index, array in enumerate(arguments):
        buffer.set_arg(index, array.data)
    for index, array in enumerate(results):
        buffer.set_res(index, array.data)
    return buffer, evaluate
