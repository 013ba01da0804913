import math

import pytest

from modelgen.errors import ModelError
from modelgen.gears import Gear, GearMesh, mesh_phase, phase_between


def circular(one, two):
    """Distance of two phases on the circle."""
    return abs((one - two + 0.5) % 1.0 - 0.5)


def test_one_tooth_is_one_period():
    assert mesh_phase(26, 2 * math.pi / 26 * 3.25, phase_at_zero=0.5) == pytest.approx(0.75)
    assert mesh_phase(46, -2 * math.pi / 46 * 0.25) == pytest.approx(0.75)
    assert mesh_phase(10, -1e-30) == 0.0


def test_both_gears_of_a_pair_count_the_same_phase():
    rotation = 0.4321
    assert circular(mesh_phase(26, rotation), mesh_phase(46, rotation * 26 / 46)) < 1e-12


@pytest.mark.parametrize(("teeth", "planets"), [(24, 3), (25, 3), (26, 4), (31, 5)])
def test_planets_on_a_sun(teeth, planets):
    # Parker and Lin 2004: the n-th planet's mesh lags by z psi_n / (2 pi).
    for planet in range(planets):
        lag = phase_between(Gear(teeth, 0.003), 2 * math.pi * planet / planets)
        assert circular(lag, -teeth * planet / planets) < 1e-12


def rotation_until_contact(gear, flank_1, radius_1, flank_2, radius_2, angle):
    """Turn a gear, all its teeth spelled out, from contact at the first pitch point to the next one at the second."""
    center = -flank_1 * gear.half_angle(radius_1)  # so that the first flank of tooth 0 lies at angle 0
    flanks = [center + 2 * math.pi * tooth / gear.teeth + flank_2 * gear.half_angle(radius_2) for tooth in range(gear.teeth)]
    return min((angle - flank) % (2 * math.pi) for flank in flanks)


@pytest.mark.parametrize("idler", [False, True])
@pytest.mark.parametrize("angle", [0.7, 2.0, math.pi, 5.1])
def test_two_meshes_on_one_gear_by_spelling_out_the_teeth(idler, angle):
    gear = Gear(23, 0.004, 0.2)
    radii = 0.0462, 0.0470
    turned = rotation_until_contact(gear, -1 if idler else 1, radii[0], 1, radii[1], angle)
    phase = phase_between(gear, angle, *radii, idler=idler)
    assert circular(phase + gear.teeth * turned / (2 * math.pi), 0) < 1e-9


def test_pitch_phase_lies_inside_the_contact():
    mesh = GearMesh(Gear(26, 0.007), Gear(46, 0.007), 0.110)
    assert 0 < mesh.pitch_phase < mesh.transverse_contact_ratio
    # Recess and approach change places with the driver.
    back = GearMesh(mesh.gear_2, mesh.gear_1, 0.110)
    assert back.pitch_phase == pytest.approx(mesh.transverse_contact_ratio - mesh.pitch_phase, rel=1e-12)


@pytest.mark.parametrize("radius", [0.0, 0.040, 0.06])
def test_a_pitch_radius_beside_the_flank_is_refused(radius):
    with pytest.raises(ModelError, match=r"mesh phase of 23 teeth: pitch radius is .*; give a finite value >= 0\.0432"):
        phase_between(Gear(23, 0.004), 1.0, pitch_radius_1=radius)
