"""Stiff problems of the initial value problem test set (Mazzia and Magherini, Bari), to six digits by every implicit solver."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import InitialValueProblem, SolverOptions
from modelgen.solvers.registry import solve

Ode = Callable[..., InitialValueProblem]

IMPLICIT = ("cvodes", "idas", "collocation", "rosenbrock")

HIRES_END = [
    *(0.0007371312573325668, 0.0001442485726316185, 5.888729740967575e-05, 0.001175651343283149),
    *(0.002386356198831331, 0.006238968252742796, 0.002849998395185769, 0.002850001604814231),
]
VAN_DER_POL_END = [1.706167732170483, -0.8928097010247975]  # at t = 2, eps = 1e-6


def hires(t: ca.SX, y: ca.SX, p: ca.SX) -> list[ca.SX]:
    y1, y2, y3, y4, y5, y6, y7, y8 = ca.vertsplit(y)
    return [
        -1.71 * y1 + 0.43 * y2 + 8.32 * y3 + 0.0007,
        1.71 * y1 - 8.75 * y2,
        -10.03 * y3 + 0.43 * y4 + 0.035 * y5,
        8.32 * y2 + 1.71 * y3 - 1.12 * y4,
        -1.745 * y5 + 0.43 * y6 + 0.43 * y7,
        -280 * y6 * y8 + 0.69 * y4 + 1.71 * y5 - 0.43 * y6 + 0.69 * y7,
        280 * y6 * y8 - 1.81 * y7,
        -280 * y6 * y8 + 1.81 * y7,
    ]


def van_der_pol(t: ca.SX, y: ca.SX, p: ca.SX) -> list[ca.SX]:
    return [y[1], ((1 - y[0] ** 2) * y[1] - y[0]) / 1e-6]


@pytest.mark.parametrize("name", IMPLICIT)
def test_hires(ode: Ode, name: str) -> None:
    problem = ode(hires, [1, 0, 0, 0, 0, 0, 0, 0.0057], 321.8122, scale=np.full(8, 1e-3))
    run = solve(problem, name, SolverOptions(tolerance=1e-9))
    assert run.outcome is Outcome.SUCCESS, run.message
    assert run.states[-1] == pytest.approx(HIRES_END, rel=1e-6)


@pytest.mark.parametrize("name", IMPLICIT)
def test_van_der_pol(ode: Ode, name: str) -> None:
    run = solve(ode(van_der_pol, [2.0, 0.0], 2.0), name, SolverOptions(tolerance=1e-9))
    assert run.outcome is Outcome.SUCCESS, run.message
    assert run.states[-1] == pytest.approx(VAN_DER_POL_END, rel=1e-6)
    assert run.statistics.steps < 50_000  # an explicit method needs millions
