"""Explicit Runge-Kutta methods as data: a file of numbers is all that a new method needs.

Part of ``lowering``; ``methods`` reads the files; the steps of the virtual machine (``solvers.tableau_step``,
``solvers.doubled_step``) and of C are made from them. The stages of a step from (t, y) to (t + h, y1) are k_0 = y' at the start,
k_1 ... k_(s-1), then k_s = y' at the end (a method whose last stage is that slope lists it once), then extra stages that only the
dense output needs. Source: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.1-II.6. The order conditions
that every file must meet are those of ``rooted_trees``.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from modelgen.errors import LoweringError

Row = tuple[Fraction, ...]
ZERO, HALF, ONE = Fraction(0), Fraction(1, 2), Fraction(1)


@dataclass(frozen=True)
class Tableau:
    """One method; all numbers are exact (rationals, or decimals as published).

    Stage i is f(t + c_i h, y + h sum_j a_ij k_j). ``c``, ``a`` (lower triangle, row i has i entries) and ``b`` are those of the
    stages 0 ... s-1 with c_0 = 0; y1 = y + h sum b_i k_i. ``errors``: weights over the stages 0 ... s, whose sums h sum e_i k_i
    estimate the error of y1, with ``error_orders`` (a row vanishes up to that order). One row: its largest entry is the error.
    Two rows, of orders p > q: E_p^2 / sqrt(E_p^2 + 0.01 E_q^2) of their largest entries (the authors of the 8th-order method).
    No row: the method is doubled, a step beside two halves (``doubled``).
    ``dense``: for all stages, the coefficients of theta, theta^2, ... in y(t + theta h) = y + h sum_i P_i(theta) k_i, exact to
    ``dense_order``; stages above s have their nodes and rows in ``extra_c`` and ``extra_a`` (row j over s + 1 + j stages).
    ``locates_events``: whether the dense output is good enough to locate events on it. ``crosscheck_tolerance``: at which the
    method's own error is some 1e-7 of the swing of a driveline.
    """

    name: str
    description: str
    order: int
    c: Row
    a: tuple[Row, ...]
    b: Row
    errors: tuple[Row, ...] = ()
    error_orders: tuple[int, ...] = ()
    dense: tuple[Row, ...] = ()
    dense_order: int = 0
    extra_c: Row = ()
    extra_a: tuple[Row, ...] = ()
    locates_events: bool = False
    crosscheck_tolerance: float = 1e-8

    def __post_init__(self) -> None:
        where, s = f"method {self.name!r}", len(self.b)
        lengths = {
            "c": (len(self.c), s),
            "a": ([len(row) for row in self.a], list(range(s))),
            "errors": ([len(row) for row in self.errors], [s + 1] * len(self.error_orders)),
            "dense": (len(self.dense), s + 1 + len(self.extra_c) if self.dense else 0),
            "extra_a": ([len(row) for row in self.extra_a], [s + 1 + j for j in range(len(self.extra_c))]),
        }
        for name, (found, wanted) in lengths.items():
            if found != wanted:
                raise LoweringError(where, f"{name} has {found} entries, wanted are {wanted}", "see Tableau for the layout")
        for index, (node, row) in enumerate(zip((*self.c, *self.extra_c), (*self.a, *self.extra_a), strict=True)):
            if abs(node - sum(row, ZERO)) > 1e-15:
                raise LoweringError(where, f"row {index} adds up to {float(sum(row)):.17g}, its node is {float(node):.17g}")

    @property
    def is_doubled(self) -> bool:
        """Whether the error is measured by step doubling, for want of one of its own."""
        return not self.errors

    def correction(self, extrapolate: bool) -> float:
        """The share of the difference that extrapolation adds to a doubled step, 1/(2^p - 1) (the paper's Eq. 31)."""
        return 1 / (2**self.order - 1) if self.is_doubled and extrapolate else 0.0

    @property
    def stages(self) -> int:
        """s: evaluations that a step costs (the slope at its start is known, the one at its end is the next step's)."""
        return len(self.b)

    @property
    def control(self) -> int:
        """The power of the step in the measured error, which decides how step sizes answer to it."""
        powers = [order + 1 for order in self.error_orders] or [self.order + 1]
        return powers[0] if len(powers) == 1 else 2 * powers[0] - powers[1]

    @property
    def nodes(self) -> Row:
        """c of all stages: 0 ... s-1, the end, the extra ones."""
        return (*self.c, ONE, *self.extra_c)

    @property
    def rows(self) -> tuple[Row, ...]:
        """a of all stages: 0 ... s-1, the end (its row is b), the extra ones."""
        return (*self.a, self.b, *self.extra_a)


QUINTIC: tuple[tuple[int, ...], ...] = (
    (1, 0, -23, 66, -68, 24),
    (0, 1, -6, 13, -12, 4),
    (0, 0, 16, -32, 16, 0),
    (0, 0, -8, 32, -40, 16),
    (0, 0, 7, -34, 52, -24),
    (0, 0, -1, 5, -8, 4),
)
"""Hermite's quintic through start, middle and end of a step: coefficients of 1, theta, ... theta^5 in the weights of
[y0, h y0', ym, h ym', y1, h y1']."""


def doubled(method: Tableau, extrapolate: bool = True) -> Tableau:
    """Step doubling as one method: a step of h, two of h/2, and their difference as the error (the paper's Eq. 28-32).

    The stages: k_0; the others of the whole step; those of the first half; the slope in the middle; those of the second half.
    ``extrapolate`` adds Eq. 31's 1/(2^p - 1) of the difference, which raises the order by one. Dense output: Hermite's quintic.

    >>> from modelgen.lowering.methods import read_tableau
    >>> method = doubled(read_tableau("rk4"))
    >>> method.stages, method.order, method.control
    (11, 5, 5)
    """
    s, total = method.stages, 3 * method.stages - 1
    middle = 2 * s - 1

    def spread(weights: Row, first: int, offset: int, scale: Fraction = ONE) -> list[Fraction]:
        """Weights over the stages of one part of the step, as weights over all."""
        row = [ZERO] * total
        for j, weight in enumerate(weights):
            row[first if j == 0 else offset + j] += scale * weight
        return row

    def plus(one: list[Fraction], other: list[Fraction], scale: Fraction = ONE) -> list[Fraction]:
        return [left + scale * right for left, right in zip(one, other, strict=True)]

    whole, first = spread(method.b, 0, 0), spread(method.b, 0, s - 1, HALF)
    halves = plus(first, spread(method.b, middle, middle, HALF))
    difference = plus(halves, whole, -ONE)
    share = Fraction(1, 2**method.order - 1) if extrapolate else ZERO
    y_end, y_middle = plus(halves, difference, share), plus(first, difference, share / 2)
    rows = [spread(row, 0, 0) for row in method.a]
    rows += [spread(row, 0, s - 1, HALF) for row in method.a[1:]]
    rows += [first]
    rows += [plus(first, spread(row, middle, middle, HALF)) for row in method.a[1:]]
    half = [node / 2 for node in method.c[1:]]
    dense = [[QUINTIC[2][m] * at_middle + QUINTIC[4][m] * at_end for m in range(1, 6)]
             for at_middle, at_end in zip(y_middle, y_end, strict=True)] + [[ZERO] * 5]  # fmt: skip
    for stage, slope in ((0, QUINTIC[1]), (middle, QUINTIC[3]), (total, QUINTIC[5])):
        dense[stage] = plus(dense[stage], [Fraction(each) for each in slope[1:]])
    order = method.order + extrapolate
    return Tableau(
        name=f"{method.name}, doubled" + (", extrapolated" if extrapolate else ""),
        description=f"{method.description}, a step beside two halves",
        order=order,
        c=(*method.c, *half, HALF, *(HALF + node for node in half)),
        a=tuple(tuple(row[:i]) for i, row in enumerate(rows)),
        b=tuple(y_end),
        errors=((*difference, ZERO),),
        error_orders=(method.order,),
        dense=tuple(tuple(row) for row in dense),
        dense_order=min(order, 5),
    )
