"""Right-hand sides that go wrong: every solver ends with the right name, in words, with what it had, and says nothing else."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Budget, InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.registry import solve

Ode = Callable[..., InitialValueProblem]

NAMES = ("rk4", "cvodes", "idas", "collocation", "erk", "rosenbrock")
TIMES = np.linspace(0.0, 2.0, 21)

# rate of x0 (x1 follows it), outcome, when [s], words
FAULTS = {
    "nan after 1": (lambda t, x: ca.if_else(t > 1, math.nan, -x), Outcome.NON_FINITE_RATE, 1.0, "gives nan for the rate of 'x0'"),
    "inf after 1": (lambda t, x: ca.if_else(t > 1, math.inf, -x), Outcome.NON_FINITE_RATE, 1.0, "gives inf for the rate of 'x0'"),
    "root of a negative": (lambda t, x: ca.sqrt(1 - t) - x, Outcome.NON_FINITE_RATE, 1.0, "roots, logarithms or quotients"),
    "nan from the start": (lambda t, x: math.nan * x, Outcome.NON_FINITE_RATE, 0.0, "t = 0 s"),
    "y' = y^2": (lambda t, x: x**2, Outcome.DIVERGED, 1.0, "state 'x0' grew without bound"),
    "y' = y^3": (lambda t, x: x**3, Outcome.DIVERGED, 0.5, "state 'x0' grew without bound"),
    "pole of the coefficient": (lambda t, x: x / (1 - t) ** 2, Outcome.DIVERGED, 0.955, "grew without bound"),
    "runaway": (lambda t, x: 30 * x, Outcome.DIVERGED, 0.7, "grew without bound"),
    "friction": (lambda t, x: -5 * ca.sign(x), Outcome.CHATTERING, 0.2, "jumps between -5 and 5 at every step"),
    "driven friction": (lambda t, x: -5 * ca.sign(x) + ca.sin(t), Outcome.CHATTERING, 0.205, "the rate of 'x0'"),
    "two-level switch": (lambda t, x: ca.if_else(x > 0.3, -5, 2), Outcome.CHATTERING, 0.14, "jumps between -5 and 2"),
}


def faulty(ode: Ode, fault: str) -> InitialValueProblem:
    rate = FAULTS[fault][0]
    return ode(lambda t, x, p: [rate(t, x[0]), x[0] - x[1]], [1.0, 0.0], TIMES)


def check(run: Trajectory, outcome: Outcome, words: str) -> None:
    assert run.outcome is outcome, run.message
    assert words in run.message
    assert len(run.times) == len(run.states)
    assert np.isfinite(run.states).all()


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("name", NAMES)
def test_every_fault_has_its_name(ode: Ode, name: str, fault: str, capfd: pytest.CaptureFixture[str]) -> None:
    _, outcome, when, words = FAULTS[fault]
    begin = time.perf_counter()
    run = solve(faulty(ode, fault), name, SolverOptions(tolerance=1e-8, budget=Budget(max_seconds=20)))
    assert time.perf_counter() - begin < 21
    check(run, outcome, words)
    told = float(run.message.split("t = ")[1].split(" s")[0])
    assert told == pytest.approx(when, abs=0.15 if fault == "runaway" else 0.01)
    # What was computed until then is there: all outputs before, none after.
    assert len(run.times) >= np.count_nonzero(when - 0.02 > TIMES)
    assert run.times.tolist() == TIMES[: len(run.times)].tolist()
    assert run.times[-1] <= told + 1e-9
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", NAMES)
def test_an_impossible_tolerance(ode: Ode, name: str, capfd: pytest.CaptureFixture[str]) -> None:
    problem = ode(lambda t, x, p: [-x[0], ca.sin(x[0])], [1.0, 0.0], TIMES)
    run = solve(problem, name, SolverOptions(tolerance=1e-30, budget=Budget(max_seconds=20)))
    assert run.outcome in ({Outcome.STEP_TOO_SMALL, Outcome.NEWTON_FAILED} if name == "collocation" else {Outcome.STEP_TOO_SMALL})
    assert "loosen" in run.message
    assert run.times.tolist() == [0.0]
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", ["rk4", "collocation", "erk", "rosenbrock"])
@pytest.mark.parametrize("fault", ["nan after 1", "y' = y^2", "nan from the start"])
def test_fixed_steps_end_with_a_name_too(ode: Ode, name: str, fault: str) -> None:
    run = solve(faulty(ode, fault), name, SolverOptions(tolerance=1e-8, fixed_step=1e-3))
    allowed = {FAULTS[fault][1], Outcome.NEWTON_FAILED} if name == "collocation" else {FAULTS[fault][1]}
    if fault == "y' = y^2" and name == "rosenbrock":
        allowed |= {Outcome.SUCCESS}  # an implicit method with large steps jumps over the pole, to finite numbers
    assert run.outcome in allowed, run.message
    assert np.isfinite(run.states).all()


def test_fixed_steps_that_are_unstable_diverge(ode: Ode) -> None:
    run = solve(ode(lambda t, x, p: [-1e4 * x[0]], [1.0], 1.0), "rk4", SolverOptions(tolerance=1.0, fixed_step=1e-2))
    check(run, Outcome.DIVERGED, "state 'x0' grew without bound")


def test_newton_failure_has_its_name(ode: Ode, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("modelgen.solvers.collocation.NEWTON_ITERATIONS", 1)
    problem = ode(lambda t, x, p: [x[1], ((1 - x[0] ** 2) * x[1] - x[0]) * 1e3], [2.0, 0.0], TIMES)
    run = solve(problem, "collocation", SolverOptions(tolerance=1e-8, fixed_step=1e-2))
    check(run, Outcome.NEWTON_FAILED, "implicit equations could not be solved")


SOUND = {
    "steep but smooth friction": lambda t, x, p: [x[1], ca.cos(t) - x[0] - 0.5 * ca.tanh(1e3 * x[1])],
    "hard impact on both flanks": lambda t, x, p: [
        x[1],
        ca.sin(5 * t) - 1e4 * ca.if_else(x[0] > 1e-2, x[0] - 1e-2, ca.if_else(x[0] < -1e-2, x[0] + 1e-2, 0)),
    ],
    "force that switches with time": lambda t, x, p: [x[1], ca.sign(ca.sin(40 * t))],
    "rest": lambda t, x, p: [x[1], -1e6 * x[0] - 10 * x[1]],
    "damping in contact only": lambda t, x, p: [x[1], ca.if_else(x[0] < 0, -1e4 * x[0] - 20 * x[1], 0) - 9.81],
    "stiff": lambda t, x, p: [-1e4 * (x[0] - ca.cos(t)), x[0]],
}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("model", SOUND)
def test_models_that_are_only_difficult_are_not_called_faulty(ode: Ode, name: str, model: str) -> None:
    start = [0.0, 0.0] if model == "rest" else [1.0, 0.0] if model == "stiff" else [5e-2, 0.0]
    run = solve(ode(SOUND[model], start, TIMES), name, SolverOptions(tolerance=1e-7))
    assert run.outcome is Outcome.SUCCESS, run.message
