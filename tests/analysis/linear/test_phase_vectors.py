"""Phase vectors and gear hammer, on engines and gears whose sums are known on paper."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen import Driveline, GearPair, HarmonicTorque, Inertia, Shaft, assemble, lower, modal
from modelgen.analysis import forced, gear_hammer, phase_vectors
from modelgen.errors import CaseError

FIRING = [0, 4, 2, 5, 1, 3]  # in units of 120 degrees: a four-stroke six-cylinder engine that fires 1-5-3-6-2-4


def engine(crank=1e9) -> Driveline:
    """Six equal cylinders on a crank so stiff that the first mode turns it as one, on the half order."""
    throws = [Inertia(f"throw_{n}", inertia=0.1) for n in range(6)]
    cranks = [Shaft(f"crank_{n}", f"throw_{n}", f"throw_{n + 1}", stiffness=crank) for n in range(5)]
    fired = [
        HarmonicTorque(
            f"cylinder_{n}", f"throw_{n}", sine=[100.0] * 12, base="half", phase=turn * np.pi / 3,
        )
        for n, turn in enumerate(FIRING)
    ]  # fmt: skip
    end = (Inertia("flywheel", inertia=2.0), Shaft("shaft", "throw_5", "flywheel", stiffness=1e5))
    return Driveline(
        "six", speed="1500 rpm", reference="flywheel", bases={"half": "1/2"}, elements=(*throws, *cranks, *end, *fired)
    )


def test_only_the_major_orders_add_up_on_a_stiff_crank() -> None:
    """Orders 3 and 6 of a six-cylinder four-stroke engine; all others cancel (Den Hartog, Mechanical Vibrations, sec. 5.4)."""
    result = phase_vectors(lower(assemble(engine())))
    assert result.sources == tuple(f"cylinder_{n}" for n in range(6))
    assert result.addition[0] == pytest.approx([0, 0, 0, 0, 0, 1] * 2, abs=1e-3)
    assert np.abs(result.sums[0, 5]) == pytest.approx(np.abs(result.vectors[0, :, 5]).sum(), rel=1e-6)
    assert result.critical_speeds[0, 5] == pytest.approx(2 * np.pi * result.frequencies[0] / 3, rel=1e-12)


def test_vectors_are_torque_times_shape_turned_by_the_firing_order() -> None:
    model = lower(assemble(engine(crank=4e4)))
    result, modes = phase_vectors(model), modal(model)
    for n, turn in enumerate(FIRING):
        # a sine is the real part of -i e^(i x); the third harmonic of the half order turns by three times the phase.
        expected = -100j * np.exp(3j * turn * np.pi / 3) * modes.shapes[n, 1:]
        assert result.of(f"cylinder_{n}")[:, 2] == pytest.approx(expected, abs=1e-9)
    with pytest.raises(CaseError, match="no source 'cylinder_9'; nearest is 'cylinder_"):
        result.of("cylinder_9")


def test_a_misfire_leaves_one_vector_out() -> None:
    model = lower(assemble(engine()))
    whole, missing = phase_vectors(model), phase_vectors(model, {"cylinder_2.scale": 0.0})
    assert "cylinder_2" not in missing.sources
    assert missing.sums[0] == pytest.approx(whole.sums[0] - whole.of("cylinder_2")[0], abs=1e-9)
    assert np.abs(missing.sums[0, 0]) == pytest.approx(np.abs(whole.of("cylinder_2")[0, 0]), rel=1e-2)


def test_the_sum_is_the_force_on_the_mode() -> None:
    """At the critical speed of a lightly damped mode the amplitude is |sum| / (modal inertia 2 zeta omega^2)."""
    line = engine().change("shaft", damping="modal", damping_ratio=1e-4)
    model = lower(assemble(line))
    vectors, modes = phase_vectors(model), modal(model)
    speed = float(vectors.critical_speeds[0, 5])
    result = forced(model, [speed], channels=["flywheel.angle_deviation"])
    omega = 2 * np.pi * modes.frequencies[1]
    expected = np.abs(vectors.sums[0, 5]) / (modes.modal_inertia[1] * 2e-4 * omega**2) * np.abs(modes.shapes[-1, 1])
    assert np.abs(result["flywheel.angle_deviation"][0, 5]) == pytest.approx(expected, rel=1e-2)


def geared(alternating: float, mean: float = 100.0) -> Driveline:
    return Driveline(
        "geared", speed="1200 rpm", reference="motor", bases={"turn": 2},
        elements=(
            Inertia("motor", inertia=1.0), Inertia("fan", inertia=4.0),
            GearPair("mesh", "motor", "fan", teeth_a=20, teeth_b=40, module="5 mm", mean_stiffness=1e12, damping_ratio=0.1),
            HarmonicTorque("drive", "motor", mean=mean, cosine=[alternating], base="turn"),
            HarmonicTorque("drag", "fan", mean=-2 * mean),
        ),
    )  # fmt: skip


@pytest.mark.parametrize(("alternating", "hammer"), [(190.0, False), (210.0, True)])
@pytest.mark.parametrize("sense", [1, -1])
def test_gears_hammer_where_half_the_torque_passes_the_mean(alternating: float, hammer: bool, sense: int) -> None:
    """Both sides have the same inertia at the motor: the stiff mesh passes half of the alternating torque on."""
    result = gear_hammer(forced(lower(assemble(geared(alternating, 100.0 * sense))), ["600 rpm", "1200 rpm"]))
    gear = result.gears["mesh"]
    radius = 0.05 * np.cos(np.radians(20))
    assert gear.hammer.tolist() == [hammer] * 2
    assert gear.mean == pytest.approx(100 * sense / radius, rel=1e-6)
    assert gear.alternating == pytest.approx(alternating / 2 / radius, rel=1e-4)
    assert gear.ratio == pytest.approx(alternating / 200, rel=1e-4)
    assert gear.least == pytest.approx((100 - alternating / 2) / radius, rel=5e-3)
    assert ("first at 600 rpm" if hammer else "never") in str(result)


def test_unloaded_gears_always_hammer() -> None:
    gear = gear_hammer(forced(lower(assemble(geared(10.0, 0.0))))).gears["mesh"]
    assert gear.hammer.all()
    assert np.isinf(gear.ratio).all()


def test_a_driveline_without_gears_is_refused() -> None:
    with pytest.raises(CaseError, match="holds no load of a gear"):
        gear_hammer(forced(lower(assemble(engine()))))
