"""Shaft: its torque and its sign, and where its damping coefficient comes from."""

from __future__ import annotations

import math

import pytest

from modelgen.elements import Inertia, Shaft
from modelgen.equations import assemble
from modelgen.errors import ModelError
from modelgen.lowering import lower
from modelgen.model import Driveline
from modelgen.solvers.bound_model import operating_point

J_A, J_B, K = 1.3, 0.4, 250.0


def compiled(**damping):
    disks = [Inertia("disk_a", inertia=J_A), Inertia("disk_b", inertia=J_B)]
    return lower(assemble(Driveline("pair", [*disks, Shaft("shaft", "disk_a", "disk_b", stiffness=K, **damping)])))


def coefficient(**damping):
    model = compiled(**damping)
    return model.evaluate(0.0, [0.0] * 4, model.parameters.vector())["shaft.viscous_coefficient"]


def test_torque_is_positive_when_a_drives_b():
    model = compiled(damping="value", damping_coefficient=2.0)
    now = model.evaluate(0.0, [0.0, 0.1, 0.0, 3.0], model.parameters.vector())
    assert now["shaft.twist"] == 0.1
    assert now["shaft.torque"] == pytest.approx(0.1 * K + 3.0 * 2.0)
    assert now["disk_a.acceleration"] == pytest.approx(-now["shaft.torque"] / J_A)
    assert now["disk_b.acceleration"] == pytest.approx(now["shaft.torque"] / J_B)


def test_per_shaft_damping_is_a_ratio_of_the_local_two_disk_mode():
    assert coefficient(damping_ratio=0.035) == pytest.approx(2 * 0.035 * math.sqrt(K * J_A * J_B / (J_A + J_B)), rel=1e-15)


def test_given_coefficient():
    assert coefficient(damping="value", damping_coefficient=7.5) == 7.5


def test_loss_factor_gives_a_coefficient_at_one_frequency():
    assert coefficient(damping="loss_factor", loss_factor=0.1, reference_frequency="500 rpm") == pytest.approx(
        0.1 * K / (500 * math.pi / 30), rel=1e-14
    )


def test_modal_damping_leaves_the_shaft_and_damps_the_mode():
    model = compiled(damping="modal", damping_ratio=0.035)
    assert coefficient(damping="modal", damping_ratio=0.035) == 0
    assert model.equations.modal_ratio == "shaft.damping_ratio"
    # The one elastic mode of two disks: the same as the ratio of the local mode.
    point = operating_point(model)
    expected = 2 * 0.035 * math.sqrt(K * J_A * J_B / (J_A + J_B))
    assert point.damping == pytest.approx(expected * point.stiffness / K, rel=1e-12)


def test_per_shaft_damping_needs_an_inertia_that_it_can_see(cranks):
    words = "shaft 'shaft': needs the inertia at its flange 'b', but node 'crank' has none that is constant; put an Inertia on it"
    with pytest.raises(ModelError, match=words):
        assemble(
            Driveline(
                "line", [Inertia("disk", inertia=1.0), cranks("crank", mass=2.0), Shaft("shaft", "disk", "crank", stiffness=K)]
            )
        )


@pytest.fixture
def cranks():
    """A class whose inertia depends on its angle only."""
    import sympy

    from modelgen.model import Element, Flange, Param

    class RockingMass(Element):
        flange = Flange()
        mass = Param("kg*m^2", positive=True)

        def kinetic_energy(self):
            return self.mass * (2 + sympy.sin(self.flange.angle)) * self.flange.speed**2 / 2

    yield RockingMass
    del Element.vocabulary["rocking_mass"]
