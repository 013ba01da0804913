"""Method B of ISO 6336-1, and Eq. 1-8 beside it (benchmark G7, computed separately)."""

import math

import numpy as np
import pytest

from modelgen.errors import CaseError, ModelError
from modelgen.gears import Gear, GearMesh, gear_blank_factor, iso6336_stiffness, mesh_stiffness_series

UNIT = 1e9  # N/(mm um) in N/m^2
# module [mm], teeth: contact ratio, largest pair stiffness and mean mesh stiffness by Eq. 1-8, c'_th and c_gamma [N/(mm um)].
G7 = {
    (3, 30, 30): (1.6535, 15.57, 21.38, 16.39, 19.05),
    (3, 50, 50): (1.7547, 17.68, 25.67, 18.02, 22.01),
    (7, 26, 46): (1.6804, 16.09, 22.41, 17.0, 20.03),
    (9, 17, 108): (1.6878, 16.03, 22.33, 17.02, 20.12),
}


def spur(module, teeth_1, teeth_2, **arguments):
    return GearMesh(Gear(teeth_1, 1e-3 * module), Gear(teeth_2, 1e-3 * module), face_width=0.1, **arguments)


@pytest.mark.parametrize("gears", G7)
def test_benchmark(gears):
    mesh = spur(*gears)
    iso = iso6336_stiffness(mesh)
    single = np.max(mesh.pair_stiffness(np.linspace(mesh.contact_start, mesh.contact_end, 2001))) / mesh.face_width
    mean = mesh_stiffness_series(mesh, 0).mean / mesh.face_width
    found = (mesh.transverse_contact_ratio, single / UNIT, mean / UNIT, iso.theoretical / UNIT, iso.mesh / UNIT)
    assert found == pytest.approx(G7[gears], rel=5e-3)
    # The acceptance of the tooth model: in the usual range, and within a fifth of the standard.
    assert 13 < single / UNIT < 19
    assert 18 < mean / UNIT < 27
    assert single == pytest.approx(iso.theoretical, rel=0.2)
    assert mean == pytest.approx(iso.mesh, rel=0.2)


def test_published_helical_pair():
    # z 17/103, m_n 8 mm, b 100 mm, beta 15.8 degrees, x 0.14522/0, rack with h_fP = 1.4: the pair of ISO/TR 6336-30 example 1.
    # Reference values as listed in github.com/gfsReboucas/Drivetrain, ISO_6336.m, example_01.
    helix = math.radians(15.8)
    mesh = GearMesh(
        Gear(17, 0.008, 0.14522, clearance=0.4, helix_angle=helix), Gear(103, 0.008, clearance=0.4, helix_angle=helix), 0.100
    )
    iso = iso6336_stiffness(mesh)
    assert iso.theoretical / UNIT == pytest.approx(17.85584, rel=1e-4)
    assert iso.single / UNIT == pytest.approx(12.37047, rel=1e-4)
    assert iso.mesh / UNIT == pytest.approx(17.46485, rel=5e-4)
    assert iso.mesh_across / UNIT == pytest.approx(14.84512, rel=5e-4)


def test_both_profile_shifts_enter():
    # q' of 25/60 teeth with x 0.3/0.2, the nine terms of the series worked by hand [1e-8 mm um/N].
    terms = [4723000, 622040, 429850, -190500, -139848, -38600, -80627, 47610, 7280]
    iso = iso6336_stiffness(GearMesh(Gear(25, 0.005, 0.3), Gear(60, 0.005, 0.2), 0.05))
    assert iso.theoretical / UNIT == pytest.approx(1e8 / sum(terms), rel=1e-7)


def test_the_pinion_is_found_whichever_gear_drives():
    one, two = Gear(19, 0.005, 0.3), Gear(60, 0.005, -0.1)
    forward, backward = iso6336_stiffness(GearMesh(one, two, 0.05)), iso6336_stiffness(GearMesh(two, one, 0.05))
    assert backward.theoretical == forward.theoretical
    assert backward.mesh == pytest.approx(forward.mesh, rel=1e-13)


def test_softer_material_and_light_load_count():
    steel, iron = iso6336_stiffness(spur(7, 26, 46)), iso6336_stiffness(spur(7, 26, 46, young_modulus=0.59 * 206e9))
    assert iron.single == pytest.approx(0.59 * steel.single)
    assert iron.theoretical == steel.theoretical
    assert iso6336_stiffness(spur(7, 26, 46), line_load=6.25e3).mesh == pytest.approx(steel.mesh / 2)
    assert iso6336_stiffness(spur(7, 26, 46), line_load=500e3) == steel


def test_gear_blank_factor():
    # 1 + ln(0.3) / (5 e^(3/5)), and the limits 0.2 and 1 of web and rim.
    assert gear_blank_factor(0.03, 0.1, 0.015, 0.005) == pytest.approx(0.867849, abs=5e-7)
    assert gear_blank_factor(0.01, 0.1, 0.001, 0.005) == gear_blank_factor(0.02, 0.1, 0.005, 0.005)
    thin = iso6336_stiffness(spur(7, 26, 46), blank_factor=0.9)
    assert thin.mesh == pytest.approx(0.9 * iso6336_stiffness(spur(7, 26, 46)).mesh)


@pytest.mark.parametrize("shifts", [(0.0, 0.2), (-0.26, -0.26)])
def test_profile_shifts_outside_the_standard_are_refused(shifts):
    mesh = GearMesh(Gear(80, 0.005, shifts[0]), Gear(120, 0.005, shifts[1]), 0.05)
    with pytest.raises(
        CaseError, match=r"ISO 6336-1 method B of 80/120 teeth: profile shifts .* are outside the standard's range"
    ):
        iso6336_stiffness(mesh)


@pytest.mark.parametrize("arguments", [{"blank_factor": 0}, {"line_load": -1}, {"line_load": math.nan}])
def test_bad_factors_are_refused(arguments):
    with pytest.raises(ModelError, match=f"{next(iter(arguments))} is .*; give a finite value > 0"):
        iso6336_stiffness(spur(7, 26, 46), **arguments)
