"""Action equals reaction: a uniform rotation takes no power from what only joins shafts, and a gear shows an inertia i^2 J."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.elements import GearPair, Inertia, RigidGear, Shaft, SteppedTorque
from modelgen.equations import assemble
from modelgen.lowering import lower
from modelgen.model import Driveline
from modelgen.solvers.operating_point import natural_frequencies


def test_torques_of_an_element_do_no_work_in_uniform_rotation(bench):
    # sum of r_f tau_f = 0 with r_f the speeds at which the flanges turn together, whatever state the element is in.
    if len(bench.disks) < 2:
        return
    model, p = bench.model, bench.p
    still = model.evaluate(0.0, np.zeros(len(model.states)), p)
    ratio = np.array([still[f"{disk}.speed"] for disk in bench.disks])
    for t, x in bench.states(20):
        now = model.evaluate(t, x, p)
        torque = np.array([bench.inertia(disk) * now[f"{disk}.acceleration"] for disk in bench.disks])
        size = np.abs(ratio) @ np.abs(torque)
        torque[0] -= now["push.torque"]
        assert ratio @ torque == pytest.approx(0, abs=1e-12 * size)


def two_disks(*between, inertia_a=1.3, inertia_b=0.7, torque=5.0):
    disks = [Inertia("disk_a", inertia=inertia_a), Inertia("disk_b", inertia=inertia_b)]
    push = SteppedTorque("push", "disk_a", before=torque, after=torque)
    return lower(assemble(Driveline("pair", [*disks, *between, push], speed=1.0, reference="disk_a")))


def test_an_inertia_is_seen_through_a_rigid_gear_by_the_square_of_the_ratio():
    ratio = 41 / 17
    model = two_disks(RigidGear("gear", "disk_a", "disk_b", teeth_a=41, teeth_b=17))
    now = model.evaluate(0.0, [0.3, 0.1], model.parameters.vector())
    assert now["disk_a.acceleration"] == pytest.approx(5.0 / (1.3 + ratio**2 * 0.7), rel=1e-14)
    assert now["disk_b.acceleration"] == pytest.approx(ratio * now["disk_a.acceleration"], rel=1e-14)
    # The gear passes on what the far disk needs, and its teeth turn it into that much torque over there.
    assert now["gear.torque"] == pytest.approx(ratio * 0.7 * now["disk_b.acceleration"], rel=1e-13)


@pytest.mark.parametrize("through", [True, False])
def test_damping_sees_an_inertia_through_a_gear(through):
    # A shaft between disk_a and the side a of the gear: the node's inertia is i^2 J_b, with or without a wheel of its own.
    ratio, stiffness, zeta = 30 / 12, 80.0, 0.04
    wheel = [] if through else [Inertia("wheel", inertia=0.2)]
    line = Driveline(
        "seen",
        [
            Inertia("disk_a", inertia=1.3),
            Inertia("disk_b", "gear.b", inertia=0.7),
            *wheel,
            RigidGear("gear", teeth_a=30, teeth_b=12),
            Shaft("shaft", "disk_a", "gear.a", stiffness=stiffness, damping_ratio=zeta),
        ],
    )
    line = line if through else line.connect("wheel", "gear.a")
    model = lower(assemble(line))
    seen = ratio**2 * 0.7 + (0 if through else 0.2)
    coefficient = model.evaluate(0.0, np.zeros(4), model.parameters.vector())["shaft.viscous_coefficient"]
    assert coefficient == pytest.approx(2 * zeta * np.sqrt(stiffness * 1.3 * seen / (1.3 + seen)), rel=1e-14)


@pytest.mark.parametrize("stiffness", [1e10, 1e12])
def test_a_stiff_gear_pair_tends_to_the_rigid_gear(stiffness):
    def chain(gear):
        disks = [Inertia(f"disk_{n}", inertia=inertia) for n, inertia in enumerate((2.0, 0.1, 0.3, 1.1), 1)]
        shafts = [Shaft("first", "disk_1", "disk_2", stiffness=3e4), Shaft("second", "disk_3", "disk_4", stiffness=5e4)]
        model = lower(assemble(Driveline("chain", [*disks, *shafts, gear], speed=1.0, reference="disk_1")))
        p = model.parameters.vector()
        n = len(model.equations.groups)
        mean = np.asarray(model.mean_model.means(p)[0]).ravel()
        mass, _, spring = (each.full() for each in model.mean_model.linear(np.zeros(n), np.zeros(n), [], p, mean))
        return natural_frequencies(mass, spring)

    teeth = {"teeth_a": 20, "teeth_b": 50}
    rigid = chain(RigidGear("gear", "disk_2", "disk_3", **teeth))
    elastic = chain(GearPair("gear", "disk_2", "disk_3", module=0.008, mean_stiffness=stiffness, **teeth))
    # The error falls as the compliance does.
    assert elastic[:3] == pytest.approx(rigid, rel=1e6 / stiffness, abs=1e-4)
    assert elastic[3] > 50 * rigid[2]
