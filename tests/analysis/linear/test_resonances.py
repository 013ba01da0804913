"""Peaks between the speeds of a grid: read right by speeds that are added at resonances."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen import Compiled, Driveline, HarmonicTorque, Inertia, Shaft, assemble, forced, lower

GRID = np.linspace(60.0, 220.0, 41)
CHANNELS = ("first.torque", "second.torque", "c.angle_deviation")


@pytest.fixture(scope="module")
def model() -> Compiled:
    line = Driveline(
        "three",
        speed=100.0,
        reference="a",
        bases={"turn": 1},
        parameters={"zeta": 0.02},
        elements=[
            *(Inertia("a", inertia=3.0), Inertia("b", inertia=1.0), Inertia("c", inertia=2.0)),
            Shaft("first", "a", "b", stiffness=3e5, damping_ratio="zeta"),
            Shaft("second", "b", "c", stiffness=2e5, damping_ratio="zeta"),
            HarmonicTorque("shaking", "a", base="turn", cosine=[40.0, 0.0, 30.0, 0.0, 10.0, 5.0]),
        ],
    )
    return lower(assemble(line))


@pytest.mark.parametrize("zeta", [pytest.param(0.005, marks=pytest.mark.proof), 0.02, pytest.param(0.1, marks=pytest.mark.proof)])
def test_peaks_are_those_of_a_grid_a_hundred_times_finer(model: Compiled, zeta: float) -> None:
    fine = forced(model, np.linspace(60.0, 220.0, 4001), {"zeta": zeta}, channels=CHANNELS, refine=False)
    coarse = forced(model, GRID, {"zeta": zeta}, channels=CHANNELS, refine=False)
    refined = forced(model, GRID, {"zeta": zeta}, channels=CHANNELS)
    assert coarse.speeds.tolist() == GRID.tolist()
    assert set(GRID.tolist()) | set(refined.added) == set(refined.speeds.tolist())
    kept = np.isin(refined.speeds, GRID)
    for channel in CHANNELS:
        peak = fine.swing(channel).half_pp.max()
        assert refined.swing(channel).half_pp.max() == pytest.approx(peak, rel=5e-3)
        assert refined[channel][kept] == pytest.approx(coarse[channel], rel=1e-12, abs=1e-12 * peak)
    if zeta < 0.05:  # the fault: the grid alone reads the first shaft a quarter low or worse
        assert coarse.swing("first.torque").half_pp.max() < 0.75 * fine.swing("first.torque").half_pp.max()
        assert f"{len(refined.added)} speeds added at resonances" in str(refined)


def test_nothing_is_added_at_one_speed_on_a_fine_grid_or_without_damping(model: Compiled) -> None:
    assert forced(model, channels=CHANNELS).added == ()
    near = np.linspace(110.0, 112.0, 41)
    assert forced(model, near, {"zeta": 0.1}, channels=CHANNELS).added == ()
    assert forced(model, GRID, {"zeta": 0.0}, channels=CHANNELS).added == ()
