"""A step of any explicit Runge-Kutta method, from its tableau, as one CasADi function.

Part of ``solvers``, between ``lowering.tableau`` and ``march``. A method is a file of numbers there; here its stages are written
out, with the weighted sums that measure the error and the stages that only the dense output needs in a function of their own.
"""

from __future__ import annotations

import functools
from typing import Any

import casadi as ca
import numpy as np

from modelgen.lowering.tableau import Tableau
from modelgen.solvers.coordinates import symbols_for
from modelgen.solvers.dense_output import Interpolant
from modelgen.solvers.method import Method


@functools.lru_cache(maxsize=16)
def tableau_method(rate: ca.Function, tableau: Tableau) -> Method:
    """A method for ``march`` from a rate (t, y, q) -> y' and a tableau with an error estimate and a dense output.

    >>> from modelgen.lowering.methods import read_tableau
    >>> t, y, q = ca.SX.sym("t"), ca.SX.sym("y"), ca.SX.sym("q")
    >>> growth = tableau_method(ca.Function("growth", [t, y, q], [y]), read_tableau("dopri5"))
    >>> nodes, _ = growth.step(0, 0.1, ca.DM([[1, 1]]), 0)
    >>> print(f"{float(nodes[-2]) / np.exp(0.1) - 1:.0e}")
    2e-10
    """
    symbols = symbols_for(rate)
    n, s = rate.numel_in(1), tableau.stages
    t, h, state, q = symbols.sym("t"), symbols.sym("h"), symbols.sym("state", n, 2), symbols.sym("q", rate.numel_in(2))
    y, rows, nodes = state[:, 0], tableau.rows, tableau.nodes
    slopes: list[Any] = [state[:, 1]]
    times = {node: t + float(node) * h for node in nodes}  # one for equal nodes, so that equal terms are found
    for stage in range(1, s + 1):
        slopes.append(rate(times[nodes[stage]], y + h * _sum(rows[stage], slopes), q))
    y_end = y + h * _sum(tableau.b, slopes)
    errors = [h * _sum(row, slopes) for row in tableau.errors]
    largest = [ca.mmax(ca.fabs(each)) for each in errors]
    error = largest[0]
    if len(errors) == 2:
        error = largest[0] ** 2 / ca.sqrt(largest[0] ** 2 + 0.01 * largest[1] ** 2 + 1e-300)
    guard = ca.sumsqr(y_end) + ca.sumsqr(h * slopes[s]) + sum(ca.sumsqr(each) for each in errors)
    used = [stage for stage in range(1, s) if any(row[stage] for row in (*zip(*tableau.dense, strict=True), *tableau.extra_a))]
    kept = [slopes[stage] for stage in used]
    options = {"cse": True} if symbols is ca.SX else {}
    step = ca.Function(
        "step",
        [t, h, state, q],
        [ca.horzcat(*kept, y_end, slopes[s]), ca.vertcat(error, guard)],
        ["t", "h", "state", "q"],
        ["nodes", "measures"],
        options,
    )
    extra = None
    if tableau.extra_c:
        given = symbols.sym("nodes", n, len(used) + 2)
        known: list[Any] = [state[:, 1], *([symbols.zeros(n)] * (s - 1)), given[:, -1]]
        for column, stage in enumerate(used):
            known[stage] = given[:, column]
        for node, row in zip(tableau.extra_c, tableau.extra_a, strict=True):
            known.append(rate(t + float(node) * h, y + h * _sum(row, known), q))
        names = ["t", "h", "state", "nodes", "q"]
        extra = ca.Function("extra", [t, h, state, given, q], [ca.horzcat(*known[s + 1 :])], names, ["more"], options)
    order = [0, *range(s + 1, len(nodes)), *used]  # stages in the order of the interpolant's nodes
    weights = [tableau.dense[stage] for stage in order]
    nothing = [0.0] * len(tableau.dense[0])
    coefficients = [nothing, *weights, nothing, tableau.dense[s]]
    return Method(
        step,
        control=tableau.control,
        evaluations=s,
        interpolant=Interpolant(
            np.array([[0.0, *map(float, row)] for row in coefficients]),
            np.array([False] + [True] * len(order) + [False, True]),
        ),
        extra=extra,
        extra_evaluations=len(tableau.extra_c),
    )


def _sum(weights: Any, slopes: list[Any]) -> Any:
    """The weighted sum of the slopes whose weight is not zero."""
    return sum(float(weight) * slope for weight, slope in zip(weights, slopes, strict=False) if weight)
