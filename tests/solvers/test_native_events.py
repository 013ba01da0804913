"""Events in generated C: the log of the virtual machine and of closed forms, for one trajectory and in lanes."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np
import pytest

from modelgen.errors import CaseError
from modelgen.lowering.switching import Crossing, ModeVariable, Switching
from modelgen.solvers.event_log import EventLog
from modelgen.solvers.gather import Gather
from modelgen.solvers.lanes import Lanes, solve_lanes
from modelgen.solvers.native import solve_native
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Budget, InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.registry import solve

Columns = Callable[[Any, Any, Any], Sequence[Any]]
OPTIONS = SolverOptions(tolerance=1e-8)


pytestmark = pytest.mark.usefixtures("own_cache")


def hybrid(
    rates: Columns,
    guards: Columns,
    crossings: Sequence[Crossing],
    x0: Sequence[float],
    times: Any,
    p: Sequence[float] = (),
    modes: Sequence[ModeVariable] = (),
    reset: Columns | None = None,
) -> InitialValueProblem:
    t, x, q = ca.SX.sym("t"), ca.SX.sym("x", len(x0)), ca.SX.sym("p", len(p))
    rhs, guard = (ca.Function("f", [t, x, q], [ca.vertcat(*made(t, x, q))]) for made in (rates, guards))
    resets = None if reset is None else ca.Function("resets", [t, x, q], [ca.vertcat(*reset(t, x, q))])
    switching = Switching(tuple(modes), tuple(crossings), guard, len(p), resets)
    names = tuple(f"x{index}" for index in range(len(x0)))
    return InitialValueProblem(rhs, names, x0, p, np.ones(len(x0)), 0.0, np.atleast_1d(times), switching)


def ball(restitution: float, end: float) -> InitialValueProblem:
    return hybrid(
        lambda t, x, p: [x[1], -9.81],
        lambda t, x, p: [x[0]],
        [Crossing("bounce", -1, reset=0)],
        [1.0, 0.0],
        np.linspace(0, end, 41),
        p=[restitution],
        reset=lambda t, x, p: [x[0], -p[0] * x[1]],
    )


def bounces(restitution: float, end: float) -> np.ndarray:
    first = math.sqrt(2 / 9.81)
    times = [first]
    while (last := times[-1] + 2 * first * restitution ** len(times)) < end:
        times.append(last)
    return np.array(times)


GAP = 0.3
FLANK = (
    *(Crossing("free-drive", 1, 0, 0, 1), Crossing("drive-free", -1, 0, 1, 0)),
    *(Crossing("free-coast", -1, 0, 0, 2), Crossing("coast-free", 1, 0, 2, 0)),
)


@pytest.fixture(scope="module")
def rattler() -> InitialValueProblem:
    """A forced oscillator with backlash; p: amplitude, frequency, flags of free, drive and coast. A section lies on a border."""

    def rates(t: Any, x: Any, p: Any) -> list[Any]:
        spring = p[3] * (x[0] - GAP) + p[4] * (x[0] + GAP)
        return [x[1], -4 * spring - 0.05 * x[1] + p[0] * ca.cos(p[1] * t)]

    return hybrid(
        rates,
        lambda t, x, p: [x[0] - GAP, x[0] - GAP, x[0] + GAP, x[0] + GAP, x[0] - GAP, x[1]],
        [*FLANK, Crossing("border", 0), Crossing("top", -1)],
        [1.0, 0.0],
        np.linspace(0, 40, 201),
        p=[0.8, 1.3, 1.0, 0.0, 0.0],
        modes=[ModeVariable("flank", ("free", "drive", "coast"), 2)],
    )


def log_of(run: Trajectory) -> EventLog:
    assert run.events is not None
    return run.events


def native(problem: InitialValueProblem, options: SolverOptions, method: str = "rk4") -> list[Trajectory]:
    """One trajectory by itself, and the second of three in lanes."""
    return [solve_native(problem, options, method), solve_lanes([problem] * 3, options, method=method).trajectories[1]]


@pytest.mark.parametrize("method", ["rk4", pytest.param("dopri5", marks=pytest.mark.slow), "dop853"])
def test_bounces_of_a_ball(method: str) -> None:
    expected = bounces(0.8, 4.0)
    for run in native(ball(0.8, 4.0), OPTIONS, method):
        log = log_of(run)
        assert run.outcome is Outcome.SUCCESS
        assert np.abs(log.times - expected).max() < 1e-11
        assert np.abs(log.states[:, 0]).max() < 1e-11
        assert log.counts.tolist() == [len(expected)]
        assert run.states.shape == (41, 2)
        assert run.states[:, 0].min() > -1e-12


def test_a_ball_that_comes_to_rest_ends_as_zeno() -> None:
    end = math.sqrt(2 / 9.81) * (1 + 2 * 0.5 / (1 - 0.5))
    for run in native(ball(0.5, 4.0), OPTIONS):
        assert run.outcome is Outcome.ZENO
        assert "events of 'bounce' follow each other ever faster" in run.message
        assert log_of(run).times[-1] == pytest.approx(end, abs=1e-6)
        assert run.times[-1] <= end


@pytest.mark.parametrize("method", ["rk4", "dopri5", "dop853"])
def test_a_ball_never_falls_through_the_floor(method: str) -> None:
    """Whatever is left of its flights: steps longer than a flight find the way back down, not the way up from the floor."""
    for restitution, tolerance in ((0.3, 1e-6), (0.3, 1e-9), (0.5, 1e-9)):
        for run in native(ball(restitution, 4.0), SolverOptions(tolerance=tolerance), method):
            assert run.outcome is Outcome.ZENO
            expected = math.sqrt(2 / 9.81) * (2 * np.cumsum(restitution ** np.arange(12)) - 1)
            assert log_of(run).times[:12] == pytest.approx(expected, abs=1e-9)
    for run in native(ball(0.0, 4.0), OPTIONS, method):
        assert run.outcome is Outcome.EVENT_CHATTER


@pytest.mark.parametrize("options", [{}, {"rule": "paper"}, {"fixed_step": 0.03}])
def test_the_log_is_that_of_the_virtual_machine(rattler: InitialValueProblem, options: dict) -> None:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 5)
    assert rattler.switching is not None
    flank = ca.Function("flank", [t, x, p], [rattler.switching.guards(t, x, p)[:4]])
    plain = dataclasses.replace(rattler, switching=dataclasses.replace(rattler.switching, crossings=FLANK, guards=flank))
    chosen = SolverOptions(tolerance=1e-8, **options)
    expected = solve(plain, "rk4", chosen)
    known = log_of(expected)
    assert len(known) > 30
    for run in native(plain, chosen):
        log = log_of(run)
        assert run.outcome is expected.outcome
        assert np.array_equal(log.which, known.which)
        assert np.abs(log.times - known.times).max() < 1e-10
        assert np.abs(log.states - known.states).max() < 1e-10
        assert np.abs(log.shares - known.shares).max() < 1e-10
        assert np.array_equal(log.counts, known.counts)
        assert log.start == known.start == (1,)
        assert np.abs(run.states - expected.states).max() < 1e-10


@pytest.mark.parametrize("method", ["dopri5", pytest.param("dop853", marks=pytest.mark.slow)])
def test_other_methods_find_the_same_events(rattler: InitialValueProblem, method: str) -> None:
    options = SolverOptions(tolerance=1e-10)
    expected = log_of(solve_native(rattler, options))
    for run in native(rattler, options, method):
        log = log_of(run)
        assert np.array_equal(log.which, expected.which)
        assert np.abs(log.times - expected.times).max() < 1e-8


def test_sections_change_nothing_and_are_found_on_a_border_of_modes_too(rattler: InitialValueProblem) -> None:
    for run in native(rattler, OPTIONS):
        log = log_of(run)
        assert log.counts[4] == log.counts[0] + log.counts[1] > 10
        border, flank = log.times[log.which == 4], log.times[log.which < 2]
        assert np.abs(border - flank).max() < 1e-12
        assert log.counts[5] > 5
        assert np.abs(log.states[log.which == 5, 1]).max() < 1e-12
        assert log.shares.sum() == pytest.approx(1.0, abs=1e-12)


def test_the_log_does_not_depend_on_the_output_times(rattler: InitialValueProblem) -> None:
    few = dataclasses.replace(rattler, times=[40.0])
    for one, other in zip(native(rattler, OPTIONS), native(few, OPTIONS), strict=True):
        assert np.array_equal(log_of(one).times, log_of(other).times)
        assert one.statistics.steps == other.statistics.steps


@pytest.mark.slow
def test_no_zero_of_a_fast_guard_is_lost() -> None:
    rng = np.random.default_rng(1)
    first = hybrid(
        lambda t, x, p: [1.0 + 0 * x[0]],
        lambda t, x, p: [ca.sin(p[0] * t + p[1])] * 3,
        [Crossing("up", 1), Crossing("down", -1), Crossing("both", 0)],
        [0.0],
        [10.0],
        p=[1.0, 0.0],
    )
    draws = [[10 ** rng.uniform(0, 2), rng.uniform(0, 2 * math.pi)] for _ in range(50)]
    runs = solve_lanes([dataclasses.replace(first, p=p) for p in draws], SolverOptions(tolerance=1e-4)).trajectories
    for (omega, phase), run in zip(draws, runs, strict=True):
        turns = np.arange(math.ceil(phase / math.pi), math.floor((10 * omega + phase) / math.pi) + 1)
        zeros, log = (turns * math.pi - phase) / omega, log_of(run)
        for number, expected in enumerate((zeros[turns % 2 == 0], zeros[turns % 2 == 1], zeros)):
            assert np.abs(log.times[log.which == number] - expected).max() < 1e-12
    one = solve_native(dataclasses.replace(first, p=draws[0]), SolverOptions(tolerance=1e-4))
    assert np.abs(log_of(one).times - log_of(runs[0]).times).max() < 1e-12


@pytest.mark.parametrize(("depth", "count"), [(1e-3, 6), (1e-9, 6), (-1e-9, 0)])
def test_a_guard_that_grazes_zero(depth: float, count: int) -> None:
    problem = hybrid(
        lambda t, x, p: [x[1], -x[0]], lambda t, x, p: [x[0] + 1 - p[0]], [Crossing("touch", 0)], [1.0, 0.0], [20.0], p=[depth]
    )
    half = math.acos(1 - depth) if count else 0.0
    expected = np.array([math.pi * turn + side * half for turn in (1, 3, 5) for side in (-1, 1)])
    for run in native(problem, SolverOptions(tolerance=1e-12)):
        times = log_of(run).times
        assert len(times) == count
        if count:
            assert np.abs(times - expected).max() < 1e-6


def test_coulomb_friction_turns_and_rests() -> None:
    friction, start = 0.3, 2.75

    def rates(t: Any, x: Any, p: Any) -> list[Any]:
        return [x[1], (-x[0] - friction * (p[0] - p[2])) * (1 - p[1])]

    problem = hybrid(
        rates,
        lambda t, x, p: [x[1], x[1], -x[0] - friction, -x[0] + friction],
        [
            *(Crossing("stop forward", -1, 0, 0, 1), Crossing("stop back", 1, 0, 2, 1)),
            *(Crossing("go", 1, 0, 1, 0), Crossing("go back", -1, 0, 1, 2)),
        ],
        [start, 0.0],
        np.linspace(0, 20, 101),
        p=[0.0, 1.0, 0.0],
        modes=[ModeVariable("brake", ("forward", "stick", "back"), 0)],
    )
    for run in native(problem, OPTIONS):
        log = log_of(run)
        assert log.start == (2,)  # found by the chain at the start, which is not logged
        stops = log.which < 2
        assert np.abs(log.times[stops] - math.pi * np.arange(1, 6)).max() < 1e-7
        turning = [(-1) ** k * (start - 2 * k * friction) for k in range(1, 6)]
        assert np.abs(log.states[stops, 0] - turning).max() < 1e-7
        assert run.states[-1, 0] == pytest.approx(turning[-1], abs=1e-7)
        assert len(log) == 9  # four times it goes on at once


@pytest.fixture(scope="module")
def wedge() -> InitialValueProblem:
    """x' = -sign(x) as two modes that push back to the border."""
    return hybrid(
        lambda t, x, p: [p[1] - p[0]],
        lambda t, x, p: [x[0], x[0]],
        [Crossing("down", -1, 0, 0, 1), Crossing("up", 1, 0, 1, 0)],
        [1.0],
        np.linspace(0, 3, 31),
        p=[1.0, 0.0],
        modes=[ModeVariable("side", ("above", "below"), 0)],
    )


