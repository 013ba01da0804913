import math

import numpy as np
import pytest

from modelgen.errors import ModelError
from modelgen.gears import Gear, GearMesh, contact_deflection, tooth_deflection

PAIR = GearMesh(Gear(26, 0.007), Gear(46, 0.007), face_width=0.110)
HIGH = GearMesh(Gear(60, 0.004, addendum=1.35), Gear(80, 0.004, addendum=1.35), face_width=0.050)  # contact ratio above 2
SHIFTED = GearMesh(Gear(19, 0.005, 0.4), Gear(40, 0.005, 0.1), face_width=0.050)


@pytest.mark.parametrize(
    ("teeth", "ratio"),
    # The reference truck's pairs and the two of benchmark G7, to the digits given there.
    [
        ((26, 46), 1.680378021540319),
        ((17, 108), 1.687793188132352),
        ((24, 48), 1.674705148191976),
        ((18, 108), 1.695275780851538),
        ((30, 30), pytest.approx(1.6535, abs=5e-5)),
        ((50, 50), pytest.approx(1.7547, abs=5e-5)),
    ],
)
def test_contact_ratio(teeth, ratio):
    mesh = GearMesh(*(Gear(number, 0.007) for number in teeth), face_width=0.1)
    assert mesh.transverse_contact_ratio == (ratio if not isinstance(ratio, float) else pytest.approx(ratio, rel=1e-14))
    assert mesh.total_contact_ratio == mesh.transverse_contact_ratio
    assert mesh.overlap_ratio == 0


def test_unshifted_gears_run_at_the_reference_center_distance():
    assert PAIR.center_distance == pytest.approx(0.252, rel=1e-15)
    assert math.degrees(PAIR.working_pressure_angle) == pytest.approx(20, rel=1e-14)
    assert PAIR.ratio == 46 / 26


def test_shifted_teeth_fill_the_pitch_circle_without_backlash():
    # At the working pitch circles the two thicknesses add up to the pitch: the definition of the backlash-free center distance.
    radius_1 = SHIFTED.center_distance / (1 + SHIFTED.ratio)
    angle_1 = 2 * float(SHIFTED.gear_1.tooth.half_angle(radius_1))
    angle_2 = 2 * float(SHIFTED.gear_2.tooth.half_angle(SHIFTED.center_distance - radius_1))
    assert angle_1 * radius_1 + angle_2 * radius_1 * SHIFTED.ratio == pytest.approx(2 * math.pi * radius_1 / 19, rel=1e-13)


def test_pair_stiffness_at_the_pitch_point():
    # Worked figure 16.04 N/(mm um) = 1 / (30.7329 + 25.9753 + 5.6245) per pm.
    pitch_point = PAIR.contact_start + PAIR.pitch_phase * PAIR.base_pitch
    assert pitch_point == pytest.approx(0.091 * math.sin(math.radians(20)), rel=1e-14)
    assert PAIR.pair_stiffness(pitch_point) / PAIR.face_width == pytest.approx(1e12 / (30.7329 + 25.9753 + 5.6245), rel=1e-5)


def test_pair_stiffness_adds_the_deflections_of_both_load_points():
    position = np.linspace(PAIR.contact_start, PAIR.contact_end, 7)
    radius_1 = np.sqrt(PAIR.gear_1.base_radius**2 + position**2)
    radius_2 = np.sqrt(PAIR.gear_2.base_radius**2 + (0.252 * math.sin(math.radians(20)) - position) ** 2)
    sum_of_three = (
        tooth_deflection(PAIR.gear_1.tooth, radius_1, 206e9, 0.3).total
        + tooth_deflection(PAIR.gear_2.tooth, radius_2, 206e9, 0.3).total
        + contact_deflection(206e9, 0.3)
    )
    assert PAIR.pair_stiffness(position) == pytest.approx(0.110 / sum_of_three, rel=1e-12)


def test_no_stiffness_beside_the_path_of_contact():
    assert PAIR.pair_stiffness(np.array([PAIR.contact_start - 1e-6, PAIR.contact_end + 1e-6])).tolist() == [0, 0]


@pytest.mark.parametrize("mesh", [PAIR, SHIFTED, HIGH])
def test_the_mesh_is_the_sum_of_the_pairs_in_contact(mesh):
    phase = np.array([0.0, 0.1, 0.35, 0.6, 0.85, 0.999])
    start, pitch = mesh.contact_start, mesh.base_pitch
    summed = sum(mesh.pair_stiffness(start + (phase + pair) * pitch) for pair in range(4))
    assert mesh.stiffness(phase) == pytest.approx(summed, rel=1e-14)
    assert mesh.stiffness(phase - 5) == pytest.approx(mesh.stiffness(phase), rel=1e-12)


