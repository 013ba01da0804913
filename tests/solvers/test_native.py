"""Runs in generated C: the same steps as the virtual machine's solver, lanes that do not feel each other, endings with a name."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from modelgen import assemble, load, lower
from modelgen.errors import CaseError
from modelgen.lowering.native.library import solver_of
from modelgen.solvers import Budget, Case, operating_point
from modelgen.solvers.lanes import Lanes, solve_lanes
from modelgen.solvers.native import solve_native
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.registry import solve
from modelgen.solvers.simulate import initial_value_problem

Ode = Callable[..., InitialValueProblem]


pytestmark = pytest.mark.usefixtures("own_cache")


def dead_zone(x: ca.SX, half_width: float) -> ca.SX:
    return ca.if_else(x > half_width, x - half_width, ca.if_else(x < -half_width, x + half_width, 0))


def rattler(t: Any, x: Any, p: Any) -> list[Any]:
    """A forced backlash oscillator; p: frequency, amplitude, damping."""
    return [x[1], -4 * dead_zone(x[0], 0.3) - p[2] * x[1] + p[1] * (ca.cos(p[0] * t) + 0.2 * ca.sin(2 * p[0] * t))]


def swinger(t: Any, x: Any, p: Any) -> list[Any]:
    """A forced pendulum: smooth, so that rounding is not amplified where a step meets a kink."""
    return [x[1], -4 * ca.sin(x[0]) - p[2] * x[1] + p[1] * (ca.cos(p[0] * t) + 0.2 * ca.sin(2 * p[0] * t))]


@pytest.fixture(scope="module")
def swings(ode: Ode, sweep: list[InitialValueProblem]) -> list[InitialValueProblem]:
    """The problems of the sweep for the pendulum."""
    rhs = ode(swinger, [1.0, 0.0], 1.0, p=[1.0, 1.0, 1.0]).rhs
    return [dataclasses.replace(each, rhs=rhs) for each in sweep]


@pytest.fixture(scope="module")
def sweep(ode: Ode) -> list[InitialValueProblem]:
    """Eleven rattlers that differ in parameters, start and scale."""
    first = ode(rattler, [1.0, 0.0], np.linspace(0.0, 8.0, 41), p=[1.7, 0.5, 0.05])
    rng = np.random.default_rng(3)
    draw = rng.uniform
    return [
        dataclasses.replace(first, p=[draw(1, 2), draw(0.2, 1), draw(0, 0.3)], x0=draw(-1, 1, 2), scale=draw(0.5, 2, 2))
        for _ in range(11)
    ]


def steps(run: Trajectory) -> tuple[int, int, int]:
    return run.statistics.steps, run.statistics.rejected, run.statistics.evaluations


@pytest.mark.parametrize("extrapolate", [True, False])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_c_and_lanes_take_the_steps_of_the_virtual_machine(
    swings: list[InitialValueProblem], tolerance: float, extrapolate: bool
) -> None:
    options = SolverOptions(tolerance=tolerance, extrapolate=extrapolate)
    expected = [solve(problem, "rk4", options) for problem in swings]
    for found in ([solve_native(problem, options) for problem in swings], solve_lanes(swings, options).trajectories):
        for one, other in zip(found, expected, strict=True):
            assert one.outcome is Outcome.SUCCESS
            assert one.message == other.message
            assert steps(one) == steps(other)
            assert one.statistics.smallest_step == pytest.approx(other.statistics.smallest_step, rel=1e-2)
            assert one.statistics.largest_step == pytest.approx(other.statistics.largest_step, rel=1e-2)
            assert np.array_equal(one.times, other.times)
            assert np.abs(one.states - other.states).max() < 1e-10


def test_across_kinks_they_agree_within_the_tolerance(sweep: list[InitialValueProblem]) -> None:
    options = SolverOptions(tolerance=1e-9)
    expected = [solve(problem, "rk4", options) for problem in sweep]
    for found in ([solve_native(problem, options) for problem in sweep], solve_lanes(sweep, options).trajectories):
        for one, other in zip(found, expected, strict=True):
            assert np.abs(one.states - other.states).max() < 1e-7
            assert one.statistics.evaluations == pytest.approx(other.statistics.evaluations, rel=0.1)


def test_across_kinks_the_virtual_machine_differs_from_itself_as_much(sweep: list[InitialValueProblem]) -> None:
    """Which step meets a kink is decided by last digits: changed ones of parameters scatter its steps as C's rounding does."""
    options, rng = SolverOptions(tolerance=1e-9), np.random.default_rng(7)
    for problem in sweep[:3]:
        one, other = solve(problem, "rk4", options), solve_native(problem, options)
        changed = [dataclasses.replace(problem, p=problem.p * (1 + 2.2e-16 * rng.integers(-2, 3, 3))) for _ in range(8)]
        own = [solve(each, "rk4", options) for each in changed]
        counts = [run.statistics.evaluations for run in (one, *own)]
        middle, scatter = np.mean(counts), np.ptp(counts)
        assert scatter > 0.005 * middle
        assert abs(other.statistics.evaluations - middle) < 2 * scatter
        assert np.abs(other.states - one.states).max() < 5 * max(np.abs(run.states - one.states).max() for run in own)


