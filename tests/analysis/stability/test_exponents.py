"""Lyapunov exponents that are known: on paper, in the literature, and from the multipliers of a periodic orbit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from modelgen.analysis import ExponentsResult, lyapunov_exponents, periodic_orbit
from modelgen.analysis.stability.course import Course
from modelgen.analysis.stability.interval import half_width, student
from modelgen.drivelines import load
from modelgen.equations import assemble, system
from modelgen.errors import CaseError
from modelgen.lowering import Compiled, lower
from modelgen.solvers import Case
from modelgen.solvers.problem import SolverOptions

LORENZ = {"x": 1.0, "y": 1.0, "z": 20.0}, {"x": "10*(y - x)", "y": "x*(28 - z) - y", "z": "x*y - 8*z/3"}
ROESSLER = {"x": 1.0, "y": 1.0, "z": 0.0}, {"x": "-y - z", "y": "x + 0.2*y", "z": "0.2 + z*(x - 5.7)"}
OSCILLATOR = {"x": 1.0, "v": 0.0}
VM = {"backend": "vm"}


def plain(states: dict[str, float], rates: dict[str, str]) -> Compiled:
    return lower(system(states, rates))


def exponents(states: dict[str, float], rates: dict[str, str], end: float, **options: Any) -> ExponentsResult:
    chosen = {name: options.pop(name) for name in ("largest", "stretch") if name in options}
    return lyapunov_exponents(Case(plain(states, rates), end=end, **{"tolerance": 1e-9, **options}), **chosen)


@pytest.mark.parametrize("backend", ["vm", "auto"])
def test_decay(backend: str) -> None:
    found = exponents({"x": 1.0}, {"x": "-x"}, 20.0, options={"backend": backend})
    assert found.exponents == pytest.approx([-1.0], abs=1e-8)
    assert (found.sign, found.dimension, found.flow, found.complete) == ("negative", 0.0, None, True)
    assert abs(found.trace_gap) < 1e-8


def test_the_damped_oscillator_loses_half_of_its_damping_in_each_direction() -> None:
    found = exponents(OSCILLATOR, {"x": "v", "v": "-x - 0.2*v"}, 400.0, options=VM)
    assert np.all(np.abs(found.exponents + 0.1) < np.minimum(found.half_width, 1e-3))
    assert found.exponents.sum() == pytest.approx(-0.2, abs=1e-8)
    assert (found.sign, found.flow) == ("negative", None)


def test_the_undamped_oscillator_has_zeros_and_nothing_is_decided() -> None:
    found = exponents(OSCILLATOR, {"x": "v", "v": "-x"}, 200.0, options=VM)
    assert np.abs(found.exponents).max() < 1e-9
    assert found.sign == "undecided"


def test_a_limit_cycle() -> None:
    """Van der Pol, mu = 1: the period is 6.66328686, and the mean of mu (1 - x^2) over it is the other exponent."""
    found = exponents(OSCILLATOR, {"x": "v", "v": "(1 - x**2)*v - x"}, 1000.0, record_from=50.0)
    orbit = periodic_orbit(Case(plain(OSCILLATOR, {"x": "v", "v": "(1 - x**2)*v - x"}), end=40.0))
    assert (found.flow, found.sign, found.dimension) == (0, "negative", 1.0)
    assert abs(found.exponents[0]) < 1e-3
    assert found.exponents[1] == pytest.approx(math.log(orbit.largest) / orbit.period, abs=2e-3)
    assert abs(found.trace_gap) < 1e-8


def test_lorenz() -> None:
    """C1: 0.9056, 0, -14.5723 and dimension 2.062 (J. C. Sprott, Chaos and Time-Series Analysis, 2003)."""
    found = exponents(*LORENZ, 1050.0, record_from=50.0, tolerance=1e-10)
    assert found.exponents == pytest.approx([0.9056, 0.0, -14.5723], abs=0.01)
    assert found.divergence == pytest.approx(-41 / 3, abs=1e-12)
    assert abs(found.trace_gap) < 1e-8
    assert found.dimension == pytest.approx(2.062, abs=2e-3)
    assert (found.sign, found.flow) == ("positive", 1)
    assert np.all(np.abs(found.exponents - [0.9056, 0.0, -14.5723]) < found.half_width)
    assert found.half_width.max() < 0.05


def test_the_largest_alone_is_the_same() -> None:
    found = exponents(*LORENZ, 550.0, record_from=50.0, largest=True)
    assert abs(found.exponents[0] - 0.9056) < found.half_width[0] < 0.1
    assert (len(found.exponents), found.complete, found.sign, found.flow) == (1, False, "positive", None)
    assert math.isnan(found.trace_gap)
    assert math.isnan(found.dimension)


def test_roessler() -> None:
    """C2: 0.0714, 0, -5.3943 (J. C. Sprott, Chaos and Time-Series Analysis, 2003)."""
    found = exponents(*ROESSLER, 8200.0, record_from=200.0, tolerance=1e-10)
    away = np.abs(found.exponents - [0.0714, 0.0, -5.3943])
    assert np.all(away < np.maximum(found.half_width, 0.003))
    assert found.half_width.max() < 0.02
    assert abs(found.trace_gap) < 1e-8


@pytest.mark.slow
def test_the_commensurate_truck_agrees_with_its_multipliers() -> None:
    """The rigid pair apart, thirty that are negative; pairs of multipliers 0.138486 and 0.084014 over 0.378947 s."""
    model = lower(assemble(load("fracturing-truck-commensurate")))
    period = 12 * 60 / 1900
    found = lyapunov_exponents(Case(model, end=24 * period, record_from=4 * period, tolerance=1e-5))
    assert found.neutral == ("flywheel.angle_deviation", "flywheel.angle_deviation_rate")
    assert (len(found.exponents), found.sign, found.period) == (30, "negative", pytest.approx(period))
    assert found.exponents[:4].mean() == pytest.approx(math.log(0.138486 * 0.084014) / 2 / period, abs=0.05)
    assert abs(found.trace_gap) < 0.1
    assert found.duration / period == pytest.approx(round(found.duration / period))


def test_a_span_that_is_too_short_and_a_stretch_that_is_none() -> None:
    with pytest.raises(CaseError, match=r"from 0 to 10 s holds 10 stretches of 1 s, of which at least 16 are needed"):
        exponents({"x": 1.0}, {"x": "-x"}, 10.0, stretch=1.0)
    with pytest.raises(CaseError, match=r"stretch: is -1.0; give a positive time"):
        exponents({"x": 1.0}, {"x": "-x"}, 10.0, stretch=-1.0)
    with pytest.raises(CaseError, match="motion: stopped at t = "):
        exponents({"x": 1.0}, {"x": "x**2"}, 10.0)


def test_progress_reaches_its_end() -> None:
    seen: list[float] = []
    exponents({"x": 1.0}, {"x": "-x"}, 20.0, options={"progress": seen.append, "backend": "vm"})
    assert seen[-1] == 1.0


def test_intervals_of_independent_terms_hold_19_of_20_times() -> None:
    rng = np.random.default_rng(7)
    means = rng.standard_normal((640, 400))
    held = np.abs(means.mean(axis=0)) < half_width(means)
    assert 0.93 < held.mean() < 1.0
    assert half_width(means).mean() == pytest.approx(1.96 / math.sqrt(640), rel=0.25)


def test_intervals_grow_where_terms_hang_together() -> None:
    rng = np.random.default_rng(7)
    noise = rng.standard_normal((6400, 1))
    walk = np.zeros_like(noise)
    for k in range(1, len(noise)):
        walk[k] = 0.9 * walk[k - 1] + noise[k]
    assert float(half_width(walk)[0]) == pytest.approx(1.96 / (1 - 0.9) / math.sqrt(6400), rel=0.35)
    assert np.isnan(half_width(noise[:15])).all()


@pytest.mark.parametrize(("freedom", "wanted"), [(4, 2.776), (7, 2.365), (15, 2.131), (31, 2.040), (63, 1.998)])
def test_student(freedom: int, wanted: float) -> None:
    assert student(freedom) == pytest.approx(wanted, rel=6e-3 if freedom < 5 else 1e-3)


def test_a_course_goes_on_where_it_was() -> None:
    from modelgen.analysis.stability.coordinates import vibration_of

    problem = vibration_of(Case(plain(OSCILLATOR, {"x": "v", "v": "-x"}), end=1.0)).problem
    course = Course(problem, "rk4", SolverOptions(1e-10))
    first = course.advance(np.array([0.5, 1.0]))
    again = course.advance(np.array([2.0]))
    assert [each.t0 for each in (*first, *again)] == [0.0, 0.5, 1.0]
    assert again[0].x0 == pytest.approx([math.cos(1.0), -math.sin(1.0)], abs=1e-8)
    assert course.state[0] == pytest.approx(math.cos(2.0), abs=1e-8)
    assert course.advance(np.array([2.0])) == []
    assert course.moves()


UEDA = {"x": 1.0, "v": 0.0}, {"x": "v", "v": "-0.05*v - x**3 + 7.5*cos(t)"}


def test_stretches_adapt_where_deviations_grow_without_bound() -> None:
    """Ueda's oscillator over 8200 s: stretches of 125 s would let deviations grow e^12-fold and more; the sum is -0.05."""
    found = exponents(*UEDA, 8200.0, record_from=200.0)
    assert found.exponents.sum() == pytest.approx(-0.05, abs=1e-8)
    assert found.exponents[0] == pytest.approx(0.11, abs=0.01)
    assert found.sign == "positive"
    assert found.left_out == pytest.approx(8000 - found.duration, rel=1e-9)
    assert f"{found.left_out:.4g} s of the span are left out" in str(found)


