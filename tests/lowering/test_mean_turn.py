"""Laws that depend on the angle of a shaft are averaged over its turns in linear questions, and it is said."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy

from modelgen import (
    Driveline,
    Element,
    Flange,
    GroundSpring,
    HarmonicTorque,
    Inertia,
    Param,
    RigidGear,
    Shaft,
    assemble,
    forced,
    lower,
    modal,
    operating_point,
    quantity,
)


class Eccentric(Element):
    """k (1 + e cos 2 phi) between two shafts, phi the angle of the first."""

    a, b = Flange(), Flange()
    k, e = Param("N*m/rad"), Param("1")

    @quantity("N*m")
    def torque(self):
        return self.k * (1 + self.e * sympy.cos(2 * self.a.angle)) * (self.a.angle - self.b.angle)

    def torques(self):
        return {self.a: -self.torque, self.b: self.torque}


DISKS = [Inertia("m", inertia=2.0), Inertia("n", inertia=3.0)]


def line(*more, **speed):
    return Driveline("line", elements=[*DISKS, Eccentric("q", "m", "n", k=100.0, e=0.3), *more], **speed)


def test_the_mean_stiffness_makes_the_mode():
    """sqrt(100 (1/2 + 1/3))/2 pi = 1.4529 Hz; frozen at the angle zero it would be 1.6565 Hz."""
    found = modal(lower(assemble(line(speed=10.0, reference="m"))))
    assert found.frequencies[1] == pytest.approx(math.sqrt(100 * (1 / 2 + 1 / 3)) / (2 * math.pi), rel=1e-12)
    assert found.averaged == ("q",)
    assert "q: the law depends on the angle of a shaft, and is averaged over its turns here" in str(found)


def test_the_static_state_and_the_forced_response_see_the_mean():
    torques = [HarmonicTorque("drive", "m", base="o", mean=6.0, cosine=[1.0]), HarmonicTorque("load", "n", mean=-6.0)]
    model = lower(assemble(line(*torques, speed=10.0, reference="m", bases={"o": ("m", 1)})))
    point = operating_point(model)
    assert point.angle[0] - point.angle[1] == pytest.approx(0.06, rel=1e-12)
    answer = forced(model, [10.0], channels=["q.torque"])
    assert answer.averaged == ("q",)
    omega = 10.0
    reduced = 100.0 / (100.0 - 2.0 * 3.0 / 5.0 * omega**2) * 3.0 / 5.0  # torque of the spring per torque on m
    assert abs(answer.amplitudes[0, 0, 0]) == pytest.approx(abs(reduced), rel=1e-9)


def test_without_an_operating_speed_nothing_turns():
    assert modal(lower(assemble(line()))).frequencies[1] == pytest.approx(math.sqrt(130 * (1 / 2 + 1 / 3)) / (2 * math.pi))
    held = line(GroundSpring("g", "n", stiffness=1.0), speed=10.0, reference="m")
    assert modal(lower(assemble(held))).averaged == ()  # ground holds every shaft at rest in the mean


def test_behind_a_gear_the_law_is_averaged_over_the_turns_of_its_own_shaft():
    parts = [*DISKS, Inertia("w", inertia=1.0), RigidGear("gear", "w", "m", teeth_a=17, teeth_b=53)]
    geared = Driveline("geared", elements=[*parts, Eccentric("q", "m", "n", k=100.0, e=0.3)], speed=10.0, reference="w")
    plain = Driveline("plain", elements=[*parts, Shaft("q", "m", "n", stiffness=100.0)], speed=10.0, reference="w")
    wanted, found = (modal(lower(assemble(each))).frequencies for each in (plain, geared))
    assert np.allclose(found, wanted, rtol=1e-12)
