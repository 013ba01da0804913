"""Every operation in C against CasADi's virtual machine, on one double and on lanes; own sine and cosine against mpmath."""

from __future__ import annotations

import math

import casadi as ca
import mpmath
import numpy as np
import pytest

from modelgen.lowering.native import native_solver
from modelgen.lowering.native.graph import Graph
from modelgen.lowering.native.operations import OPERATIONS

pytestmark = pytest.mark.usefixtures("compiled_here")

# Two arguments each; those with one ignore the second.
OPERATION_ROWS = [
    *(
        lambda a, b, f=f: f(a)
        for f in (ca.exp, ca.log, ca.sqrt, ca.sin, ca.cos, ca.tan, ca.asin, ca.acos, ca.atan, ca.sinh, ca.cosh)
    ),
    *(lambda a, b, f=f: f(a) for f in (ca.tanh, ca.asinh, ca.acosh, ca.atanh, ca.erf, ca.log1p, ca.expm1, ca.floor, ca.ceil)),
    *(lambda a, b, f=f: f(a) for f in (ca.fabs, ca.sign, ca.logic_not)),
    *(
        lambda a, b, f=f: f(a, b)
        for f in (ca.atan2, ca.fmin, ca.fmax, ca.fmod, ca.copysign, ca.hypot, ca.remainder, ca.logic_and, ca.logic_or)
    ),
    *(
        lambda a, b, f=f: f(a, b)
        for f in (lambda a, b: a + b, lambda a, b: a - b, lambda a, b: a * b, lambda a, b: a / b, lambda a, b: a**b)
    ),
    *(lambda a, b, f=f: f(a, b) for f in (ca.lt, ca.le, ca.eq, ca.ne)),
    lambda a, b: a**1.7,
    lambda a, b: -a,
    lambda a, b: a * a,
    lambda a, b: 2 * a,
    lambda a, b: 1 / a,
    lambda a, b: ca.if_else(a > b, ca.log(a), b),
    lambda a, b: ca.if_else(a, b, 3),
    lambda a, b: (a < b) + 2 * ca.logic_not(a < b) + ca.if_else(ca.logic_and(a < b, a), 1, 0),
]
N = len(OPERATION_ROWS)


def multiple(order: int, angle: ca.SX) -> tuple[ca.SX, ca.SX]:
    """sin and cos of a multiple of an angle, by angle addition of the halves."""
    if order == 1:
        return ca.sin(angle), ca.cos(angle)
    (s1, c1), (s2, c2) = multiple(order // 2, angle), multiple(order - order // 2, angle)
    return s1 * c2 + c1 * s2, c1 * c2 - s1 * s2


def every_operation() -> ca.Function:
    """Rate i is operation i of the states 2 i and 2 i + 1; the other rates are zero."""
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2 * N), ca.SX.sym("p", 0)
    rows = [row(x[2 * i], x[2 * i + 1]) for i, row in enumerate(OPERATION_ROWS)]
    return ca.Function("f", [t, x, p], [ca.vertcat(*rows, ca.SX.zeros(N))])


def test_the_rows_hold_every_operation_of_the_table() -> None:
    found = {node.operation for node in Graph.of(every_operation()).nodes}
    assert OPERATIONS - found <= {ca.OP_ASSIGN}


@pytest.mark.parametrize("lanes", [False, True])
def test_every_operation_equals_that_of_the_virtual_machine(lanes: bool) -> None:
    function = every_operation()
    solver, rng = native_solver(function, lanes), np.random.default_rng(5)
    special = np.array([0.0, -0.0, 1.0, -1.0, 0.5, 1.5, -2.5, 3.0, 1e-300, 1e300, math.inf, -math.inf, math.nan])
    for trial in range(120):
        x = rng.choice(special, 2 * N) if trial % 2 else rng.uniform(-3, 3, 2 * N)
        with np.errstate(all="ignore"):
            expected, found = np.asarray(function(0, x, [])).ravel(), solver.rates(0.0, x, [])
            close = np.isclose(found, expected, rtol=2e-15, atol=1e-15, equal_nan=True)
        bad = np.flatnonzero(~close)
        assert not bad.size, [(int(i), x[2 * i : 2 * i + 2].tolist(), found[i], expected[i]) for i in bad[:5]]


def test_sine_and_cosine_of_lanes_are_within_two_units_in_the_last_place() -> None:
    count = 32
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2 * count), ca.SX.sym("p", 0)
    solver = native_solver(ca.Function("f", [t, x, p], [ca.vertcat(ca.sin(x[:count]), ca.cos(x[count:]))]), lanes=True)
    rng = np.random.default_rng(2)
    worst = 0.0
    with mpmath.workdps(45):
        for reach in 4 * (1e-8, 1.0, 10.0, 1e3, 1e6, 2.6e8, 1e12):
            angles = rng.uniform(-reach, reach, count)
            angles[:8] = np.pi / 4 * np.arange(1, 9)  # the worst of them lie next to multiples of pi/2
            found = solver.rates(0.0, np.concatenate([angles, angles]), [])
            for value, angle, function in zip(
                found, [*angles, *angles], [mpmath.sin] * count + [mpmath.cos] * count, strict=True
            ):
                exact = function(mpmath.mpf(float(angle)))
                worst = max(worst, abs(float((mpmath.mpf(float(value)) - exact) / math.ulp(float(exact)))))
    assert worst < 2.0


@pytest.mark.parametrize("lanes", [False, True])
def test_harmonics_after_many_periods_against_mpmath(lanes: bool) -> None:
    orders = (1, 2, 3, 5, 8, 12, 24)
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2 * len(orders)), ca.SX.sym("p", 1)
    waves = [wave for order in orders for wave in multiple(order, p * t)]
    solver = native_solver(ca.Function("f", [t, x, p], [ca.vertcat(*waves)]), lanes)
    worst = 0.0
    with mpmath.workdps(40):
        for frequency in (230.38346126, 1.0, 7e4 / 3):
            for periods in (0.3, 1e2, 12345.678, 99999.99):
                time = periods * 2 * math.pi / frequency
                found = solver.rates(time, np.zeros(2 * len(orders)), [frequency])
                angle = mpmath.mpf(frequency) * mpmath.mpf(time)
                exact = [float(f(order * angle)) for order in orders for f in (mpmath.sin, mpmath.cos)]
                worst = max(worst, np.abs(found - exact).max())
    assert worst <= 1e-12