def test_the_means_are_over_the_span_that_was_asked_for() -> None:
    found = exponents(OSCILLATOR, {"x": "v", "v": "-x - 0.2*v"}, 300.0, record_from=100.0, options=VM)
    assert (found.begin, found.duration, found.left_out) == (100.0, pytest.approx(200.0), 0.0)
    assert "left out" not in str(found)


def test_chaos_that_comes_to_rest() -> None:
    """Lorenz at r = 22: transient chaos before one of two fixed points, whose eigenvalues give the exponents."""
    rates = {"x": "10*(y - x)", "y": "x*(22 - z) - y", "z": "x*y - 8*z/3"}
    found = exponents({"x": 1.0, "y": 1.0, "z": 20.0}, rates, 600.0, tolerance=1e-8)
    c = math.sqrt(8 / 3 * 21)
    real = np.sort(np.linalg.eigvals([[-10, 10, 0], [1, -1, -c], [c, c, -8 / 3]]).real)[::-1]
    assert not found.stationary
    assert (found.sign, found.ends_in, found.transient_chaos) == ("negative", "rest", True)
    assert 5 < found.transient < 500
    assert found.transient_exponents[0] == pytest.approx(0.8, abs=0.3)
    assert np.all(np.abs(found.exponents - real) < np.maximum(found.half_width, 0.02))
    assert f"not stationary: {found.transient:.6g} s of transient" in str(found)


