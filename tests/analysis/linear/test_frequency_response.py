"""Frequency response: against dense complex solutions and closed forms, and where it is refused."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.analysis.linear.frequency_response import frequency_response
from modelgen.errors import CaseError


def chain(rng, n):
    """M, C, K of a free chain with random disks, shafts and drag."""
    mass = np.diag(rng.uniform(0.1, 2.0, n))
    stiffness, damping = np.zeros((n, n)), np.diag(rng.uniform(0.0, 1.0, n))
    for i in range(n - 1):
        pair = np.zeros(n)
        pair[i : i + 2] = 1, -1
        stiffness += rng.uniform(1e4, 1e6) * np.outer(pair, pair)
        damping += rng.uniform(1.0, 9.0) * np.outer(pair, pair)
    return mass, damping, stiffness


def by_dense_solution(mass, damping, stiffness, omega, force, hysteresis=0.0):
    return np.array(
        [
            np.linalg.solve(stiffness + 1j * hysteresis + 1j * w * damping - w**2 * mass, f)
            for w, f in zip(omega, force.T, strict=True)
        ]
    ).T


@pytest.mark.parametrize("n", [1, 2, 7, 40])
def test_a_chain_against_dense_solutions(n: int) -> None:
    rng = np.random.default_rng(n)
    mass, damping, stiffness = chain(rng, n)
    omega = np.concatenate(
        [np.linspace(1, 3000, 60), np.sqrt(np.linalg.eigvals(stiffness / np.diag(mass)[:, None]).real[:1]) + 0.1]
    )
    force = rng.standard_normal((n, len(omega))) + 1j * rng.standard_normal((n, len(omega)))
    found = frequency_response(mass, damping, stiffness, omega, force, 0.02 * stiffness)
    expected = by_dense_solution(mass, damping, stiffness, omega, force, 0.02 * stiffness)
    assert np.abs(found - expected).max(axis=0) == pytest.approx(0, abs=1e-9 * np.abs(expected).max())


def test_full_and_unsymmetric_matrices() -> None:
    rng = np.random.default_rng(5)
    mass, damping, stiffness = chain(rng, 12)
    damping = damping + rng.standard_normal((12, 12))
    stiffness[0, 11] += 700.0
    omega, force = np.linspace(10, 900, 30), rng.standard_normal((12, 30))
    expected = by_dense_solution(mass, damping, stiffness, omega, force)
    assert frequency_response(mass, damping, stiffness, omega, force) == pytest.approx(expected, rel=1e-8, abs=1e-18)


def test_a_pivot_of_zero_is_no_obstacle() -> None:
    """At sqrt(k/J) the end disk by itself has no dynamic stiffness; elimination from the end would divide by zero."""
    mass, stiffness = np.diag([1.0, 3.0, 1.0]), np.array([[400.0, -400, 0], [-400, 1300, -900], [0, -900, 900]])
    omega, force = np.array([20.0, 30.0, 17.0]), np.array([1.0, 0.0, 0.0])
    found = frequency_response(mass, np.zeros((3, 3)), stiffness, omega, force)
    expected = by_dense_solution(mass, np.zeros((3, 3)), stiffness, omega, np.tile(force[:, None], 3))
    assert found == pytest.approx(expected, rel=1e-10, abs=1e-18)


def test_the_frequency_of_an_undamped_mode_is_refused() -> None:
    with pytest.raises(CaseError, match="20 rad/s is the frequency of an undamped mode; add damping"):
        frequency_response(np.eye(1) * 2, np.zeros((1, 1)), np.eye(1) * 800, np.array([10.0, 20.0]), np.array([1.0]))


def test_shapes_that_do_not_fit_are_refused() -> None:
    with pytest.raises(CaseError, match=r"does not fit: .* give \(n, n\) matrices"):
        frequency_response(np.eye(2), np.eye(2), np.eye(2), np.array([1.0]), np.ones((3, 1)))
