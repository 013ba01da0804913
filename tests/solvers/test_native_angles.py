"""Angles advanced by the slopes of their speeds alone: the same run as state by state, wherever the states stand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

from modelgen.lowering.native.kinds import Kinds
from modelgen.solvers.lanes import solve_lanes
from modelgen.solvers.native import solve_native
from modelgen.solvers.problem import InitialValueProblem, SolverOptions
from modelgen.solvers.registry import solve

Ode = Callable[..., InitialValueProblem]

pytestmark = pytest.mark.usefixtures("own_cache")


def mixed(t: Any, x: Any, p: Any) -> list[Any]:
    """Two oscillators and a lag, in no order; one speed is the rate of two states."""
    v2, q1, lag, v1, q2 = (x[k] for k in range(5))
    first, second = -4 * ca.sin(q1) - 0.1 * v1 + p[0] * lag + ca.sin(3 * t), -9 * q2 - 0.2 * v2 + q1 * ca.cos(2 * t)
    return [second, v1, q1 - lag, first, v2, v1]


def contiguous(t: Any, x: Any, p: Any) -> list[Any]:
    second, v1, _, first, v2, _ = mixed(t, ca.vertcat(x[3], x[0], x[1], x[2], x[1]), p)
    return [v1, v2, first, second]


def plain(t: Any, x: Any, p: Any) -> list[Any]:
    return [p[0] * x[1] + ca.cos(t), -x[0] * x[1] ** 2]


def test_kinds_of_states() -> None:
    kinds = Kinds.of([None, 3, None, None, 0, 3])
    assert (kinds.angles, kinds.speeds, kinds.plain) == ((1, 4), (3, 0), (2, 5))
    assert Kinds.of([1, 2, None]).angles == (1,)  # the rate of an angle is no speed
    assert len(kinds.tables()) == 3
    assert not Kinds.of([2, 3, None, None]).tables()


@pytest.mark.parametrize("rates", [mixed, contiguous, plain])
@pytest.mark.parametrize("options", [{}, {"rule": "paper"}, {"fixed_step": 0.01}, {"extrapolate": False}])
def test_runs_are_those_of_the_virtual_machine(ode: Ode, rates: Any, options: dict[str, Any]) -> None:
    problem = ode(rates, np.linspace(0.1, 0.6, {mixed: 6, contiguous: 4, plain: 2}[rates]), np.linspace(0.0, 8.0, 41), p=[0.7])
    chosen = SolverOptions(tolerance=1e-8, **options)
    expected = solve(problem, "rk4", chosen)
    for run in (solve_native(problem, chosen), solve_lanes([problem] * 3, chosen).trajectories[1]):
        assert run.statistics.steps == expected.statistics.steps
        assert run.statistics.rejected == expected.statistics.rejected
        assert np.abs(run.states - expected.states).max() < 1e-11 * max(1.0, np.abs(expected.states).max())
