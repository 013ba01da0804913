"""The section of one tooth; the worked figures of z = 26, m = 7 mm, 20 degrees were computed separately."""

import math

import pytest

from modelgen.errors import ModelError
from modelgen.gears import Gear, Tooth

TOOTH = Tooth(teeth=26, module=7.0, profile_shift=0.0, pressure_angle=math.radians(20), addendum=1.0, clearance=0.25)


@pytest.mark.parametrize(
    ("name", "millimeters"),
    [
        ("base_radius", 85.5120),
        ("involute_start_radius", 86.1736),
        ("root_thickness", 12.8590),
        ("tip_thickness", 5.0661),
        ("height", 15.9689),
        ("rectangle_height", 3.9351),
        ("apex_height", 23.7920),
    ],
)
def test_worked_figures(name, millimeters):
    assert getattr(TOOTH, name) == pytest.approx(millimeters, abs=5e-5)


def test_load_at_the_pitch_point():
    assert TOOTH.load_height(TOOTH.reference_radius) == pytest.approx(8.8357, abs=5e-5)
    assert math.degrees(TOOTH.load_angle(TOOTH.reference_radius)) == pytest.approx(16.5385, abs=5e-5)


def test_half_a_pitch_is_tooth_on_the_reference_circle():
    assert 2 * TOOTH.half_angle(TOOTH.reference_radius) * TOOTH.teeth == pytest.approx(math.pi)


def test_thickness_and_heights_meet_the_tip_and_the_root_line():
    assert TOOTH.load_height(TOOTH.tip_radius) == pytest.approx(TOOTH.height, rel=1e-14)
    assert TOOTH.load_height(TOOTH.involute_start_radius) == pytest.approx(TOOTH.rectangle_height, rel=1e-13)
    # The sides of the trapezoid meet at the apex.
    slope = (TOOTH.root_thickness - TOOTH.tip_thickness) / (TOOTH.height - TOOTH.rectangle_height)
    assert TOOTH.root_thickness - slope * (TOOTH.apex_height - TOOTH.rectangle_height) == pytest.approx(0, abs=1e-12)


def test_seventeen_teeth_start_at_the_base_circle():
    # 17 teeth lie just under the theoretical limit of 17.097: t < 0.
    gear = Gear(17, 0.009)
    assert gear.tooth.involute_start_roll == 0
    assert gear.involute_start_radius == gear.base_radius


@pytest.mark.parametrize("teeth", [14, 15, 16])
def test_slight_undercut_is_allowed(teeth):
    assert Gear(teeth, 0.005).tooth.root_thickness > 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            {"teeth": 12},
            r"gear with 12 teeth: undercut reaches the flank .*; use more teeth or a profile_shift of at least 0\.123",
        ),
        ({"teeth": 17, "profile_shift": 1.2}, "the teeth are pointed below the tip circle; reduce profile_shift or addendum"),
        (
            {"teeth": 10, "addendum": 0.2, "pressure_angle": 0.35, "profile_shift": -0.5},
            r"the section is no tooth \(root thickness 0\.00635 m, tip thickness 0\.006353 m",
        ),
        (
            {"teeth": 40, "addendum": 0.1, "profile_shift": -2},
            "the tip circle lies below the start of the involute; raise addendum",
        ),
    ],
)
def test_impossible_teeth_are_refused(arguments, words):
    with pytest.raises(ModelError, match=words):
        Gear(module=0.005, **arguments)


def test_the_offered_profile_shift_cures_the_undercut():
    assert Gear(12, 0.005, profile_shift=0.123).teeth == 12
