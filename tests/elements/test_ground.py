"""Spring and damper to ground: what they see is absolute."""

from __future__ import annotations

import math

import pytest

from modelgen.elements import GroundDamper, GroundSpring, Inertia
from modelgen.equations import assemble
from modelgen.lowering import lower
from modelgen.model import Driveline
from modelgen.solvers.bound_model import operating_point


def compiled(*elements, **more):
    return lower(assemble(Driveline("mounted", [Inertia("disk", inertia=2.0), *elements], **more)))


def test_a_sprung_disk_has_no_rigid_mode():
    model = compiled(GroundSpring("mount", "disk", stiffness=50.0, damping=3.0))
    assert model.equations.rigid == ()
    assert operating_point(model).frequencies() == pytest.approx([math.sqrt(50 / 2) / (2 * math.pi)])
    now = model.evaluate(0.0, [0.2, 0.5], model.parameters.vector())
    assert now["mount.torque"] == pytest.approx(50 * 0.2 + 3 * 0.5)
    assert now["disk.acceleration"] == pytest.approx(-now["mount.torque"] / 2)


def test_drag_sees_the_operating_speed():
    model = compiled(GroundDamper("brake", "disk", damping=0.3), speed=100.0, reference="disk", drifts=True)
    assert model.equations.rigid == (0,)
    now = model.evaluate(0.0, [0.0, 0.0], model.parameters.vector())
    assert now["brake.torque"] == pytest.approx(30.0)
    assert now["disk.acceleration"] == pytest.approx(-15.0)
    assert operating_point(model).drift == pytest.approx(-15.0)
