"""Scaled coordinates: every solver integrates y = (x - x0) / scale, so that a tolerance means the same for all of them.

Part of ``solvers``, between a problem and any solver. Counting from the start instead of from zero makes a constant added to a
state that acts on nothing (1e6 rad along a rigid rotation) drop out exactly: no digits are lost to it, and no error weight
grows with it. The start and the scale are parameters of the functions, so that a new start does not build them anew.
"""

from __future__ import annotations

import functools
from typing import Any

import casadi as ca
import numpy as np

from modelgen.solvers.outcome import Ending, Outcome
from modelgen.solvers.problem import InitialValueProblem, Statistics, Trajectory, Vector

LARGEST_INLINE = 20_000  # instructions; building a step from copies of the function takes some 50 us for each


def symbols_for(function: ca.Function) -> Any:
    """SX where the function is to be written out operation by operation (twice as fast), MX where it is to be called.

    Called are functions that CasADi cannot write out, and those so large that writing them out would take seconds.
    """
    inline = function.is_a("SXFunction") and function.n_instructions() <= LARGEST_INLINE
    return ca.SX if inline else ca.MX


@functools.lru_cache(maxsize=16)
def scaled_rate(rhs: ca.Function) -> ca.Function:
    """The function (t, y, q) -> y' of a right-hand side (t, x, p) -> x', with x = x0 + scale y and q = [x0, scale, p].

    >>> t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p")
    >>> rate = scaled_rate(ca.Function("decay", [t, x, p], [-p * x]))
    >>> rate(0, 0.5, [10, 2, 3])  # x = 11, x' = -33, y' = x' / 2
    DM(-16.5)
    """
    n, m = rhs.numel_in(1), rhs.numel_in(2)
    symbols = symbols_for(rhs)
    t, y, q = symbols.sym("t"), symbols.sym("y", n), symbols.sym("q", 2 * n + m)
    x0, scale, p = q[:n], q[n : 2 * n], q[2 * n :]
    arguments = (t, x0 + scale * y, p) if m else (t, x0 + scale * y, symbols(*rhs.size_in(2)))
    return ca.Function("rate", [t, y, q], [rhs(*arguments) / scale], ["t", "y", "q"], ["ydot"])


class ScaledProblem:
    """A problem in scaled coordinates: its rate function, the parameter vector of that, and the way back to states.

    The flags of the present modes stand in ``parameters``. ``rates(t, y)`` evaluates y' numerically;
    ``states(y)`` gives x for one y (nx,) or a stack of them (n, nx).
    """

    def __init__(self, problem: InitialValueProblem) -> None:
        self.problem = problem
        self.size = problem.x0.size
        self.rate = scaled_rate(problem.rhs)
        self.parameters = self.parameters_from(np.zeros(self.size))
        self._time, self._y, self._ydot = np.zeros(1), np.zeros(self.size), np.zeros(self.size)
        self._buffer, self._evaluate = self.rate.buffer()
        for index, array in enumerate((self._time, self._y, self.parameters)):
            self._buffer.set_arg(index, array.data)
        self._buffer.set_res(0, self._ydot.data)

    def parameters_from(self, y: Vector) -> Vector:
        """The vector q for coordinates that count from the state at y instead of from the start."""
        return np.concatenate([self.states(y), self.problem.scale, self.problem.p])

    def rates(self, t: float, y: Vector) -> Vector:
        """y' at a time and a place; what the function gives, finite or not."""
        self._time[0], self._y[:] = t, y
        self._evaluate()
        return self._ydot.copy()

    def states(self, y: Vector) -> Vector:
        """x = x0 + scale y."""
        return self.problem.x0 + self.problem.scale * y

    def trajectory(self, reached: Vector, ending: Ending, statistics: Statistics) -> Trajectory:
        """The trajectory of the y (n, nx) at the output times that were reached; success never carries a non-finite value."""
        finite = np.isfinite(reached).all(axis=1)
        count = len(reached) if finite.all() else int(np.argmin(finite))
        states = self.states(reached[:count])
        if count < len(reached) and ending.outcome.is_good:
            state = int(np.argmin(np.isfinite(reached[count])))
            time, value = float(self.problem.times[count]), float(reached[count, state])
            sentence = Outcome.NON_FINITE_STATE.sentence(time=time, state=self.problem.names[state], value=value)
            ending = Ending(Outcome.NON_FINITE_STATE, sentence)
        return Trajectory(self.problem.times[:count], states, *ending, statistics)