def test_above_a_contact_ratio_of_two_two_pairs_always_carry():
    assert HIGH.transverse_contact_ratio > 2
    weakest = np.min(HIGH.pair_stiffness(np.linspace(HIGH.contact_start, HIGH.contact_end, 50)))
    assert np.min(HIGH.stiffness(np.linspace(0, 1, 50))) > 2 * weakest


def test_a_pair_enters_at_phase_zero_and_leaves_at_the_fractional_contact_ratio():
    left, right = (PAIR.stiffness(np.array([phase - 1e-9, phase + 1e-9])) for phase in PAIR.breaks)
    assert left[1] - left[0] == pytest.approx(float(PAIR.pair_stiffness(PAIR.contact_start)), rel=1e-6)
    assert right[0] - right[1] == pytest.approx(float(PAIR.pair_stiffness(PAIR.contact_end)), rel=1e-6)


def test_the_driven_gear_driving_runs_the_path_backward():
    back = GearMesh(SHIFTED.gear_2, SHIFTED.gear_1, SHIFTED.face_width)
    phase = np.linspace(0.01, 0.99, 30)
    ratio = SHIFTED.transverse_contact_ratio
    assert back.stiffness(ratio - phase) == pytest.approx(SHIFTED.stiffness(phase), rel=1e-12)


def test_stiffness_is_proportional_to_width_and_modulus():
    double = GearMesh(PAIR.gear_1, PAIR.gear_2, 2 * PAIR.face_width, 3 * PAIR.young_modulus)
    assert double.stiffness(0.2) == pytest.approx(6 * PAIR.stiffness(0.2), rel=1e-13)


def test_a_shear_factor_of_1_2_takes_four_to_five_percent():
    phases = (np.arange(2000) + 0.5) / 2000
    timoshenko = GearMesh(PAIR.gear_1, PAIR.gear_2, PAIR.face_width, shear_factor=1.2)
    assert 0.04 < 1 - np.mean(timoshenko.stiffness(phases)) / np.mean(PAIR.stiffness(phases)) < 0.05


def test_the_offered_tip_shortening_cures_the_interference():
    shifted = Gear(20, 0.005, 0.9)
    with pytest.raises(ModelError, match=r"touch 20 teeth below the start .* tip_shortening of at least 0\.017"):
        GearMesh(shifted, Gear(40, 0.005), 0.05)
    cured = GearMesh(shifted, Gear(40, 0.005, tip_shortening=0.017), 0.05)
    assert cured.contact_start >= shifted.involute_start_roll
    assert cured.gear_2.tip_radius == pytest.approx(0.1 + 0.983 * 0.005)


@pytest.mark.parametrize(
    ("gear_1", "gear_2", "arguments", "words"),
    [
        (
            Gear(26, 0.007),
            Gear(46, 0.008),
            {},
            r"gear mesh 26/46: the gears differ in module \(0\.007 and 0\.008\); give both the same",
        ),
        (Gear(26, 0.007), Gear(46, 0.007, helix_angle=0.1), {}, "differ in helix_angle"),
        (
            Gear(26, 0.007),
            Gear(46, 0.007),
            {"face_width": -0.1},
            r"face_width is -0\.1 m; give a finite value >= 1e-06 m and < 10 m",
        ),
        (Gear(26, 0.007), Gear(46, 0.007), {"face_width": 110}, "face_width is 110 m"),
        (Gear(26, 0.007), Gear(46, 0.007), {"young_modulus": 206}, "young_modulus is 206 Pa"),
        (
            Gear(26, 0.007),
            Gear(46, 0.007),
            {"poisson_ratio": 0.6},
            r"poisson_ratio is 0\.6; give a finite value >= 0 and <= 0\.5",
        ),
        (Gear(26, 0.007), Gear(46, 0.007), {"shear_factor": math.nan}, "shear_factor is nan"),
        (
            Gear(30, 0.005, -0.65),
            Gear(30, 0.005, -0.65),
            {},
            r"no backlash-free center distance with profile shifts -0\.65 and -0\.65; raise their sum",
        ),
        (
            Gear(40, 0.005, addendum=0.5),
            Gear(40, 0.005, addendum=0.5),
            {},
            r"contact ratio is 0\.\d+, below 1: the teeth lose contact",
        ),
        (
            Gear(14, 0.005),
            Gear(100, 0.005),
            {},
            r"the tips of 100 teeth touch 14 teeth below the start of the involute .*; give the 100 teeth a tip_shortening of",
        ),
        (
            Gear(60, 0.005, 0.4, clearance=0),
            Gear(60, 0.005, 0.4, clearance=0),
            {},
            r"the tips of 60 teeth strike the root circle of 60 \(clearance -0\.\d+ m\); raise clearance or tip_shortening",
        ),
    ],
)
def test_gears_that_cannot_mesh_are_refused(gear_1, gear_2, arguments, words):
    with pytest.raises(ModelError, match=words):
        GearMesh(gear_1, gear_2, **{"face_width": 0.1} | arguments)
