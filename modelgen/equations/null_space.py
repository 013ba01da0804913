"""The null space of linear rows: which unknowns are independent, and every other one as a row over those.

Part of the grammar. It is applied twice: to the constraints over node angles (``modelgen.equations.nodes``), and to the relative
angles that laws see over the independent angles (``modelgen.equations.coordinates``). The choice is made at the
values at hand; what it gives are expressions of the parameters, with the conditions under which the choice stays right.

First the greedy part, which is all that a train of shafts and gears needs: a row that sees exactly one unknown not yet placed
places it; when none does, an unknown becomes independent. A row left over either vanishes (it is redundant, as in a closed loop)
or relates independent unknowns, as two planetary sets on the same shafts do: it is then solved for one of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import sympy

from modelgen.equations.conditions import Condition, Exact

Row = Mapping[int, sympy.Expr]
ONE = sympy.Integer(1)


@dataclass
class NullSpace:
    """Unknowns over the independent ones.

    ``steps``: order of placement, each unknown with the row that places it (None: independent, or solved from a row left over).
    ``over``: every unknown as a row over the independent ones, empty where it is zero. ``solved``: unknowns taken out of the
    independent ones by a row left over. ``redundant``: rows that say nothing new. ``conditions``: what must stay so.
    """

    steps: list[tuple[int, int | None]] = field(default_factory=list)
    over: dict[int, dict[int, sympy.Expr]] = field(default_factory=dict)
    solved: dict[int, int] = field(default_factory=dict)
    redundant: list[int] = field(default_factory=list)
    conditions: list[Condition] = field(default_factory=list)

    @property
    def independent(self) -> list[int]:
        """The unknowns that stay, in the order of their choice."""
        return [unknown for unknown, row in self.steps if row is None and unknown not in self.solved]


def null_space(
    count: int, rows: Sequence[Row], first: int, exact: Exact, element_of: Callable[[int], str] = lambda row: f"row {row}"
) -> NullSpace:
    """The null space of ``rows`` over ``count`` unknowns; ``first`` stays independent where it can.

    ``element_of`` says whose row it is, for the words of a condition that a later parameter vector breaks.

    >>> one, two = sympy.Integer(1), sympy.Integer(2)
    >>> willis = {0: one, 1: two, 2: -one - two}  # sun + 2 ring = 3 carrier
    >>> found = null_space(3, [willis], 0, Exact({}))
    >>> found.independent, found.over[2]
    ([0, 1], {0: 1/3, 1: 2/3})
    """
    return _Elimination(rows, exact, element_of).solve(count, first)


class _Elimination:
    def __init__(self, rows: Sequence[Row], exact: Exact, element_of: Callable[[int], str]) -> None:
        self.exact, self.element_of = exact, element_of
        self.found = NullSpace()
        self.rows = [self._at_hand(index, row) for index, row in enumerate(rows)]

    def solve(self, count: int, first: int) -> NullSpace:
        found = self.found
        found.steps, left = place(count, self.rows, first)
        for unknown, index in found.steps:
            if index is None:
                found.over[unknown] = {unknown: ONE}
                continue
            row = self.rows[index]
            self._needs(index, row[unknown], row)
            others = {other: c for other, c in row.items() if other != unknown}
            found.over[unknown] = {root: -total / row[unknown] for root, total in self._combined(index, others).items()}
        for index in left:
            self._relate(index, first)
        return found

    def _relate(self, index: int, first: int) -> None:
        """Takes a row that no unknown needed for its place: redundant, or solved for one of the independent unknowns."""
        found = self.found
        residual = self._combined(index, self.rows[index])
        if not residual:
            found.redundant.append(index)
            return
        size = {root: abs(float(self.exact(c))) for root, c in residual.items()}
        pivot = max((root for root in residual if root != first), key=lambda root: (size[root], root), default=first)
        self._needs(index, residual[pivot], residual)
        solution = {root: -c / residual[pivot] for root, c in residual.items() if root != pivot}
        found.solved[pivot] = index
        for row in found.over.values():
            factor = row.pop(pivot, None)
            if factor is None:
                continue
            for root, c in solution.items():
                terms = [row.pop(root), factor * c] if root in row else [factor * c]
                if (total := self._total(index, terms)) is not None:
                    row[root] = total

    def _combined(self, index: int, row: Row) -> dict[int, sympy.Expr]:
        """A row over unknowns as a row over the independent ones."""
        terms: dict[int, list[sympy.Expr]] = {}
        for unknown, c in row.items():
            for root, ratio in self.found.over[unknown].items():
                terms.setdefault(root, []).append(c * ratio)
        totals = {root: self._total(index, each) for root, each in terms.items()}
        return {root: total for root, total in totals.items() if total is not None}

    def _total(self, index: int, terms: Sequence[sympy.Expr]) -> sympy.Expr | None:
        """The sum of terms, or None where they cancel, which must then stay so."""
        total = sympy.Add(*terms)
        if len(terms) == 1 or not self.exact.vanishes(terms):
            return total
        if total != 0:
            self.found.conditions.append(Condition(self.element_of(index), tuple(terms), vanishes=True))
        return None

    def _at_hand(self, index: int, row: Row) -> dict[int, sympy.Expr]:
        """The row without coefficients that are zero at the values at hand, which must then stay so."""
        kept = {}
        for unknown, c in row.items():
            if c.is_zero is False or not self.exact.vanishes([c], list(row.values())):
                kept[unknown] = c
            elif c != 0:
                self.found.conditions.append(Condition(self.element_of(index), (c,), tuple(row.values()), vanishes=True))
        return kept

    def _needs(self, index: int, pivot: sympy.Expr, row: Row) -> None:
        """Notes that a coefficient by which is divided must not vanish, where its symbols do not say so by themselves."""
        if pivot.is_zero is not False:
            self.found.conditions.append(Condition(self.element_of(index), (pivot,), tuple(row.values()), vanishes=False))


def place(count: int, rows: Sequence[Row], first: int) -> tuple[list[tuple[int, int | None]], list[int]]:
    """Order of the unknowns, each with the row that places it (None: independent), and the rows that place none."""
    steps: list[tuple[int, int | None]] = []
    placed: set[int] = set()
    touching: dict[int, list[int]] = {unknown: [] for unknown in range(count)}
    missing = [set(row) for row in rows]
    for index, row in enumerate(rows):
        for unknown in row:
            touching[unknown].append(index)
    ready = [index for index, unknowns in enumerate(missing) if len(unknowns) == 1]
    used: set[int] = set()

    def put(unknown: int, row: int | None) -> None:
        placed.add(unknown)
        steps.append((unknown, row))
        for index in touching[unknown]:
            missing[index].discard(unknown)
            if len(missing[index]) == 1:
                ready.append(index)

    roots = iter([first, *(unknown for unknown in range(count) if unknown != first)])
    while len(placed) < count:
        while ready:
            index = ready.pop(0)
            if len(missing[index]) == 1:
                used.add(index)
                put(next(iter(missing[index])), index)
        if len(placed) < count:
            put(next(unknown for unknown in roots if unknown not in placed), None)
    return steps, [index for index in range(len(rows)) if index not in used]
