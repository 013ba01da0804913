import math

import numpy as np
import pytest

from modelgen.errors import CaseError, ModelError
from modelgen.gears import equivalent_mass, mesh_damping

# The truck's gears: J1, J2 [kg m^2], r_b1, r_b2 [m], k0 [N/m].
MESH_A = (3.2, 2.0, 0.0855120, 0.1512905), 2.464662e9
MESH_B = (0.55, 95.0, 0.0718865, 0.4566906), 4.910195e9


def test_equivalent_mass_gives_the_frequency_of_two_free_gears():
    # Free-free pair: the elastic frequency squared is k (r1^2/J1 + r2^2/J2).
    (one, two, radius_1, radius_2), stiffness = MESH_A
    arm = np.array([radius_1, -radius_2])
    squared_frequencies = np.linalg.eigvals(stiffness * np.outer(arm / [one, two], arm))
    assert np.max(squared_frequencies) == pytest.approx(stiffness / equivalent_mass(one, two, radius_1, radius_2), rel=1e-12)


@pytest.mark.parametrize(("mesh", "local_mode"), [(MESH_A, 926), (MESH_B, 1201)])
def test_corrected_damping_is_the_ratio_of_critical(mesh, local_mode):
    gears, stiffness = mesh
    mass = equivalent_mass(*gears)
    frequency = math.sqrt(stiffness / mass)
    assert frequency / (2 * math.pi) == pytest.approx(local_mode, abs=0.6)
    assert mesh_damping(stiffness, *gears) / (2 * mass * frequency) == pytest.approx(0.1, rel=1e-12)


@pytest.mark.parametrize(("mesh", "times"), [(MESH_A, 69), (MESH_B, 174)])
def test_the_printed_form_is_69_to_174_times_smaller(mesh, times):
    gears, stiffness = mesh
    assert mesh_damping(stiffness, *gears) / mesh_damping(stiffness, *gears, form="literal") == pytest.approx(times, abs=0.5)


def test_the_printed_form_is_eq_10():
    (one, two, radius_1, radius_2), stiffness = MESH_A
    printed = stiffness * one * two * radius_1**2 * radius_2**2 / (radius_1**2 * one + radius_2**2 * two)
    damping = mesh_damping(stiffness, one, two, radius_1, radius_2, damping_ratio=0.17, form="literal")
    assert damping == pytest.approx(0.34 * math.sqrt(printed), rel=1e-14)


def test_damping_follows_the_root_of_the_stiffness():
    gears, stiffness = MESH_A
    assert mesh_damping(stiffness * np.array([[1.0, 4.0, 0.0]]), *gears) == pytest.approx(
        mesh_damping(stiffness, *gears) * np.array([[1.0, 2.0, 0.0]])
    )


def test_an_unknown_form_is_refused():
    with pytest.raises(CaseError, match="mesh damping: there is no form 'litteral'; nearest is 'literal'"):
        mesh_damping(1e9, *MESH_A[0], form="litteral")


@pytest.mark.parametrize(
    ("position", "value", "words"),
    [
        (0, -1e9, r"stiffness is -1e\+09 N/m at its lowest; give finite values >= 0"),
        (0, math.nan, "stiffness is nan"),
        (1, 0, r"inertia_1 is 0 kg\*m\^2; give a finite value"),
        (3, 85.5e3, r"base_radius_1 is 85500\.0 m; give a finite value"),
        (5, -0.1, r"damping_ratio is -0\.1"),
    ],
)
def test_bad_numbers_are_refused(position, value, words):
    arguments = [1e9, *MESH_A[0], 0.1]
    arguments[position] = value
    with pytest.raises(ModelError, match=words):
        mesh_damping(*arguments)