def test_modes_that_push_back_to_the_border_end_as_chatter(wedge: InitialValueProblem) -> None:
    for run in native(wedge, OPTIONS):
        assert run.outcome is Outcome.EVENT_CHATTER
        assert "switches forth and back without time passing" in run.message
        assert log_of(run).times == pytest.approx(1.0, abs=1e-9)
        assert run.times[-1] == pytest.approx(1.0)


def test_the_budget_of_events_and_an_event_that_stops(rattler: InitialValueProblem) -> None:
    full = log_of(solve_native(rattler, OPTIONS))
    for run in native(rattler, SolverOptions(tolerance=1e-8, budget=Budget(max_events=5))):
        assert run.outcome is Outcome.MAX_EVENTS
        assert "the budget of 5 events is used up" in run.message
        assert len(log_of(run)) == 5
        assert run.times[-1] <= full.times[5] < run.times[-1] + 0.2
    assert rattler.switching is not None
    crossings = list(rattler.switching.crossings)
    crossings[5] = dataclasses.replace(crossings[5], stops=True)
    stopping = dataclasses.replace(rattler, switching=dataclasses.replace(rattler.switching, crossings=tuple(crossings)))
    first = full.times[full.which == 5][0]
    for run in native(stopping, OPTIONS):
        assert run.outcome is Outcome.EVENT
        assert run.outcome.is_good
        assert "event 'top' asked for it" in run.message
        assert log_of(run).times[-1] == pytest.approx(first, abs=1e-12)
        assert run.times[-1] <= first < run.times[-1] + 0.2
    final = solve_lanes([stopping], OPTIONS, gather=Gather(states=False))
    assert final.trajectories[0].times[0] == pytest.approx(first, abs=1e-12)
    assert abs(final.final[0, 1]) < 1e-12


