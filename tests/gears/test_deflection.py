"""Eq. 3-6 and 8 against worked figures (z = 26 and 46, m = 7 mm, E = 206 GPa, nu = 0.3) and against their own integrals."""

import math

import numpy as np
import pytest

from modelgen.errors import ModelError
from modelgen.gears import Gear, contact_deflection, tooth_deflection

YOUNG, POISSON = 206e9, 0.3
PICO = 1e12


def deflection(gear, radius, shear_factor=1.0):
    return tooth_deflection(gear.tooth, radius, YOUNG, POISSON, shear_factor)


def test_worked_figures_at_the_pitch_point():
    parts = deflection(Gear(26, 0.007), 0.091)
    assert PICO * parts.rectangle == pytest.approx(4.8011, abs=5e-5)
    assert PICO * parts.trapezoid == pytest.approx(1.2160, abs=5e-5)
    assert PICO * parts.shear == pytest.approx(8.6256, abs=5e-5)
    assert PICO * parts.foundation == pytest.approx(16.0901, abs=5e-5)
    assert PICO * parts.total == pytest.approx(30.7329, abs=5e-5)
    assert PICO * deflection(Gear(46, 0.007), 0.161).total == pytest.approx(25.9753, abs=5e-5)
    assert PICO * contact_deflection(YOUNG, POISSON) == pytest.approx(5.6245, abs=5e-5)


@pytest.mark.parametrize(
    ("teeth", "shift", "height"), [(26, 0.0, 0.0), (26, 0.0, 0.9), (17, 0.0, 0.0), (108, 0.0, -0.5), (20, 0.4, 0.8)]
)
def test_bending_and_shear_are_the_integrals_of_a_cantilever(teeth, shift, height):
    gear = Gear(teeth, 0.007, shift)
    tooth, radius = gear.tooth, gear.reference_radius + height * gear.module
    parts = deflection(gear, radius)
    load, rectangle = float(tooth.load_height(radius)), tooth.rectangle_height
    nodes, weights = np.polynomial.legendre.leggauss(60)
    component = math.cos(float(tooth.load_angle(radius))) ** 2

    def integral(function, start, end):
        y = start + (end - start) * (nodes + 1) / 2
        return (end - start) / 2 * float(weights @ function(y))

    def width(y):
        slope = (tooth.root_thickness - tooth.tip_thickness) / (tooth.height - rectangle)
        return tooth.root_thickness - slope * (y - rectangle)

    shear_modulus = YOUNG / (2 * (1 + POISSON))
    bend = 12 * component / YOUNG
    straight = integral(lambda y: (load - y) ** 2, 0, rectangle) / tooth.root_thickness**3
    tapered = integral(lambda y: (load - y) ** 2 / width(y) ** 3, rectangle, load)
    assert parts.rectangle == pytest.approx(bend * straight, rel=1e-12)
    assert parts.trapezoid == pytest.approx(bend * tapered, rel=1e-12)
    sheared = rectangle / tooth.root_thickness + integral(lambda y: 1 / width(y), rectangle, load)
    assert parts.shear == pytest.approx(component / shear_modulus * sheared, rel=1e-12)


def test_the_shear_factor_multiplies_the_shear_alone():
    literal, timoshenko = deflection(Gear(26, 0.007), 0.091), deflection(Gear(26, 0.007), 0.091, shear_factor=1.2)
    assert timoshenko.total - literal.total == pytest.approx(0.2 * literal.shear, rel=1e-12)


def test_below_the_start_of_the_involute_the_rectangle_ends_at_the_load():
    gear = Gear(26, 0.007)
    start = gear.involute_start_radius
    below = deflection(gear, start - 1e-4)
    load = gear.tooth.load_height(start - 1e-4)
    component = math.cos(gear.tooth.load_angle(start - 1e-4)) ** 2
    assert below.trapezoid == 0
    assert below.rectangle == pytest.approx(4 * component * load**3 / (YOUNG * gear.tooth.root_thickness**3), rel=1e-12)
    # No jump where the rule changes.
    assert deflection(gear, start - 1e-12).total == pytest.approx(deflection(gear, start + 1e-12).total, rel=1e-8)


@pytest.mark.parametrize("radius", [0.080, 0.0981, math.nan])
def test_a_load_beside_the_flank_is_refused(radius):
    with pytest.raises(ModelError, match=r"the load is not on the flank; give radii from 0\.085512 to 0\.098 m"):
        deflection(Gear(26, 0.007), radius)
