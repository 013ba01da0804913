"""Gaussian elimination on the graph of a driveline, for many matrices of one pattern at a time.

Below the questions of ``linear``. A driveline is nearly a tree: eliminated from the leaves on, it fills in next to
nothing, and one pass costs as many operations as there are shafts. Every operation acts on all matrices at once (all
frequencies, or all shifts), which takes the place of a loop over them. There is no pivoting: who uses it checks residuals.
Sources: S. Parter, SIAM Rev. 3 (1961) 119 (trees do not fill in); A. George, J. W. H. Liu, Computer Solution of Large Sparse
Positive Definite Systems (1981), ch. 5 (minimum degree).
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class _Step:
    """Eliminates ``node``: its uneliminated ``neighbors``, and the slots of column, row and the entries they change."""

    node: int
    neighbors: Indices
    column: Indices
    row: Indices
    changed: Indices


class Elimination:
    """Order and fill of an elimination for all matrices (n, n) whose entries lie at ``rows``, ``columns`` or their mirror images.

    ``slots`` counts the entries that a matrix needs with its fill; ``work`` the multiplications of one factorization.

    >>> chain = Elimination(3, np.array([0, 1, 1, 2]), np.array([1, 0, 2, 1]))
    >>> chain.slots, chain.work  # a chain of three does not fill in
    (7, 4)
    """

    def __init__(self, size: int, rows: Indices, columns: Indices) -> None:
        self.size = size
        near: list[set[int]] = [set() for _ in range(size)]
        for i, j in zip(rows.tolist(), columns.tolist(), strict=True):
            if i != j:
                near[i].add(j)
                near[j].add(i)
        self._slot: dict[tuple[int, int], int] = {(i, i): i for i in range(size)}
        self.steps: list[_Step] = []
        waiting = [(len(each), node) for node, each in enumerate(near)]
        heapq.heapify(waiting)
        done = [False] * size
        while waiting:
            degree, k = heapq.heappop(waiting)
            if done[k] or degree != len(near[k]):
                continue  # an older entry; the current one is still in the heap
            done[k] = True
            around = sorted(near[k])
            for i in around:
                near[i].discard(k)
                near[i].update(j for j in around if j != i)
            for i in around:
                heapq.heappush(waiting, (len(near[i]), i))
            self.steps.append(
                _Step(
                    k,
                    np.array(around, dtype=np.intp),
                    np.array([self._at(i, k) for i in around], dtype=np.intp),
                    np.array([self._at(k, i) for i in around], dtype=np.intp),
                    np.array([self._at(i, j) for i in around for j in around], dtype=np.intp),
                )
            )
        self.slots = len(self._slot)
        self.work = sum(len(step.neighbors) + len(step.changed) for step in self.steps)

    def _at(self, row: int, column: int) -> int:
        return self._slot.setdefault((row, column), len(self._slot))

    def slots_of(self, rows: Indices, columns: Indices) -> Indices:
        """Slot of each entry of a matrix."""
        return np.array([self._slot[i, j] for i, j in zip(rows.tolist(), columns.tolist(), strict=True)], dtype=np.intp)

    def factor(self, values: Array) -> Factors:
        """Factors of the matrices with ``values`` (slots, matrices), real or complex. A zero pivot leaves infinities behind."""
        left = values.copy()
        lower: list[Array] = []
        with np.errstate(all="ignore"):
            for step in self.steps:
                factors = left[step.column] / left[step.node]
                left[step.changed] -= (factors[:, None] * left[step.row]).reshape(len(step.changed), left.shape[1])
                lower.append(factors)
        return Factors(self, lower, left)


@dataclass(frozen=True, eq=False)
class Factors:
    """What a factorization leaves: multipliers of each step, and the upper part; ``pivots`` (n, matrices)."""

    elimination: Elimination
    lower: list[Array]
    upper: Array

    @property
    def pivots(self) -> Array:
        """Pivots by node. For symmetric matrices, as many are negative as there are negative eigenvalues (Sylvester)."""
        return self.upper[: self.elimination.size]

    def solve(self, right: Array) -> Array:
        """Solutions (n, columns); one column per matrix, or any number of columns for a single matrix."""
        x = np.array(right, dtype=np.result_type(right, self.upper))
        with np.errstate(all="ignore"):
            for step, factors in zip(self.elimination.steps, self.lower, strict=True):
                x[step.neighbors] -= factors * x[step.node]
            for step in reversed(self.elimination.steps):
                x[step.node] = (x[step.node] - (self.upper[step.row] * x[step.neighbors]).sum(axis=0)) / self.upper[step.node]
        return x
