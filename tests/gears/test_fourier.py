"""Eq. 9 for the gears of the reference fracturing truck.

The stored rows of the truck's data set (k0, a, b to seven digits below) are means over 20 000 equidistant phases, midpoints. At
each of the two jumps such a mean is off by up to half a step, 2.5e-5 of the jump: this, not the integration here, is the
distance.
"""

import math
import time

import numpy as np
import pytest

from modelgen.errors import CaseError, ModelError
from modelgen.gears import Gear, GearMesh, fit_series, mesh_stiffness_rows, mesh_stiffness_series, series_errors

# teeth, module [m], width [m]: stored k0 [N/m], then a_1 ... a_10 and b_1 ... b_10 [MN/m].
TRUCK = {
    (26, 46, 0.007, 0.110): (
        2464682994.27,
        [-300.7596, 111.4241, 12.72940, -78.29824, 34.87522, 22.06088, -44.87560, 13.29885, 22.52771, -29.64566],
        [496.4295, 250.5964, 9.844403, 99.84019, 114.5322, 9.921593, 44.90914, 76.76320, 11.93343, 23.42506],
    ),
    (17, 108, 0.009, 0.220): (
        4910206995.54,
        [-577.4802, 193.8000, 49.32113, -151.2712, 42.82928, 63.14187, -78.95313, -1.049739, 57.59921, -41.99039],
        [973.1910, 525.8748, 47.26571, 178.2369, 242.6466, 45.17208, 67.99681, 158.0539, 51.58833, 28.10967],
    ),
    (24, 48, 0.007, 0.110): (
        2435786597.34,
        [-289.8435, 115.4180, 1.754408, -73.95209, 42.26592, 11.69205, -43.41896, 22.40212, 13.27171, -30.70497],
        [501.7815, 239.9802, 9.797655, 109.8615, 106.4454, 6.600170, 55.65840, 70.81221, 6.276150, 34.18158],
    ),
    (18, 108, 0.009, 0.220): (
        4977262642.75,
        [-596.5481, 176.9412, 74.81427, -150.9605, 17.12202, 80.45026, -65.47650, -27.81777, 63.03999, -19.20305],
        [961.4317, 550.7312, 58.83062, 152.6685, 252.9424, 67.19950, 45.39435, 154.5761, 78.82399, 14.28355],
    ),
}


def rows(teeth_1, teeth_2, module, face_width, order=10, **changes):
    arguments = {
        "pressure_angle": math.radians(20),
        "young_modulus": 206e9,
        "poisson_ratio": 0.3,
        "shear_factor": 1.0,
        "profile_shift_1": 0.0,
        "profile_shift_2": 0.0,
    }
    return mesh_stiffness_rows(teeth_1, teeth_2, module, face_width, order=order, **arguments | changes)


def pair(teeth_1, teeth_2, module, face_width):
    return GearMesh(Gear(teeth_1, module), Gear(teeth_2, module), face_width)


@pytest.fixture(scope="module")
def truck_pair():
    return pair(26, 46, 0.007, 0.110)


@pytest.mark.parametrize("gears", TRUCK)
def test_the_rows_of_the_truck(gears):
    mean, cosine, sine = rows(*gears)
    stored_mean, stored_cosine, stored_sine = TRUCK[gears]
    assert mean == pytest.approx(stored_mean, rel=1e-5)
    assert cosine == pytest.approx(1e6 * np.array(stored_cosine), abs=2e-5 * mean)
    assert sine == pytest.approx(1e6 * np.array(stored_sine), abs=2e-5 * mean)


@pytest.mark.parametrize("gears", TRUCK)
def test_the_stored_rows_are_means_of_20000_midpoints(gears):
    mesh = pair(*gears)
    stored_mean, stored_cosine, stored_sine = TRUCK[gears]
    phase = (np.arange(20_000) + 0.5) / 20_000
    stiffness = mesh.stiffness(phase)
    assert np.mean(stiffness) == pytest.approx(stored_mean, rel=1e-11)
    angle = 2 * math.pi * np.arange(1, 11)[:, None] * phase
    assert 2 * np.mean(stiffness * np.cos(angle), axis=1) == pytest.approx(1e6 * np.array(stored_cosine), rel=1e-6)
    assert 2 * np.mean(stiffness * np.sin(angle), axis=1) == pytest.approx(1e6 * np.array(stored_sine), rel=1e-6)


