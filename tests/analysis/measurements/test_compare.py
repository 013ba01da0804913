"""Synthetic measurements, made from a run with known differences, laid over that run."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from modelgen import Case, Driveline, HarmonicTorque, Inertia, Shaft, simulate
from modelgen.analysis.measurements.compare import ComparisonResult, compare
from modelgen.analysis.measurements.measurement import Measurement
from modelgen.analysis.measurements.signals import best_shift, correlation, interpolant, order_amplitudes
from modelgen.errors import CaseError, UnitError
from modelgen.solvers.solution import Solution

ANGLE, TORQUE = "engine.angle_deviation", "shaft.torque"
PERIOD = 0.08  # two turns at 1500 rpm


@pytest.fixture(scope="module")
def solution() -> Solution:
    """A settled run of ten engine cycles, sampled every 0.2 ms."""
    line = Driveline(
        "set",
        speed="1500 rpm",
        reference="engine",
        elements=(
            Inertia("engine", inertia=3.0),
            Inertia("load", inertia=1.0),
            Shaft("shaft", "engine", "load", stiffness=4e4, damping_ratio=0.05),
            HarmonicTorque(
                "firing", "engine", mean=200.0, sine=[30.0, 0, 80.0, 20.0], cosine=[10.0, 50.0, 0, 40.0], base="cycle"
            ),
            HarmonicTorque("brake", "load", mean=-200.0),
        ),
        bases={"cycle": ("engine", "1/2"), "turn": ("engine", 1)},
    )
    return simulate(Case(line, end=2.4, record_from=1.6, samples=4001, tolerance=1e-9, channels=(ANGLE, TORQUE)))


def recorded(solution: Solution, lag: float = 0.0, first: float = 1.7, last: float = 2.3, samples: int = 1801) -> Measurement:
    """The run as a recorder with another clock would have it: angle 10 % larger on a ramp, torque 50 N*m higher."""
    t = np.linspace(first, last, samples)
    angle = 1.1 * interpolant(solution.times, solution[ANGLE])(t + lag) + 0.3 + 2.0 * t
    torque = interpolant(solution.times, solution[TORQUE])(t + lag) + 50.0
    units = {ANGLE: "rad", TORQUE: "N*m"}
    return Measurement("bench", "time", "t", t, {ANGLE: angle, TORQUE: torque}, units, units)


def test_known_differences_are_found(solution: Solution) -> None:
    result = compare(solution, recorded(solution))
    angle, torque = result.channels
    assert (result.base, result.frequency, result.shift, result.aligned) == ("cycle", pytest.approx(12.5), 0.0, False)
    assert result.window == (pytest.approx(2.3 - 7 * PERIOD), pytest.approx(2.3))
    assert angle.treatment == "best straight line taken out"
    assert angle.simulated_extent.half_pp / angle.measured_extent.half_pp == pytest.approx(1 / 1.1, rel=2e-4)
    assert angle.half_pp_difference == pytest.approx(-0.1 * angle.simulated_extent.half_pp, rel=2e-3)
    assert angle.peak_difference == pytest.approx(-0.1 * angle.simulated_extent.peak, rel=1e-2)
    assert angle.correlation == pytest.approx(1.0, abs=1e-9)
    assert torque.treatment == "as it is"
    assert torque.measured_extent.mean - torque.simulated_extent.mean == pytest.approx(50.0, abs=0.1)
    assert torque.half_pp_difference == pytest.approx(0.0, abs=1e-3 * torque.simulated_extent.half_pp)  # samples beside the peaks
    assert torque.rms_difference == pytest.approx(50.0, rel=1e-5)
    for order in (*angle.orders[:4], *torque.orders[:4]):
        assert order.phase_difference == pytest.approx(0.0, abs=1e-4)
    assert [order.difference / order.measured for order in angle.orders[:4]] == pytest.approx([1 / 1.1 - 1] * 4, rel=1e-4)
    assert angle.orders[7].phase_difference is None  # no torque of order 8


def test_amplitudes_and_phases_are_those_of_the_torque(solution: Solution) -> None:
    """(-w^2 M + i w C + K) x = T with T = cosine - i sine on the engine, order by order."""
    result = compare(solution, recorded(solution), {ANGLE: ANGLE}, orders=[1, 3])
    first, third = result.channels[0].orders
    for order, sine, cosine in ((first, 30.0, 10.0), (third, 80.0, 0.0)):
        w = 2 * math.pi * 12.5 * order.order
        k, c = 4e4, 2 * 0.05 * math.sqrt(4e4 * 0.75)
        dynamic = np.array([[k + 1j * w * c - 3 * w**2, -k - 1j * w * c], [-k - 1j * w * c, k + 1j * w * c - w**2]])
        exact = np.linalg.solve(dynamic, [cosine - 1j * sine, 0.0])[0]
        assert order.simulated == pytest.approx(abs(exact), rel=1e-5)
        assert order.simulated_phase == pytest.approx(float(np.angle(exact)), abs=1e-5)


def test_a_lag_turns_the_phases_and_the_best_one_turns_them_back(solution: Solution) -> None:
    lag = 0.0037
    data = recorded(solution, lag)
    apart = compare(solution, data).channels[0].orders
    for order in apart[:4]:
        expected = math.remainder(-2 * math.pi * order.frequency * lag, 2 * math.pi)
        assert order.phase_difference == pytest.approx(expected, abs=1e-3)
    result = compare(solution, data, align=True)
    assert result.shift == pytest.approx(lag, abs=1e-5)
    assert "best lag" in str(result)
    for order in result.channels[0].orders[:4]:
        assert order.phase_difference == pytest.approx(0.0, abs=5e-3)


def test_clocks_that_never_meet_are_put_together_up_to_whole_periods(solution: Solution) -> None:
    data = recorded(solution)
    own = Measurement("bench", "time", "t", data.abscissa - 1.7, data.channels, data.units, data.written)
    with pytest.raises(CaseError, match=r"covers 1.6 to 2.4 s, the measurement 0 to 0.6 s: too little in common; set start"):
        compare(solution, own)
    assert compare(solution, own, start=1.7).channels[0].correlation == pytest.approx(1.0, abs=1e-9)
    result = compare(solution, own, align=True)
    assert math.remainder(result.shift - 1.7, PERIOD) == pytest.approx(0.0, abs=1e-5)
    assert result.remarks == ("of lags that differ by whole periods of the signals one is as good as another",)


def test_a_measurement_over_crank_angle(solution: Solution) -> None:
    data = recorded(solution)
    speed = 1500 * math.pi / 30
    turned = Measurement("bench", "angle", "phi", data.abscissa * speed, data.channels, data.units, data.written)
    over_time, over_angle = (compare(solution, each, base="turn", orders=[1]).channels[1] for each in (data, turned))
    assert over_angle.orders[0].measured == pytest.approx(over_time.orders[0].measured, rel=1e-9)
    assert over_angle.times == pytest.approx(over_time.times)
    with pytest.raises(CaseError, match="comparison, shaft: there is no 'engin'; nearest is 'engine'"):
        compare(solution, turned, shaft="engin")


def test_a_file_with_other_names_and_units(solution: Solution, tmp_path: Path) -> None:
    data = recorded(solution, samples=901)
    rows = [f"{1e3 * t:.5f};{x / 1e3:.9f}".replace(".", ",") for t, x in zip(data.abscissa, data.channels[TORQUE], strict=True)]
    path = tmp_path / "bench.csv"
    path.write_text("\n".join(["t [ms];M1 [kNm]", *rows]), encoding="utf-8")
    result = compare(solution, path, {TORQUE: "M1"})
    assert result.channels[0].rms_difference == pytest.approx(50.0, rel=1e-4)
    assert "shaft.torque over 'M1' (as it is)" in str(result)
    with pytest.raises(CaseError, match=r"column 'M1': is no channel of the solution; .*; pair them with channels="):
        compare(solution, path)


def test_a_loaded_solution_compares_with_a_base_in_hertz(solution: Solution, tmp_path: Path) -> None:
    loaded = Solution.load(solution.save(tmp_path / "run.npz"))
    with_base = compare(loaded, recorded(solution), base=12.5, orders=[2])
    assert with_base.channels[0].orders[0].frequency == pytest.approx(25.0)
    without = compare(loaded, recorded(solution))
    assert without.channels[0].orders == ()
    assert without.remarks[0].startswith("no orders")
    with pytest.raises(CaseError, match="'cycle', but a loaded solution does not know its model; give the base frequency in Hz"):
        compare(loaded, recorded(solution), base="cycle")
    with pytest.raises(CaseError, match="no base frequency bounds the lag; give longest_lag in seconds"):
        compare(loaded, recorded(solution), align=True)


def asked(solution: Solution, **options: object) -> ComparisonResult:
    return compare(solution, recorded(solution), **options)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"channels": {"shaft.tork": TORQUE}}, "no output 'shaft.tork'; nearest is 'shaft.torque'"),
        ({"channels": {TORQUE: "torque"}}, "bench, column 'torque': there is none; nearest is 'shaft.torque'"),
        ({"channels": {}}, "comparison, channels: are none"),
        ({"base": "cycles"}, "there is no base frequency 'cycles'; nearest is 'cycle'"),
        ({"base": -1.0}, "comparison, base: is -1 Hz; give a positive frequency"),
        ({"orders": [0]}, "comparison, orders: hold 0; give whole numbers from 1 up"),
        ({"orders": [0.5]}, "hold 0.5; give whole numbers from 1 up; take a slower base for half orders"),
        ({"orders": [500]}, "order 500 is 6250 Hz, samples 0.0003333 s apart over the common span see up to order"),
        ({"start": 9.0}, "the solution covers 1.6 to 2.4 s, the measurement 10.7 to 11.3 s: too little in common"),
        ({"base": 0.1}, "no period of a base frequency fits into the common span 1.7 to 2.3 s"),
        ({"align": True, "longest_lag": 5.0}, "too little for a lag of 5 s; record longer, or give a shorter longest_lag"),
        ({"align": True, "longest_lag": -1.0}, "longest_lag: is -1 s; give a positive time"),
    ],
)
def test_what_cannot_be_compared(solution: Solution, options: dict[str, object], words: str) -> None:
    with pytest.raises(CaseError, match=words):
        asked(solution, **options)


def test_dimensions_must_agree(solution: Solution) -> None:
    with pytest.raises(UnitError, match=r"is in N\*m, 'engine.angle_deviation' is in rad"):
        asked(solution, channels={ANGLE: TORQUE})


def test_orders_by_least_squares_are_exact_on_unequal_samples() -> None:
    t = np.sort(np.random.default_rng(3).uniform(5.0, 6.0, 300))
    x = 7.0 + 3.0 * t + 2.0 * np.cos(2 * np.pi * 4 * t + 0.5) + 0.1 * np.sin(2 * np.pi * 12 * t)
    found = order_amplitudes(t, x, 4.0, 3, line=True)
    assert np.abs(found) == pytest.approx([2.0, 0.0, 0.1], abs=1e-10)
    assert np.angle(found[[0, 2]]) == pytest.approx([0.5, -np.pi / 2], abs=1e-9)


def test_the_best_shift_is_found_between_the_candidates() -> None:
    assert best_shift(lambda s: -((s - 0.1234567) ** 2), -1.0, 1.0, 0.05) == pytest.approx(0.1234567, abs=1e-7)
    assert best_shift(lambda s: s, -1.0, 1.0, 0.05) == pytest.approx(1.0, abs=1e-7)
    assert correlation(np.ones(5), np.arange(5.0)) == 0.0
