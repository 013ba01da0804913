import numpy as np
import pytest

from modelgen.gears.piecewise import gauss_nodes, pieces, sample_phases, window_average


def test_pieces_of_rounding_length_are_left_out():
    assert pieces([0.0, 1e-15, 0.25, 1.25, -0.25]) == [(1e-15, 0.25), (0.25, 0.75), (0.75, 1.0)]


def test_a_step_times_a_wave_is_integrated_to_rounding():
    phases, weights = gauss_nodes([0.0, 0.3], waves=12)
    step = np.where(phases < 0.3, 2.0, 1.0)
    assert weights @ step == pytest.approx(1.3, rel=1e-14)
    assert weights @ (step * np.sin(2 * np.pi * 12 * phases)) == pytest.approx(
        (1 - np.cos(2 * np.pi * 3.6)) / (24 * np.pi), abs=1e-15
    )


def test_samples_see_both_sides_of_a_jump():
    values = np.where(sample_phases([0.0, 0.3], per_period=4) < 0.3, 2.0, 1.0)
    assert {1.0, 2.0} == set(values)
    close = np.abs(sample_phases([0.0, 0.3], per_period=4) - 0.3) < 1e-12
    assert sorted(values[close]) == [1.0, 2.0]


@pytest.mark.parametrize("width", [1e-9, 0.2, 0.5, 1.0, 1.7, 3.0])
def test_the_average_over_a_window_is_exact_for_a_saw(width):
    phase = np.array([-0.4, 0.0, 0.1, 0.75, 12.3])

    def antiderivative(x):  # of x mod 1
        return np.floor(x) / 2 + (x % 1.0) ** 2 / 2

    expected = (antiderivative(phase) - antiderivative(phase - width)) / width
    assert window_average(lambda x: x % 1.0, [0.0], width, phase)[1:] == pytest.approx(expected[1:], abs=1e-14 + 1e-15 / width)
