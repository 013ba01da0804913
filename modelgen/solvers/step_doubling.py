"""Step doubling: one step of h and two of h/2 as one function, with the difference that controls the step.

Part of ``solvers``; source: the paper's Eq. 28-32. A method of order p advances by ``increment``; the whole step errs by
c h^(p+1), the two half steps by 2 c (h/2)^(p+1), so their difference (Eq. 32) measures the error, and 1/(2^p - 1) of it
(Eq. 31; 1/15 for p = 4) may be added to the result. Everything stands in one CasADi function, so that a loop in Python pays one
call per step and generated C can take the step over as it is.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import casadi as ca

from modelgen.solvers.coordinates import symbols_for

# (f, time at a fraction of the interval, its length, y, y' at the start, q) -> what y gains over the interval
Increment = Callable[[Callable[[Any, Any], Any], Callable[[Fraction], Any], Any, Any, Any, Any], Any]
HALF, ONE = Fraction(1, 2), Fraction(1)
EXACT = 2**53  # whole numbers up to here are doubles


def step_doubling(
    rate: ca.Function, increment: Increment, order: int, extrapolate: bool, *, unseen: float = 0.0, inline: bool = True
) -> ca.Function:
    """The function (t, h, state, q) -> (nodes, measures, whole, halves) of a rate (t, y, q) -> y'.

    ``state`` (nx, 2) holds [y, y'] at the start; ``nodes`` (nx, 4) [y, y'] in the middle and at the end, where the last two
    columns are the state of the next step. ``measures`` (2): the largest |difference| of all states (Eq. 32), and a sum of
    squares that is finite only if everything is (a maximum would hide NaN). ``whole`` and ``halves`` (nx): the plain results of
    one step and of two. Differences are taken between increments, so that a large y costs them no digits. ``unseen``: the part of
    the step at its start in which the method takes no slope (see ``_unseen_error``). ``inline``: write the rate out into the step
    where possible; an increment that calls a solver cannot be written out.
    """
    symbols = symbols_for(rate) if inline else ca.MX
    n = rate.numel_in(1)
    t, h, state, q = symbols.sym("t"), symbols.sym("h"), symbols.sym("state", n, 2), symbols.sym("q", rate.numel_in(2))
    y, slope = state[:, 0], state[:, 1]

    def f(time: Any, place: Any) -> Any:
        return rate(time, place, q)

    @functools.cache
    def time(fraction: Fraction) -> Any:
        """A time of the step; one for equal fractions, so that equal terms are found."""
        return t + share_of(h, fraction) if fraction else t

    whole = increment(f, time, h, y, slope, q)
    first = increment(f, lambda fraction: time(fraction / 2), h / 2, y, slope, q)
    second_slope = f(time(HALF), y + first)
    second = increment(f, lambda fraction: time(HALF + fraction / 2), h / 2, y + first, second_slope, q)
    difference = (first + second) - whole
    correction = difference / (2**order - 1) if extrapolate else symbols.zeros(n)
    y_middle = y + (first + correction / 2)  # the first half step holds half of the error
    y_end = y + (first + second + correction)
    slope_end = f(time(ONE), y_end)
    error = ca.mmax(ca.fabs(difference))
    if unseen:
        error = ca.fmax(error, _unseen_error(f, t, h, y, (slope, second_slope, slope_end), y_end - y, unseen))
    guard = ca.sumsqr(y_end) + ca.sumsqr(h * slope_end) + ca.sumsqr(difference)
    return ca.Function(
        "step",
        [t, h, state, q],
        [
            ca.horzcat(y_middle, second_slope, y_end, slope_end),
            ca.vertcat(error, guard),
            y + whole,
            y + (first + second),
        ],
        ["t", "h", "state", "q"],
        ["nodes", "measures", "whole", "halves"],
        {"cse": symbols is ca.SX},  # the parts that depend on time only appear at five distinct times, not at eleven
    )


def share_of(h: Any, fraction: Fraction) -> Any:
    """A fraction of h, in as few roundings as can be."""
    above, below = fraction.numerator, fraction.denominator
    if max(above, below) > EXACT:
        return float(fraction) * h
    scaled = h if above == 1 else above * h
    return scaled if below == 1 else scaled / below


def _unseen_error(
    f: Callable[[Any, Any], Any], t: Any, h: Any, y: Any, slopes: tuple[Any, Any, Any], gain: Any, unseen: float
) -> Any:
    """What a kink or jump costs at most that lies before the first slope of the whole step and of the halves alike.

    By Simpson's rule the slope at the start follows from the gain and the other two slopes; what is left of it was not seen. In a
    stiff model a slope is as wrong as the state is away from its slow motion, times the stiffness; a difference of rates along
    what is left measures the stiffness, and takes it out again.
    """
    start, middle, end = slopes
    left = start - (6 * gain / h - 4 * middle - end)
    size = ca.mmax(ca.fabs(left)) + 1e-300
    stiffness = ca.mmax(ca.fabs(f(t, y + 1e-6 / size * left) - start)) / 1e-6
    return unseen * h * size / (1 + h * stiffness)
