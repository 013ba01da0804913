"""What lanes hand on of their runs: channels, their reductions, and memory that stays flat."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

from modelgen.errors import CaseError
from modelgen.solvers.gather import Gather
from modelgen.solvers.lanes import Lanes, solve_lanes
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Budget, InitialValueProblem, SolverOptions

OPTIONS = SolverOptions(tolerance=1e-8)
T, X, P = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 2)
CHANNELS = ca.Function("channels", [T, X, P], [ca.vertcat(X[0] ** 2 + P[1] * ca.cos(P[0] * T), X[1], ca.exp(-P[0]))])


pytestmark = pytest.mark.usefixtures("own_cache")


def swinger(t: Any, x: Any, p: Any) -> list[Any]:
    return [x[1], -4 * ca.sin(x[0]) - 0.1 * x[1] + p[1] * ca.cos(p[0] * t)]


@pytest.fixture(scope="module", params=[0.0, 1.25])
def sweep(ode: Callable[..., InitialValueProblem], request: pytest.FixtureRequest) -> list[InitialValueProblem]:
    """Eleven pendulums; outputs begin at the start, and later."""
    first = ode(swinger, [1.0, 0.0], np.linspace(request.param, 8.0, 83), p=[1.7, 0.5])
    return [dataclasses.replace(first, p=[1.0 + 0.1 * k, 0.3 + 0.05 * k], x0=[0.1 * k, 0.2]) for k in range(11)]


def values(problem: InitialValueProblem, states: np.ndarray) -> np.ndarray:
    return np.array([CHANNELS(t, x, problem.p).full()[:, 0] for t, x in zip(problem.times, states, strict=True)])


def test_channels_are_those_of_the_states_at_the_output_times(sweep: list[InitialValueProblem]) -> None:
    lanes = solve_lanes(sweep, OPTIONS, gather=Gather(channels=CHANNELS, keep=True))
    assert lanes.channels is not None
    for index, problem in enumerate(sweep):
        expected = values(problem, lanes.trajectories[index].states)
        assert np.abs(lanes.channels[index] - expected).max() < 1e-13
        found = np.array([getattr(lanes, f"channel_{name}")[index] for name in ("lowest", "highest", "mean", "mean_square")])
        reductions = (expected.min(axis=0), expected.max(axis=0), expected.mean(axis=0), (expected**2).mean(axis=0))
        assert np.allclose(found, reductions, rtol=1e-12, atol=1e-14)


def test_without_states_only_the_end_of_each_run_remains(sweep: list[InitialValueProblem]) -> None:
    everything = solve_lanes(sweep, OPTIONS, gather=Gather(channels=CHANNELS, keep=True))
    little = solve_lanes(sweep, OPTIONS, gather=Gather(states=False, channels=CHANNELS))
    assert little.channels is None
    assert np.array_equal(little.channel_mean, everything.channel_mean)
    assert np.array_equal(little.final, everything.final)
    for run, full in zip(little.trajectories, everything.trajectories, strict=True):
        assert run.times.tolist() == [full.times[-1]]
        assert run.states[0] == pytest.approx(full.states[-1], abs=1e-15)
    assert solve_lanes(sweep, OPTIONS, gather=Gather(states=False)).channel_mean is None


def bits(lanes: Lanes) -> list[bytes]:
    reductions = (lanes.channels, lanes.channel_lowest, lanes.channel_highest, lanes.channel_mean, lanes.channel_mean_square)
    return [b"".join(array[index].tobytes() for array in reductions) for index in range(len(lanes.trajectories))]


def test_channels_do_not_depend_on_neighbors_order_or_threads(sweep: list[InitialValueProblem]) -> None:
    gather = Gather(channels=CHANNELS, keep=True)
    expected = bits(solve_lanes(sweep, OPTIONS, 1, gather))
    assert len(set(expected)) == len(sweep)
    assert bits(solve_lanes(sweep[::-1], OPTIONS, 1, gather))[::-1] == expected
    assert bits(solve_lanes(sweep[:3], OPTIONS, 1, gather)) == expected[:3]
    assert bits(solve_lanes(sweep * 3, OPTIONS, 3, gather)) == expected * 3


def test_a_run_that_stops_early_is_reduced_over_what_it_reached(sweep: list[InitialValueProblem]) -> None:
    options = SolverOptions(tolerance=1e-8, budget=Budget(max_steps=40))
    lanes = solve_lanes(sweep, options, gather=Gather(channels=CHANNELS, keep=True))
    assert lanes.channels is not None
    for index, (problem, run) in enumerate(zip(sweep, lanes.trajectories, strict=True)):
        assert run.outcome is Outcome.MAX_STEPS
        reached = len(run.times)
        assert np.isfinite(lanes.channels[index, :reached]).all()
        assert np.isnan(lanes.channels[index, reached:]).all()
        if reached:
            assert lanes.channel_mean[index] == pytest.approx(lanes.channels[index, :reached].mean(axis=0))
        else:
            assert np.isnan(lanes.channel_mean[index]).all()
        assert np.isfinite(lanes.final[index]).all()
        assert problem.t0 <= 8.0


WRONG: list[tuple[Callable[[], object], str]] = [
    (lambda: Gather(keep=True), "keep: is asked for without channels"),
    (lambda: Gather(states=1), "states: is 1; give True or False"),  # type: ignore[arg-type]
    (lambda: Gather(events=-1), "events: is -1; give a whole number"),
    (lambda: Gather(channels="x"), "channels: is a str"),
    (lambda: Gather(channels=ca.Function("f", [T, X], [X])), "has 2 inputs and 1 outputs"),
    (lambda: Gather(channels=ca.Function("f", [T, X, P], [X.T])), "wanted is a column"),
]


@pytest.mark.parametrize(("ask", "words"), WRONG)
def test_what_cannot_be_gathered_is_refused_by_words(ask: Callable[[], object], words: str) -> None:
    with pytest.raises(CaseError, match=words):
        ask()


def test_channels_of_another_model_are_refused(sweep: list[InitialValueProblem]) -> None:
    other = ca.SX.sym("x", 3)
    channels = ca.Function("other", [T, other, P], [other])
    with pytest.raises(CaseError, match="channels: take 3 states and 2 parameters, the model has 2 and 2"):
        solve_lanes(sweep, OPTIONS, gather=Gather(channels=channels))
