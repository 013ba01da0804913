"""Starts: values of channels, states, earlier solutions, and what contradicts itself."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen import (
    Case,
    Driveline,
    GearPair,
    HarmonicTorque,
    Inertia,
    RigidGear,
    Shaft,
    assemble,
    lower,
    operating_point,
    simulate,
)
from modelgen.errors import CaseError, UnitError
from modelgen.solvers.start import starting_state


@pytest.fixture(scope="module")
def model():
    parts = [
        Inertia("motor", inertia=0.3), Inertia("pinion", inertia=0.05), Inertia("fan", inertia=1.5),
        Shaft("coupling", "motor", "pinion", stiffness=2e4, damping_ratio=0.02),
        GearPair("mesh", "pinion", "fan", teeth_a=20, teeth_b=40, module="3 mm", mean_stiffness=4e8, half_backlash="40 um"),
        HarmonicTorque("drive", "motor", base="order", mean=100.0, cosine=[30.0, 10.0]),
        HarmonicTorque("load", "fan", mean=-200.0),
    ]  # fmt: skip
    return lower(assemble(Driveline("line", elements=parts, speed="1500 rpm", reference="motor", bases={"order": ("motor", 2)})))


def first(model, start, begin=0.0):
    run = simulate(Case(model, begin=begin, end=begin + 1e-5, samples=2, start=start))
    return {name: float(values[0]) for name, values in run.channels.items()}


OPERATING = 1500 * np.pi / 30


def test_channels_are_met_and_what_is_not_named_is_at_rest(model):
    found = first(model, {"motor.speed": "0 rpm", "coupling.torque": "5 N*m", "mesh.deflection": 0.0})
    assert found["motor.speed"] == 0.0
    assert found["coupling.torque"] == pytest.approx(5.0, rel=1e-12)
    assert found["mesh.deflection"] == 0.0
    assert found["pinion.speed"] == pytest.approx(OPERATING)
    assert found["fan.speed"] == pytest.approx(OPERATING / 2)


def test_one_torque_leaves_the_others_at_zero(model):
    found = first(model, {"coupling.torque": "5 N*m"})
    assert found["coupling.twist"] == pytest.approx(5.0 / 2e4)
    assert found["mesh.force"] == 0.0
    assert found["motor.speed"] == pytest.approx(OPERATING)


def test_a_force_inside_the_backlash_closes_it(model):
    found = first(model, {"mesh.force": 1000.0})
    assert found["mesh.deflection"] == pytest.approx(40e-6 + 1000.0 / 4e8)
    assert found["coupling.twist"] == pytest.approx(0.0, abs=1e-15)
    assert found["pinion.speed"] == pytest.approx(OPERATING)


def test_the_order_of_elements_changes_no_start(model):
    line = model.equations.source
    start = {"motor.speed": "1400 rpm", "fan.angle_deviation": 0.01}
    wanted = first(model, start)
    for seed in range(4):
        parts = [line.elements[k] for k in np.random.default_rng(seed).permutation(len(line.elements))]
        other = lower(assemble(Driveline("line", elements=parts, speed=line.speed, reference="motor", bases=line.bases)))
        found = first(other, start)
        assert found["motor.speed"] == pytest.approx(wanted["motor.speed"])
        assert found["fan.angle_deviation"] == pytest.approx(0.01)


def test_states_are_set_on_top_of_the_static_ones(model):
    static = first(model, "static")
    found = first(model, {"coupling.twist": 0.002})
    assert found["coupling.twist"] == 0.002
    assert found["mesh.deflection"] == static["mesh.deflection"]


def test_a_run_goes_on_where_another_ended(model):
    whole = simulate(Case(model, end=0.04, samples=5, tolerance=1e-9))
    half = simulate(Case(model, end=0.02, samples=5, tolerance=1e-9))
    rest = simulate(Case(model, begin=0.02, end=0.04, samples=5, tolerance=1e-9, start=half))
    assert rest["coupling.torque"][0] == half["coupling.torque"][-1]
    assert rest["coupling.torque"][-1] == pytest.approx(whole["coupling.torque"][-1], rel=1e-5)
    assert Case(model, end=1.0, start=half).start == Case(model, end=1.0, start=half.final).start


@pytest.mark.parametrize(
    ("start", "words"),
    [
        ({"motor.sped": 1.0}, "start: names 'motor.sped', which is no state and no channel; nearest is 'motor.speed'"),
        ({"motor.speed": "3 N*m"}, "start of 'motor.speed': "),
        ({"motor.speed": float("nan")}, "start of 'motor.speed': holds a number that is not finite, nan"),
        ({"motor.speed": None}, "start of 'motor.speed': is None; give a finite number in rad/s, or a text with a unit"),
        ("standstil", "case, start: is 'standstil'; give \"static\", \"zero\", or values of states by name"),
        ({"drive.torque": 3.0}, r"start: cannot meet 'drive.torque' = 3 \(found 140 N\*m\)"),
        ({"motor.speed": 3.0, "motor.angle_deviation_rate": 1.0}, "start: cannot meet 'motor.speed' = 3"),
        ({"coupling.twist": 0.1, "coupling.stored_energy": 1.0}, "start: cannot meet 'coupling.stored_energy' = 1"),
    ],
)  # fmt: skip
def test_what_cannot_be_a_start_is_refused(model, start, words):
    with pytest.raises((CaseError, UnitError), match=words):
        first(model, start)


@pytest.mark.parametrize("seed", range(4))
def test_an_earlier_run_goes_on_in_any_order_and_with_any_reference(seed):
    """Four inertias with two shafts and a gear: every order and every reference chooses other states."""
    rng = np.random.default_rng(seed)
    parts = [Inertia(name, inertia=value) for name, value in zip("ABCD", (1.0, 0.3, 0.7, 2.0), strict=True)]
    parts += [Shaft("s", "A", "B", stiffness=900.0), Shaft("u", "C", "D", stiffness=400.0)]
    parts += [RigidGear("g", "B", "C", teeth_a=20, teeth_b=37), HarmonicTorque("p", "A", mean=3.0)]
    begun = simulate(Case(Driveline("line", elements=parts), end=0.2, start={"s.torque": 5.0}, tolerance=1e-11))
    order = rng.permutation(len(parts))
    line = Driveline("line", elements=[parts[k] for k in order], reference="ABCD"[seed])
    for model in (begun.case.model, lower(assemble(line))):
        run = simulate(Case(model, begin=0.2, end=0.4, start=begun, tolerance=1e-11, samples=11))
        if model is begun.case.model:
            wanted = run
        for name in "ABCD":
            assert run[f"{name}.speed"] == pytest.approx(wanted[f"{name}.speed"], abs=1e-8)
            assert run[f"{name}.angle"] == pytest.approx(wanted[f"{name}.angle"], abs=1e-9)
    other = Driveline("other", elements=[*parts, Inertia("E", inertia=1.0), Shaft("v", "D", "E", stiffness=10.0)], reference="E")
    with pytest.raises(CaseError, match="which is no state and no channel"):
        Case(other, end=1.0, start=begun)


@pytest.mark.parametrize("small", [1e-20, 1e-40, 1e-100])
@pytest.mark.parametrize("swap", [False, True])
def test_a_start_by_channels_is_met_with_an_inertia_that_is_nearly_nothing(small, swap):
    parts = [Inertia("A", inertia=0.5), Inertia("B", inertia=small), Shaft("s", "A", "B", stiffness=1e4)]
    model = lower(assemble(Driveline("light", elements=[parts[1], parts[0], parts[2]] if swap else parts)))
    for start in ({"A.speed": 3.0}, {"s.torque": 2.0}, {"A.speed": 1.0, "B.speed": 2.0}):
        case = Case(model, end=1e-12, samples=2, start=start)
        found = starting_state(model, operating_point(model), case.start)
        channels = model.evaluate(0.0, found, operating_point(model).p)
        assert {name: channels[name] for name in start} == pytest.approx(start)
