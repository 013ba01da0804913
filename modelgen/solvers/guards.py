"""Guards over a step as CasADi functions: their values and rates, what of them a step resolves, and what may have crossed zero.

Part of ``solvers``; bound to a step by ``march``, read by ``events``. One call per step gives all that a step without an event
needs, so that guards which never fire cost little.

A step must resolve a guard that moves faster than the state: the cubic through the values and rates g, g' at both ends is
compared with value and rate in the middle, relative to the guard's size over the step (both, because either alone vanishes at
times, and a fast guard would slip through). Where a guard keeps its sign but turns toward zero and back within a half step, it
may have crossed twice; if it is convex there, as the resolution makes likely, it stays beyond the point where its tangents meet.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.lowering.switching import Switching
from modelgen.solvers.dense_output import Interpolant
from modelgen.solvers.method import BoundStep, bind
from modelgen.solvers.problem import InitialValueProblem, Vector

RESOLUTION = 0.02  # of a guard's size: how far the cubic may be from it
DIP = 0.1  # of a guard's size: a dip that stays further away from zero is not searched
TINY = 1e-300


@dataclass(frozen=True, eq=False)
class GuardFunctions:
    """``watch`` looks at a whole step, ``at`` at one theta of it (y, then guards and their rates), ``rates`` at one (t, y, y').

    In scaled coordinates, like the step: q = [x0, scale, p].
    """

    watch: ca.Function
    at: ca.Function
    rates: ca.Function


@functools.lru_cache(maxsize=16)
def guard_functions(switching: Switching, interpolant: Interpolant, n: int) -> GuardFunctions:
    """The functions of the guards of a problem with n states over the steps of a method."""
    count, rows = len(switching.crossings), interpolant.slopes.size
    scalars = t, h, theta = ca.SX.sym("t"), ca.SX.sym("h"), ca.SX.sym("theta")
    state, rest = ca.SX.sym("state", n, 2), ca.SX.sym("nodes", n, rows - 2)
    q, y, slope = ca.SX.sym("q", 2 * n + switching.p_size), ca.SX.sym("y", n), ca.SX.sym("slope", n)
    x0, scale, p = q[:n], q[n : 2 * n], q[2 * n :]
    nodes = [*ca.horzsplit(state), *ca.horzsplit(rest)]

    def rates(time: Any, place: Any, speed: Any) -> Any:
        return switching.guard_rates(time, x0 + scale * place, scale * speed, p)

    def inside(fraction: Any) -> tuple[Any, Any]:
        place, speed = interpolant.between(fraction, h, nodes)
        return place, rates(t + fraction * h, place, speed)

    middle, end = inside(0.5)[1], rates(t + h, rest[:, -2], rest[:, -1])
    start, floors = ca.SX.sym("start", 2 * count), ca.SX.sym("floors", count)
    total, worst, suspicion = ca.SX(0), ca.SX(0), ca.SX(0)
    for same in _surfaces(switching):
        index, flags = same[0], [_flag(switching, each, p) for each in same]
        active: Any = ca.SX(1) if None in flags else sum(flags) > 0.5
        g, rate = ([values[index + offset] for values in (start, middle, end)] for offset in (0, count))
        size = functools.reduce(ca.fmax, [ca.fabs(each) for each in (*g, *(h * each for each in rate))], floors[index])
        off = ca.fabs((g[0] + g[2]) / 2 + h / 8 * (rate[0] - rate[2]) - g[1])
        off_rate = ca.fabs(1.5 * (g[2] - g[0]) - h * ((rate[0] + rate[2]) / 4 + rate[1]))
        worst = ca.fmax(worst, ca.if_else(active, ca.fmax(off, off_rate / 8) / (RESOLUTION * size), 0))
        total += ca.if_else(active, off + off_rate, 0)
        suspect = ca.logic_or(g[0] * g[1] <= 0, g[0] * g[2] <= 0)
        s = ca.sign(g[0])
        for k in (0, 1):
            closing = ca.logic_and(s * rate[k] < 0, s * rate[k + 1] > 0)
            crossed = (g[k + 1] - h / 2 * rate[k + 1] - g[k]) / (rate[k] - rate[k + 1])  # where tangents meet, from point k
            suspect = ca.logic_or(suspect, ca.logic_and(closing, s * (g[k] + crossed * rate[k]) < DIP * size))
        suspicion = ca.fmax(suspicion, ca.logic_and(active, suspect))
    options = {"cse": True}
    step = [t, h, state, rest, q]
    measures = ca.vertcat(worst + TINY * total, suspicion)  # a maximum would hide NaN
    return GuardFunctions(
        watch=ca.Function("watch", [*step, start, floors], [ca.densify(ca.vertcat(middle, end)), measures], options),
        at=ca.Function("at", [scalars[0], h, theta, state, rest, q], [ca.densify(ca.vertcat(*inside(theta)))], options),
        rates=ca.Function("rates", [t, y, slope, q], [ca.densify(rates(t, y, slope))], options),
    )


def _surfaces(switching: Switching) -> list[list[int]]:
    """The numbers of the crossings, those with the same guard together."""
    t, x, p = (ca.SX.sym(name, switching.guards.numel_in(index)) for index, name in enumerate("txp"))
    guards = ca.cse(ca.densify(switching.guards(t, x, p)))
    found: list[list[int]] = []
    for index in range(len(switching.crossings)):
        known = next((same for same in found if ca.is_equal(guards[same[0]], guards[index], 20)), None)
        if known is None:
            found.append([index])
        else:
            known.append(index)
    return found


def _flag(switching: Switching, index: int, p: Any) -> Any:
    """The flag of the mode in which a crossing is watched; None if that is always."""
    crossing = switching.crossings[index]
    if crossing.variable is None or crossing.leave is None:
        return None
    return p[switching.modes[crossing.variable].first + crossing.leave]


def guard_floors(switching: Switching, problem: InitialValueProblem, tolerance: float) -> tuple[Vector, Vector]:
    """Per guard, the size below which it means nothing, and the size of its rounding: both by its derivatives at the start.

    An error of a state of ``tolerance`` times its scale moves a guard by the first; the last digits of the states by the second.
    """
    steepness = np.abs(np.array(_gradient(switching)(problem.t0, problem.x0, problem.p)))
    steepness = np.where(np.isfinite(steepness), steepness, 0.0).reshape(len(switching.crossings), problem.x0.size)
    floors = tolerance * steepness @ problem.scale + TINY
    return floors, 64 * np.finfo(float).eps * steepness @ (np.abs(problem.x0) + problem.scale)


@functools.lru_cache(maxsize=16)
def _gradient(switching: Switching) -> ca.Function:
    """(t, x, p) -> derivatives of the guards by the states (ng, nx)."""
    guards = switching.guards
    t, x, p = (ca.SX.sym(name, guards.numel_in(index)) for index, name in enumerate("txp"))
    return ca.Function("gradient", [t, x, p], [ca.densify(ca.jacobian(guards(t, x, p), x))])


class BoundGuards:
    """The guards over one bound step: ``watch`` after each step that is good enough, ``at`` for a closer look.

    ``start`` (2 ng: guards, rates) and ``floors`` (ng) are shared with whoever keeps them. ``suspicious``: whether a guard may
    have crossed zero since the sign that it had at the start of the step.
    """

    def __init__(self, functions: GuardFunctions, bound: BoundStep, q: Vector, start: Vector, floors: Vector) -> None:
        self.start, self.suspicious = start, False
        self.values, self.measures = np.zeros((2, start.size)), np.zeros(2)
        self.end = self.values[1]
        self._size = bound.nodes.shape[1]
        self._theta, self._result = np.zeros(1), np.zeros(self._size + start.size)
        step = (bound.time, bound.size, bound.state, bound.nodes, q, start, floors)
        self._watch, self._evaluate = bind(functions.watch, step, (self.values, self.measures))
        arguments = (bound.time, bound.size, self._theta, bound.state, bound.nodes, q)
        self._at, self._evaluate_at = bind(functions.at, arguments, (self._result,))
        self._kept_alive = bound, q, floors

    def watch(self) -> float:
        """Look at the step just evaluated; how much of a guard it leaves unresolved: 1 is allowed.

        Infinite where a guard is not a number. ``suspicious`` says whether a guard may have crossed zero.
        """
        self._evaluate()
        unresolved, suspicion = self.measures.tolist()
        self.suspicious = suspicion != 0
        return unresolved if unresolved < math.inf else math.inf

    def at(self, theta: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """y, and guards and rates [g, g'], at a fraction of the step; both are overwritten by the next call."""
        self._theta[0] = theta
        self._evaluate_at()
        return self._result[: self._size], self._result[self._size :]
