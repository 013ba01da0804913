"""Guards over a step as CasADi functions: their values and rates, what of them a step resolves, and what may have crossed zero.

Part of ``solvers``; bound to a step by ``march``, read by ``events``. One call per step gives all that a step without an event
needs, so that guards which never fire cost little.

A step must resolve a guard that moves faster than the state: the cubic through the values and rates g, g' at both ends is
compared with value and rate in the middle, relative to the guard's size over the step (both, because either alone vanishes at
times, and a fast guard would slip through).

A guard that is linear in the states cannot have crossed zero where the Bernstein coefficients of the polynomial through its three
values and rates have one sign, and stay further from zero than the polynomial may be from the guard: by its two highest powers
where the dense output has a degree above five, and by the sixth derivative of what else depends on time (the remainder of Hermite
interpolation; Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.6). Other guards with an enclosure are
always looked at. What can only be sampled may have crossed where it changes its sign, or turns toward zero and back within a half
step and the tangents meet near zero or beyond.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.lowering.guard_kinds import SAMPLED, guard_counting
from modelgen.lowering.step_control import DIP, RESOLUTION
from modelgen.lowering.switching import Switching
from modelgen.solvers.dense_output import Interpolant
from modelgen.solvers.method import BoundStep, bind
from modelgen.solvers.problem import InitialValueProblem, Vector

TINY = 1e-300
NODE_POLYNOMIAL = 1 / 432  # the largest (u (u - 1/2) (u - 1))^2 between 0 and 1
REST = NODE_POLYNOMIAL / 720
HERMITE_DEGREE = 5


@dataclass(frozen=True, eq=False)
class GuardFunctions:
    """``watch`` looks at a whole step, ``at`` at one theta of it (y, then guards and their rates), ``rates`` at one (t, y, y').

    ``high`` (ng, 2): what the guards have beyond the quintic through start, middle and end, as c0 and c1 of (c0 + c1 theta) times
    the square of theta (theta - 1/2) (theta - 1). In scaled coordinates, like the step: q = [x0, scale, p].
    """

    watch: ca.Function
    at: ca.Function
    rates: ca.Function
    high: ca.Function


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
    high = _beyond_the_quintic(interpolant, h, nodes, lambda move: rates(t + h, rest[:, -2], move)[count:])
    start, limits = ca.SX.sym("start", 2 * count), ca.SX.sym("limits", count, 3)
    ways = guard_counting(switching).ways
    total, worst, suspicion = ca.SX(0), ca.SX(0), ca.SX(0)
    for same in _surfaces(switching):
        index, flags = same[0], [_flag(switching, each, p) for each in same]
        active: Any = ca.SX(1) if None in flags else sum(flags) > 0.5
        g, rate = ([values[index + offset] for values in (start, middle, end)] for offset in (0, count))
        turns = [h * each for each in rate]
        size = functools.reduce(ca.fmax, [ca.fabs(each) for each in (*g, *turns)], limits[index, 0])
        off = ca.fabs((g[0] + g[2]) / 2 + (turns[0] - turns[2]) / 8 - g[1])
        off_rate = ca.fabs(1.5 * (g[2] - g[0]) - ((turns[0] + turns[2]) / 4 + turns[1]))
        worst = ca.fmax(worst, ca.if_else(active, ca.fmax(off, off_rate / 8) / (RESOLUTION * size), 0))
        total += ca.if_else(active, off + off_rate, 0)
        if ways[index] == SAMPLED:
            suspect = _sampled(g, turns, size, limits[index, 1])
        else:
            margin = limits[index, 1] + limits[index, 2] * h**6
            margin += NODE_POLYNOMIAL * ca.fmax(ca.fabs(high[index, 0]), ca.fabs(high[index, 0] + high[index, 1]))
            coefficients = bernstein_quintic(g, turns)
            suspect = ca.logic_not(functools.reduce(ca.fmin, [ca.sign(g[0]) * each for each in coefficients]) > margin)
        suspicion = ca.fmax(suspicion, ca.logic_and(active, suspect))
    options = {"cse": True}
    step = [t, h, state, rest, q]
    measures = ca.vertcat(worst + TINY * total, suspicion)  # a maximum would hide NaN
    return GuardFunctions(
        watch=ca.Function("watch", [*step, start, limits], [ca.densify(ca.vertcat(middle, end)), measures], options),
        at=ca.Function("at", [scalars[0], h, theta, state, rest, q], [ca.densify(ca.vertcat(*inside(theta)))], options),
        rates=ca.Function("rates", [t, y, slope, q], [ca.densify(rates(t, y, slope))], options),
        high=ca.Function("high", step, [ca.densify(high)], options),
    )


def bernstein_quintic(g: Sequence[Any], turns: Sequence[Any]) -> list[Any]:
    """The six Bernstein coefficients of the quintic through values and h times rates at start, middle and end of a step.

    >>> [round(each, 12) for each in bernstein_quintic([0.0, 0.25, 1.0], [0.0, 1.0, 2.0])]  # the square of theta
    [0.0, 0.0, 0.1, 0.3, 0.6, 1.0]
    """
    first, last = g[0] + turns[0] / 5, g[2] - turns[2] / 5
    total = 3.2 * g[1] - (g[0] + g[2]) / 10 - (first + last) / 2
    step = 1.6 * turns[1] + (g[0] - g[2]) / 2 + 1.5 * (first - last)
    return [g[0], first, (total - step) / 2, (total + step) / 2, last, g[2]]


def _beyond_the_quintic(interpolant: Interpolant, h: Any, nodes: list[Any], rates_of: Callable[[Any], Any]) -> Any:
    """c0 and c1 of guards that are linear in the states, from the powers six and seven of the dense output."""
    n, degree = nodes[0].numel(), interpolant.coefficients.shape[1] - 1
    powers = []
    for power in (6, 7):
        total = ca.SX.zeros(n)
        for row, slope, node in zip(interpolant.coefficients, interpolant.slopes, nodes, strict=True):
            if node is not nodes[0] and power <= degree and row[power]:
                total = total + row[power] * (h * node if slope else node - nodes[0])
        powers.append(total)
    still = rates_of(ca.SX.zeros(n))
    six, seven = ((rates_of(each) - still) if degree > HERMITE_DEGREE else 0 * still for each in powers)
    return ca.horzcat(six + 3 * seven, seven)


def _sampled(g: Sequence[Any], turns: Sequence[Any], size: Any, near: Any) -> Any:
    suspect = functools.reduce(ca.logic_or, [g[0] * g[1] <= 0, g[0] * g[2] <= 0, *(ca.fabs(each) <= near for each in g)])
    s = ca.sign(g[0])
    for k in (0, 1):
        closing = ca.logic_and(s * turns[k] < 0, s * turns[k + 1] > 0)
        crossed = (g[k + 1] - turns[k + 1] / 2 - g[k]) / (turns[k] - turns[k + 1])  # where tangents meet, from point k
        suspect = ca.logic_or(suspect, ca.logic_and(closing, s * (g[k] + crossed * turns[k]) < DIP * size))
    return suspect


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

    ``start`` (2 ng: guards, rates) and ``limits`` (3, ng: sizes below which a guard means nothing, below which it is near zero,
    and the sixth derivatives of ``guard_counting``, times ``REST``) are shared with whoever keeps them. ``suspicious``: whether a
    guard may have crossed zero since the sign that it had at the start of the step.
    """

    def __init__(self, functions: GuardFunctions, bound: BoundStep, q: Vector, start: Vector, limits: Vector) -> None:
        self.start, self.suspicious, self.bound = start, False, bound
        self.values, self.measures = np.zeros((2, start.size)), np.zeros(2)
        self.end = self.values[1]
        self._size = bound.nodes.shape[1]
        self._theta, self._result = np.zeros(1), np.zeros(self._size + start.size)
        self._high = np.zeros((2, start.size // 2))
        step = (bound.time, bound.size, bound.state, bound.nodes, q)
        self._watch, self._evaluate = bind(functions.watch, (*step, start, limits), (self.values, self.measures))
        self._beyond, self._evaluate_high = bind(functions.high, step, (self._high,))
        arguments = (bound.time, bound.size, self._theta, bound.state, bound.nodes, q)
        self._at, self._evaluate_at = bind(functions.at, arguments, (self._result,))
        self._kept_alive = bound, q, limits

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

    def polynomial(self, index: int) -> NDArray[np.float64]:
        """The eight Bernstein coefficients of a guard that is a polynomial over the step."""
        self._evaluate_high()
        count, h = self.start.size // 2, float(self.bound.size[0])
        at = (self.start, self.values[0], self.values[1])
        quintic = bernstein_quintic([float(v[index]) for v in at], [h * float(v[count + index]) for v in at])
        found: NDArray[np.float64] = RAISED @ np.array(quintic) + BEYOND @ self._high[:, index]
        return found


def _raised() -> NDArray[np.float64]:
    """From degree five to seven: the same polynomial by eight Bernstein coefficients."""
    matrix = np.eye(6)
    for degree in (5, 6):
        rows = np.zeros((degree + 2, degree + 1))
        for i in range(degree + 2):
            rows[i, min(i, degree)] += 1 - i / (degree + 1)
            rows[i, max(i - 1, 0)] += i / (degree + 1)
        matrix = rows @ matrix
    return matrix


def _beyond() -> NDArray[np.float64]:
    """Bernstein coefficients, of degree seven, of (theta (theta - 1/2) (theta - 1))^2, and of theta times it."""
    square = np.array([0, 0, 0.25, -1.5, 3.25, -3, 1, 0])
    powers = np.array([square, np.roll(square, 1)])
    weights = np.array([[math.comb(i, j) / math.comb(7, j) for j in range(8)] for i in range(8)])
    return weights @ powers.T


RAISED, BEYOND = _raised(), _beyond()
