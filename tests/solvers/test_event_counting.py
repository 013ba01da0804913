"""Roots of guards within a step: pairs of any distance are counted or noted as a touch, none is invented; the log says how."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np
import pytest
from numpy.polynomial import polynomial

from modelgen.lowering.switching import Crossing
from modelgen.solvers.event_log import EventLog
from modelgen.solvers.lanes import solve_lanes
from modelgen.solvers.problem import InitialValueProblem, SolverOptions
from modelgen.solvers.registry import solve

Hybrid = Callable[..., InitialValueProblem]
METHODS = ("rk4", pytest.param("dopri5", marks=pytest.mark.proof), "dop853")
ONE_STEP = {"tolerance": 1e-6, "fixed_step": 1.0}
DEGREE = 4

pytestmark = pytest.mark.usefixtures("own_cache")


@dataclasses.dataclass(frozen=True)
class Pair:
    """A polynomial guard over the step from 0 to 1 with two roots in it, or none: its scale, roots and quadratic rest."""

    roots: tuple[float, ...]
    coefficients: np.ndarray
    dip: float


def pairs(seed: int, count: int) -> list[Pair]:
    """Polynomials of degree four; two roots split by 1 to 1e-7 of the step, or in every fifth none, but a dip above zero."""
    rng = np.random.default_rng(seed)
    found = []
    for index in range(count):
        split = min(10 ** rng.uniform(-7, 0), 0.9)
        first = rng.uniform(0.02, 0.98 - split)
        middle, half = first + split / 2, split / 2
        center, width = rng.uniform(-0.5, 1.5), rng.uniform(0.3, 2)
        rest = np.array([center**2 + width**2, -2 * center, 1.0]) * rng.choice([-1, 1]) * 10 ** rng.uniform(-3, 3)
        none = index % 5 == 4
        square = [middle**2 + (half**2 if none else -(half**2)), -2 * middle, 1.0]
        dip = half**2 * abs(polynomial.polyval(middle, rest))
        found.append(Pair(() if none else (first, first + split), polynomial.polymul(square, rest), dip))
    return found


def chain(hybrid: Hybrid, each: Pair, first: InitialValueProblem | None = None) -> InitialValueProblem:
    """The polynomial as the first of five states, each the integral of the next."""
    x0 = [c * math.factorial(k) for k, c in enumerate(each.coefficients)]
    scale = np.maximum(np.abs(x0), 1e-12 * np.abs(x0).max())
    if first is not None:
        return dataclasses.replace(first, x0=x0, scale=scale)
    return hybrid(
        lambda t, x, p: [*(x[k + 1] for k in range(DEGREE)), 0 * t],
        lambda t, x, p: [x[0]],
        [Crossing("g", 0)],
        x0,
        [1.0],
        scale=scale,
    )


def product(hybrid: Hybrid, each: Pair, first: InitialValueProblem | None = None) -> InitialValueProblem:
    """The polynomial as a product of the state, which runs with time: no linear combination, so it is enclosed."""
    rest = polynomial.polydiv(each.coefficients, polynomial.polyfromroots(each.roots))[0] if each.roots else each.coefficients
    p = [*(each.roots or (9.0, 9.0)), *(rest if each.roots else rest[:3])]
    if first is not None:
        return dataclasses.replace(first, p=p)
    return hybrid(
        lambda t, x, p: [1.0 + 0 * t],
        lambda t, x, p: [(x[0] - p[0]) * (x[0] - p[1]) * (p[2] + x[0] * (p[3] + x[0] * p[4]))],
        [Crossing("g", 0)],
        [0.0],
        [1.0],
        p=p,
    )


def check(each: Pair, log: EventLog) -> bool:
    """Whether a pair was counted; else it is a touch whose dip is below eight roundings, or there was none."""
    if len(log) == len(each.roots):
        assert log.times == pytest.approx(each.roots, abs=1e-5)
        assert not (each.roots and len(log.touch_times))
        return True
    assert len(log) == 0
    assert log.touch_times == pytest.approx([sum(each.roots) / 2], abs=1e-5)
    assert each.dip < 8 * log.roundings[0]
    return False


def counted(hybrid: Hybrid, make: Any, method: str, seed: int, count: int, single: int) -> int:
    """Check so many pairs in lanes, and the first of them on the virtual machine and in C; how many were counted."""
    made = [each for each in pairs(seed, count) if make is chain or each.roots]
    problems: list[InitialValueProblem] = []
    for each in made:
        problems.append(make(hybrid, each, problems[0] if problems else None))
    found = 0
    for each, run in zip(made, solve_lanes(problems, SolverOptions(**ONE_STEP), method=method).trajectories, strict=True):
        assert run.events is not None
        found += check(each, run.events)
    for backend in ("vm", "c"):
        for each, problem in zip(made[:single], problems, strict=False):
            log = solve(problem, method, SolverOptions(**ONE_STEP, backend=backend)).events
            assert log is not None
            assert log.counting == ("polynomial" if make is chain else "enclosed",)
            check(each, log)
    return found


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("make", [chain, product])
def test_pairs_of_roots_are_counted(hybrid: Hybrid, make: Any, method: str) -> None:
    assert counted(hybrid, make, method, seed=14, count=200, single=12) >= 0.9 * 160


@pytest.mark.proof
@pytest.mark.parametrize("method", ["rk4", "dopri5", "dop853"])
@pytest.mark.parametrize("make", [chain, product])
def test_a_thousand_pairs_of_roots_are_counted(hybrid: Hybrid, make: Any, method: str) -> None:
    found = counted(hybrid, make, method, seed=2026, count=1250, single=1250)
    print(f"{make.__name__}, {method}: {found} of {1250 if make is chain else 1000} counted, the others touches")
    assert found >= 0.9 * 1000


def everywhere(problem: InitialValueProblem, method: str, **options: Any) -> list[EventLog]:
    """The logs of the virtual machine, of C, and of lanes."""
    runs = [solve(problem, method, SolverOptions(**options, backend=backend)) for backend in ("vm", "c")]
    runs.append(solve_lanes([problem] * 3, SolverOptions(**options), method=method).trajectories[1])
    logs = []
    for run in runs:
        assert run.outcome.is_good, run.message
        assert run.events is not None
        logs.append(run.events)
    return logs


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("above", "passings"), [(1e-10, 0), (-1e-10, 2)])
def test_a_ball_that_passes_a_plane_by_a_hair(hybrid: Hybrid, method: str, above: float, passings: int) -> None:
    speed, gravity = 5.0, 9.81
    height = speed**2 / (2 * gravity)
    problem = hybrid(
        lambda t, x, p: [x[1], -gravity + 0 * t],
        lambda t, x, p: [x[0] - p[0]],
        [Crossing("plane", 0)],
        [0.0, speed],
        [1.0],
        p=[height * (1 + above)],
    )
    for log in everywhere(problem, method, tolerance=1e-6):
        half = math.sqrt(2 * abs(above) * height / gravity)
        assert log.times == pytest.approx([speed / gravity - half, speed / gravity + half][:passings], abs=1e-8)
        assert log.touches() == []
        assert log.ways() == {"plane": "polynomial"}


@pytest.mark.parametrize("method", METHODS)
def test_what_comes_to_zero_and_turns_back_is_a_touch(hybrid: Hybrid, method: str) -> None:
    problem = hybrid(lambda t, x, p: [x[1], 2 + 0 * t], lambda t, x, p: [x[0]], [Crossing("floor", -1)], [1.0, -2.0], [3.0])
    for log in everywhere(problem, method, tolerance=1e-6):
        # Rounding may bring it to the other side, by less than the guard's own: then it has fallen through; it is never dropped.
        assert [*log.times, *log.touch_times] == pytest.approx([1.0], abs=1e-6)
        assert np.abs(log.states[:, 0]).max(initial=0.0) <= log.roundings[0]
        assert method != "rk4" or "0 events; touched zero: 1 floor" in str(log)


def test_the_log_says_how_each_guard_was_counted(hybrid: Hybrid) -> None:
    guards: Callable[[Any, Any, Any], Sequence[Any]] = lambda t, x, p: [  # noqa: E731
        x[0] - 2 * t - 9,
        x[0] * x[1] - 9,
        x[1] + ca.sin(3 * t) - 9,
        ca.fmin(x[0], x[1]) - 9,
        ca.sign(x[0]) * x[1] - 9,
    ]
    crossings = [Crossing(name, 0) for name in ("line", "product", "wave", "least", "jump")]
    problem = hybrid(lambda t, x, p: [x[1], -x[0]], guards, crossings, [1.0, 0.0], [1.0])
    for log in everywhere(problem, "rk4", tolerance=1e-6):
        assert log.counting == ("polynomial", "enclosed", "enclosed", "enclosed", "sampled")


@pytest.mark.parametrize("method", METHODS)
def test_a_wave_beside_a_state_is_counted_by_enclosures(hybrid: Hybrid, method: str) -> None:
    # x = t: the roots of t + a sin(w t) - c, many of them in one step of 0.5.
    problem = hybrid(
        lambda t, x, p: [1.0 + 0 * t], lambda t, x, p: [x[0] + 0.4 * ca.sin(9 * t) - 1.0], [Crossing("g", 0)], [0.0], [2.0]
    )
    grid = np.linspace(0, 2, 200_001)
    values = grid + 0.4 * np.sin(9 * grid) - 1
    expected = grid[:-1][values[:-1] * values[1:] < 0]
    for log in everywhere(problem, method, tolerance=1e-3):
        assert log.times == pytest.approx(expected, abs=1e-5)
        assert log.counting == ("enclosed",)
