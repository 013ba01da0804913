"""One door to all solvers: names, options, and the same answer behind each name."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from modelgen.errors import CaseError
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import InitialValueProblem, SolverOptions
from modelgen.solvers.registry import SOLVERS, solve

Ode = Callable[..., InitialValueProblem]

NAMES = ("rk4", "dopri5", "verner65", "dop853", "cvodes", "idas", "collocation", "erk", "rosenbrock")


def gear_pair(t: ca.SX, x: ca.SX, p: ca.SX) -> list[ca.SX]:
    """x'' + 2 zeta x' + (1 + 0.2 cos 1.3 t) f(x) = Fm + Fa cos 1.3 t, dead zone of half width 1 (Kahraman and Singh 1990)."""
    contact = ca.if_else(x[0] > 1, x[0] - 1, ca.if_else(x[0] < -1, x[0] + 1, 0))
    return [x[1], p[1] + p[2] * ca.cos(1.3 * t) - 2 * p[0] * x[1] - (1 + 0.2 * ca.cos(1.3 * t)) * contact]


PARAMETERS = [0.02, 0.1, 0.3]  # loses contact and finds it again, some ten times in the horizon below


def test_the_names() -> None:
    assert tuple(SOLVERS) == NAMES
    assert all(solver.order in (4, 5, 6, 8) and solver.description for solver in SOLVERS.values())


@pytest.mark.parametrize(("name", "words"), [("rk45", "nearest is 'rk4'"), ("CVODES", "none named 'CVODES'"), (4, "named 4")])
def test_an_unknown_name_is_refused(ode: Ode, name: object, words: str) -> None:
    with pytest.raises(CaseError, match=words):
        solve(ode(lambda t, x, p: [-x], [1.0], 1.0), name, SolverOptions(tolerance=1e-6))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("option", [{"fixed_step": 0.1}, {"rule": "paper"}, {"extrapolate": False}])
def test_an_option_without_use_is_refused(ode: Ode, name: str, option: dict[str, object]) -> None:
    problem, options = ode(lambda t, x, p: [-x], [1.0], 1.0), SolverOptions(tolerance=1e-6, **option)
    if set(option) <= SOLVERS[name].extra_options:
        assert solve(problem, name, options).outcome is Outcome.SUCCESS
    else:
        with pytest.raises(
            CaseError, match=rf"solver '{name}': has no use for {next(iter(option))} = .*leave it out, or take rk4 or"
        ):
            solve(problem, name, options)


@pytest.fixture(scope="module")
def reference() -> tuple[np.ndarray, np.ndarray]:
    from scipy.integrate import solve_ivp  # an independent method and implementation, with the kinks located

    times = np.linspace(0.0, 40.0, 401)

    def rates(t: float, x: np.ndarray) -> list[float]:
        zeta, mean, amplitude = PARAMETERS
        contact = x[0] - np.clip(x[0], -1, 1)
        return [x[1], mean + amplitude * np.cos(1.3 * t) - 2 * zeta * x[1] - (1 + 0.2 * np.cos(1.3 * t)) * contact]

    done = solve_ivp(rates, (0.0, 40.0), [1.5, 0.0], method="DOP853", rtol=1e-13, atol=1e-13, t_eval=times, max_step=0.01)
    return times, done.y.T


# Largest error over all times and states at tolerances of 1e-6 and 1e-10, at most: twice what was measured. Nine changes of
# contact cost each method according to how well its error estimate sees a kink.
ERRORS = {
    "rk4": (4e-5, 4e-9),
    "dopri5": (2e-2, 4e-7),
    "verner65": (2e-3, 8e-7),
    "dop853": (1e-4, 2e-8),
    "cvodes": (4e-3, 2e-6),
    "idas": (1e-3, 2e-6),
    "collocation": (7e-5, 6e-10),
    "erk": (2e-2, 2e-6),
    "rosenbrock": (1e-3, 5e-8),
}


@pytest.mark.parametrize("name", NAMES)
def test_all_agree_and_differences_fall_with_the_tolerance(ode: Ode, name: str, reference: tuple[np.ndarray, np.ndarray]) -> None:
    times, exact = reference
    problem = ode(gear_pair, [1.5, 0.0], times, p=PARAMETERS)
    errors = []
    for tolerance in (1e-6, 1e-8, 1e-10):
        run = solve(problem, name, SolverOptions(tolerance=tolerance))
        assert run.outcome is Outcome.SUCCESS, run.message
        assert np.array_equal(run.times, times)
        errors.append(np.abs(run.states - exact).max())
    assert errors[0] < ERRORS[name][0]
    assert errors[0] > errors[2]
    assert errors[0] > errors[1] > errors[2] or name in ("verner65", "dop853")  # of all the least made for kinks: it wants events
    assert errors[2] < ERRORS[name][1]