def test_a_truck_over_a_tenth_of_a_second() -> None:
    model = lower(assemble(load("fracturing-truck")))
    point = operating_point(model)
    problem, _ = initial_value_problem(Case(model, end=0.1, samples=101), point)
    options = SolverOptions(tolerance=1e-10)
    single, lanes = solve_native(problem, options), solve_lanes([problem] * 2, options).trajectories[1]
    expected = solve(problem, "rk4", options)
    fluctuating = np.ptp(expected.states, axis=0) / 2
    n = len(fluctuating) // 2
    for run in (single, lanes):
        for group in (slice(0, n), slice(n, 2 * n)):
            assert np.abs(run.states - expected.states)[:, group].max() < 1e-9 * fluctuating[group].max()


def bits(lanes: Lanes) -> list[bytes]:
    return [run.states.tobytes() + final.tobytes() for run, final in zip(lanes.trajectories, lanes.final, strict=True)]


def test_a_run_in_lanes_does_not_feel_its_neighbors(sweep: list[InitialValueProblem]) -> None:
    options = SolverOptions(tolerance=1e-6)
    expected = bits(solve_lanes(sweep, options, threads=1))
    assert len(set(expected)) == len(sweep)
    assert bits(solve_lanes(sweep[::-1], options, threads=1))[::-1] == expected
    for count in (1, 3, 8, 9):
        assert bits(solve_lanes(sweep[:count], options, threads=1)) == expected[:count]
    for _ in range(3):
        assert bits(solve_lanes(sweep * 3, options, threads=3)) == expected * 3
    broken = dataclasses.replace(sweep[0], p=[1.0, 1e306, 0.0])
    assert bits(solve_lanes([broken, *sweep, broken], options))[1:-1] == expected


def test_parameters_change_without_a_build(sweep: list[InitialValueProblem], own_cache: Path) -> None:
    solve_native(sweep[0], SolverOptions(tolerance=1e-3))
    before = {path: path.stat().st_mtime_ns for path in own_cache.iterdir()}
    one, other = (solve_native(problem, SolverOptions(tolerance=1e-3)) for problem in sweep[:2])
    assert not np.array_equal(one.states, other.states)
    assert {path: path.stat().st_mtime_ns for path in own_cache.iterdir()} == before


def test_a_library_is_found_again(sweep: list[InitialValueProblem], monkeypatch: pytest.MonkeyPatch) -> None:
    expected = solve_native(sweep[0], SolverOptions(tolerance=1e-6))
    solver_of.cache_clear()
    monkeypatch.setattr("modelgen.lowering.native.compiler.Compiler.build", None)  # a build would fail
    again = solve_native(sweep[0], SolverOptions(tolerance=1e-6))
    assert np.array_equal(again.states, expected.states)


def test_every_run_may_have_output_times_of_its_own(swings: list[InitialValueProblem]) -> None:
    strobes = [dataclasses.replace(each, times=2 * math.pi / each.p[0] * np.arange(1, 4)) for each in swings]
    options = SolverOptions(tolerance=1e-8)
    for problem, run in zip(strobes, solve_lanes(strobes, options).trajectories, strict=True):
        assert np.abs(run.states - solve(problem, "rk4", options).states).max() < 1e-11


def test_a_constant_on_a_state_that_acts_on_nothing_changes_nothing(ode: Ode) -> None:
    def rates(t: ca.SX, x: ca.SX, p: ca.SX) -> list[ca.SX]:
        return [x[1], -ca.sin(x[0]), 200 + x[1]]

    times = np.linspace(0.0, 5.0, 51)
    near, far = (solve_native(ode(rates, [1.0, 0.0, start], times), SolverOptions(tolerance=1e-11)) for start in (0.0, 1e6))
    assert np.array_equal(near.states[:, :2], far.states[:, :2])


ENDINGS = [
    ("max steps", rattler, {"budget": Budget(max_steps=50)}, Outcome.MAX_STEPS, "the budget of 50 steps"),
    ("blow-up", lambda t, x, p: [x[0] ** 2, 0 * x[1]], {}, Outcome.DIVERGED, "'x0' grew without bound"),
    ("bound", lambda t, x, p: [x[0], 0 * x[1]], {"budget": Budget(bound=100.0)}, Outcome.DIVERGED, "grew without bound"),
    ("NaN", lambda t, x, p: [ca.sqrt(0.5 - t), x[0]], {}, Outcome.NON_FINITE_RATE, "gives nan for the rate of 'x0'"),
    ("NaN at once", lambda t, x, p: [ca.log(x[1] - 1), x[0]], {}, Outcome.NON_FINITE_RATE, "gives nan for the rate of 'x0'"),
    (
        "step",
        lambda t, x, p: [50 * ca.cos(100 * t), 1],
        {"budget": Budget(smallest_step=1e-3)},
        Outcome.STEP_TOO_SMALL,
        "steps of 0.008 s",
    ),
    ("chatter", lambda t, x, p: [-50 * ca.sign(x[0]), x[0]], {}, Outcome.CHATTERING, "the rate of 'x0'"),
]