def bits(lanes: Lanes) -> list[bytes]:
    parts = []
    assert lanes.channels is not None
    for index, run in enumerate(lanes.trajectories):
        log = log_of(run)
        arrays = (
            run.states,
            log.times,
            log.which,
            log.states,
            log.counts,
            log.shares,
            lanes.final[index],
            lanes.channels[index],
        )
        parts.append(b"".join(array.tobytes() for array in (*arrays, lanes.channels[index])))
    return parts


@pytest.mark.parametrize("method", ["rk4", "dop853"])
def test_events_do_not_depend_on_neighbors_order_or_threads(rattler: InitialValueProblem, method: str) -> None:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 5)
    gather = Gather(channels=ca.Function("force", [t, x, p], [p[3] * (x[0] - GAP) + p[4] * (x[0] + GAP)]), keep=True)
    sweep = [dataclasses.replace(rattler, p=[0.2 + 0.1 * k, 0.9 + 0.07 * k, 1.0, 0.0, 0.0]) for k in range(11)]
    options = SolverOptions(tolerance=1e-6)
    expected = bits(solve_lanes(sweep, options, 1, gather, method))
    assert len(set(expected)) == len(sweep)
    assert bits(solve_lanes(sweep[::-1], options, 1, gather, method))[::-1] == expected
    for count in (1, 3, 9):
        assert bits(solve_lanes(sweep[:count], options, 1, gather, method)) == expected[:count]
    assert bits(solve_lanes(sweep * 3, options, 3, gather, method)) == expected * 3


