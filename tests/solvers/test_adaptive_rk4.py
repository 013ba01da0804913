"""The paper's solver: its order, its rule of step sizes, and periods known in closed form."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest
from scipy.special import ellipk

from modelgen.solvers import march
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.registry import solve

Ode = Callable[..., InitialValueProblem]


def dead_zone(x: ca.SX, half_width: float) -> ca.SX:
    return ca.if_else(x > half_width, x - half_width, ca.if_else(x < -half_width, x + half_width, 0))


def forced_pendulum(t: ca.SX, x: ca.SX, p: ca.SX) -> list[ca.SX]:
    return [x[1], -ca.sin(x[0]) - 0.1 * x[1] + 0.5 * ca.cos(2 * t)]


def solved(problem: InitialValueProblem, **options: object) -> Trajectory:
    trajectory = solve(problem, "rk4", SolverOptions(**options))
    assert trajectory.outcome is Outcome.SUCCESS, trajectory.message
    return trajectory


@pytest.mark.parametrize(("extrapolate", "order"), [(False, 4), (True, 5)])
def test_measured_order_with_fixed_steps(ode: Ode, extrapolate: bool, order: int) -> None:
    problem = ode(forced_pendulum, [1.0, 0.0], 2.0)
    exact = solved(problem, tolerance=1e-13).states[-1]
    sizes = np.array([0.05, 0.025, 0.0125])
    errors = [
        np.abs(solved(problem, tolerance=1.0, fixed_step=size, extrapolate=extrapolate).states[-1] - exact).max()
        for size in sizes
    ]
    measured = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert abs(measured - order) < 0.15


def test_fixed_steps_are_equal_and_at_most_as_large_as_asked(ode: Ode) -> None:
    for size, count in ((0.3, 7), (0.25, 8), (5.0, 1)):
        cost = solved(ode(forced_pendulum, [1.0, 0.0], 2.0), tolerance=1.0, fixed_step=size).statistics
        assert (cost.steps, cost.rejected, cost.evaluations) == (count, 0, 1 + 11 * count)
        assert cost.largest_step == pytest.approx(2.0 / count)
        assert cost.smallest_step == pytest.approx(2.0 / count)


# Exact periods (closed forms checked against quadrature): pendulum T = 4 K(sin^2(a/2)); Duffing x'' + x + x^3 = 0 from A at rest,
# T = 4 K(m)/sqrt(1 + A^2) with m = A^2/(2 (1 + A^2)); K(m) by its parameter m.
PERIODS = [
    *[("pendulum", np.radians(angle), 4 * ellipk(np.sin(np.radians(angle) / 2) ** 2)) for angle in (30, 90, 150, 170)],
    *[("duffing", A, 4 * ellipk(A**2 / (2 * (1 + A**2))) / np.sqrt(1 + A**2)) for A in (1.0, 2.0)],
]


@pytest.mark.parametrize(("system", "amplitude", "period"), PERIODS)
@pytest.mark.parametrize("rule", ["smooth", "paper"])
def test_periods_against_elliptic_integrals(ode: Ode, system: str, amplitude: float, period: float, rule: str) -> None:
    force = {"pendulum": lambda x: ca.sin(x), "duffing": lambda x: x + x**3}[system]
    problem = ode(lambda t, x, p: [x[1], -force(x[0])], [amplitude, 0.0], period)
    assert period_of(solved(problem, tolerance=1e-11, rule=rule), float(force(amplitude)), period) == pytest.approx(
        period, rel=1e-9
    )


def period_of(trajectory: Trajectory, force: float, guess: float) -> float:
    """When the speed passes zero next to the guess, from the speed there: v = -force (t - T) at the turning point."""
    return guess + float(trajectory.states[-1, 1]) / force


@pytest.mark.parametrize("rule", ["smooth", "paper"])
@pytest.mark.parametrize("extrapolate", [False, True])
def test_period_of_a_backlash_oscillator_with_error_control_alone(ode: Ode, rule: str, extrapolate: bool) -> None:
    # x'' + w^2 f(x) = 0 with a dead zone of half width b, from A at rest: T = 2 pi/w + 4 b/(w (A - b)); w = 1, b = 1, A = 2.
    exact = 2 * np.pi + 4
    problem = ode(lambda t, x, p: [x[1], -dead_zone(x[0], 1.0)], [2.0, 0.0], exact)
    trajectory = solved(problem, tolerance=1e-11, rule=rule, extrapolate=extrapolate)
    assert period_of(trajectory, 1.0, exact) == pytest.approx(exact, abs=1e-8)


def test_the_paper_rule_halves_and_doubles_and_takes_only_steps_that_passed(ode: Ode, monkeypatch: pytest.MonkeyPatch) -> None:
    tolerance, taken = 1e-7, []
    accept = march._March.accept

    def record(self: march._March, bound: march.Trial, t_new: float, h: float) -> bool:
        taken.append((h, bound[0].measures[0], t_new))
        return accept(self, bound, t_new, h)

    monkeypatch.setattr(march._March, "accept", record)
    problem = ode(lambda t, x, p: [x[1], 5 * (1 - x[0] ** 2) * x[1] - x[0]], [2.0, 0.0], 20.0)
    solved(problem, tolerance=tolerance, rule="paper")
    sizes, errors, times = np.array(taken).T
    assert errors.max() <= tolerance
    away = times < 20.0 - 2 * sizes.max()  # the last steps are cut to meet the end
    powers = np.log2(sizes[away] / sizes[0])
    assert powers == pytest.approx(np.round(powers), abs=1e-6)
    assert np.ptp(np.round(powers)) >= 3


def test_the_paper_rule_costs_more_than_the_smooth_one_for_the_same_error(ode: Ode) -> None:
    problem = ode(forced_pendulum, [1.0, 0.0], 20.0)
    exact = solved(problem, tolerance=1e-13).states[-1]
    smooth, paper = (solved(problem, tolerance=1e-8, rule=rule) for rule in ("smooth", "paper"))
    assert max(np.abs(run.states[-1] - exact).max() for run in (smooth, paper)) < 1e-7
    assert smooth.statistics.evaluations < 0.7 * paper.statistics.evaluations
    assert smooth.statistics.rejected < 0.1 * smooth.statistics.steps


def test_the_error_falls_with_the_tolerance(ode: Ode) -> None:
    problem = ode(lambda t, x, p: [x[1], -dead_zone(x[0], 1.0) + 0.3 * ca.cos(t)], [2.0, 0.0], 20.0)
    exact = solved(problem, tolerance=1e-13).states[-1]
    for tolerance in (1e-5, 1e-7, 1e-9, 1e-11):
        error = np.abs(solved(problem, tolerance=tolerance).states[-1] - exact).max()
        assert error < 100 * tolerance


def test_output_times_never_change_the_steps(ode: Ode) -> None:
    few, many = (
        solved(ode(forced_pendulum, [1.0, 0.0], times), tolerance=1e-9) for times in ([10.0], np.linspace(0.0, 10.0, 3001))
    )
    assert few.statistics.steps == many.statistics.steps
    assert few.states[-1] == pytest.approx(many.states[-1], abs=1e-14)
    assert many.states[0].tolist() == [1.0, 0.0]


def test_outputs_between_steps_are_as_accurate_as_steps(ode: Ode) -> None:
    times = np.linspace(0.0, 10.0, 2001)[1:]
    for rates in (forced_pendulum, lambda t, x, p: [x[1], -dead_zone(x[0], 0.5)]):
        problem = ode(rates, [1.0, 0.0], times)
        exact = solved(problem, tolerance=1e-12).states
        for tolerance in (1e-6, 1e-9):
            run = solved(problem, tolerance=tolerance)
            assert run.statistics.steps < times.size / 4
            errors = np.abs(run.states - exact).max(axis=1)
            assert errors.max() < 3 * max(errors[-1], tolerance)


def test_a_constant_on_a_state_that_acts_on_nothing_changes_nothing(ode: Ode) -> None:
    def rates(t: ca.SX, x: ca.SX, p: ca.SX) -> list[ca.SX]:
        return [x[1], -ca.sin(x[0]), 200 + x[1]]  # the third, a rolling angle, is fed and unheard

    times = np.linspace(0.0, 5.0, 51)
    near, far = (solved(ode(rates, [1.0, 0.0, start], times), tolerance=1e-11) for start in (0.0, 1e6))
    assert np.array_equal(near.states[:, :2], far.states[:, :2])
    assert far.states[:, 2] - 1e6 == pytest.approx(near.states[:, 2], abs=1e-9)


def test_the_first_and_the_largest_step_are_kept(ode: Ode) -> None:
    quiet = ode(lambda t, x, p: [-0.01 * x[0]], [1.0], 10.0)
    assert solved(quiet, tolerance=1e-3).statistics.largest_step > 1.0
    cost = solved(quiet, tolerance=1e-3, first_step=1e-3, largest_step=0.5).statistics
    assert cost.largest_step == pytest.approx(0.5)
    assert cost.smallest_step == pytest.approx(1e-3)


def test_rest_is_not_left_by_rounding_but_by_the_force(ode: Ode) -> None:
    late = ode(lambda t, x, p: [x[1], ca.if_else(t > 3, 1, 0)], [0.0, 0.0], [2.9, 4.0])
    run = solved(late, tolerance=1e-9, largest_step=0.1)
    assert run.states[0].tolist() == [0.0, 0.0]
    assert run.states[1] == pytest.approx([0.5, 1.0], abs=1e-7)