@pytest.mark.parametrize("name", NAMES)
def test_a_run_repeats_itself_to_the_last_bit(ode: Ode, name: str) -> None:
    problem = ode(gear_pair, [1.5, 0.0], np.linspace(0.0, 40.0, 401), p=PARAMETERS)
    one, other = (solve(problem, name, SolverOptions(tolerance=1e-7)) for _ in range(2))
    assert one.states.tobytes() == other.states.tobytes()
    assert (one.statistics.steps, one.statistics.evaluations) == (other.statistics.steps, other.statistics.evaluations)


@pytest.mark.parametrize("name", NAMES)
def test_the_tolerance_refers_to_the_scale_and_not_to_the_unit(ode: Ode, name: str) -> None:
    """The same problem in radians and in microradians, by its scale, gives the same figures."""
    plain = ode(lambda t, x, p: [x[1], -ca.sin(x[0])], [1.0, 0.0], np.linspace(0.5, 10.0, 20))
    small = ode(lambda t, x, p: [x[1], -1e6 * ca.sin(x[0] / 1e6)], [1e6, 0.0], np.linspace(0.5, 10.0, 20), scale=[1e6, 1e6])
    runs = [solve(problem, name, SolverOptions(tolerance=1e-7)) for problem in (plain, small)]
    assert runs[1].states / 1e6 == pytest.approx(runs[0].states, abs=1e-10)


@pytest.mark.parametrize("name", NAMES)
def test_a_constant_on_a_state_that_acts_on_nothing_changes_nothing(ode: Ode, name: str) -> None:
    def rates(t: ca.SX, x: ca.SX, p: ca.SX) -> list[ca.SX]:
        return [x[1], -ca.sin(x[0]), 200 + x[1]]

    times = np.linspace(0.0, 5.0, 51)
    near, far = (solve(ode(rates, [1.0, 0.0, start], times), name, SolverOptions(tolerance=1e-9)).states for start in (0.0, 1e6))
    assert np.abs(near - far)[:, :2].max() < 1e-12
    assert far[:, 2] - 1e6 == pytest.approx(near[:, 2], abs=1e-8)


@pytest.mark.parametrize("name", NAMES)
def test_any_start_time_and_any_grid(ode: Ode, name: str) -> None:
    irregular = 100.0 + np.sort(np.random.default_rng(7).uniform(0.0, 3.0, 200))
    clustered = np.sort(np.concatenate([irregular, irregular[100] + np.array([1e-13, 2e-12, 1e-10, 1e-8])]))
    problem = ode(lambda t, x, p: [p[0] * ca.cos(t)], [0.0], clustered, p=[2.0], t0=100.0)
    run = solve(problem, name, SolverOptions(tolerance=1e-9))
    assert run.outcome is Outcome.SUCCESS, run.message
    assert run.states[:, 0] == pytest.approx(2 * (np.sin(clustered) - np.sin(100.0)), abs=1e-7)


@pytest.mark.parametrize("name", NAMES)
def test_one_time_at_the_start_is_no_work(ode: Ode, name: str) -> None:
    run = solve(ode(lambda t, x, p: [-x], [1.0], 3.0, t0=3.0), name, SolverOptions(tolerance=1e-9))
    assert (run.outcome, run.states.tolist(), run.statistics.steps) == (Outcome.SUCCESS, [[1.0]], 0)


@pytest.mark.parametrize("name", ["rk4", "dopri5", "verner65", "dop853", "collocation", "erk", "rosenbrock"])
def test_fixed_steps_converge(ode: Ode, name: str) -> None:
    problem = ode(lambda t, x, p: [x[1], -ca.sin(x[0])], [1.0, 0.0], 2.0)
    exact = solve(problem, "rk4", SolverOptions(tolerance=1e-13)).states[-1]
    errors = [
        np.abs(solve(problem, name, SolverOptions(tolerance=1e-13, fixed_step=size)).states[-1] - exact).max()
        for size in (1 / 8, 1 / 16)
    ]
    assert errors[1] < errors[0] / 2**3.5
    assert errors[0] < 1e-4


@pytest.mark.parametrize("name", NAMES)
def test_the_largest_step_is_kept(ode: Ode, name: str) -> None:
    problem = ode(lambda t, x, p: [x[1], ca.if_else(ca.fabs(t - 0.61) < 0.01, 1, 0)], [0.0, 0.0], 1.0)  # a short pulse
    run = solve(problem, name, SolverOptions(tolerance=1e-6, largest_step=5e-3))
    assert run.states[-1, 1] == pytest.approx(0.02, rel=0.02)
    assert run.statistics.steps >= 200