def test_channels_see_the_mode_that_holds(rattler: InitialValueProblem) -> None:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 5)
    gather = Gather(channels=ca.Function("force", [t, x, p], [p[3] * (x[0] - GAP) + p[4] * (x[0] + GAP)]), keep=True)
    lanes = solve_lanes([rattler], OPTIONS, gather=gather)
    place = lanes.trajectories[0].states[:, 0]
    expected = np.sign(place) * np.maximum(np.abs(place) - GAP, 0)
    assert np.abs(lanes.channels[0, :, 0] - expected).max() < 1e-12


def test_logs_can_be_cut_short_while_counts_go_on(rattler: InitialValueProblem) -> None:
    full = log_of(solve_native(rattler, OPTIONS))
    for run in solve_lanes([rattler] * 2, OPTIONS, gather=Gather(events=3)).trajectories:
        assert np.abs(log_of(run).times - full.times[:3]).max() < 1e-9
        assert np.array_equal(log_of(run).counts, full.counts)


@pytest.mark.slow
def test_a_log_longer_than_the_room_of_a_worker_is_complete() -> None:
    problem = hybrid(
        lambda t, x, p: [1.0 + 0 * x[0]], lambda t, x, p: [ca.sin(p[0] * t)], [Crossing("zero", 0)], [0.0], [10.0], p=[1500.0]
    )
    for run in native(problem, SolverOptions(tolerance=1e-4)):
        log = log_of(run)
        assert log.counts.tolist() == [len(log)] == [4774]
        assert np.abs(log.times - math.pi / 1500.0 * np.arange(1, 4775)).max() < 1e-12


