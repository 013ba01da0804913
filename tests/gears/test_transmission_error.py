import math

import numpy as np
import pytest

from modelgen.errors import ModelError
from modelgen.gears import Gear, GearMesh, MeshError, static_transmission_error

PAIR = GearMesh(Gear(26, 0.007), Gear(46, 0.007), face_width=0.110)
TORQUE = 6442.0


def test_the_lag_is_force_over_stiffness_plus_error():
    error = MeshError(amplitude=10e-6, mean=2e-6, angle=0.3)
    loaded = static_transmission_error(PAIR, TORQUE, error)
    force = TORQUE / PAIR.gear_1.base_radius
    expected = force / PAIR.stiffness(loaded.phase) + 2e-6 + 10e-6 * np.sin(2 * math.pi * loaded.phase + 0.3)
    assert loaded.value == pytest.approx(expected, rel=1e-13)


def test_it_is_the_equilibrium_of_the_loaded_flank_whatever_the_backlash():
    # Eq. 12: k (delta - b) = F with delta = TE - e + b.
    loaded = static_transmission_error(PAIR, TORQUE, MeshError(amplitude=10e-6))
    force = TORQUE / PAIR.gear_1.base_radius
    for half_backlash in (0.0, 75e-6):
        delta = loaded.value + half_backlash - MeshError(amplitude=10e-6)(loaded.phase)
        assert PAIR.stiffness(loaded.phase) * (delta - half_backlash) == pytest.approx(np.full(delta.shape, force), rel=1e-9)


def test_mean_and_peak_to_peak():
    loaded = static_transmission_error(PAIR, TORQUE)
    midpoints = (np.arange(20_000) + 0.5) / 20_000
    lag = TORQUE / PAIR.gear_1.base_radius / PAIR.stiffness(midpoints)
    assert loaded.mean == pytest.approx(np.mean(lag), rel=5e-5)
    assert loaded.peak_to_peak == pytest.approx(np.ptp(lag), rel=1e-4)
    assert loaded.peak_to_peak >= np.ptp(lag)
    with_error = static_transmission_error(PAIR, TORQUE, MeshError(amplitude=10e-6, mean=3e-6))
    assert with_error.mean == pytest.approx(loaded.mean + 3e-6, rel=1e-12)


def test_without_error_it_is_proportional_to_the_torque():
    one, two = static_transmission_error(PAIR, TORQUE), static_transmission_error(PAIR, 2 * TORQUE)
    assert two.value == pytest.approx(2 * one.value, rel=1e-14)
    assert two.peak_to_peak == pytest.approx(2 * one.peak_to_peak, rel=1e-12)


@pytest.mark.parametrize("torque", [0.0, -1.0, math.inf])
def test_an_unloaded_flank_is_refused(torque):
    with pytest.raises(ModelError, match=r"static transmission error: torque_1 is .*; give a finite value > 0"):
        static_transmission_error(PAIR, torque)


def test_a_negative_amplitude_is_refused():
    with pytest.raises(ModelError, match=r"mesh error: amplitude is -1e-05 m; give a finite value >= 0"):
        MeshError(amplitude=-1e-5)
