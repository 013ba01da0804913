"""Periodic orbits that are known: Mathieu's tongues, limit cycles, period doubling, and the commensurate truck."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.special import mathieu_a, mathieu_b

from modelgen.analysis import PeriodicOrbit, periodic_orbit
from modelgen.analysis.stability.multipliers import kind_of_loss, kinds_of_loss, multipliers_of, stability
from modelgen.drivelines import load
from modelgen.equations import assemble, system
from modelgen.errors import CaseError
from modelgen.lowering import lower
from modelgen.solvers import Case, simulate

OSCILLATOR = {"x": 1.0, "v": 0.0}
MATHIEU = lower(system({"y": 0.0, "v": 0.0}, {"y": "v", "v": "-(a - 2*q*cos(2*t))*y"}, {"a": 1.0, "q": 1.0}))
DUFFING = lower(system(OSCILLATOR, {"x": "v", "v": "x - x**3 - 0.3*v + force*cos(1.2*t)"}, {"force": 0.2}))
PERIOD = 2 * math.pi / 1.2


def orbit_of(states: dict[str, float], rates: dict[str, str], end: float = 40.0, **options: Any) -> PeriodicOrbit:
    return periodic_orbit(Case(lower(system(states, rates)), end=end), **options)


@pytest.mark.parametrize("q", [1.0, 5.0])
@pytest.mark.parametrize(
    ("value", "side"), [((mathieu_a, 0), 1), ((mathieu_a, 1), -1), ((mathieu_a, 2), 1), ((mathieu_b, 1), -1), ((mathieu_b, 2), 1)]
)
def test_mathieu(value: tuple[Any, int], side: int, q: float) -> None:
    """N9: on the borders of stability, both multipliers over pi are 1 (a0, a2, b2) or -1 (a1, b1)."""
    characteristic, number = value
    case = Case(MATHIEU, end=1.0, parameters={"a": float(characteristic(number, q)), "q": q})
    found = periodic_orbit(case, period=math.pi)
    assert found.multipliers.sum().real == pytest.approx(2 * side, abs=1e-9)
    assert np.prod(found.multipliers) == pytest.approx(1.0, abs=1e-9)
    assert (found.stability, found.found, found.proven) == ("undecided", True, False)
    assert "stability is undecided" in found.verdict


def test_mathieu_inside_and_between_tongues() -> None:
    inside = periodic_orbit(Case(MATHIEU, end=1.0, parameters={"a": 1.0, "q": 0.5}), period=math.pi)
    assert inside.losses == ("flip",)
    assert "exists and is unstable (flip)" in inside.verdict
    between = periodic_orbit(Case(MATHIEU, end=1.0, parameters={"a": 2.5, "q": 0.5}), period=math.pi)
    assert np.abs(between.multipliers) == pytest.approx([1.0, 1.0], abs=1e-9)
    assert kind_of_loss(between.multipliers[0]) == "Neimark-Sacker"


def test_van_der_pol() -> None:
    found = orbit_of(OSCILLATOR, {"x": "v", "v": "(1 - x**2)*v - x"})
    assert found.period == pytest.approx(6.66328685932, abs=1e-9)
    assert found.flow == pytest.approx(1.0, abs=1e-9)
    assert (found.proven, found.order, found.autonomous) == (True, 1, True)
    assert found.verdict.startswith("limit cycle proven")
    shorter = orbit_of(OSCILLATOR, {"x": "v", "v": "(1 - x**2)*v - x"}, period=13.3)
    assert shorter.period == pytest.approx(found.period, abs=1e-9)


def test_a_forced_linear_oscillator() -> None:
    found = orbit_of(OSCILLATOR, {"x": "v", "v": "-4*x - 0.2*v + cos(t)"}, period=2 * math.pi)
    gain = 1 / complex(3, 0.2)
    assert found.start == pytest.approx({"x": gain.real, "v": -gain.imag}, abs=1e-10)
    assert np.abs(found.multipliers) == pytest.approx([math.exp(-0.2 * math.pi)] * 2, abs=1e-10)
    assert found.proven


def test_an_orbit_that_hardly_attracts_says_so() -> None:
    found = orbit_of(OSCILLATOR, {"x": "v", "v": "-4*x - 1e-5*v + cos(t)"}, period=2 * math.pi, settle=0)
    assert found.proven
    assert found.half_life == pytest.approx(math.log(2) / (0.5e-5 * 2 * math.pi), rel=1e-4)
    assert "period 1 proven, though it hardly attracts (a deviation halves in 2.2e+04 periods, 1.4e+05 s" in found.verdict


def test_a_doubled_period_and_the_single_one_beneath_it() -> None:
    """Duffing's double well at a force of 0.28: the motion in one well has doubled; period 1 is there and unstable by a flip."""
    case = Case(DUFFING, end=1.0, parameters={"force": 0.28}, tolerance=1e-8)
    doubled = periodic_orbit(case, order=2, period=PERIOD, settle=200)
    assert (doubled.order, doubled.proven, doubled.base_period) == (2, True, PERIOD)
    assert doubled.period == pytest.approx(2 * PERIOD)
    single = periodic_orbit(case.change(start=dict(doubled.start)), order=1, period=PERIOD, settle=0)
    assert (single.order, single.found, single.losses) == (1, True, ("flip",))


