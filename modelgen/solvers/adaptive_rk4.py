"""The product's own solver: the classical Runge-Kutta method of order 4 with step doubling.

Part of ``solvers``; source: the paper's Eq. 23-32. Eleven evaluations per step: the slope at the start belongs to the whole step
and to the first half alike and is the end slope of the step before. A rejected step keeps it.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import casadi as ca

from modelgen.solvers.method import Method
from modelgen.solvers.step_doubling import step_doubling

ORDER = 4
EVALUATIONS = 11  # 3 for the whole step, 3 + 4 for the halves, 1 for the slope at the end


def rk4_increment(f: Callable[[Any, Any], Any], times: tuple[Any, Any, Any], h: Any, y: Any, k1: Any, q: Any) -> Any:
    """What y gains over a step: h/6 (K1 + 2 K2 + 2 K3 + K4), Eq. 23-27, for a given K1 = f(start, y)."""
    _, middle, end = times
    k2 = f(middle, y + h / 2 * k1)
    k3 = f(middle, y + h / 2 * k2)
    k4 = f(end, y + h * k3)
    return h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


@functools.lru_cache(maxsize=16)
def rk4_step(rate: ca.Function, extrapolate: bool = True) -> ca.Function:
    """One step-doubling step (t, h, [y, y'], q) -> (nodes, measures, whole, halves) of a rate (t, y, q) -> y'.

    The outputs are described in ``step_doubling``. For y' = y, Eq. 30: the halves err by a sixteenth of the whole step.

    >>> t, y, q = ca.SX.sym("t"), ca.SX.sym("y"), ca.SX.sym("q")
    >>> step = rk4_step(ca.Function("growth", [t, y, q], [y]))
    >>> _, _, whole, halves = step(0, 0.01, ca.DM([[1, 1]]), 0)
    >>> print(f"{float((ca.exp(0.01) - halves) / (ca.exp(0.01) - whole)):.4f}")
    0.0625
    """
    return step_doubling(rate, rk4_increment, ORDER, extrapolate)


def rk4_method(rate: ca.Function, extrapolate: bool = True) -> Method:
    """The step with what ``march`` needs to know of it."""
    return Method(rk4_step(rate, extrapolate), ORDER + 1, EVALUATIONS)
