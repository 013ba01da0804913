"""Outputs between steps: exact for polynomials of degree five, of sixth order otherwise, whatever the grid."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.solvers.dense_output import BLOCK, HERMITE, DenseOutput

QUINTIC = np.polynomial.Polynomial([3.0, -1.0, 2.0, 0.5, -4.0, 1.5])
SLOPE = QUINTIC.deriv()


def nodes(*times: float) -> np.ndarray:
    return np.array([[function(time)] for time in times for function in (QUINTIC, SLOPE)])


def test_a_quintic_is_reproduced() -> None:
    start, end = 0.3, 1.1
    times = np.linspace(start, end, 33)
    weights = HERMITE.weights((times - start) / (end - start))
    weights[1::2] *= end - start
    assert weights.T @ nodes(start, 0.7, end).ravel() == pytest.approx(QUINTIC(times), abs=5e-14)


@pytest.mark.parametrize("count", [1, 7, 1000, 20_000])
def test_any_grid_over_any_steps(count: int) -> None:
    ends = np.cumsum(np.geomspace(1e-4, 1e-2, 3 * BLOCK + 5))
    times = np.linspace(0.0, ends[-1], count + 1)[1:]
    output = DenseOutput(times, 0.0, 1)
    recorded, before = 0, 0.0
    for end in ends:
        if output.next_time <= end:
            output.record(before, end - before, end, nodes(before), nodes(0.5 * (before + end), end))
            recorded += 1
        before = end
    assert output.reached()[:, 0] == pytest.approx(QUINTIC(times), rel=1e-12)
    assert recorded <= min(count, ends.size)
    assert output.next_time == np.inf


def test_only_what_was_passed_is_given_back() -> None:
    output = DenseOutput(np.array([0.0, 0.5, 1.0, 1.5]), 0.0, 1)
    assert output.reached().tolist() == [[0.0]]  # the start, in coordinates that count from it
    output.record(0.0, 1.0, 1.0, nodes(0.0), nodes(0.5, 1.0))
    assert output.reached()[1:, 0] == pytest.approx(QUINTIC(np.array([0.5, 1.0])), rel=1e-14)
    assert output.next_time == 1.5
