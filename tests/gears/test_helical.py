import math

import numpy as np
import pytest

from modelgen.gears import (
    Gear,
    GearMesh,
    fit_series,
    iso6336_stiffness,
    mesh_stiffness_series,
    series_errors,
    stiffness_variation,
)


def helical(helix_degrees, face_width, teeth=(26, 46)):
    helix = math.radians(helix_degrees)
    return GearMesh(*(Gear(number, 0.007, helix_angle=helix) for number in teeth), face_width=face_width)


def width_for_overlap(helix_degrees, overlap):
    return overlap * math.pi * 0.007 / math.sin(math.radians(helix_degrees))


def test_contact_ratios_of_a_published_helical_pair():
    # Geometry of ISO/TR 6336-30 example 1: z 17/103, m_n 8, b 100, beta 15.8 degrees, x 0.145 (0.14522 at a = 500 mm).
    helix = math.radians(15.8)
    mesh = GearMesh(
        Gear(17, 0.008, 0.14522, clearance=0.4, helix_angle=helix), Gear(103, 0.008, clearance=0.4, helix_angle=helix), 0.100
    )
    assert mesh.center_distance == pytest.approx(0.5, abs=1e-7)
    assert mesh.overlap_ratio == pytest.approx(0.1 * math.sin(helix) / (math.pi * 0.008))
    assert mesh.total_contact_ratio == mesh.transverse_contact_ratio + mesh.overlap_ratio


@pytest.mark.parametrize("overlap", [0.3, 0.9, 1.08, 2.5])
def test_the_stack_is_the_mean_of_many_slices(overlap):
    mesh = helical(15, width_for_overlap(15, overlap))
    assert mesh.overlap_ratio == pytest.approx(overlap)
    phase = np.linspace(0, 1, 9)
    lags = overlap * (np.arange(4000) + 0.5) / 4000
    slices = np.mean(mesh.slice_stiffness(phase[:, None] - lags), axis=1)
    assert mesh.stiffness(phase) == pytest.approx(slices, rel=3e-4)


@pytest.mark.parametrize(("helix", "width"), [(15.8, 0.100), (5.0, 0.02), (30.0, 0.110)])
def test_the_rows_of_the_stack_are_those_of_its_stiffness(helix, width):
    mesh = helical(helix, width)
    by_sinc, by_quadrature = mesh_stiffness_series(mesh, 12), fit_series(mesh.stiffness, mesh.breaks, 12)
    assert by_sinc.mean == pytest.approx(by_quadrature.mean, rel=1e-12)
    assert by_sinc.cosine == pytest.approx(by_quadrature.cosine, abs=1e-12 * by_sinc.mean)
    assert by_sinc.sine == pytest.approx(by_quadrature.sine, abs=1e-12 * by_sinc.mean)


@pytest.mark.parametrize("overlap", [1, 2, 3])
def test_a_whole_overlap_ratio_leaves_no_variation(overlap):
    variation = stiffness_variation(helical(20, width_for_overlap(20, overlap)))
    assert variation.peak_to_peak < 1e-12


def test_overlap_smooths():
    stacks = [helical(20, width_for_overlap(20, overlap)) for overlap in (0.01, 0.25, 0.5, 0.75)]
    roughness = [stiffness_variation(stack).peak_to_peak for stack in stacks]
    assert roughness == sorted(roughness, reverse=True)
    assert roughness[0] > 0.4 > 0.2 > roughness[-1]


def test_the_mean_per_width_does_not_depend_on_the_overlap():
    means = [mesh_stiffness_series(helical(20, width), 0).mean / width for width in (0.01, 0.05, 0.11)]
    assert means == pytest.approx([means[0]] * 3, rel=1e-12)


@pytest.mark.parametrize("helix_degrees", [1e-9, 1e-6, 1e-4])
def test_a_vanishing_helix_is_a_spur_gear(helix_degrees):
    almost, spur = helical(helix_degrees, 0.110), helical(0, 0.110)
    phase = np.array([0.1, 0.4, 0.8])
    assert almost.stiffness(phase) == pytest.approx(spur.stiffness(phase), rel=1e-6)


def test_without_jumps_the_largest_error_falls_too():
    errors = series_errors(helical(20, width_for_overlap(20, 0.5)), 20)
    assert errors.maximum[20] < errors.maximum[5] / 2 < errors.maximum[1] / 4


@pytest.mark.parametrize("helix", [8, 15, 25, 30])
def test_the_mean_is_within_a_fifth_of_iso_6336(helix):
    mesh = helical(helix, 0.110)
    assert mesh_stiffness_series(mesh, 0).mean / mesh.face_width == pytest.approx(iso6336_stiffness(mesh).mesh, rel=0.2)
