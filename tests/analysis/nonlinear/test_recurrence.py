"""Recurrence of sequences: periods, transients, and what must not pass for a period."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.analysis.nonlinear.recurrence import departures, recurrence


@pytest.mark.parametrize("period", [1, 2, 3, 7, 16])
def test_the_smallest_period_counts(period: int) -> None:
    sequence = np.tile(np.arange(period, dtype=float)[:, None], (100 // period, 1))
    found = recurrence(sequence, 1e-9)
    assert (found.period, found.first, found.residual) == (period, 0, 0.0)


def test_period_17_is_none() -> None:
    found = recurrence(np.tile(np.arange(17.0)[:, None], (10, 1)), 1e-9)
    assert found.period == 0
    assert found.residual > 0.5


def test_the_transient_ends_where_departures_do() -> None:
    decay = 10.0 ** -np.arange(60.0)[:, None]
    found = recurrence(decay, 1e-6)
    # 10^-k differs from the last one, which is nothing, by 10^-k.
    assert (found.period, found.first) == (1, 6)


def test_a_slow_creep_is_no_period() -> None:
    creep = 1e-7 * np.arange(100.0)[:, None]
    assert recurrence(creep, 1e-6).period == 0
    assert np.abs(np.diff(creep, axis=0)).max() < 1e-6


def test_swinging_while_settling_is_no_period_2() -> None:
    k = np.arange(60)
    swinging = (3e-6 * (-0.99) ** k)[:, None]
    assert recurrence(swinging, 1e-6).period == 0
    assert recurrence(swinging * 20, 1e-4).period == 1


def test_a_large_motion_is_held_against_its_own_size() -> None:
    rng = np.random.default_rng(1)
    noisy = 100 * np.ones((50, 1)) + 1e-5 * rng.uniform(-1, 1, size=(50, 1))
    assert recurrence(noisy, 1e-6).period == 1
    assert recurrence(noisy - 100, 1e-6).period == 0


def test_departures_are_from_the_last_of_the_same_phase() -> None:
    assert departures(np.array([[0.0], [5.0], [1.0], [5.5]]), 2).tolist() == [1.0, 0.5, 0.0, 0.0]


def test_few_strobes_prove_nothing() -> None:
    assert recurrence(np.zeros((15, 2)), 1e-6).period == 0
    assert recurrence(np.zeros((16, 2)), 1e-6).period == 1
