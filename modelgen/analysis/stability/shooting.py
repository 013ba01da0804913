"""Shooting: a start from which a motion comes back to itself, by Newton's method with exact derivatives.

Below ``orbits``. With P the state one period later, P(z) - z = 0; its derivative, the monodromy matrix less one, comes from the
variational equations. Where no excitation sets the period, that is one unknown more, and the step may not go along the motion.
Everything counts in scales of the states. A step that makes it worse is halved.
Source: A. H. Nayfeh, B. Balachandran, Applied Nonlinear Dynamics (1995), sec. 6.1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.stability.course import Course
from modelgen.analysis.stability.propagators import propagators
from modelgen.errors import CaseError
from modelgen.solvers.problem import InitialValueProblem, SolverOptions

Array = NDArray[np.float64]
CLOSE = 1e-12
"""Residual below which rounding is all that is left."""
ITERATIONS, HALVINGS = 30, 8
PIECES = 64
"""Of a period: they fill the lanes of two cores twice, whatever the width."""
SHORTEST = 0.2
"""Share of its first guess below which a free period has collapsed to a point of rest."""


class Shot(NamedTuple):
    """``state`` (n,), ``period`` [s], ``residual`` (largest |P(z) - z|) and ``monodromy`` (n, n) in scales, ``rounds``."""

    state: Array
    period: float
    residual: float
    monodromy: Array
    rounds: int


def shoot(problem: InitialValueProblem, period: float, free: bool, options: SolverOptions, report: Callable[[int], None]) -> Shot:
    """The best start that Newton's method finds from ``problem.x0``; ``free``: the period is unknown too.

    The residual says whether it is an orbit. Raises CaseError only where not even the start can be followed for one period.
    """
    state, time = problem.x0.copy(), period
    gap, monodromy = _miss(problem, state, time, options)
    rounds = 0
    while rounds < ITERATIONS and np.abs(gap).max() > CLOSE:
        rounds += 1
        report(rounds)
        step, stretch = _step(problem, state, time, gap, monodromy, free)
        for halving in range(HALVINGS):
            share = 0.5**halving
            trial, longer = state + share * step * problem.scale, time + share * stretch
            if longer < SHORTEST * period:
                continue
            try:
                found = _miss(problem, trial, longer, options)
            except CaseError:  # the trial cannot be followed for a period: nearer to the start it can
                continue
            if np.linalg.norm(found[0]) < (1 - 0.1 * share) * np.linalg.norm(gap):
                break
        else:
            break
        (gap, monodromy), state, time = found, trial, longer
    return Shot(state, time, float(np.abs(gap).max()), monodromy, rounds)


def residual(problem: InitialValueProblem, state: Array, period: float, options: SolverOptions) -> float:
    """Largest |P(z) - z| in scales of the states."""
    course = Course(replace(problem, x0=state), "rk4", options)
    course.advance(np.array([problem.t0 + period]))
    return float(np.abs((course.state - state) / problem.scale).max())


def _miss(problem: InitialValueProblem, state: Array, period: float, options: SolverOptions) -> tuple[Array, Array]:
    """(P(z) - z) in scales, and the monodromy matrix: the product of the propagators of its pieces, which run side by side."""
    course = Course(replace(problem, x0=state), "rk4", options)
    pieces = course.advance(problem.t0 + period * np.arange(1, PIECES + 1) / PIECES)
    monodromy = np.eye(len(state))
    for matrix in propagators(pieces, period / PIECES, options, method="rk4").matrices:
        monodromy = matrix @ monodromy
    return (course.state - state) / problem.scale, monodromy


def _step(
    problem: InitialValueProblem, state: Array, period: float, gap: Array, monodromy: Array, free: bool
) -> tuple[Array, float]:
    """Newton's step of the state, in scales, and of the period [s]; the smallest where the matrix is singular."""
    n = len(state)
    if not free:
        return np.asarray(np.linalg.lstsq(monodromy - np.eye(n), -gap, rcond=1e-13)[0], dtype=float), 0.0
    begin = speed_at(problem, state)
    size = float(np.linalg.norm(begin)) or 1.0
    end = speed_at(problem, state + gap * problem.scale)
    matrix = np.zeros((n + 1, n + 1))
    matrix[:n, :n], matrix[:n, n], matrix[n, :n] = monodromy - np.eye(n), end / size, begin / size
    found = np.linalg.lstsq(matrix, np.append(-gap, 0.0), rcond=1e-13)[0]
    return np.asarray(found[:n], dtype=float), float(found[n]) / size


def speed_at(problem: InitialValueProblem, state: Array) -> Array:
    """dz/dt in scales at the start of the problem."""
    return np.asarray(problem.rhs(problem.t0, state, problem.p)).ravel() / problem.scale
