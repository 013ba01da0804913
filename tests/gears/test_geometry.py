import math

import numpy as np
import pytest

from modelgen.errors import ModelError
from modelgen.gears import Gear


def test_a_whole_float_counts_as_teeth():
    assert Gear(26.0, 0.007) == Gear(26, 0.007)
    assert isinstance(Gear(26.0, 0.007).teeth, int)
    assert Gear(np.int64(26), np.float64(0.007)) == Gear(26, 0.007)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"teeth": 26.5}, r"gear: teeth is 26\.5; give a whole number from 3"),
        ({"teeth": -40}, "teeth is -40; give a whole number"),
        ({"teeth": True}, "teeth is True; give a whole number"),
        ({"teeth": 10**400}, "teeth is 1000.*; give a whole number"),
        ({"module": 7}, r"gear with 26 teeth: module is 7 m; give a finite value >= 1e-06 m and < 1 m"),
        ({"module": math.nan}, "module is nan; give a finite value"),
        ({"module": "7 mm"}, "module is '7 mm'; give a finite value"),
        ({"pressure_angle": 20}, r"pressure_angle is 20 rad; give a finite value >= 0\.1 rad and <= 0\.8 rad"),
        ({"helix_angle": -0.2}, r"helix_angle is -0\.2 rad"),
        ({"profile_shift": math.inf}, "profile_shift is inf"),
        ({"addendum": 0}, "addendum is 0; give a finite value > 0"),
        ({"clearance": -0.1}, r"clearance is -0\.1; give a finite value >= 0"),
    ],
)
def test_bad_numbers_are_refused_by_name(arguments, words):
    with pytest.raises(ModelError, match=words):
        Gear(**{"teeth": 26, "module": 0.007} | arguments)


def test_virtual_teeth_of_a_published_helical_pair():
    # z 17/103, m_n 8, beta 15.8 degrees, x 0.145: 18.905 and 114.543, the geometry of ISO/TR 6336-30 example 1.
    helix = math.radians(15.8)
    assert Gear(17, 0.008, 0.145, helix_angle=helix).virtual_teeth == pytest.approx(18.905, abs=5e-4)
    assert Gear(103, 0.008, helix_angle=helix).virtual_teeth == pytest.approx(114.543, abs=5e-4)


def test_helical_identities():
    gear = Gear(31, 0.004, 0.2, helix_angle=0.4)
    # ISO 21771: tan(beta_b) = tan(beta) cos(alpha_t); sin(alpha_n) = sin(alpha_t) cos(beta_b).
    assert math.tan(gear.base_helix_angle) == pytest.approx(math.tan(0.4) * math.cos(gear.transverse_pressure_angle), rel=1e-14)
    sine = math.sin(gear.transverse_pressure_angle) * math.cos(gear.base_helix_angle)
    assert math.sin(gear.pressure_angle) == pytest.approx(sine, rel=1e-14)
    # Start of the involute, straight from the transverse rack.
    angle = gear.transverse_pressure_angle
    start = gear.reference_radius * math.sin(angle) - (1 - 0.2) * gear.module / math.sin(angle)
    assert gear.involute_start_roll == pytest.approx(start, rel=1e-13)
    assert gear.tip_radius == pytest.approx(gear.reference_radius + 1.2 * gear.module, rel=1e-15)
    assert gear.root_radius == pytest.approx(gear.reference_radius - 1.05 * gear.module, rel=1e-15)


def test_the_flank_of_the_section_begins_and_ends_with_the_transverse_one():
    gear = Gear(31, 0.004, 0.2, helix_angle=0.4)
    ends = gear.section_radius(np.array([gear.involute_start_roll, gear.tip_roll]))
    assert ends == pytest.approx([gear.tooth.involute_start_radius, gear.tooth.tip_radius], rel=1e-14)


def test_a_spur_gear_is_its_own_section():
    gear = Gear(26, 0.007)
    assert gear.tooth.tip_radius == gear.tip_radius
    assert gear.section_radius(0.03) == pytest.approx(math.hypot(gear.base_radius, 0.03), rel=1e-15)
    assert gear.half_angle(0.09) == pytest.approx(float(gear.tooth.half_angle(0.09)), rel=1e-14)
