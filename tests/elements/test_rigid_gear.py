"""Rigid gear: exact kinematics, eliminated; the torque through its teeth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from modelgen.elements import GroundDamper, HarmonicTorque, Inertia, RigidGear
from modelgen.equations import assemble
from modelgen.errors import ModelError
from modelgen.lowering import lower
from modelgen.model import Driveline


def train(*gears, **more):
    disks = [Inertia(name, inertia=inertia) for name, inertia in (("first", 2.0), ("second", 0.5), ("third", 0.3))]
    return Driveline("train", [*disks, *gears], **more)


def test_three_disks_on_two_gears_are_one_degree_of_freedom():
    line = train(
        RigidGear("low", "first", "second", teeth_a=17, teeth_b=60),
        RigidGear("high", "second", "third", teeth_a=23, teeth_b=40),
        HarmonicTorque("drive", "first", mean=9.0),
        speed=100.0,
        reference="third",
    )
    model = lower(assemble(replace(line, drifts=True)))
    assert len(model.states) == 2
    second, third = 17 / 60, 17 / 60 * 23 / 40
    now = model.evaluate(0.0, [0.1, 0.0], model.parameters.vector())
    assert now["third.speed"] == pytest.approx(100.0, rel=1e-15)
    assert now["first.speed"] == pytest.approx(100 / third, rel=1e-14)
    assert now["first.acceleration"] == pytest.approx(9 / (2.0 + second**2 * 0.5 + third**2 * 0.3), rel=1e-14)
    # Between the gears: what the first passes on is what the second disk and the second gear need.
    assert now["low.torque"] / second == pytest.approx(0.5 * now["second.acceleration"] + now["high.torque"], rel=1e-12)


def test_tooth_numbers_are_parameters():
    model = lower(assemble(train(
        RigidGear("low", "first", "second", teeth_a=17, teeth_b=60),
        RigidGear("high", "second", "third", teeth_a=23, teeth_b=40),
        speed=100.0, reference="first",
    )))  # fmt: skip
    p = model.parameters.vector({"low.teeth_a": 30})
    assert model.evaluate(0.0, np.zeros(2), p)["second.speed"] == pytest.approx(50.0, rel=1e-15)


def test_a_closed_loop_of_agreeing_gears_is_lawful():
    line = train(
        RigidGear("one", "first", "second", teeth_a=20, teeth_b=40),
        RigidGear("two", "second", "third", teeth_a=40, teeth_b=30),
        RigidGear("closing", "first", "third", mesh="internal", teeth_a=20, teeth_b=30),
        GroundDamper("drag", "third", damping=1.0),
    )
    assert len(assemble(line).groups) == 1


@pytest.mark.parametrize(
    ("mesh", "teeth", "words"),
    [
        ("internal", 31, "closes a loop of rigid gears whose ratios do not agree; check the tooth numbers on the loop"),
        (
            "external",
            30,
            "closes a loop of gears whose senses of rotation contradict; an even number of external gear pairs must lie",
        ),
    ],
)
def test_a_loop_that_cannot_turn(mesh, teeth, words):
    line = train(
        RigidGear("one", "first", "second", teeth_a=20, teeth_b=40),
        RigidGear("two", "second", "third", teeth_a=40, teeth_b=30),
        RigidGear("closing", "first", "third", mesh=mesh, teeth_a=20, teeth_b=teeth),
    )
    with pytest.raises(ModelError, match=f"^rigid_gear '(two|closing)': {words}"):
        assemble(line)
