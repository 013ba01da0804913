"""Angles, windows and modes on drivelines whose answers are known on paper."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from modelgen import (
    Case,
    Driveline,
    HarmonicTorque,
    Inertia,
    Shaft,
    assemble,
    load,
    lower,
    modal,
    operating_point,
    settled_window,
    simulate,
)
from modelgen.analysis.time_domain.angles import angle_channels, angles, referred_ratios
from modelgen.analysis.time_domain.window import Window
from modelgen.errors import CaseError
from modelgen.solvers.crosscheck import without_line

DEGREE = np.pi / 180


def rigid_like() -> Driveline:
    """A stiff two-disk line shaken at 10 Hz: both disks roll with T / (J omega^2)."""
    return Driveline(
        "rolling",
        speed="600 rpm",
        reference="engine",
        elements=(
            Inertia("engine", inertia=3.0),
            Inertia("load", inertia=1.0),
            Shaft("shaft", "engine", "load", stiffness=1e7, damping_ratio=0.05),
            HarmonicTorque("shaking", "engine", cosine=[40.0], base="once"),
        ),
        bases={"once": ("engine", 1)},
    )


def test_rolling_is_in_the_vibration_angle_and_not_in_the_elastic_one() -> None:
    case = Case(rigid_like(), end=1.0, tolerance=1e-9)
    model = case.model
    point = operating_point(model)
    window = Window(0.2, 1.0, 8, "once", 0.1, True)
    solution = simulate(case.change(record_from=0.2, samples=8001, channels=angle_channels(model.outputs)))
    result = angles(solution, window, point)
    rolling = 40.0 / (4.0 * (20 * np.pi) ** 2)
    twist = 40.0 * (1 / 4.0) / 1e7
    for name in ("engine", "load"):
        assert result.inertias[name].vibration.half_pp == pytest.approx(rolling, rel=1e-2)
        assert result.inertias[name].elastic.half_pp < 2 * twist
    assert result.twists["shaft"].half_pp == pytest.approx(twist, rel=2e-2)


def test_the_best_line_is_taken_out_exactly() -> None:
    t = np.linspace(3.0, 5.0, 4001)
    wave = np.sin(2 * np.pi * 8 * t)
    assert without_line(t, 7.0 + 3.0 * t) == pytest.approx(0.0, abs=1e-12)
    assert without_line(t, 7.0 + 3.0 * t + wave) == pytest.approx(wave - np.polyval(np.polyfit(t, wave, 1), t), abs=1e-12)


def test_referred_ratios_follow_the_teeth() -> None:
    model = lower(assemble(load("fracturing-truck")))
    ratios = referred_ratios(model, operating_point(model))
    assert ratios["flywheel"] == 1.0
    assert ratios["pump_pinion"] == pytest.approx(26 / 46, rel=1e-14)
    assert ratios["pump_free_end"] == pytest.approx(26 / 46 * 17 / 108, rel=1e-14)


def test_a_window_is_whole_revolutions_after_the_decay() -> None:
    model = lower(assemble(load("fracturing-truck")))
    point = operating_point(model)
    window = settled_window(model, point)
    slowest = modal(model, point=point).decay_rates.min()
    assert window.period == pytest.approx(60 / 1900 * 46 / 26 * 108 / 17, rel=1e-12)
    assert (window.last - window.first) / window.period == pytest.approx(8)
    assert window.first >= np.log(1000) / slowest > window.first - window.period
    assert window.settled


def test_an_undamped_line_is_never_settled_and_says_so() -> None:
    model = lower(assemble(load("fracturing-truck").set(zeta=0.0, xi=0.0)))
    window = settled_window(model, operating_point(model), longest=5.0)
    assert not window.settled
    assert window.last <= 5.0


def test_a_line_without_base_frequencies_has_no_window() -> None:
    line = Driveline("two", elements=(Inertia("a", inertia=1.0), Inertia("b", inertia=1.0), Shaft("s", "a", "b", stiffness=1.0)))
    model = lower(assemble(line))
    with pytest.raises(CaseError, match="has no base frequency to count revolutions of"):
        settled_window(model, operating_point(model))


def test_a_window_outside_the_solution_is_refused() -> None:
    case = Case(rigid_like(), end=0.3)
    with pytest.raises(CaseError, match=r"covers 0 to 0.3 s, the window is 0.2 to 1 s"):
        angles(simulate(case), Window(0.2, 1.0, 8, "once", 0.1, True), operating_point(case.model))


def test_modes_of_a_free_chain() -> None:
    """Equal disks: 2 sqrt(k/J) sin(j pi / 2n) (Thomson, Theory of Vibration, ch. 10: free-free chain)."""
    n, k, j = 6, 3e4, 0.2
    line = Driveline(
        "chain",
        elements=(
            *(Inertia(f"disk_{i}", inertia=j) for i in range(n)),
            *(Shaft(f"shaft_{i}", f"disk_{i}", f"disk_{i + 1}", stiffness=k) for i in range(n - 1)),
        ),
    )
    result = modal(lower(assemble(line)))
    exact = 2 * np.sqrt(k / j) * np.sin(np.arange(n) * np.pi / (2 * n)) / (2 * np.pi)
    assert result.frequencies == pytest.approx(exact, rel=1e-12, abs=1e-9)
    assert result.rigid == 1
    assert result.shapes[:, 0] == pytest.approx(1.0)


def test_damped_pairs_of_the_two_disk_line() -> None:
    line = rigid_like()
    result = modal(lower(assemble(line)))
    omega = np.sqrt(1e7 * (1 / 3 + 1))
    assert result.damping_ratios == pytest.approx([0.05], rel=1e-9)
    assert result.damped_frequencies == pytest.approx([omega * np.sqrt(1 - 0.05**2) / (2 * np.pi)], rel=1e-9)


@pytest.mark.slow
def test_the_public_check_of_the_truck() -> None:
    """Modal damping 0.035, mesh damping 0.1, zero start, pump revolutions 41 to 48: an independent fixed-step RK4 at 2.5 us gave
    vibration angles 0.564, 0.655, 0.229 and elastic angles 0.185, 0.267, 0.236 degrees."""
    line = load("fracturing-truck").change("shaft", damping="modal")
    case = Case(line, end=1.0)
    model, point = case.model, operating_point(case.model)
    window = settled_window(model, point)
    window = dataclasses.replace(window, first=40 * window.period, last=48 * window.period)
    count = int((window.last - window.first) * 20000)
    case = case.change(
        start="zero",
        end=window.last,
        record_from=window.first,
        samples=count,
        tolerance=1e-5,
        channels=angle_channels(model.outputs),
    )
    result = angles(simulate(case), window, point)
    expected = {"flywheel": (0.564, 0.185), "damper": (0.655, 0.267), "pump_free_end": (0.229, 0.236)}
    for name, (vibration, elastic) in expected.items():
        assert result.inertias[name].vibration.peak / DEGREE == pytest.approx(vibration, rel=0.01)
        assert result.inertias[name].elastic.peak / DEGREE == pytest.approx(elastic, rel=0.01)
    # Its force extremes came from coarser samples: 7.5 ... 141.9 and 83.6 ... 250.5 kN.
    assert result.meshes["transmission_mesh"].largest == pytest.approx(141.9e3, rel=0.01)
    assert result.meshes["pump_mesh"].largest == pytest.approx(250.5e3, rel=0.01)
