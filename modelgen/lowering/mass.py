"""The mass matrix as sparse terms over groups, and M x = b solved block by block.

Part of ``lower``, below ``fixed`` and ``forces``. A driveline of shafts and gears has a diagonal mass matrix; planetary sets,
and inertias that depend on the angles of several shafts, couple a few groups each. Such a block is symmetric and positive
definite, so elimination needs no pivoting. G. Golub, C. Van Loan, Matrix Computations, 4th ed., sec. 4.2.
"""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

Terms = dict[tuple[int, int], ca.SX]
"""Entries of a sparse matrix by row and column."""


def add(terms: Terms, key: tuple[int, int], value: ca.SX) -> None:
    """Adds to an entry."""
    terms[key] = terms.get(key, ca.SX(0)) + value


def matrix_of(terms: Terms, size: int) -> ca.SX:
    """The square matrix of the terms."""
    matrix = ca.SX(size, size)
    for (row, column), value in terms.items():
        matrix[row, column] += value
    return matrix


def blocks_of(mass: Terms) -> list[list[int]]:
    """Groups that the mass matrix couples, each block in order."""
    block = {group: {group} for pair in mass for group in pair}
    for a, b in mass:
        if block[a] is not block[b]:
            block[a] |= block[b]
            for group in block[b]:
                block[group] = block[a]
    return [sorted(each) for each in {id(each): each for each in block.values()}.values()]


def solve_symmetric(mass: Terms, right: Mapping[int, ca.SX]) -> dict[int, ca.SX]:
    """x of M x = b for the groups of every block that b touches; M is symmetric and positive definite.

    >>> two, one = ca.SX(2), ca.SX(1)
    >>> x = solve_symmetric({(0, 0): two, (0, 1): one, (1, 0): one, (1, 1): two, (2, 2): two}, {0: ca.SX(3)})
    >>> {group: float(each) for group, each in x.items()}
    {0: 2.0, 1: -1.0}
    """
    found: dict[int, ca.SX] = {}
    for block in blocks_of(mass):
        if any(group in right for group in block):
            found.update(_solved(mass, block, {group: right.get(group, ca.SX(0)) for group in block}))
    return found


def _solved(mass: Terms, block: list[int], b: dict[int, ca.SX]) -> dict[int, ca.SX]:
    """Elimination without pivoting, then back substitution."""
    if len(block) == 1:
        [group] = block
        return {group: b[group] / mass[group, group]}
    rows = {i: {j: mass[i, j] for j in block if (i, j) in mass} for i in block}
    for place, pivot in enumerate(block):
        for i in block[place + 1 :]:
            if pivot not in rows[i]:
                continue
            factor = rows[i].pop(pivot) / rows[pivot][pivot]
            for j, value in rows[pivot].items():
                if j > pivot:
                    rows[i][j] = rows[i].get(j, ca.SX(0)) - factor * value
            b[i] = b[i] - factor * b[pivot]
    found: dict[int, ca.SX] = {}
    for i in reversed(block):
        rest = b[i] - sum((c * found[j] for j, c in rows[i].items() if j > i), start=ca.SX(0))
        found[i] = rest / rows[i][i]
    return {group: found[group] for group in block}