def test_guards_of_another_kind_in_one_task_are_refused(rattler: InitialValueProblem) -> None:
    other = dataclasses.replace(rattler, switching=None)
    with pytest.raises(CaseError, match="problem 1: has other guards than the first"):
        solve_lanes([rattler, other], OPTIONS)


def test_a_run_goes_on_from_where_an_event_stopped_it(rattler: InitialValueProblem) -> None:
    """The way of a return map: one section after the other, each run from the end of the one before."""
    problem = hybrid(lambda t, x, p: [x[1], -x[0]], lambda t, x, p: [x[1]], [Crossing("top", -1, stops=True)], [1.0, 0.0], [20.0])
    for _ in range(3):
        lanes = solve_lanes([problem], SolverOptions(tolerance=1e-10), gather=Gather(states=False))
        assert lanes.trajectories[0].outcome is Outcome.EVENT
        assert lanes.trajectories[0].times[0] == pytest.approx(2 * math.pi, abs=1e-9)
        problem = dataclasses.replace(problem, x0=lanes.final[0])


@pytest.mark.slow
def test_a_guard_without_a_value_ends_the_run_with_a_name() -> None:
    """The square root ends at 1 s, after the guard's zero at 0.99 s."""
    problem = hybrid(
        lambda t, x, p: [1.0 + 0 * x[0]], lambda t, x, p: [ca.sqrt(1 - t) - 0.1], [Crossing("root", 0)], [0.0], [3.0]
    )
    for run in native(problem, OPTIONS):
        assert run.outcome is Outcome.STEP_TOO_SMALL
        assert len(log_of(run)) == 1