def test_a_step_in_a_sequence_is_found_and_noise_is_none() -> None:
    from modelgen.analysis.stability.stationarity import steady_from

    rng = np.random.default_rng(3)
    assert sum(bool(steady_from(1 + rng.standard_normal(480))) for _ in range(200)) <= 1
    walk = np.zeros(4800)
    for k in range(1, len(walk)):
        walk[k] = 0.95 * walk[k - 1] + rng.standard_normal()
    assert steady_from(1 + walk) == 0
    late = np.where(np.arange(960) < 700, 2.0, -1.0) + 0.5 * rng.standard_normal(960)
    assert steady_from(late) == pytest.approx(700, abs=20)
    assert steady_from(np.ones(960)) == steady_from(np.ones(10)) == 0


@pytest.mark.parametrize("power", [3, 5])
@pytest.mark.parametrize("end", [200.0, 3000.0])
def test_an_algebraic_decay_has_no_exponent_yet(power: int, end: float) -> None:
    """x' = -x^n: the local exponent goes to 0 as 1/t, so every mean is too large; the interval holds the long-run value."""
    found = exponents({"x": 1.0}, {"x": f"-x**{power}"}, end, record_from=1.0, options=VM)
    assert (found.stationary, found.sign) == (False, "undecided")
    assert "not stationary: the largest local exponent still drifts, -" in str(found)
    assert abs(found.exponents[0]) < found.half_width[0]


def test_damping_by_the_cube_of_the_speed_has_none_either() -> None:
    found = exponents(OSCILLATOR, {"x": "v", "v": "-x - v**3"}, 400.0, options=VM)
    assert (found.stationary, found.sign) == (False, "undecided")
    assert np.all(np.abs(found.exponents) < found.half_width)


@pytest.mark.parametrize("start", [1e-8, 1e-6])
def test_a_motion_that_still_departs_is_not_stationary(start: float) -> None:
    """x' = 0.05 x - x^3 near 0, where neighbors part; it comes to x^2 = 0.05, where they meet with -0.1."""
    found = exponents({"x": start}, {"x": "0.05*x - x**3"}, 200.0 if start < 1e-7 else 150.0, options=VM)
    assert (found.stationary, found.sign) == (False, "undecided")
    assert "not stationary: the motion still departs from where it was, in steps that have grown" in str(found)
    cycle = exponents({"x": start, "v": 0.0}, {"x": "v", "v": "(0.05 - x**2)*v - x"}, 250.0, options=VM)
    assert (cycle.stationary, cycle.sign) == (False, "undecided")


def test_what_grows_by_a_linear_law_has_its_exponents_all_the_way() -> None:
    found = exponents({"x": 1e-8}, {"x": "0.05*x"}, 200.0, options=VM)
    assert (found.stationary, found.sign, found.remarks[1:]) == (True, "undecided", ())
    assert found.exponents == pytest.approx([0.05], abs=1e-8)


def test_a_drift_is_found_and_noise_is_none() -> None:
    from modelgen.analysis.stability.stationarity import departure, drift

    rng = np.random.default_rng(5)
    assert sum(drift(1 + rng.standard_normal(480)) is not None for _ in range(500)) == 0
    walk = np.zeros(4800)
    for k in range(1, len(walk)):
        walk[k] = 0.95 * walk[k - 1] + rng.standard_normal()
    assert drift(0.1 + walk) is None
    assert drift(1 / np.arange(20.0, 500.0) + 1e-4 * rng.standard_normal(480)) is not None
    assert drift(1 + np.exp(-np.arange(480) / 20)) is None  # it has arrived
    assert drift(np.ones(10)) is None
    assert departure(rng.standard_normal((480, 3))) == 0
    assert departure(np.cumsum(rng.standard_normal((480, 2)), axis=0)) == 0
    assert departure(np.exp(-np.arange(480.0))[:, None]) == 0
