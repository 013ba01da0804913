"""The referee: MuJoCo's own primitives against modelgen, exact solutions, and words for what the referee does not have."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from modelgen import Driveline, GearPair, GroundSpring, HarmonicTorque, Inertia, Shaft, load
from modelgen.analysis.referee.comparison import referee
from modelgen.errors import CaseError
from modelgen.plots import plot

pytest.importorskip("mujoco", reason="needs the extra referee")


def geared(**mesh: object) -> Driveline:
    return Driveline(
        "geared",
        speed="1500 rpm",
        reference="motor",
        elements=[
            Inertia("motor", inertia=0.5),
            Inertia("pinion", inertia=0.05),
            Inertia("wheel", inertia=0.4),
            Shaft("coupling", "motor", "pinion", stiffness="20 kN*m/rad", damping_ratio=0.02),
            GearPair(
                "mesh", "pinion", "wheel", teeth_a=21, teeth_b=63, module="4 mm",
                stiffness_cosine=[3e7, 1e7], stiffness_sine=[1e7, 0.0], damping_ratio=0.05,
                **{"mean_stiffness": "2e8 N/m", "error_amplitude": "5 um", "half_backlash": "20 um", **mesh},
            ),
            HarmonicTorque("drive", "motor", mean="150 N*m", sine=[20.0, 5.0], cosine=[40.0, 0.0], base="order", phase=0.3),
            HarmonicTorque("load", "wheel", mean="-450 N*m"),
        ],
        bases={"order": ("motor", 2)},
    )  # fmt: skip


def test_an_independent_engine_sees_the_same_vibration() -> None:
    result = referee(geared(half_backlash=0.0), 0.05, samples=201, backend="vm")
    assert result.worst[1] < 1e-6
    assert abs(result.worst_peak[1]) < 1e-6
    assert {"mesh.force", "mesh.deflection", "coupling.twist", "wheel.angle_deviation"} <= set(result.difference)


def test_the_order_of_the_referee_shows_in_its_step() -> None:
    smooth = geared(half_backlash=0.0)
    runs = (referee(smooth, 0.02, samples=11, step=step, backend="vm", tolerance=1e-11) for step in (4e-5, 2e-5))
    coarse, fine = (run.worst[1] for run in runs)
    assert 3.7 < np.log2(coarse / fine) < 4.3


def test_contact_that_is_lost_costs_the_fixed_step_its_order() -> None:
    result = referee(geared(), 0.05, samples=201, backend="vm")
    pressed = np.abs(result.ours["mesh.deflection"]) > 20e-6
    assert 0.5 < pressed.mean() < 0.999  # lost, and found again
    assert result.worst[1] < 1e-3


def test_a_wrong_number_shows() -> None:
    """The referee must be able to fail: one percent of stiffness on one side only is seen."""
    result = referee(geared(), 0.02, samples=51, backend="vm")
    other = referee(geared(mean_stiffness="2.02e8 N/m"), 0.02, samples=51, backend="vm")
    difference = np.abs(result.theirs["mesh.force"] - other.ours["mesh.force"]).max() / np.ptp(other.ours["mesh.force"])
    assert difference > 1e-3


def test_mean_stiffness_on_both_sides() -> None:
    result = referee(geared(half_backlash=0.0), 0.02, samples=51, mean_stiffness=True, backend="vm")
    assert result.worst[1] < 1e-6
    varying = referee(geared(half_backlash=0.0), 0.02, samples=51, backend="vm")
    assert np.abs(result.ours["mesh.force"] - varying.ours["mesh.force"]).max() > 1.0  # N: the rows did something


@pytest.mark.slow
def test_the_truck_with_everything_on() -> None:
    result = referee(load("fracturing-truck"), 1.0, samples=5001)
    assert result.worst[1] < 1e-6
    assert abs(result.worst_peak[1]) < 1e-3


@pytest.mark.slow
def test_the_truck_at_mean_stiffness() -> None:
    result = referee(load("fracturing-truck"), 0.1, samples=1001, mean_stiffness=True, step=4e-7, tolerance=1e-11)
    assert result.worst[1] < 1e-6


def test_the_figure_shows_forces_and_motions() -> None:
    figure = plot(referee(geared(), 0.01, samples=51, backend="vm"))
    texts = [axes.get_title(loc="left") for axes in figure.axes]
    assert any("mesh force" in text for text in texts)
    assert "every channel" in texts[-1]
    with pytest.raises(CaseError, match=r"no channel 'mesh\.farce'; .*mesh\.force"):
        plot(referee(geared(), 0.01, samples=51, backend="vm"), channels=("mesh.farce",))


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (geared(viscous="contact_only"), "viscous = 'contact_only'"),
        (geared(damping="literal"), "literal mesh damping"),
        (geared().change("coupling", damping="modal"), "modal damping"),
        (geared().add(GroundSpring("mount", "motor", stiffness=1.0)), "ground_spring has no counterpart"),
    ],
)
def test_what_the_referee_does_not_have(line: Driveline, words: str) -> None:
    with pytest.raises(CaseError, match=words):
        referee(line, 0.01, backend="vm")


def test_a_step_longer_than_the_run() -> None:
    with pytest.raises(CaseError, match="give a step smaller than the end"):
        referee(geared(), 0.01, step=0.02)


def test_without_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(CaseError, match=r"package mujoco is not installed; pip install 'modelgen\[referee\]'"):
        referee(geared(), 0.01)
