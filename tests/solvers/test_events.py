"""Events are found, in order, at their times, whatever the outputs; what follows from them; how a run of them ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

from modelgen.errors import CaseError
from modelgen.lowering.switching import Crossing
from modelgen.solvers.event_log import EventLog
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Budget, InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.registry import solve

Hybrid = Callable[..., InitialValueProblem]

EXPLICIT = ("rk4", "dopri5", "dop853")


def run(
    problem: InitialValueProblem, method: str = "rk4", tolerance: float = 1e-8, **options: Any
) -> tuple[Trajectory, EventLog]:
    trajectory = solve(problem, method, SolverOptions(tolerance=tolerance, **options))
    assert trajectory.events is not None
    return trajectory, trajectory.events


@pytest.mark.parametrize("method", EXPLICIT)
def test_every_zero_of_a_guard_faster_than_the_state(hybrid: Hybrid, method: str) -> None:
    rng = np.random.default_rng(20)
    total = 0
    crossings = [Crossing("up", 1), Crossing("down", -1), Crossing("both", 0)]
    any_sine = hybrid(
        lambda t, x, p: [1.0 + 0 * t], lambda t, x, p: [ca.sin(p[0] * t + p[1])] * 3, crossings, [0.0], 1.0, p=[1.0, 0.0]
    )
    for omega, phase in zip(10 ** rng.uniform(0, 2.7, 50), rng.uniform(0, 2 * np.pi, 50), strict=True):
        first, last = np.ceil(phase / np.pi), np.floor((omega + phase) / np.pi)
        exact = (np.arange(first, last + 1) * np.pi - phase) / omega
        logs = []
        for times in (np.ones(1), np.linspace(0.0, 1.0, 1001)):
            trajectory, log = run(replace(any_sine, p=[omega, phase], times=times), method, 1e-6)
            assert trajectory.outcome is Outcome.SUCCESS
            logs.append(log)
        assert np.array_equal(logs[0].times, logs[1].times)
        assert np.array_equal(logs[0].which, logs[1].which)
        both = logs[0].times[logs[0].which == 2]
        assert both == pytest.approx(exact, abs=1e-14)
        rising = np.cos(omega * exact + phase) > 0
        assert logs[0].times[logs[0].which == 0] == pytest.approx(exact[rising], abs=1e-14)
        assert logs[0].times[logs[0].which == 1] == pytest.approx(exact[~rising], abs=1e-14)
        total += len(exact)
    assert total > 800


# N2: x'' + f(x) = 0 with a dead zone of half width 1, from 2 at rest; the exact solution is four arcs.
BACKLASH = [
    Crossing("gap.up", 1, 0, 0, 1), Crossing("up.gap", -1, 0, 1, 0),
    Crossing("gap.down", -1, 0, 0, 2), Crossing("down.gap", 1, 0, 2, 0),
]  # fmt: skip
PERIOD = 2 * np.pi + 4
PASSAGES = np.array([np.pi / 2, np.pi / 2 + 2, 3 * np.pi / 2 + 2, 3 * np.pi / 2 + 4])


def backlash(hybrid: Hybrid, times: Any, **changes: Any) -> InitialValueProblem:
    return hybrid(
        lambda t, x, p: [x[1], -p[1] * (x[0] - 1) - p[2] * (x[0] + 1)],
        lambda t, x, p: [x[0] - 1, x[0] - 1, x[0] + 1, x[0] + 1],
        BACKLASH,
        [2.0, 0.0],
        times,
        modes=[("flank", ("gap", "up", "down"))],
        **changes,
    )


def without_events(ode: Callable[..., InitialValueProblem], times: Any) -> InitialValueProblem:
    return ode(lambda t, x, p: [x[1], -(x[0] - ca.fmin(1, ca.fmax(-1, x[0])))], [2.0, 0.0], times)


@pytest.mark.parametrize("rule", ["smooth", "paper"])
@pytest.mark.parametrize("method", [*EXPLICIT, "collocation"])
def test_a_backlash_oscillator_by_its_closed_form(hybrid: Hybrid, method: str, rule: str) -> None:
    trajectory, log = run(backlash(hybrid, [0.0, PERIOD]), method, 1e-12 if method != "collocation" else 1e-9, rule=rule)
    slack = 1e-10 if method != "collocation" else 1e-6
    assert log.times == pytest.approx(PASSAGES, abs=slack)
    assert log.which.tolist() == [1, 2, 3, 0]
    assert log.start == (1,)  # found before anything is logged
    assert trajectory.states[-1] == pytest.approx([2.0, 0.0], abs=slack)
    assert log.states[:, 0] == pytest.approx([1, -1, -1, 1], abs=slack)
    assert log.share() == pytest.approx(
        {"flank.gap": 4 / PERIOD, "flank.up": np.pi / PERIOD, "flank.down": np.pi / PERIOD}, abs=slack
    )
    assert log.counts.tolist() == [1, 1, 1, 1]
    assert log.rows()[0][1:] == ("up.gap", "up", "gap")
    assert log.modes(np.array([0.0, 2.0, 4.0, PASSAGES[-1] - 1e-5, PERIOD]))[:, 0].tolist() == [1, 0, 2, 0, 1]


def test_no_output_moves_an_event_and_no_section_a_step(hybrid: Hybrid) -> None:
    coarse, fine = (run(backlash(hybrid, times)) for times in ([30.0], np.linspace(5.0, 30.0, 1201)))
    assert np.array_equal(coarse[1].times, fine[1].times)
    assert np.array_equal(coarse[1].states, fine[1].states)
    assert coarse[0].statistics.steps == fine[0].statistics.steps
    plain = hybrid(lambda t, x, p: [x[1], -x[0]], lambda t, x, p: [x[0]], [Crossing("far", 1, stops=True)], [1e-3, 1.0], 3.0)
    noted = hybrid(
        lambda t, x, p: [x[1], -x[0]], lambda t, x, p: [x[0], x[1]], [Crossing("far", 1), Crossing("top", 0)], [1e-3, 1.0], 3.0
    )
    one, other = run(plain), run(noted)
    assert one[0].statistics.steps == other[0].statistics.steps
    assert np.array_equal(one[0].states, other[0].states)
    assert other[1].times == pytest.approx([np.pi / 2 - 1e-3], abs=1e-7)


@pytest.mark.parametrize("method", EXPLICIT)
def test_with_events_the_same_error_takes_at_most_half_the_evaluations(
    hybrid: Hybrid, ode: Callable[..., InitialValueProblem], method: str
) -> None:
    costs = []
    for problem in (backlash(hybrid, 3 * PERIOD), without_events(ode, 3 * PERIOD)):
        runs = [solve(problem, method, SolverOptions(tolerance=tolerance)) for tolerance in 10.0 ** -np.arange(2.0, 9.6, 0.25)]
        found = [(np.abs(each.states[-1] - [2.0, 0.0]).max(), each.statistics.evaluations) for each in runs]
        costs.append([min(cost for error, cost in found if error <= wanted) for wanted in (1e-4, 1e-5, 1e-6)])
    assert (np.array(costs[0]) < 0.5 * np.array(costs[1])).all()


@pytest.mark.parametrize(("extrapolate", "order"), [(False, 4), (True, 5)])
def test_fixed_steps_keep_their_order_across_kinks(
    hybrid: Hybrid, ode: Callable[..., InitialValueProblem], extrapolate: bool, order: int
) -> None:
    end = 2.0 + PERIOD  # not at a turning point, where the error in time would not show
    exact = np.array([1.0 - (2.0 - np.pi / 2), -1.0])
    counts = np.array([40, 80, 160])
    measured = {}
    for name, problem in (("with", backlash(hybrid, end)), ("without", without_events(ode, end))):
        errors = []
        for count in counts:
            # Several sizes close to each other: without events the error depends on where the steps meet the kinks.
            sizes = end / (count + np.arange(0, 8))
            runs = [solve(problem, "rk4", SolverOptions(tolerance=1.0, fixed_step=h, extrapolate=extrapolate)) for h in sizes]
            errors.append(max(np.abs(each.states[-1] - exact).max() for each in runs))
        measured[name] = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert abs(measured["with"] - order) < 0.25
    assert measured["without"] < 2.3


def test_fixed_steps_go_on_to_the_planned_times(hybrid: Hybrid) -> None:
    cost = run(backlash(hybrid, 8.0), fixed_step=0.5)[0].statistics
    assert cost.steps == 16 + 3  # three events, each with a short step to the next of the planned times


GRAVITY = 9.81


def ball(hybrid: Hybrid, end: float, restitution: float, height: float = 1.0, **changes: Any) -> InitialValueProblem:
    return hybrid(
        lambda t, x, p: [x[1], -GRAVITY + 0 * t],
        lambda t, x, p: [x[0]],
        [Crossing("floor", -1, reset=0)],
        [height, 0.0],
        end,
        resets=lambda t, x, p: [[x[0], -restitution * x[1]]],
        **changes,
    )


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("restitution", [0.5, 0.8])
def test_a_bouncing_ball_by_its_closed_form_and_its_end(hybrid: Hybrid, method: str, restitution: float) -> None:
    trajectory, log = run(ball(hybrid, np.linspace(0, 10, 101), restitution), method)
    fall = np.sqrt(2 / GRAVITY)
    k = np.arange(12)
    exact = fall * (1 + 2 * restitution * (1 - restitution**k) / (1 - restitution))
    assert log.times[:12] == pytest.approx(exact, abs=1e-12)
    assert log.states[:12, 1] == pytest.approx(-np.sqrt(2 * GRAVITY) * restitution**k, abs=1e-11)
    rest = fall * (1 + restitution) / (1 - restitution)
    assert trajectory.outcome is Outcome.ZENO, trajectory.message
    assert "events of 'floor' follow each other ever faster" in trajectory.message
    assert float(log.times[-1]) == pytest.approx(rest, abs=1e-5)
    assert trajectory.times[-1] <= rest
    assert trajectory.states[:, 0].min() > -1e-9


def test_a_law_that_pushes_back_from_both_sides_is_named(hybrid: Hybrid) -> None:
    relay = hybrid(
        lambda t, x, p: [p[1] - p[0]],
        lambda t, x, p: [x[0], x[0]],
        [Crossing("up", 1, 0, 1, 0), Crossing("down", -1, 0, 0, 1)],
        [1.0],
        5.0,
        modes=[("sign", ("plus", "minus"))],
    )
    trajectory, log = run(relay)
    assert trajectory.outcome is Outcome.EVENT_CHATTER, trajectory.message
    assert "switches forth and back without time passing" in trajectory.message
    assert log.times[0] == pytest.approx(1.0, abs=1e-14)
    assert log.times[-1] == pytest.approx(1.0, abs=1e-6)


def test_modes_without_a_lawful_one_are_named(hybrid: Hybrid) -> None:
    confused = hybrid(
        lambda t, x, p: [1.0 + 0 * t],
        lambda t, x, p: [x[0] - 1, x[0] - 0.5],
        [Crossing("there", 1, 0, 0, 1, reset=0), Crossing("back", 1, 0, 1, 0)],
        [0.0],
        5.0,
        modes=[("mode", ("one", "other"))],
        resets=lambda t, x, p: [[x[0] + 1]],
    )
    trajectory, log = run(confused)
    assert trajectory.outcome is Outcome.EVENT_CHATTER
    assert log.times == pytest.approx(np.ones(32), abs=1e-14)


def test_the_budget_of_events(hybrid: Hybrid) -> None:
    trajectory, log = run(backlash(hybrid, np.linspace(0, 100, 101)), budget=Budget(max_events=6))
    assert trajectory.outcome is Outcome.MAX_EVENTS
    assert "budget of 6 events is used up (the next is 'down.gap')" in trajectory.message
    assert len(log) == 6
    assert trajectory.times[-1] < log.times[-1] + PERIOD


def test_a_stop_ends_the_run_and_is_good(hybrid: Hybrid) -> None:
    stopped = hybrid(
        lambda t, x, p: [x[1], -x[0]],
        lambda t, x, p: [x[0] - 0.5, x[1]],
        [Crossing("half", -1, stops=True), Crossing("top", 1)],
        [1.0, 0.0],
        np.linspace(0, 10, 1001),
    )
    trajectory, log = run(stopped)
    assert trajectory.outcome is Outcome.EVENT
    assert trajectory.outcome.is_good
    assert trajectory.message == "stopped at t = 1.04719755 s: event 'half' asked for it"
    assert log.times == pytest.approx([np.pi / 3], abs=1e-7)
    assert trajectory.times[-1] == pytest.approx(1.04)
    assert log.states[0] == pytest.approx([0.5, -np.sqrt(0.75)], abs=1e-7)


@pytest.mark.parametrize("depth", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("method", EXPLICIT)
def test_a_guard_that_dips_below_zero_within_a_step_is_found_twice(hybrid: Hybrid, method: str, depth: float) -> None:
    dip = hybrid(
        lambda t, x, p: [1.0 + 0 * t], lambda t, x, p: [(x[0] - 1) ** 2 - p[0]], [Crossing("dip", 0)], [0.0], 5.0, p=[depth]
    )
    _, log = run(dip, method)
    assert log.times == pytest.approx([1 - np.sqrt(depth), 1 + np.sqrt(depth)], abs=1e-9)


def test_a_guard_that_only_touches_zero_is_no_event(hybrid: Hybrid) -> None:
    for shift, found in ((0.0, 0), (1e-9, 0), (-1e-9, 2)):
        touch = hybrid(
            lambda t, x, p: [1.0 + 0 * t], lambda t, x, p: [(t - 1) ** 2 + p[0]], [Crossing("touch", 0)], [0.0], 5.0, p=[shift]
        )
        assert len(run(touch)[1]) == found


def test_many_guards_in_one_step_come_in_the_order_of_time_then_of_numbers(hybrid: Hybrid) -> None:
    places = np.array([0.7, 0.3, 0.5, 0.3, 0.9])
    crossings = [Crossing(str(index), 1) for index in range(5)]
    _, log = run(hybrid(lambda t, x, p: [1.0 + 0 * t], lambda t, x, p: [x[0] - each for each in places], crossings, [0.0], 1.0))
    assert log.which.tolist() == [1, 3, 2, 0, 4]
    assert log.times == pytest.approx(np.sort(places), abs=1e-14)


def test_two_events_with_effect_at_one_time_both_happen(hybrid: Hybrid) -> None:
    twins = hybrid(
        lambda t, x, p: [x[1], -1.0 + 0 * t, x[3], -1.0 + 0 * t],
        lambda t, x, p: [x[0], x[2]],
        [Crossing("left", -1, reset=0), Crossing("right", -1, reset=1)],
        [1.0, 0.0, 1.0, 0.0],
        4.0,
        resets=lambda t, x, p: [[x[0], -x[1], x[2], x[3]], [x[0], x[1], x[2], -0.5 * x[3]]],
    )
    trajectory, log = run(twins)
    assert log.which[:2].tolist() == [0, 1]
    assert log.times[0] == log.times[1] == pytest.approx(np.sqrt(2), abs=1e-13)
    assert trajectory.states[-1, 0] == pytest.approx(np.sqrt(2) * (4 - np.sqrt(2)) - (4 - np.sqrt(2)) ** 2 / 2, abs=1e-10)


def test_a_start_on_the_border_goes_where_the_motion_goes(hybrid: Hybrid) -> None:
    for speed, mode in ((1.0, "right"), (-1.0, "left")):
        start = hybrid(
            lambda t, x, p: [p[0]],
            lambda t, x, p: [x[0], x[0]],
            [Crossing("r", 1, 0, 0, 1), Crossing("l", -1, 0, 1, 0)],
            [0.0],
            [0.0, 1.0],
            p=[speed],
            modes=[("side", ("left", "right"))],
        )
        assert run(start)[1].share()[f"side.{mode}"] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("method", EXPLICIT)
def test_a_guard_in_both_directions_toggles_once_at_each_zero(hybrid: Hybrid, method: str) -> None:
    toggle = hybrid(
        lambda t, x, p: [1.0 + 0 * t],
        lambda t, x, p: [ca.sin(5 * x[0])] * 2,
        [Crossing("on", 0, 0, 0, 1), Crossing("off", 0, 0, 1, 0)],
        [0.1],
        7.0,
        modes=[("lamp", ("dark", "lit"))],
    )
    _, log = run(toggle, method)
    assert log.times == pytest.approx(np.pi / 5 * np.arange(1, 12) - 0.1, abs=1e-13)
    assert log.which.tolist() == [0, 1] * 5 + [0]


def ball_over_sections(hybrid: Hybrid, restitution: float, end: float) -> InitialValueProblem:
    return hybrid(
        lambda t, x, p: [x[1], -9.81],
        lambda t, x, p: [x[0], x[0], x[0] + 1e3 - 1e3],
        [Crossing("bounce", -1, reset=0), Crossing("floor", -1), Crossing("nearly", -1)],
        [1.0, 0.0],
        end,
        p=[restitution],
        resets=lambda t, x, p: [[x[0], -p[0] * x[1]]],
    )


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("method", EXPLICIT)
def test_a_ball_never_falls_through_the_floor(hybrid: Hybrid, method: str, tolerance: float) -> None:
    first = np.sqrt(2 / 9.81)
    for restitution in (0.3, 0.5):
        trajectory, log = run(ball_over_sections(hybrid, restitution, 4.0), method, tolerance)
        assert trajectory.outcome is Outcome.ZENO
        bounces = log.times[log.which == 0]
        expected = first * (1 + 2 * np.cumsum(restitution ** np.arange(1, 12)))
        assert bounces[:12] == pytest.approx([first, *expected], abs=1e-9)
        assert log.counts[1:].tolist() == [len(bounces)] * 2


def test_what_an_impact_brings_to_rest_on_a_surface_stays_there_or_chatters(hybrid: Hybrid) -> None:
    trajectory, log = run(ball_over_sections(hybrid, 0.0, 4.0))
    assert trajectory.outcome is Outcome.EVENT_CHATTER
    assert log.times == pytest.approx(np.full(len(log), np.sqrt(2 / 9.81)), abs=1e-12)
    free = hybrid(
        lambda t, x, p: [x[1], 0 * t],
        lambda t, x, p: [x[0] - 0.1],
        [Crossing("wall", 1, reset=0)],
        [0.0, 0.7],
        1000.0,
        resets=lambda t, x, p: [[x[0], 0.0]],
    )
    trajectory, log = run(free)
    assert trajectory.outcome is Outcome.SUCCESS
    assert len(log) == 1


@pytest.mark.parametrize("method", EXPLICIT)
def test_sections_on_the_border_of_modes_are_found_with_its_events(hybrid: Hybrid, method: str) -> None:
    borders = backlash(hybrid, 2.2 * PERIOD)
    with_sections = hybrid(
        lambda t, x, p: [x[1], -p[1] * (x[0] - 1) - p[2] * (x[0] + 1)],
        lambda t, x, p: [x[0] - 1, x[0] - 1, x[0] + 1, x[0] + 1, x[0] - 1, 3 * x[0] + 0.1 - 3.1, x[0] + 1],
        [*BACKLASH, Crossing("both", 0), Crossing("scaled", -1), Crossing("falling", -1)],
        [2.0, 0.0],
        2.2 * PERIOD,
        modes=[("flank", ("gap", "up", "down"))],
    )
    log = run(with_sections, method)[1]
    for section, events in ((4, (0, 1)), (5, (1,)), (6, (2,))):
        assert log.times[log.which == section] == pytest.approx(log.times[np.isin(log.which, events)], abs=1e-13)
    assert log.times[log.which < 4] == pytest.approx(run(borders, method)[1].times, abs=1e-6)


def test_a_run_may_start_on_the_section_that_stops_it(hybrid: Hybrid) -> None:
    section = hybrid(lambda t, x, p: [x[1], -x[0]], lambda t, x, p: [x[1]], [Crossing("top", -1, stops=True)], [1.0, 0.0], 20.0)
    for _ in range(3):
        trajectory, log = run(section, tolerance=1e-10)
        assert trajectory.outcome is Outcome.EVENT
        assert log.times == pytest.approx([2 * np.pi], abs=1e-8)
        section = replace(section, x0=log.states[-1])


def test_forth_and_back_without_time_is_chatter_whatever_the_rounding(hybrid: Hybrid) -> None:
    for place in (0.3, 0.7, 1.1, 2.3):
        push = hybrid(
            lambda t, x, p: [p[1] - p[0]],
            lambda t, x, p: [x[0], x[0]],
            [Crossing("down", -1, 0, 0, 1), Crossing("up", 1, 0, 1, 0)],
            [place],
            [10.0],
            modes=[("side", ("above", "below"))],
        )
        trajectory, log = run(push)
        assert trajectory.outcome is Outcome.EVENT_CHATTER
        assert log.times[0] == pytest.approx(place, abs=1e-12)


def test_a_guard_without_a_number_ends_the_run_by_name(hybrid: Hybrid) -> None:
    lost = hybrid(
        lambda t, x, p: [1.0 + 0 * t], lambda t, x, p: [ca.sqrt(1 - x[0]) + 1], [Crossing("root", 1)], [0.0], [0.5, 2.0]
    )
    trajectory, _ = run(lost)
    assert not trajectory.outcome.is_good
    assert trajectory.times.tolist() == [0.5]


def test_a_guard_that_is_rounding_does_not_stop_the_clock(hybrid: Hybrid) -> None:
    noise = hybrid(
        lambda t, x, p: [x[1], -x[0], x[3], -x[2]],
        lambda t, x, p: [(x[0] + 1e3) - (x[2] + 1e3)],
        [Crossing("none", 0)],
        [1.0, 0.0, 1.0, 0.0],
        20.0,
    )
    quiet = hybrid(
        lambda t, x, p: [x[1], -x[0], x[3], -x[2]], lambda t, x, p: [x[0] + 9], [Crossing("far", 0)], [1.0, 0.0, 1.0, 0.0], 20.0
    )
    assert run(noise)[0].statistics.steps == run(quiet)[0].statistics.steps


def test_guards_that_never_fire_cost_no_evaluation(hybrid: Hybrid, ode: Callable[..., InitialValueProblem]) -> None:
    def rates(t: Any, x: Any, p: Any) -> list[Any]:
        return [x[1], -ca.sin(x[0]) + 0.1 * ca.cos(3 * t)]

    plain = solve(ode(rates, [1.0, 0.0], 20.0), "rk4", SolverOptions(tolerance=1e-8))
    watched, log = run(
        hybrid(rates, lambda t, x, p: [x[0] - 3, x[1] + 4], [Crossing("a", 0), Crossing("b", 0)], [1.0, 0.0], 20.0)
    )
    assert len(log) == 0
    assert watched.statistics.evaluations == plain.statistics.evaluations
    assert np.array_equal(watched.states, plain.states)
    assert plain.events is None


def test_a_solver_that_does_not_locate_events_refuses_them(hybrid: Hybrid) -> None:
    with pytest.raises(
        CaseError, match=r"solver 'cvodes': cannot locate events; take rk4 or dopri5 or dop853 or collocation, or"
    ):
        solve(backlash(hybrid, 1.0), "cvodes", SolverOptions(tolerance=1e-6))
