"""Inertia: Newton's law, and several disks on one node."""

from __future__ import annotations

import pytest

from modelgen.elements import HarmonicTorque, Inertia
from modelgen.equations import assemble
from modelgen.lowering import lower
from modelgen.model import Driveline


def test_torque_is_inertia_times_acceleration():
    model = lower(
        assemble(Driveline("one", [Inertia("disk", inertia="20 kg*m^2"), HarmonicTorque("push", "disk", mean="1 kN*m")]))
    )
    assert model.evaluate(0.0, [0.0, 0.0], model.parameters.vector())["disk.acceleration"] == pytest.approx(50.0)


def test_inertias_on_one_node_add_up():
    parts = [Inertia("disk", inertia=2.0), Inertia("ring", "disk", inertia=0.5), HarmonicTorque("push", "disk", mean=10.0)]
    model = lower(assemble(Driveline("stack", parts)))
    now = model.evaluate(0.0, [0.0, 3.0], model.parameters.vector())
    assert now["disk.acceleration"] == now["ring.acceleration"] == pytest.approx(4.0)
    assert now["total.kinetic_energy"] == pytest.approx(2.5 * 3**2 / 2)
