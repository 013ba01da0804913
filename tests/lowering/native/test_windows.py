"""Sums of waves read off polynomials in time: equal to the sums but for rounding, wherever they are read off."""

from __future__ import annotations

import casadi as ca
import mpmath
import numpy as np
import pytest

from modelgen import assemble, load, lower
from modelgen.lowering.native import native_solver
from modelgen.lowering.native.graph import Graph
from modelgen.lowering.native.stages import Stages
from modelgen.lowering.native.waves import wave_groups
from modelgen.solvers import SolverOptions
from modelgen.solvers.lanes import solve_lanes
from modelgen.solvers.native import solve_native
from modelgen.solvers.problem import InitialValueProblem

pytestmark = pytest.mark.usefixtures("compiled_here")

T, X, P = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p", 41)
ORDERS = np.arange(1, 21)


def waves() -> ca.Function:
    """x' = -x + sum of a_k cos(k w t) + b_k sin(k w t), the orders by the recurrence of the angle sums."""
    first = ca.cos(P[0] * T), ca.sin(P[0] * T)
    c, s, total = *first, ca.SX(0)
    for k in ORDERS:
        total += P[int(k)] * c + P[20 + int(k)] * s
        c, s = c * first[0] - s * first[1], s * first[0] + c * first[1]
    return ca.Function("waves", [T, X, P], [total - X])


def numbers(frequency: float) -> np.ndarray:
    return np.concatenate([[frequency], np.random.default_rng(3).normal(size=40)])


def test_a_bandwidth_is_the_highest_multiple_of_the_frequency() -> None:
    (group,) = wave_groups(graph := Graph.of(waves()))
    value = graph.nodes[group.bandwidth]
    assert {graph.nodes[each].value for each in value.operands if graph.nodes[each].operation == "constant"} == {20.0}
    product = ca.Function("f", [T, X, P], [waves()(T, 0.0, P) * ca.sin(P[0] * T) ** 2 - X])
    (group,) = wave_groups(graph := Graph.of(product))
    value = graph.nodes[group.bandwidth]
    assert {graph.nodes[each].value for each in value.operands if graph.nodes[each].operation == "constant"} == {22.0}


def test_what_is_no_sum_of_waves_has_no_group() -> None:
    total = waves()(T, 0.0, P)
    for other in (ca.sqrt(3 + ca.cos(P[0] * T)), T * ca.cos(P[0] * T), ca.cos(P[0] * T), ca.fabs(ca.sin(P[1] * T))):
        assert not wave_groups(Graph.of(ca.Function("f", [T, X, P], [other - X])))
    (group,) = wave_groups(Graph.of(ca.Function("f", [T, X, P], [ca.sqrt(100 + total) - X])))
    assert len(group.results) == 1  # below the root
    assert not Stages.of(waves()).waves


@pytest.mark.parametrize("lanes", [False, True])
@pytest.mark.parametrize("begin", [0.0, 1e4])
def test_polynomials_are_the_sums(lanes: bool, begin: float) -> None:
    """To 2e-15 of the sum of all amplitudes, where the phase has come to 4e6 radians too."""
    solver, p = native_solver(waves(), lanes), numbers(-400.0)
    times = begin + np.sort(np.random.default_rng(4).uniform(0, 0.1, 300))
    found, plain = solver.rates(times, [0.0], p, step=1e-6)[:, 0], solver.rates(times, [0.0], p)[:, 0]
    assert np.count_nonzero(found != plain) > 100
    with mpmath.workdps(40):
        for time, each in zip(times[::10], found[::10], strict=True):
            z = mpmath.expj(mpmath.mpf(float(p[0])) * mpmath.mpf(float(time)))
            exact = sum((a * z ** int(k)).real + (b * z ** int(k)).imag for k, a, b in zip(ORDERS, p[1:21], p[21:], strict=True))
            assert abs(each - exact) <= 2e-15 * np.abs(p[1:]).sum()
    assert np.abs(found - plain).max() <= 2e-15 * np.abs(p[1:]).sum()


@pytest.mark.parametrize("frequency", [0.0, np.inf, np.nan, 400.0])
def test_no_polynomial_where_none_fits(frequency: float) -> None:
    """A frequency that says nothing, or steps for which no window is wide enough: the sums themselves, to the last bit."""
    solver, p, times = native_solver(waves(), True), numbers(frequency), np.linspace(0.1, 0.2, 50)
    assert np.array_equal(solver.rates(times, [0.0], p, step=1e-4), solver.rates(times, [0.0], p), equal_nan=True)


@pytest.mark.parametrize("lanes", [False, True])
def test_the_truck_reads_its_torques_off_polynomials(lanes: bool) -> None:
    model = lower(assemble(load("fracturing-truck")))
    solver, rng, n = native_solver(model.rhs_function, lanes), np.random.default_rng(5), len(model.states) // 2
    x, p = 1e-2 * rng.standard_normal(2 * n), model.parameters.vector()
    for begin in (0.0, 100.0):
        times = begin + np.sort(rng.uniform(0, 0.02, 200))
        found, plain = solver.rates(times, x, p, step=1e-5), solver.rates(times, x, p)
        assert np.any(found != plain)
        for group in (slice(0, n), slice(n, 2 * n)):
            assert np.abs(found - plain)[:, group].max() <= 1e-13 * np.abs(plain[:, group]).max()


def test_lanes_with_and_without_polynomials_side_by_side() -> None:
    """Slow waves are read off, fast ones are not; none feels its neighbor."""
    rhs, options, times = waves(), SolverOptions(tolerance=1e-6), np.linspace(0.0, 0.3, 31)
    one = np.ones(1)
    problems = [InitialValueProblem(rhs, ("x",), 0 * one, numbers(w), one, 0.0, times) for w in np.geomspace(1.0, 3000.0, 19)]
    together = solve_lanes(problems, options, threads=1).trajectories
    for index, problem in enumerate(problems):
        (alone,) = solve_lanes([problem], options, threads=1).trajectories
        assert np.array_equal(alone.states, together[index].states)
        assert alone.statistics.steps == together[index].statistics.steps
        single = solve_native(problem, options)
        assert np.abs(single.states - alone.states).max() <= 1e-8 * np.abs(alone.states).max()
