"""Budgets of steps and seconds, progress and cancellation: a run ends when it is told to, and keeps what it has."""

from __future__ import annotations

import time
from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Budget, InitialValueProblem, SolverOptions
from modelgen.solvers.registry import solve, solver_named

Ode = Callable[..., InitialValueProblem]

NAMES = ("rk4", "cvodes", "idas", "collocation", "erk", "rosenbrock")


@pytest.fixture(scope="module")
def endless(ode: Ode) -> Callable[[int], InitialValueProblem]:
    """Twelve coupled pendulums over a horizon that takes minutes."""

    def rates(t: ca.SX, x: ca.SX, p: ca.SX) -> list[ca.SX]:
        angle, speed = x[:12], x[12:]
        pull = [100 * ((angle[i - 1] if i else 0) - 2 * angle[i] + (angle[i + 1] if i < 11 else 0)) for i in range(12)]
        return [speed, *(pull[i] - ca.sin(angle[i]) + ca.cos((i + 1) * t) for i in range(12))]

    return lambda count: ode(rates, [0.1] * 24, np.linspace(0.0, 1e4, count + 1)[1:])


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("outputs", [1, 100_000])
def test_nothing_outlives_its_budget(endless: Callable[[int], InitialValueProblem], name: str, outputs: int) -> None:
    problem, seconds = endless(outputs), []
    if "backend" in solver_named(name).extra_options:  # build its library first
        solve(problem, name, SolverOptions(tolerance=1e-9, backend="auto", budget=Budget(max_steps=100_000)))
    for _ in range(2):  # the first one may build its library, on a machine that does other things too
        begin = time.perf_counter()
        run = solve(problem, name, SolverOptions(tolerance=1e-9, budget=Budget(max_seconds=0.4)))
        seconds.append(time.perf_counter() - begin)
    assert seconds[1] < 1.4
    assert run.outcome is Outcome.MAX_TIME
    assert "the budget of 0.4 s of computing time is used up" in run.message
    assert run.statistics.steps > 0
    assert (len(run.times) > 0) == (outputs > 1)


@pytest.mark.parametrize("name", NAMES)
def test_a_budget_of_steps(ode: Ode, name: str) -> None:
    problem = ode(lambda t, x, p: [x[1], -ca.sin(x[0])], [1.0, 0.0], np.linspace(0.0, 1000.0, 1001))
    run = solve(problem, name, SolverOptions(tolerance=1e-8, budget=Budget(max_steps=500)))
    assert run.outcome is Outcome.MAX_STEPS, run.message
    assert "the budget of 500 steps is used up; raise max_steps" in run.message
    assert 1 < len(run.times) < 1001
    if name in ("rk4", "collocation"):
        assert run.statistics.steps + run.statistics.rejected in (499, 500)  # the last one tried may be neither


@pytest.mark.parametrize("name", NAMES)
def test_cancelling(endless: Callable[[int], InitialValueProblem], name: str) -> None:
    begin = time.perf_counter()
    run = solve(endless(100_000), name, SolverOptions(tolerance=1e-9, cancel=lambda: time.perf_counter() - begin > 0.1))
    assert time.perf_counter() - begin < 1.1
    assert run.outcome is Outcome.CANCELLED
    assert "cancelled on request" in run.message


@pytest.mark.parametrize("name", NAMES)
def test_progress_rises_to_one(ode: Ode, name: str) -> None:
    told: list[float] = []
    problem = ode(lambda t, x, p: [x[1], -ca.sin(x[0])], [1.0, 0.0], np.linspace(5.0, 30.0, 26), t0=5.0)
    run = solve(problem, name, SolverOptions(tolerance=1e-10, progress=told.append))
    assert run.outcome is Outcome.SUCCESS
    assert told == sorted(told)
    assert told[0] < 0.5
    assert told[-1] == 1.0


@pytest.mark.parametrize("name", NAMES)
def test_what_a_callback_raises_comes_through(ode: Ode, name: str) -> None:
    def stop() -> bool:
        raise ConnectionError("the screen is gone")

    with pytest.raises(ConnectionError, match="the screen is gone"):
        solve(ode(lambda t, x, p: [-x[0]], [1.0], 1.0), name, SolverOptions(tolerance=1e-6, cancel=stop))


@pytest.mark.parametrize("name", NAMES)
def test_a_state_out_of_bounds(ode: Ode, name: str) -> None:
    problem = ode(lambda t, x, p: [3.0, -x[1]], [1e6, 0.0], np.linspace(0.0, 10.0, 101), scale=[0.1, 1.0])
    run = solve(problem, name, SolverOptions(tolerance=1e-6, budget=Budget(bound=100.0)))  # 10 from the start, after 3.33 s
    assert run.outcome is Outcome.DIVERGED, run.message
    assert np.abs(run.states[:, 0] - 1e6).max() <= 10 + 1e-6
    assert len(run.times) > 1