def test_an_order_that_is_too_high_is_brought_down() -> None:
    found = periodic_orbit(Case(DUFFING, end=1.0, parameters={"force": 0.2}), order=4, period=PERIOD, settle=100)
    assert (found.order, found.proven) == (1, True)


@pytest.mark.slow
def test_the_commensurate_truck_has_period_one() -> None:
    model = lower(assemble(load("fracturing-truck-commensurate")))
    found = periodic_orbit(Case(model, end=1.0), tolerance=1e-11)
    assert (found.proven, found.order, len(found.multipliers)) == (True, 1, 30)
    assert found.period == pytest.approx(12 * 60 / 1900, rel=1e-15)
    assert found.neutral == ("flywheel.angle_deviation", "flywheel.angle_deviation_rate")
    assert np.abs(found.multipliers[:4]) == pytest.approx([0.138486101] * 2 + [0.084014128] * 2, abs=1e-8)
    run = simulate(Case(model, start=found.start, end=3 * found.period, samples=4, tolerance=1e-10, options={"backend": "auto"}))
    for channel in ("flywheel.angle_deviation", "pump_free_end.angle_deviation"):
        assert np.ptp(run[channel]) < 1e-9 * np.abs(run[channel]).max() + 1e-11


def test_what_does_not_close_says_so() -> None:
    found = orbit_of({"x": 1.0}, {"x": "1 + x**2/1e6 + 0.1*cos(t)"}, period=2 * math.pi, settle=0)
    assert (found.found, found.proven) == (False, False)
    assert found.verdict.startswith("not found: after ")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"order": 0}, "order: is 0; give a whole number"),
        ({"period": -1.0}, "period: is -1.0; give a positive time"),
        ({"order": 2}, "order: is 2, but nothing excites the system"),
        ({}, "does not come back near its start within 40 s"),
    ],
)
def test_wrong_requests(options: dict[str, Any], words: str) -> None:
    with pytest.raises(CaseError, match=words):
        orbit_of(OSCILLATOR, {"x": "v", "v": "-x - 0.5*v"}, **options)


def test_a_driveline_whose_frequencies_share_no_period_is_refused() -> None:
    model = lower(assemble(load("fracturing-truck")))
    with pytest.raises(CaseError, match="repeats only after"):
        periodic_orbit(Case(model, end=1.0))


def test_multipliers_are_judged() -> None:
    assert stability(np.array([0.5, 0.9999])) == "stable"
    assert stability(np.array([1.0 + 1e-9])) == "undecided"
    assert kinds_of_loss(np.array([1.5, -1.2, 0.9 + 0.9j, 0.9 - 0.9j, 0.1])) == ("fold", "flip", "Neimark-Sacker")
    turned = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
    found, flow = multipliers_of(turned @ np.array([[1.0, 4, 5], [0, 0.5, 7], [0, 0, -0.25]]) @ turned.T, 3 * turned[:, 0])
    assert found.real == pytest.approx([0.5, -0.25])
    assert flow == pytest.approx(1.0)
