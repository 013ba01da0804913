"""Steps from tableaus: the order that the file claims, measured from both sides; step doubling among them."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from modelgen.lowering.methods import read_tableau
from modelgen.lowering.tableau import doubled
from modelgen.solvers.doubled_step import doubled_step
from modelgen.solvers.method import BoundStep
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import InitialValueProblem, SolverOptions
from modelgen.solvers.registry import solve
from modelgen.solvers.tableau_step import tableau_method

Ode = Callable[..., InitialValueProblem]

T, Y, Q = ca.SX.sym("t"), ca.SX.sym("y", 2), ca.SX.sym("q")
RATE = ca.Function("rate", [T, Y, Q], [ca.vertcat(Y[1] + ca.sin(3 * T), -Q * ca.sin(Y[0]) * ca.exp(-T))])


def forced_pendulum(t: ca.SX, x: ca.SX, p: ca.SX) -> list[ca.SX]:
    return [x[1], -ca.sin(x[0]) - 0.1 * x[1] + 0.5 * ca.cos(2 * t)]


@pytest.mark.parametrize(
    ("method", "order", "sizes"),
    [("dopri5", 5, (0.1, 0.05, 0.025)), ("verner65", 6, (0.3, 0.2, 0.15)), ("dop853", 8, (10 / 32, 10 / 48, 10 / 64))],
)
def test_measured_order_with_fixed_steps(ode: Ode, method: str, order: int, sizes: tuple[float, ...]) -> None:
    problem = ode(forced_pendulum, [1.0, 0.0], 10.0)
    exact = solve(problem, "dop853", SolverOptions(tolerance=1e-14)).states[-1]
    runs = [solve(problem, method, SolverOptions(tolerance=1.0, fixed_step=size)) for size in sizes]
    errors = [np.abs(run.states[-1] - exact).max() for run in runs]
    slack = 1.1 if method == "verner65" else 0.06 * order  # its errors of order 6 are so small that those of order 7 show
    assert abs(np.polyfit(np.log(sizes), np.log(errors), 1)[0] - order) < slack
    assert all(
        run.statistics.evaluations == 1 + read_tableau(method).stages * run.statistics.steps + extra_of(method) for run in runs
    )


def extra_of(method: str) -> int:
    """The stages that the one output at the end takes in addition."""
    return len(read_tableau(method).extra_c)


@pytest.mark.parametrize(
    ("method", "order", "sizes"),
    [("dopri5", 5, (0.8, 0.4, 0.2)), ("dop853", 8, (0.4, 0.3, 0.2))],
)
def test_measured_order_between_the_ends_of_a_step(method: str, order: int, sizes: tuple[float, ...]) -> None:
    """Of one step: the dense output errs by h to the power of its order + 1."""
    tableau = read_tableau(method)
    made = tableau_method(RATE, tableau)
    start = np.array([0.7, -0.3])
    state = np.array([start, np.array(RATE(0.1, start, 1.5))[:, 0]])
    reference = tableau_method(RATE, read_tableau("dop853"))
    errors = []
    for h in sizes:
        bound = BoundStep(made, state, np.array([1.5]))
        bound.time[0], bound.size[0] = 0.1, h
        bound.evaluate()
        assert bound.complete() == len(tableau.extra_c)
        assert bound.complete() == 0
        worst = 0.0
        for theta in (0.2, 0.45, 0.8):
            y, _ = made.interpolant.between(theta, h, [*state, *bound.nodes])
            worst = max(worst, np.abs(y - advanced(reference, state, theta * h)).max())
        errors.append(worst)
    measured = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert abs(measured - (tableau.dense_order + 1)) < 0.5
    assert order > tableau.dense_order - 1


def advanced(reference: object, state: np.ndarray, span: float) -> np.ndarray:
    """The state after a time, by many small steps of order 8."""
    bound = BoundStep(reference, state.copy(), np.array([1.5]))
    place, count = bound.state, 24
    for index in range(count):
        bound.time[0], bound.size[0] = 0.1 + span * index / count, span / count
        bound.evaluate()
        place[:] = bound.nodes[-2:]
    return place[0]


@pytest.mark.parametrize("extrapolate", [True, False])
def test_step_doubling_from_its_tableau_is_the_step_written_out(extrapolate: bool) -> None:
    made = tableau_method(RATE, doubled(read_tableau("rk4"), extrapolate))
    y = np.array([1.0, -0.4])
    state = ca.horzcat(y, RATE(0.3, y, 2.5))
    nodes, measures = (np.array(part) for part in made.step(0.3, 0.2, state, 2.5))
    written_out = doubled_step(RATE, read_tableau("rk4"), extrapolate)
    expected, compared = (np.array(part) for part in written_out(0.3, 0.2, state, 2.5)[:2])
    assert nodes[:, -2:] == pytest.approx(expected[:, -2:], abs=1e-14)
    assert measures[0, 0] == pytest.approx(compared[0, 0], rel=1e-9)
    middle, slope = made.interpolant.between(0.5, 0.2, [*np.array(state).T, *nodes.T])
    assert middle == pytest.approx(expected[:, 0], abs=1e-14)
    assert slope == pytest.approx(expected[:, 1], abs=1e-13)


@pytest.mark.parametrize("method", ["dopri5", "verner65", "dop853"])
def test_the_error_is_the_one_that_the_file_weighs(method: str) -> None:
    tableau = read_tableau(method)
    made = tableau_method(RATE, tableau)
    y, h = np.array([1.0, -0.4]), 0.3
    slopes = [np.array(RATE(0.3, y, 2.5))[:, 0]]
    for node, row in zip(tableau.nodes[1 : tableau.stages + 1], tableau.rows[1 : tableau.stages + 1], strict=True):
        place = y + h * sum(float(a) * k for a, k in zip(row, slopes, strict=True))
        slopes.append(np.array(RATE(0.3 + float(node) * h, place, 2.5))[:, 0])
    largest = [np.abs(h * sum(float(e) * k for e, k in zip(row, slopes, strict=True))).max() for row in tableau.errors]
    expected = largest[0] if len(largest) == 1 else largest[0] ** 2 / np.hypot(largest[0], 0.1 * largest[1])
    _, measures = made.step(0.3, h, np.array([y, slopes[0]]).T, 2.5)
    assert float(measures[0]) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("method", ["dopri5", "verner65", "dop853"])
def test_the_error_falls_with_the_tolerance(ode: Ode, method: str) -> None:
    times = np.linspace(0.0, 20.0, 501)
    problem = ode(forced_pendulum, [1.0, 0.0], times)
    exact = solve(problem, "rk4", SolverOptions(tolerance=1e-14)).states
    for tolerance in (1e-5, 1e-7, 1e-9, 1e-11):
        run = solve(problem, method, SolverOptions(tolerance=tolerance))
        assert run.outcome is Outcome.SUCCESS
        assert np.abs(run.states - exact).max() < 100 * tolerance
