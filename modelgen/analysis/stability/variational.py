"""Variational equations: how small deviations from a motion grow, as one right-hand side that every solver runs.

Below ``exponents`` and ``orbits``. Beside x' = f(t, x, p) stand k tangent vectors v' = J v with J = df/dx, by forward
differentiation of f (no matrix is formed), the integral of tr J, and a shift of time among the parameters, so that stretches
that begin at different times run side by side as one problem.

Where an event changes the mode or the state, a deviation jumps too: with g the guard, r the reset, f- and f+ the rates before and
after, v+ = r_x v + (f+ - r_x f- - r_t) (g_x v) / (g_t + g_x f-). Where nothing jumps, that is v+ = v. Of several events that fire
at one time, each is taken with its own guard, which is right where all of them are at zero there.
Sources: R. I. Leine, H. Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems (2004), ch. 7 (saltation matrix);
J. Liouville (tr J and the volume).
"""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.lowering.switching import Crossing, Switching
from modelgen.solvers.problem import InitialValueProblem

Array = NDArray[np.float64]


class Parts(NamedTuple):
    """What an extended state holds: ``state`` (n,), integral of tr J, ``tangents`` (n, k) in scales of the states."""

    state: Array
    volume: float
    tangents: Array


@functools.lru_cache(maxsize=32)
def variational_rate(rhs: ca.Function, count: int) -> ca.Function:
    """(t, [x; integral of tr J; v1; ...; vk], [p; shift]) -> rates, of a right-hand side (t, x, p) at the time t + shift.

    >>> t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p")
    >>> rate = variational_rate(ca.Function("f", [t, x, p], [ca.vertcat(x[1], -p * x[0] - x[1])]), 1)
    >>> rate(0, [1, 0, 0, 0, 1], [4, 0])  # x' = (0, -4), tr J = -1, v' = J (0, 1)
    DM([0, -4, -1, 1, -1])
    """
    n, m = rhs.numel_in(1), rhs.numel_in(2)
    symbols = ca.SX if rhs.is_a("SXFunction") else ca.MX
    t, y, q = symbols.sym("t"), symbols.sym("y", n * (1 + count) + 1), symbols.sym("p", m + 1)
    time, x = symbols.sym("time"), symbols.sym("x", n)
    ode = rhs(time, x, q[:m])
    forward = ca.jtimes(ode, x, ca.reshape(y[n + 1 :], n, count)) if count else symbols.zeros(0, 1)
    everything = ca.vertcat(ode, ca.trace(ca.jacobian(ode, x)), ca.vec(forward))
    shifted = ca.Function("at", [time, x, y, q], [ca.densify(everything)])(t + q[m], y[:n], y, q)
    return ca.Function("variational", [t, y, q], [shifted], ["t", "x", "p"], ["ode"], {"cse": True})


def with_tangents(problem: InitialValueProblem, tangents: Array, length: float) -> InitialValueProblem:
    """The problem over ``length`` [s] from its ``t0``, with tangent vectors (n, k) in scales of the states, from time zero.

    The tangents weigh in the error control like states, each with the scale of its state. Raises CaseError for other shapes.
    """
    n = problem.x0.size
    if tangents.ndim != 2 or tangents.shape[0] != n:
        raise CaseError("variational equations, tangents", f"have shape {tangents.shape}", f"give columns of {n} entries")
    count, scale = tangents.shape[1], problem.scale
    return InitialValueProblem(
        variational_rate(problem.rhs, count),
        _names(problem.names, count),
        x0=np.concatenate([problem.x0, [0.0], (scale[:, None] * tangents).T.ravel()]),
        p=np.append(problem.p, problem.t0),
        scale=np.concatenate([scale, [1.0], np.tile(scale, count)]),
        t0=0.0,
        times=np.array([length]),
        switching=problem.switching and variational_switching(problem.rhs, problem.switching, count),
    )


@functools.lru_cache(maxsize=32)
def _names(states: tuple[str, ...], count: int) -> tuple[str, ...]:
    return (*states, "divergence", *(f"{name}, tangent {k + 1}" for k in range(count) for name in states))


def parts(problem: InitialValueProblem, extended: Array) -> Parts:
    """An extended state (n + 1 + n k,) taken apart; ``problem`` is the one without tangents."""
    n = problem.x0.size
    tangents = extended[n + 1 :].reshape(-1, n).T / problem.scale[:, None]
    return Parts(extended[:n], float(extended[n]), tangents)


