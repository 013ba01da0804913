"""Which damped pair belongs to which mode: against small steps of growing damping, and where the answer is plain."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from modelgen import Driveline, GroundDamper, Inertia, Shaft, assemble, lower, modal
from modelgen.analysis.linear.mode_pairing import followed, is_upper


def compiled(*elements, **settings):
    return lower(assemble(Driveline("line", elements=elements, **settings)))


def by_small_steps(undamped: np.ndarray, damped: np.ndarray, count: int, steps: int = 20_000) -> np.ndarray:
    """Eigenvalues at full damping in the order of the undamped pairs: each goes on from the nearest before, step by step."""
    values = np.linalg.eigvals(undamped)
    values = values[values.imag > 0]
    track = values[np.argsort(values.imag)]
    for step in range(1, steps + 1):
        now = np.linalg.eigvals(undamped + step / steps * (damped - undamped))
        # The assignment with the least sum of distances, of the few that there are.
        best = min(itertools.permutations(range(len(now)), count), key=lambda p: np.abs(now[list(p)] - track).sum())
        track = now[list(best)]
    return track


def first_order(squares: np.ndarray, damping: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    n = len(squares)
    undamped = np.block([[np.zeros((n, n)), np.eye(n)], [-np.diag(squares), np.zeros((n, n))]])
    damped = undamped.copy()
    damped[n:, n:] = -damping
    return undamped, damped


@pytest.mark.parametrize("seed", range(12))
def test_pairs_are_those_that_small_steps_lead_to(seed: int) -> None:
    rng = np.random.default_rng(seed)
    squares = np.sort(rng.uniform(0.5, 2.0, 2)) ** 2
    root = rng.standard_normal((2, 2))
    undamped, damped = first_order(squares, rng.uniform(0.02, 0.3) * root @ root.T)
    values, _, owner = followed(undamped, damped, np.array([0, 1, 0, 1]))
    wanted = by_small_steps(undamped, damped, 2, steps=2000)
    for mode in range(2):
        mine = values[(owner == mode) & is_upper(values)]
        assert np.abs(mine - wanted[mode]).min() < 1e-9


def test_a_heavily_damped_mode_may_fall_below_its_neighbor() -> None:
    """10.0 Hz hardly damped, 11.0 Hz by 0.6: its damped frequency of 8.8 Hz is the lower one, and stays its own."""
    result = modal(
        compiled(
            Inertia("a", inertia=1.0), Inertia("b", inertia=1000.0), Inertia("c", inertia=1.0),
            Shaft("s1", "a", "b", stiffness=3948.0, damping="value", damping_coefficient=0.01),
            Shaft("s2", "b", "c", stiffness=4777.0, damping="value", damping_coefficient=82.9),
        )
    )  # fmt: skip
    light, heavy = result.damped(1), result.damped(2)
    assert light.ratio == pytest.approx(0.01 / 2 / np.sqrt(3948), rel=1e-2)
    assert heavy.ratio == pytest.approx(82.9 / 2 / np.sqrt(4777), rel=1e-2)
    assert heavy.frequency < light.frequency
    assert result.pair.tolist() == [-1, 1, 0]


def test_an_overdamped_mode_is_listed_and_leaves_the_others_their_ratios() -> None:
    """A viscous damper on a soft spring: two real rates; the elastic mode keeps 0.074."""
    model = compiled(
        Inertia("r", inertia=1.0), Inertia("e", inertia=2.0), Inertia("g", inertia=5.0),
        Shaft("damper", "r", "e", stiffness=1e3, damping="value", damping_coefficient=300.0),
        Shaft("s", "e", "g", stiffness=1e5, damping_ratio=0.01),
        reference="e",
    )  # fmt: skip
    result = modal(model)
    slow, fast = result.damped(1).rates
    assert result.damped(1).ratio is None
    assert (slow, fast) == (pytest.approx(3.366, rel=1e-3), pytest.approx(416.5, rel=1e-3))
    assert slow * fast == pytest.approx(1402, rel=1e-2)  # near k (1/J_r + 1/J_e) less what the shaft lends
    assert result.damped(2).ratio == pytest.approx(0.07408, rel=1e-3)
    assert "overdamped, rates 3.366 and 416.5 1/s" in str(result)
    every = np.linalg.eigvals(_state_matrix())
    assert sorted([slow, fast]) == pytest.approx(sorted(-every[np.abs(every.imag) < 1e-9].real)[-2:], rel=1e-9)


def _state_matrix() -> np.ndarray:
    c = 2 * 0.01 * np.sqrt(1e5 * 2 * 5 / 7)
    mass = np.diag([1.0, 2.0, 5.0])
    damper, shaft = np.array([1.0, -1.0, 0.0]), np.array([0.0, 1.0, -1.0])
    stiffness = 1e3 * np.outer(damper, damper) + 1e5 * np.outer(shaft, shaft)
    damping = 300.0 * np.outer(damper, damper) + c * np.outer(shaft, shaft)
    lower_rows = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    return np.vstack([np.hstack([np.zeros((3, 3)), np.eye(3)]), lower_rows])


def test_every_mode_has_one_pair_or_two_rates_whatever_is_damped() -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        disks = [Inertia(f"d{n}", inertia=float(rng.uniform(0.5, 3))) for n in range(5)]
        coefficients = 10 ** rng.uniform(-1, 3.2, 4)
        shafts = [
            Shaft(f"s{n}", f"d{n}", f"d{n + 1}", stiffness=float(10 ** rng.uniform(3, 5)), damping="value", damping_coefficient=c)
            for n, c in enumerate(coefficients.tolist())
        ]
        result = modal(compiled(*disks, *shafts, GroundDamper("bearing", "d2", damping=5.0)))
        told = [result.damped(mode) for mode in range(1, 5)]
        pairs = [int(result.pair[mode]) for mode in range(1, 5) if result.pair[mode] >= 0]
        assert sorted(pairs) == list(range(len(result.damped_frequencies)))
        assert all((each.rates is None) != (each.ratio is None) for each in told)


def test_repeated_frequencies_share_their_pairs_out() -> None:
    """Three equal blades on a hub, damped unequally: two modes of one frequency, three pairs, each taken once."""
    blades = [Inertia(f"blade_{n}", inertia=0.5) for n in range(3)]
    stems = [
        Shaft(f"stem_{n}", "hub", f"blade_{n}", stiffness=2e4, damping="value", damping_coefficient=1.0 + n) for n in range(3)
    ]
    result = modal(compiled(Inertia("hub", inertia=2.0), *blades, *stems))
    assert sorted(result.pair[1:].tolist()) == [0, 1, 2]


def test_proportional_damping_pairs_by_formula() -> None:
    disks = [Inertia(f"d{n}", inertia=1.0 + n) for n in range(6)]
    shafts = [
        Shaft(f"s{n}", f"d{n}", f"d{n + 1}", stiffness=1e4 * (1 + n), damping="value", damping_coefficient=30.0 * (1 + n))
        for n in range(5)
    ]
    result = modal(compiled(*disks, *shafts))  # C = 3e-3 K
    for mode in range(1, 6):
        omega = 2 * np.pi * result.frequencies[mode]
        own = result.damped(mode)
        if 1.5e-3 * omega < 1:
            assert own.ratio == pytest.approx(1.5e-3 * omega, rel=1e-9)
        else:
            root = np.sqrt((1.5e-3 * omega) ** 2 - 1)
            assert own.rates == pytest.approx((omega * (1.5e-3 * omega - root), omega * (1.5e-3 * omega + root)), rel=1e-8)


def test_an_undamped_mode_has_a_ratio_of_exactly_zero() -> None:
    result = modal(compiled(Inertia("a", inertia=3.0), Inertia("b", inertia=1.0), Shaft("s", "a", "b", stiffness=3e5)))
    assert result.damped(1).ratio == 0.0
    assert not np.signbit(result.damping_ratios).any()
    assert not np.signbit(result.decay_rates).any()


def test_a_creeping_mode_keeps_a_window_waiting() -> None:
    """An overdamped mode is a thousandth of itself after ln(1000) / its slower rate."""
    from modelgen import HarmonicTorque, operating_point
    from modelgen.analysis import settled_window

    model = compiled(
        Inertia("r", inertia=1.0), Inertia("e", inertia=2.0), Inertia("g", inertia=5.0),
        Shaft("damper", "r", "e", stiffness=1e3, damping="value", damping_coefficient=300.0),
        Shaft("s", "e", "g", stiffness=1e5, damping_ratio=0.01), HarmonicTorque("t", "e", base="turn", cosine=[1.0]),
        reference="e", speed="600 rpm", bases={"turn": 1},
    )  # fmt: skip
    window = settled_window(model, operating_point(model))
    assert window.first == pytest.approx(np.ceil(np.log(1e3) / 3.366 * 10) / 10)
