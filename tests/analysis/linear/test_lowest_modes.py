"""The sparse path: elimination on trees and loops, and the lowest modes of large drivelines against all modes of small ones."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen import Driveline, Inertia, RigidGear, Shaft, assemble, lower, modal, operating_point
from modelgen.analysis.linear.elimination import Elimination

COUNT = 150


def large(damping: float = 0.0) -> Driveline:
    """A chain with a branch at every tenth disk and one gear: a tree of 165 disks."""
    disks = [Inertia(f"disk_{n}", inertia=1.0 + 0.3 * (n % 7)) for n in range(COUNT)]
    shafts = [
        Shaft(f"shaft_{n}", f"disk_{n}", f"disk_{n + 1}", stiffness=1e6 * (1 + 0.1 * (n % 5)), damping_ratio=damping)
        for n in range(COUNT - 1)
        if n != 100
    ]
    gear = RigidGear("gear", "disk_100", "disk_101", teeth_a=31, teeth_b=17)
    twigs = [Inertia(f"twig_{n}", inertia=0.5) for n in range(0, COUNT, 10)]
    stems = [Shaft(f"stem_{n}", f"disk_{n}", f"twig_{n}", stiffness=3e5, damping_ratio=damping) for n in range(0, COUNT, 10)]
    return Driveline("large", elements=(*disks, *shafts, gear, *twigs, *stems))


@pytest.fixture(scope="module")
def model():
    return lower(assemble(large(damping=0.01)))


def test_the_lowest_modes_are_those_of_all(model) -> None:
    """With the point given, the dense path is taken."""
    every, some = modal(model, point=operating_point(model), count=12), modal(model, count=12)
    assert some.frequencies[0] == 0.0
    assert some.frequencies[1:] == pytest.approx(every.frequencies[1:], rel=1e-11)
    assert np.abs(some.shapes) == pytest.approx(np.abs(every.shapes), abs=1e-5)
    assert some.potential == pytest.approx(every.potential, abs=1e-5)
    assert some.kinetic.sum(axis=0) == pytest.approx(1)
    assert not some.complete
    assert some.damping_ratios == pytest.approx(every.damping_ratios, rel=1e-6)


@pytest.mark.slow
def test_damping_projected_on_the_lowest_modes_is_good_where_it_is_light(model) -> None:
    assert modal(model, count=12).damping_ratios == pytest.approx(modal(model).damping_ratios[:11], rel=1e-3)


def test_repeated_modes_are_not_missed() -> None:
    """Twenty equal branches of eight disks on a hub: each frequency of a branch clamped at the hub comes 19 times."""
    elements = [Inertia("hub", inertia=5.0)]
    for branch in range(20):
        before = "hub"
        for n in range(8):
            name = f"disk_{branch}_{n}"
            elements += [Inertia(name, inertia=0.2), Shaft(f"shaft_{branch}_{n}", before, name, stiffness=1e4)]
            before = name
    result = modal(lower(assemble(Driveline("star", elements=tuple(elements)))), count=23)
    # Clamped-free chain: 2 sqrt(k/J) sin((2j - 1) pi / (2 (2n + 1))).
    clamped = 2 * np.sqrt(1e4 / 0.2) * np.sin(np.pi * np.array([1, 3]) / 34) / (2 * np.pi)
    assert result.frequencies[1:20] == pytest.approx(clamped[0], rel=1e-11)
    assert result.repeated[0] == tuple(range(1, 20))
    assert result.frequencies[20] > clamped[0] * 1.01
    assert result.frequencies[21:] == pytest.approx(clamped[1], rel=1e-11)


def random_matrix(rng, size, extra):
    """A symmetric, diagonally dominant matrix on a random tree with some extra entries."""
    matrix = np.zeros((size, size))
    pairs = [(n, int(rng.integers(n))) for n in range(1, size)] + [tuple(rng.integers(size, size=2)) for _ in range(extra)]
    for i, j in pairs:
        if i != j:
            matrix[i, j] = matrix[j, i] = rng.standard_normal()
    return matrix + np.diag(np.abs(matrix).sum(axis=1) + 1)


@pytest.mark.parametrize("extra", [0, 8])
def test_elimination_solves(extra: int) -> None:
    rng = np.random.default_rng(extra)
    matrix = random_matrix(rng, 30, extra)
    rows, columns = np.nonzero(matrix)
    elimination = Elimination(30, rows, columns)
    values = np.zeros((elimination.slots, 1))
    values[elimination.slots_of(rows, columns), 0] = matrix[rows, columns]
    right = rng.standard_normal((30, 3))
    assert elimination.factor(values).solve(right) == pytest.approx(np.linalg.solve(matrix, right), abs=1e-12)
    if not extra:
        assert elimination.slots == 3 * 30 - 2  # a tree does not fill in
        assert elimination.work == 2 * 29


def test_negative_pivots_count_negative_eigenvalues() -> None:
    rng = np.random.default_rng(3)
    matrix = random_matrix(rng, 25, 4)
    rows, columns = np.nonzero(matrix)
    elimination = Elimination(25, rows, columns)
    slots, diagonal = elimination.slots_of(rows, columns), elimination.slots_of(np.arange(25), np.arange(25))
    eigenvalues = np.linalg.eigvalsh(matrix)
    shifts = (eigenvalues[1:] + eigenvalues[:-1]) / 2
    values = np.zeros((elimination.slots, len(shifts)))
    values[slots] = matrix[rows, columns][:, None]
    values[diagonal] -= shifts
    assert (elimination.factor(values).pivots < 0).sum(axis=0).tolist() == list(range(1, 25))


@pytest.mark.slow
def test_a_thousand_degrees_of_freedom() -> None:
    n = 1000
    line = Driveline(
        "thousand",
        elements=(
            *(Inertia(f"disk_{i}", inertia=0.2) for i in range(n)),
            *(Shaft(f"shaft_{i}", f"disk_{i}", f"disk_{i + 1}", stiffness=3e4) for i in range(n - 1)),
        ),
    )
    result = modal(lower(assemble(line)), count=20)
    exact = 2 * np.sqrt(3e4 / 0.2) * np.sin(np.arange(20) * np.pi / (2 * n)) / (2 * np.pi)
    assert result.frequencies == pytest.approx(exact, rel=1e-9, abs=0)
