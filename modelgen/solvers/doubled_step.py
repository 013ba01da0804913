"""The product's own solver: an explicit Runge-Kutta method without an error of its own, with step doubling, from its table.

Part of ``solvers``, beside ``tableau_step``; source: the paper's Eq. 23-32, whose method is the table ``rk4``. A step of s stages
costs 3 s - 1 evaluations: the slope at the start belongs to the whole step and to the first half alike and is the end slope of
the step before. A rejected step keeps it.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import casadi as ca

from modelgen.lowering.tableau import Tableau
from modelgen.solvers.method import Method
from modelgen.solvers.step_doubling import EXACT, Increment, share_of, step_doubling


@functools.lru_cache(maxsize=16)
def doubled_step(rate: ca.Function, tableau: Tableau, extrapolate: bool = True) -> ca.Function:
    """One step-doubling step (t, h, [y, y'], q) -> (nodes, measures, whole, halves) of a rate (t, y, q) -> y'.

    The outputs are described in ``step_doubling``. For y' = y, Eq. 30: the halves err by a sixteenth of the whole step.

    >>> from modelgen.lowering.methods import read_tableau
    >>> t, y, q = ca.SX.sym("t"), ca.SX.sym("y"), ca.SX.sym("q")
    >>> step = doubled_step(ca.Function("growth", [t, y, q], [y]), read_tableau("rk4"))
    >>> _, _, whole, halves = step(0, 0.01, ca.DM([[1, 1]]), 0)
    >>> print(f"{float((ca.exp(0.01) - halves) / (ca.exp(0.01) - whole)):.4f}")
    0.0625
    """
    return step_doubling(rate, increment_of(tableau), tableau.order, extrapolate)


def doubled_method(rate: ca.Function, tableau: Tableau, extrapolate: bool = True) -> Method:
    """The step with what ``march`` needs to know of it."""
    return Method(doubled_step(rate, tableau, extrapolate), tableau.order + 1, 3 * tableau.stages - 1)


def increment_of(tableau: Tableau) -> Increment:
    """What y gains over a step of a method: h sum b_i k_i, for a given k_0; of ``rk4`` h/6 (K1 + 2 K2 + 2 K3 + K4), Eq. 23-27."""

    def increment(
        f: Callable[[Any, Any], Any], time: Callable[[Fraction], Any], h: Any, y: Any, slope: Any, q: Any
    ) -> Any:
        slopes = [slope]
        for node, row in zip(tableau.c[1:], tableau.a[1:], strict=True):
            slopes.append(f(time(node), y + _gain(row, h, slopes)))
        return _gain(tableau.b, h, slopes)

    return increment


def _gain(weights: Sequence[Fraction], h: Any, slopes: Sequence[Any]) -> Any:
    """h times a weighted sum of slopes: with whole numbers over one denominator, where they are small enough to be exact."""
    below = math.lcm(*(weight.denominator for weight in weights))
    whole = [int(weight * below) for weight in weights]
    if max(below, *map(abs, whole)) > EXACT:
        return h * sum(float(weight) * slope for weight, slope in zip(weights, slopes, strict=True) if weight)
    total = sum(slope if n == 1 else n * slope for n, slope in zip(whole, slopes, strict=True) if n)
    return share_of(h, Fraction(1, below)) * total
