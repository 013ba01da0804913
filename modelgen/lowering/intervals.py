"""Interval arithmetic on a compiled function: where its values lie while its arguments run over intervals.

Part of the compiler, beside ``switching``. The enclosure is a CasADi function itself, so that the virtual machine, C and lanes
evaluate the same one. Moore, Kearfott, Cloud, Introduction to Interval Analysis, ch. 2-5. Ends are rounded to nearest: who
compares them with zero leaves room for rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import casadi as ca

from modelgen.lowering.instructions import instructions

FAR = 1e300  # stands for infinity, which times zero would be no number

Interval = tuple[ca.SX, ca.SX]
Operation = Callable[..., Interval]


def enclosure(function: ca.Function) -> tuple[ca.Function, tuple[bool, ...]]:
    """Bounds of a function (t, x, v, p) -> column as a function (t, x, v, p) of intervals, and which rows are enclosed.

    Its x holds the lower ends and then the upper ones, its v those of v and behind them both ends of time; its t is not used. The
    result has all lower ends, then all upper ones. A row with an operation that has no enclosure is [-FAR, FAR].

    >>> t, x, v, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("v"), ca.SX.sym("p")
    >>> bounds, enclosed = enclosure(ca.Function("f", [t, x, v, p], [ca.vertcat(x**2 - p, ca.cos(x))]))
    >>> bounds(0, [-1, 3], [0, 0, 0, 0], 2), enclosed
    (DM([-2, -0.989992, 7, 1]), (True, True))
    """
    n, m, rows = function.numel_in(1), function.numel_in(3), function.numel_out(0)
    t, x, v, p = (ca.SX.sym(name, size) for name, size in zip("txvp", (1, 2 * n, 2 * n + 2, m), strict=True))
    inputs = (
        lambda row: (v[2 * n], v[2 * n + 1]),
        lambda row: (x[row], x[n + row]),
        lambda row: (v[row], v[n + row]),
        lambda row: (p[row], p[row]),
    )
    work: dict[int, Interval | None] = {}
    ends: list[Interval | None] = [(ca.SX(0), ca.SX(0))] * rows
    for code, source, target, number in instructions(function):
        if code == ca.OP_CONST:
            number = ca.SX(number)
            work[target[0]] = number, number
        elif code == ca.OP_INPUT:
            work[target[0]] = inputs[source[0]](source[1])
        elif code == ca.OP_OUTPUT:
            ends[target[1]] = work[source[0]]
        else:
            work[target[0]] = _bounds(code, [work[register] for register in source])
    known = [(-ca.SX(FAR), ca.SX(FAR)) if each is None else each for each in ends]
    column = ca.vertcat(*(low for low, _ in known), *(high for _, high in known))
    return ca.Function("enclosure", [t, x, v, p], [ca.densify(ca.cse(column))]), tuple(each is not None for each in ends)


def _bounds(code: int, operands: Sequence[Interval | None]) -> Interval | None:
    if any(each is None for each in operands):
        return None
    known = [each for each in operands if each is not None]
    if all(_is_point(each) for each in known):
        parts = [low for low, _ in known]
        value = ca.SX.binary(code, *parts) if len(parts) == 2 else ca.SX.unary(code, parts[0])
        return value, value
    if code in INCREASING:
        return ca.SX.unary(code, known[0][0]), ca.SX.unary(code, known[0][1])
    return OPERATIONS[code](*known) if code in OPERATIONS else None


def _is_point(a: Interval) -> bool:
    return ca.is_equal(a[0], a[1], 0)


def _hull(*values: ca.SX) -> Interval:
    low = high = values[0]
    for each in values[1:]:
        low, high = ca.fmin(low, each), ca.fmax(high, each)
    return low, high


def _product(a: Interval, b: Interval) -> Interval:
    if _is_point(a):
        return _hull(a[0] * b[0], a[0] * b[1])
    return _product(b, a) if _is_point(b) else _hull(a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1])


def _square(a: Interval) -> Interval:
    low, high = _hull(a[0] ** 2, a[1] ** 2)
    return ca.if_else(ca.logic_and(a[0] < 0, a[1] > 0), 0, low), high


def _inverse(a: Interval) -> Interval:
    clear = ca.logic_or(a[0] > 0, a[1] < 0)
    return ca.if_else(clear, 1 / a[1], -FAR), ca.if_else(clear, 1 / a[0], FAR)


def _magnitude(a: Interval) -> Interval:
    low, high = _hull(ca.fabs(a[0]), ca.fabs(a[1]))
    return ca.if_else(ca.logic_and(a[0] < 0, a[1] > 0), 0, low), high


def _wave(function: Callable[[ca.SX], ca.SX], peak: float) -> Operation:
    """Sine or cosine, whose peaks lie at ``peak`` and full turns from it, and its valleys half a turn away."""

    def bounds(a: Interval) -> Interval:
        low, high = _hull(function(a[0]), function(a[1]))

        def passes(place: float) -> ca.SX:
            first, last = ((end - place) / (2 * math.pi) for end in a)
            return ca.floor(last + 1e-12) >= ca.ceil(first - 1e-12)

        return ca.if_else(passes(peak + math.pi), -1.0, low), ca.if_else(passes(peak), 1.0, high)

    return bounds


def _selected(condition: Interval, a: Interval) -> Interval:
    """a where the condition is 1, and zero where it is 0; both where it may be either."""
    low, high = ca.fmin(a[0], 0), ca.fmax(a[1], 0)
    surely, never = condition[0] > 0, ca.logic_not(condition[1] > 0)
    return (
        ca.if_else(surely, a[0], ca.if_else(never, 0, low)),
        ca.if_else(surely, a[1], ca.if_else(never, 0, high)),
    )


def _compared(strictly: bool) -> Operation:
    def bounds(a: Interval, b: Interval) -> Interval:
        return (a[1] < b[0], a[0] < b[1]) if strictly else (a[1] <= b[0], a[0] <= b[1])

    return bounds


def _negative(a: Interval) -> Interval:
    return -a[1], -a[0]


def _sum(a: Interval, b: Interval) -> Interval:
    return a[0] + b[0], a[1] + b[1]


def _power(a: Interval, b: Interval) -> Interval | None:
    """A power of a positive number, by its logarithm; NaN elsewhere, which leaves it undecided."""
    logarithm = ca.log(a[0]), ca.log(a[1])
    low, high = _product(logarithm, b)
    return ca.exp(low), ca.exp(high)


INCREASING = frozenset(
    {
        *(ca.OP_ASSIGN, ca.OP_TWICE, ca.OP_EXP, ca.OP_LOG, ca.OP_SQRT, ca.OP_ASIN, ca.OP_ATAN, ca.OP_SINH, ca.OP_TANH),
        *(ca.OP_ASINH, ca.OP_ACOSH, ca.OP_ATANH, ca.OP_ERF, ca.OP_LOG1P, ca.OP_EXPM1, ca.OP_FLOOR, ca.OP_CEIL, ca.OP_SIGN),
    }
)

OPERATIONS: dict[int, Callable[..., Interval | None]] = {
    ca.OP_ADD: _sum,
    ca.OP_SUB: lambda a, b: _sum(a, _negative(b)),
    ca.OP_NEG: _negative,
    ca.OP_MUL: _product,
    ca.OP_SQ: _square,
    ca.OP_INV: _inverse,
    ca.OP_DIV: lambda a, b: _product(a, _inverse(b)),
    ca.OP_FABS: _magnitude,
    ca.OP_SIN: _wave(ca.sin, math.pi / 2),
    ca.OP_COS: _wave(ca.cos, 0.0),
    ca.OP_ACOS: lambda a: (ca.acos(a[1]), ca.acos(a[0])),
    ca.OP_FMIN: lambda a, b: (ca.fmin(a[0], b[0]), ca.fmin(a[1], b[1])),
    ca.OP_FMAX: lambda a, b: (ca.fmax(a[0], b[0]), ca.fmax(a[1], b[1])),
    ca.OP_LT: _compared(True),
    ca.OP_LE: _compared(False),
    ca.OP_NOT: lambda a: (1 - a[1], 1 - a[0]),
    ca.OP_AND: lambda a, b: (a[0] * b[0], a[1] * b[1]),
    ca.OP_OR: lambda a, b: (ca.fmax(a[0], b[0]), ca.fmax(a[1], b[1])),
    ca.OP_IF_ELSE_ZERO: _selected,
    ca.OP_POW: _power,
    ca.OP_CONSTPOW: _power,
}