@functools.lru_cache(maxsize=32)
def variational_switching(rhs: ca.Function, switching: Switching, count: int) -> Switching:
    """The same modes and guards for the extended state; every crossing that changes something resets the tangents too."""
    n, m = rhs.numel_in(1), rhs.numel_in(2)
    t, y, q = ca.SX.sym("t"), ca.SX.sym("y", n * (1 + count) + 1), ca.SX.sym("p", m + 1)
    guards = switching.guards(t + q[m], y[:n], q[:m])
    crossings, columns = [], []
    for number, crossing in enumerate(switching.crossings):
        if crossing.reset is None and crossing.enter is None:
            crossings.append(crossing)
            continue
        jump = saltation(rhs, switching, number, count)
        reset, tangents, stretch = jump(t + q[m], y[:n], q[:m], ca.reshape(y[n + 1 :], n, count))
        columns.append(ca.vertcat(reset, y[n] + stretch, ca.vec(tangents)))
        crossings.append(replace(crossing, reset=len(columns) - 1))
    return replace(
        switching,
        crossings=tuple(crossings),
        guards=ca.Function("guards", [t, y, q], [ca.densify(guards)], ["t", "x", "p"], ["guards"]),
        p_size=m + 1,
        resets=_resets(t, y, q, columns),
    )


def _resets(t: ca.SX, y: ca.SX, q: ca.SX, columns: list[ca.SX]) -> ca.Function | None:
    if not columns:
        return None
    return ca.Function("resets", [t, y, q], [ca.densify(ca.horzcat(*columns))], ["t", "x", "p"], ["states"])


def saltation(rhs: ca.Function, switching: Switching, number: int, count: int) -> ca.Function:
    """(t, x, p, V) -> state after a crossing, V (n, count) after it, log |det S| of the jump S that V makes.

    >>> t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p")
    >>> fall = ca.Function("fall", [t, x, p], [ca.vertcat(x[1], -p)])
    >>> floor = ca.Function("floor", [t, x, p], [x[0]])
    >>> bounce = ca.Function("bounce", [t, x, p], [ca.vertcat(x[0], -0.5 * x[1])])
    >>> switching = Switching((), (Crossing("floor", -1, reset=0),), floor, 1, bounce)
    >>> after = saltation(fall, switching, 0, 2)(0, [0, -2], 10, ca.DM.eye(2))[1]  # [[-e, 0], [-(1 + e) g / v, -e]]
    >>> after.full().tolist()
    [[-0.5, 0.0], [7.5, -0.5]]
    """
    n, m = rhs.numel_in(1), rhs.numel_in(2)
    crossing = switching.crossings[number]
    t, x, p, tangents = ca.SX.sym("t"), ca.SX.sym("x", n), ca.SX.sym("p", m), ca.SX.sym("V", n, count)
    after = _modes_after(switching, crossing, p)
    reset = x if crossing.reset is None or switching.resets is None else switching.resets(t, x, p)[:, crossing.reset]
    guard = switching.guards(t, x, p)[number]
    before = rhs(t, x, p)
    speed = ca.jtimes(guard, x, before) + ca.jtimes(guard, t, ca.SX(1))
    jump = rhs(t, reset, after) - ca.jtimes(reset, x, before) - ca.jtimes(reset, t, ca.SX(1))
    moved = ca.jtimes(reset, x, tangents) + jump @ (ca.jtimes(guard, x, tangents) / speed)
    stretch = ca.log(ca.fabs(_determinant(reset, x, jump, ca.jacobian(guard, x) / speed)))
    return ca.Function("saltation", [t, x, p, tangents], [reset, ca.densify(moved), stretch])


def _determinant(reset: ca.SX, x: ca.SX, jump: ca.SX, row: ca.SX) -> ca.SX:
    """det(r_x + u w^T) of a reset that changes few entries: that of I + A B is that of I + B A (Sylvester)."""
    changed = [k for k in range(x.numel()) if not ca.is_equal(reset[k], x[k])]
    unit = ca.SX.eye(x.numel())
    left = ca.horzcat(unit[:, changed], jump)
    right = ca.vertcat((ca.jacobian(reset, x) - unit)[changed, :], row)
    return ca.det(ca.densify(ca.SX.eye(len(changed) + 1) + right @ left))


def _modes_after(switching: Switching, crossing: Crossing, p: ca.SX) -> ca.SX:
    """The parameters with the flags that a crossing sets."""
    if crossing.variable is None or crossing.enter is None:
        return p
    mode, after = switching.modes[crossing.variable], ca.SX(p)
    for value in range(len(mode.values)):
        after[mode.first + value] = float(value == crossing.enter)
    return after