@pytest.mark.parametrize("gears", TRUCK)
def test_the_integration_has_converged(gears):
    mean, cosine, sine = rows(*gears, order=30)
    mesh = pair(*gears)
    finer = fit_series(mesh.stiffness, mesh.breaks, order=200)
    assert mean == pytest.approx(finer.mean, rel=1e-13)
    assert cosine == pytest.approx(finer.cosine[:30], abs=1e-13 * mean)
    assert sine == pytest.approx(finer.sine[:30], abs=1e-13 * mean)


def test_the_integration_has_converged_for_nearly_pointed_teeth():
    # Tip less than 0.02 modules thick: the trapezoid nearly reaches its apex, where Eq. 4 and 5 have a logarithm.
    mesh = GearMesh(Gear(15, 0.005, 0.97), Gear(40, 0.005, tip_shortening=0.2), 0.05)
    assert 0 < mesh.gear_1.tooth.tip_thickness < 0.02 * 0.005
    assert mesh_stiffness_series(mesh, 0).mean == pytest.approx(mesh_stiffness_series(mesh, 200).mean, rel=1e-10)


def test_the_plain_entry_is_the_mesh_with_its_shifts():
    mean, cosine, sine = rows(19, 40, 0.005, 0.050, profile_shift_1=0.4, profile_shift_2=0.1, shear_factor=1.2)
    mesh = GearMesh(Gear(19, 0.005, 0.4), Gear(40, 0.005, 0.1), 0.050, shear_factor=1.2)
    series = mesh_stiffness_series(mesh, 10)
    assert (mean, cosine.tolist(), sine.tolist()) == (series.mean, series.cosine.tolist(), series.sine.tolist())


def test_the_entry_is_deterministic_and_takes_whole_floats():
    one, two = rows(26, 46, 0.007, 0.110), rows(26.0, 46.0, 0.007, 0.110, order=10.0)
    assert one[0].hex() == two[0].hex()
    assert one[1].tobytes() + one[2].tobytes() == two[1].tobytes() + two[2].tobytes()


def test_the_entry_takes_less_than_5_ms():
    durations = []
    for _ in range(20):
        start = time.perf_counter()
        rows(26, 46, 0.007, 0.110)
        durations.append(time.perf_counter() - start)
    assert min(durations) < 5e-3


def test_the_series_comes_back_from_its_own_values(truck_pair):
    series = mesh_stiffness_series(truck_pair, 4)
    again = fit_series(series, [0.0], order=6)
    assert again.mean == pytest.approx(series.mean, rel=1e-13)
    assert again.cosine == pytest.approx([*series.cosine, 0, 0], abs=1e-13 * series.mean)
    assert again.sine == pytest.approx([*series.sine, 0, 0], abs=1e-13 * series.mean)


def test_the_rms_error_falls_while_the_largest_stays(truck_pair):
    errors = series_errors(truck_pair, 30)
    assert errors.order.tolist() == list(range(31))
    assert np.all(np.diff(errors.rms) < 0)
    # Worked figures for 26/46: 10.7, 5.2, 4.07 and 2.3 percent, the largest near 21.
    assert errors.rms[[1, 5, 10, 30]] == pytest.approx([0.107, 0.052, 0.0407, 0.023], abs=5e-4)
    assert np.all(np.abs(errors.maximum[4:] - 0.21) < 0.015)


def test_the_largest_error_is_half_the_larger_jump(truck_pair):
    # A Fourier series goes through the middle of a jump.
    jumps = truck_pair.pair_stiffness(np.array([truck_pair.contact_start, truck_pair.contact_end]))
    series = mesh_stiffness_series(truck_pair, 0)
    assert series_errors(truck_pair, 60).maximum[-1] == pytest.approx(np.max(jumps) / 2 / series.mean, rel=0.01)


def test_the_rms_error_is_what_parseval_leaves(truck_pair):
    errors, series = series_errors(truck_pair, 12), mesh_stiffness_series(truck_pair, 12)
    removed = np.cumsum(series.cosine**2 + series.sine**2) / 2 / series.mean**2
    assert errors.rms[0] ** 2 - errors.rms[1:] ** 2 == pytest.approx(removed, rel=1e-11)


@pytest.mark.parametrize("order", [-1, 2.5, 501, math.nan, "ten"])
def test_a_bad_order_is_refused(order):
    with pytest.raises(CaseError, match=r"mesh stiffness series: order is .*; give a whole number from 0 to 500"):
        rows(26, 46, 0.007, 0.110, order=order)


def test_the_entry_refuses_gears_that_cannot_run():
    with pytest.raises(ModelError, match=r"gear: teeth is 26\.5; give a whole number"):
        rows(26.5, 46, 0.007, 0.110)
