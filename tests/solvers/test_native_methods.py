"""Methods and rules of step sizes in generated C: the errors that the tolerances ask for, the steps of the virtual machine."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

from modelgen.errors import LoweringError
from modelgen.solvers.lanes import solve_lanes
from modelgen.solvers.native import solve_native
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import InitialValueProblem, SolverOptions
from modelgen.solvers.registry import solve

Ode = Callable[..., InitialValueProblem]
METHODS = ("rk4", "dopri5", "verner65", "dop853")


pytestmark = pytest.mark.usefixtures("own_cache")


def forced(t: Any, x: Any, p: Any) -> list[Any]:
    """x' = -p x + cos t + cos 2t ... whose solution is known; the forcing makes the nodes of a method count."""
    return [-p[0] * x[0] + ca.cos(p[1] * t), x[2], -x[1]]


def exact(problem: InitialValueProblem) -> np.ndarray:
    a, w = problem.p
    t = problem.times
    particular = (a * np.cos(w * t) + w * np.sin(w * t)) / (a**2 + w**2)
    decay = (problem.x0[0] - a / (a**2 + w**2)) * np.exp(-a * t)
    c, s = problem.x0[1], problem.x0[2]
    return np.stack([particular + decay, c * np.cos(t) + s * np.sin(t), s * np.cos(t) - c * np.sin(t)], axis=1)


@pytest.fixture(scope="module")
def problems(ode: Ode) -> list[InitialValueProblem]:
    first = ode(forced, [1.0, 1.0, 0.5], np.linspace(0.0, 6.0, 97), p=[0.3, 2.0])
    return [dataclasses.replace(first, p=[0.3 + 0.1 * k, 2.0 + k]) for k in range(3)]


@pytest.mark.parametrize("method", METHODS)
def test_errors_follow_the_tolerance_at_and_between_steps(problems: list[InitialValueProblem], method: str) -> None:
    for tolerance in (1e-5, 1e-9):
        options = SolverOptions(tolerance=tolerance)
        runs = [solve_native(problem, options, method) for problem in problems]
        lanes = solve_lanes(problems, options, method=method).trajectories
        for problem, one, other in zip(problems, runs, lanes, strict=True):
            assert np.abs(one.states - exact(problem)).max() < 100 * tolerance
            assert np.abs(one.states - other.states).max() < (1e-11 if method == "verner65" else 1e-12)  # see its file
            assert one.statistics.evaluations == other.statistics.evaluations


@pytest.mark.parametrize(("method", "order"), [("rk4", 5), ("dopri5", 5), ("verner65", 6), ("dop853", 8)])
def test_fixed_steps_have_the_order_of_the_method(problems: list[InitialValueProblem], method: str, order: int) -> None:
    problem = dataclasses.replace(problems[0], times=problems[0].times[-1:])
    errors = []
    for count in (12, 24):
        run = solve_native(problem, SolverOptions(tolerance=1.0, fixed_step=6.0 / count), method)
        assert run.statistics.steps == count
        errors.append(np.abs(run.states - exact(problem)).max())
    assert order - 0.6 < math.log2(errors[0] / errors[1]) < order + 1


def test_the_8th_order_pair_pays_for_dense_output_only_where_it_is_asked_for(problems: list[InitialValueProblem]) -> None:
    options = SolverOptions(tolerance=1e-8)
    last = dataclasses.replace(problems[0], times=problems[0].times[-1:])
    few, many = solve_native(last, options, "dop853").statistics, solve_native(problems[0], options, "dop853").statistics
    assert few.steps == many.steps
    assert few.evaluations == 2 + 12 * (few.steps + few.rejected) + 3
    holding = (many.evaluations - 2 - 12 * (many.steps + many.rejected)) / 3  # steps with an output in them
    assert holding == int(holding)
    assert many.steps / 2 < holding <= many.steps


@pytest.mark.parametrize("options", [{"fixed_step": 0.05}, {"rule": "paper"}, {"rule": "paper", "extrapolate": False}])
def test_rules_of_step_sizes_are_those_of_the_virtual_machine(problems: list[InitialValueProblem], options: dict) -> None:
    chosen = SolverOptions(tolerance=1e-6, **options)
    lanes = solve_lanes(problems, chosen).trajectories
    for problem, other in zip(problems, lanes, strict=True):
        expected, one = solve(problem, "rk4", chosen), solve_native(problem, chosen)
        for run in (one, other):
            assert run.outcome is Outcome.SUCCESS
            assert np.abs(run.states - expected.states).max() < 1e-12
            assert run.statistics.steps == expected.statistics.steps
            # Whether a step of exactly 1.5 times the size is worth a trial before the end is a matter of rounding.
            assert abs(run.statistics.evaluations - expected.statistics.evaluations) <= 11


def test_fixed_steps_that_leave_the_numbers_or_the_bound_have_diverged(ode: Ode) -> None:
    problem = ode(lambda t, x, p: [x[0] ** 2], [1.0], [0.5, 3.0])
    options = SolverOptions(tolerance=1e-6, fixed_step=0.01)
    for run in (solve_native(problem, options), solve_lanes([problem] * 2, options).trajectories[1]):
        assert run.outcome is Outcome.DIVERGED
        assert run.states[:, 0] == pytest.approx([2.0], rel=1e-8)


def test_an_unknown_method_is_refused_by_name(problems: list[InitialValueProblem]) -> None:
    with pytest.raises(LoweringError, match=r"there is none named 'dopri6'.*dopri5"):
        solve_native(problems[0], SolverOptions(tolerance=1e-3), "dopri6")
