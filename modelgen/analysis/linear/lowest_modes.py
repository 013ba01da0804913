"""The lowest modes of a large driveline, by subspace iteration on sparse matrices; dense matrices are never formed.

Below ``modal``. Rigid rotations are known and taken out; each iteration solves (K + s M) X' = M X along the driveline
(``elimination``) and takes the Ritz vectors of the result. In the end the negative pivots of K - m M count the modes below m, so
none is missed, repeated ones included. NumPy suffices: no sparse library is needed.
Source: K.-J. Bathe, Finite Element Procedures (1996), sec. 11.6 (subspace iteration, Sturm sequence check).
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.elimination import Elimination, Factors
from modelgen.analysis.linear.natural_modes import Modes
from modelgen.errors import CaseError

Array = NDArray[np.float64]
ITERATIONS = 100
SOLUTIONS = 2  # between one Ritz analysis and the next
STILL = 1e-14  # relative change of an eigenvalue in one iteration that is rounding


def lowest_modes(mass: ca.DM, stiffness: ca.DM, rigid: Array, count: int) -> Modes:
    """The ``count`` lowest modes, rigid ones (columns of ``rigid``) included; ``mass``, ``stiffness`` sparse and symmetric.

    Raises CaseError where the iteration does not find them all.
    """
    n, free = rigid.shape
    factor_at = _factorization(mass, stiffness)
    if free:
        rigid = np.asarray(np.linalg.solve(np.linalg.cholesky(rigid.T @ (mass @ rigid).full()), rigid.T).T)
    wanted = max(0, min(count, n) - free)
    squares, shapes = np.zeros(0), np.zeros((n, 0))
    width = min(n - free, max(2 * wanted, wanted + 8))
    while wanted:
        squares, shapes = _iterate(mass, stiffness, rigid, wanted, width, factor_at)
        # Just above the last mode wanted, or above all that are as good as equal to it.
        above = squares[wanted - 1] * (1 + 1e-7)
        found = free + int(np.sum(squares < above))
        below = int(np.sum(factor_at(-above).pivots < 0))
        if found == below:
            break
        if width == n - free or found > below:
            raise CaseError("lowest modes", f"found {found} modes where there are {below}", "ask for all modes")
        width = min(n - free, 2 * width)
    squares, shapes = squares[:wanted], shapes[:, :wanted]
    return Modes(np.concatenate([np.zeros(free), squares]), np.hstack([rigid, shapes]), free)


def _factorization(mass: ca.DM, stiffness: ca.DM) -> Callable[[float], Factors]:
    """A function that factors K + s M for any shift s; the order and fill are found once."""
    n = mass.shape[0]
    both = ca.DM(mass.sparsity() + stiffness.sparsity(), 1)
    rows, columns = (np.array(each, dtype=np.intp) for each in both.sparsity().get_triplet())
    elimination = Elimination(n, rows, columns)
    slots = elimination.slots_of(rows, columns)
    entries = [np.array((each + 0 * both).nonzeros()) for each in (mass, stiffness)]

    def factor_at(shift: float) -> Factors:
        values = np.zeros((elimination.slots, 1))
        values[slots, 0] = entries[1] + shift * entries[0]
        return elimination.factor(values)

    return factor_at


def _iterate(
    mass: ca.DM, stiffness: ca.DM, rigid: Array, wanted: int, width: int, factor_at: Callable[[float], Factors]
) -> tuple[Array, Array]:
    """Ritz values and vectors of a subspace of some width, when the lowest ones wanted have settled."""
    n = len(rigid)
    weighted = (mass @ rigid).full() if rigid.size else rigid
    x = np.random.default_rng(0).standard_normal((n, width))
    diagonal = np.array(ca.diag(stiffness)).ravel() / np.array(ca.diag(mass)).ravel()
    shift = 1e-6 * float(np.abs(diagonal).max())
    factors = factor_at(shift)
    known = np.full(width, np.inf)
    for iteration in range(ITERATIONS):
        for _ in range(SOLUTIONS):
            x = factors.solve((mass @ x).full())
            x -= rigid @ (weighted.T @ x)
            x /= np.sqrt((x * x).sum(axis=0))
        inner_mass, inner_stiffness = x.T @ (mass @ x).full(), x.T @ (stiffness @ x).full()
        lower = np.linalg.cholesky((inner_mass + inner_mass.T) / 2)
        symmetric = np.linalg.solve(lower, np.linalg.solve(lower, (inner_stiffness + inner_stiffness.T) / 2).T)
        squares, vectors = np.linalg.eigh((symmetric + symmetric.T) / 2)
        x = x @ np.linalg.solve(lower.T, vectors)
        change = np.abs(squares - known)[:wanted] / np.abs(squares[:wanted])
        if change.max() < STILL or (iteration > 10 and change.max() < 1e-11):
            return squares, x
        if iteration == 1 and squares[0] > 0:
            shift = float(squares[0])  # now that the size of the lowest is known, the best of safe shifts
            factors = factor_at(shift)
        known = squares
    raise CaseError("lowest modes", f"do not settle in {ITERATIONS} iterations", "ask for more modes, or for all")
