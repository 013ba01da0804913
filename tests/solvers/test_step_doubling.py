"""The step as one function: paper, Eq. 23-32."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import casadi as ca
import numpy as np
import pytest

from modelgen.lowering.methods import read_tableau
from modelgen.solvers import coordinates
from modelgen.solvers.collocation import radau_step
from modelgen.solvers.coordinates import ScaledProblem, scaled_rate
from modelgen.solvers.doubled_step import doubled_step
from modelgen.solvers.method import BoundStep, Method
from modelgen.solvers.problem import InitialValueProblem

Ode = Callable[..., InitialValueProblem]

rk4_step = partial(doubled_step, tableau=read_tableau("rk4"))
T, Y, Q = ca.SX.sym("t"), ca.SX.sym("y", 2), ca.SX.sym("q")
RATE = ca.Function("rate", [T, Y, Q], [ca.vertcat(Y[1] + ca.sin(3 * T), -Q * ca.sin(Y[0]) * ca.exp(-T))])


def classical(t: float, y: np.ndarray, h: float, q: float) -> np.ndarray:
    def f(time: float, place: np.ndarray) -> np.ndarray:
        return np.array([place[1] + np.sin(3 * time), -q * np.sin(place[0]) * np.exp(-time)])

    k1 = f(t, y)
    k2 = f(t + h / 2, y + h / 2 * k1)
    k3 = f(t + h / 2, y + h / 2 * k2)
    k4 = f(t + h, y + h * k3)
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def test_the_step_is_the_classical_method_written_out() -> None:
    t, h, q, y = 0.3, 0.2, 2.5, np.array([1.0, -0.4])
    state = ca.horzcat(y, RATE(t, y, q))
    whole, middle = classical(t, y, h, q), classical(t, y, h / 2, q)
    end = classical(t + h / 2, middle, h / 2, q)
    nodes, measures, plain, halves = (np.array(part) for part in rk4_step(RATE, extrapolate=False)(t, h, state, q))
    assert plain[:, 0] == pytest.approx(whole, abs=1e-15)
    assert halves[:, 0] == pytest.approx(end, abs=1e-15)
    assert nodes[:, 0] == pytest.approx(middle, abs=1e-15)
    assert nodes[:, 2] == pytest.approx(end, abs=1e-15)
    assert nodes[:, 3] == pytest.approx(np.array(RATE(t + h, end, q))[:, 0], abs=1e-15)
    assert measures[0, 0] == pytest.approx(np.abs(end - whole).max(), rel=1e-9)
    extrapolated = np.array(rk4_step(RATE, extrapolate=True)(t, h, state, q)[0])
    assert extrapolated[:, 2] == pytest.approx(end + (end - whole) / 15, abs=1e-15)  # Eq. 31
    assert extrapolated[:, 0] == pytest.approx(middle + (end - whole) / 30, abs=1e-15)  # after one of the two half steps


def test_two_half_steps_err_by_a_sixteenth_of_the_whole() -> None:
    t, y, q = ca.SX.sym("t"), ca.SX.sym("y"), ca.SX.sym("q")
    step = rk4_step(ca.Function("growth", [t, y, q], [y]))
    deviations = []
    for h in (0.08, 0.04, 0.02):
        _, _, whole, halves = (float(part[0]) for part in step(0, h, ca.DM([[1, 1]]), 0))
        deviations.append((np.exp(h) - halves) / (np.exp(h) - whole) / (1 / 16) - 1)  # Eq. 30
    assert abs(deviations[-1]) < 0.01
    assert np.abs(deviations).tolist() == sorted(np.abs(deviations), reverse=True)


@pytest.mark.parametrize("make", [rk4_step, lambda rate: radau_step(rate, 1e-13)])
def test_a_value_that_is_not_finite_shows_in_the_measures(make: Callable[..., ca.Function]) -> None:
    rate = ca.Function("rate", [T, Y, Q], [ca.vertcat(ca.sqrt(1 - T) - Y[0], -Y[1])])
    state = np.array([[0.5, 0.0], [0.5, 0.0]])
    bound = BoundStep(Method(make(rate), 5, 11), state, np.zeros(1))
    for h, finite in ((0.5, True), (1.5, False)):
        bound.size[0] = h
        bound.evaluate()
        assert np.isfinite(bound.measures[1]) == finite


def test_a_whole_step_without_a_number_is_not_hidden_by_the_largest_difference() -> None:
    # Only the last stage of the whole step meets a negative y0: 1 - 1.5 (1 - 0.75 (1 - 0.75)) < 0.
    rate = ca.Function("rate", [T, Y, Q], [ca.vertcat(-1.5 * Y[0], ca.sqrt(Y[0]))])
    plain = rk4_step(rate, extrapolate=False)
    nodes, measures, whole, halves = (np.array(part) for part in plain(0, 1, ca.DM([[1, -1.5], [0, 1]]), 0))
    assert np.isnan(whole[1, 0])
    assert np.isfinite(halves).all()
    assert np.isfinite(nodes).all()
    assert np.isnan(measures[1, 0])


def test_a_newton_iteration_that_fails_shows_in_the_measures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("modelgen.solvers.collocation.NEWTON_ITERATIONS", 1)
    stiff = ca.Function("rate", [T, Y, Q], [ca.vertcat(Y[1], ((1 - Y[0] ** 2) * Y[1] - Y[0]) * 1e3)])
    bound = BoundStep(Method(radau_step(stiff, 1e-8), 6, 30), np.array([[2.0, 1.0], [1.0, -5e3]]), np.zeros(1))
    bound.size[0] = 1e-2
    bound.evaluate()
    assert np.isnan(bound.measures[1])


def test_a_large_function_is_called_and_gives_the_same_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    state, q = ca.DM([[0.1, 0.2], [0.3, 0.4]]), 2.0
    inlined = rk4_step(RATE)
    assert inlined.is_a("SXFunction")
    monkeypatch.setattr(coordinates, "LARGEST_INLINE", 10)
    doubled_step.cache_clear()
    called = rk4_step(RATE)
    doubled_step.cache_clear()
    assert called.is_a("MXFunction")
    for one, other in zip(inlined(0.1, 0.2, state, q), called(0.1, 0.2, state, q), strict=True):
        assert np.array(one) == pytest.approx(np.array(other), abs=1e-14)


def test_scaled_coordinates_there_and_back(ode: Ode) -> None:
    problem = ode(lambda t, x, p: [p[0] * x[1], -x[0] * t], [10.0, -2.0], 1.0, p=[3.0], scale=[4.0, 0.5])
    scaled = ScaledProblem(problem)
    y = np.array([0.25, -1.0])
    assert scaled.states(y).tolist() == [11.0, -2.5]
    assert scaled.rates(2.0, y).tolist() == [3.0 * -2.5 / 4.0, -11.0 * 2.0 / 0.5]
    assert scaled_rate(problem.rhs) is scaled_rate(problem.rhs)  # built once
    there = scaled.parameters_from(y)
    assert np.array(scaled.rate(2.0, np.zeros(2), there))[:, 0] == pytest.approx(scaled.rates(2.0, y))