@pytest.mark.parametrize(("rates", "options", "outcome", "words"), [row[1:] for row in ENDINGS], ids=[row[0] for row in ENDINGS])
def test_endings_have_the_name_that_the_virtual_machine_gives(
    ode: Ode, rates: Any, options: dict, outcome: Outcome, words: str
) -> None:
    problem = ode(rates, [1.0, 0.0], np.linspace(0.0, 8.0, 41), p=[1.7, 0.5, 0.05])
    chosen = SolverOptions(tolerance=1e-6, **options)
    expected = solve(problem, "rk4", chosen)
    assert expected.outcome is outcome
    for run in (solve_native(problem, chosen), solve_lanes([problem] * 3, chosen).trajectories[2]):
        assert run.outcome is outcome, run.message
        assert words in run.message
        assert np.isfinite(run.states).all()
        if outcome is not Outcome.CHATTERING:
            assert run.times.size == expected.times.size
            assert run.states == pytest.approx(expected.states, rel=1e-6, abs=1e-9)


def test_one_failing_run_does_not_end_the_others(sweep: list[InitialValueProblem]) -> None:
    broken = dataclasses.replace(sweep[0], p=[1.0, 1e306, 0.0])
    runs = solve_lanes([*sweep, broken], SolverOptions(tolerance=1e-6)).trajectories
    assert [run.outcome for run in runs[:-1]] == [Outcome.SUCCESS] * len(sweep)
    assert runs[-1].outcome is not Outcome.SUCCESS


@pytest.mark.parametrize("many", [False, True])
def test_the_wall_clock_and_a_cancellation_stop_a_run(ode: Ode, many: bool) -> None:
    problem = ode(rattler, [1.0, 0.0], [1e9], p=[1.7, 0.5, 0.05])

    def run(**options: Any) -> Trajectory:
        chosen = SolverOptions(tolerance=1e-9, **options)
        return solve_lanes([problem] * 20, chosen).trajectories[-1] if many else solve_native(problem, chosen)

    slow = run(budget=Budget(max_seconds=0.2, max_steps=10**12, smallest_step=1e-30))
    assert slow.outcome is Outcome.MAX_TIME
    assert slow.statistics.seconds < 1.2
    told: list[float] = []
    cancelled = run(cancel=lambda: len(told) > 1, progress=told.append, budget=Budget(max_steps=10**12, smallest_step=1e-30))
    assert cancelled.outcome is Outcome.CANCELLED
    assert "cancelled on request" in cancelled.message
    assert 0.0 <= told[0] <= told[-1] < 1.0


def test_a_progress_report_that_fails_ends_all_workers(ode: Ode) -> None:
    def fails(fraction: float) -> None:
        raise RuntimeError("the screen is gone")

    problem = ode(rattler, [1.0, 0.0], [1e9], p=[1.7, 0.5, 0.05])
    options = SolverOptions(
        tolerance=1e-9, progress=fails, budget=Budget(max_steps=10**12, max_seconds=20.0, smallest_step=1e-30)
    )
    start = time.perf_counter()
    with pytest.raises(RuntimeError, match="the screen is gone"):
        solve_lanes([problem] * 30, options, threads=2)
    assert time.perf_counter() - start < 2.0


def test_progress_ends_at_one(sweep: list[InitialValueProblem]) -> None:
    told: list[float] = []
    solve_lanes(sweep, SolverOptions(tolerance=1e-4, progress=told.append))
    assert told[-1] == 1.0


WRONG: list[tuple[Callable[[list[InitialValueProblem]], object], str]] = [
    (lambda s: solve_lanes([], SolverOptions(tolerance=1e-3)), "there are no problems; give at least one"),
    (lambda s: solve_lanes(s, SolverOptions(tolerance=1e-3), threads=0), "threads: is 0; give a whole number from 1 up"),
    (
        lambda s: solve_native(s[0], SolverOptions(tolerance=1e-3, rule="paper"), "dopri5"),
        "has no rule 'paper' for 'dopri5'; it belongs to step doubling",
    ),
    (
        lambda s: solve_lanes([s[0], dataclasses.replace(s[1], times=[1.0])], SolverOptions(tolerance=1e-3)),
        "problem 1: starts at 0 s with 1 output",
    ),
    (
        lambda s: solve_lanes([s[0], dataclasses.replace(s[1], rhs=other_rhs())], SolverOptions(tolerance=1e-3)),
        "problem 1: has another right-hand side",
    ),
]


def other_rhs() -> ca.Function:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    return ca.Function("other", [t, x, p], [x])


@pytest.mark.parametrize(("ask", "words"), WRONG)
def test_what_does_not_fit_is_refused_by_words(
    sweep: list[InitialValueProblem], ask: Callable[[Any], object], words: str
) -> None:
    with pytest.raises(CaseError, match=words):
        ask(sweep)
