"""How the roots of each guard can be counted over a step: as those of a polynomial, by enclosures, or by samples only.

Part of the compiler, on ``switching`` and ``intervals``. A guard that is a linear combination of states and time, with
coefficients that depend on parameters only, is a polynomial on the dense output of a step. Another one is enclosed where every
operation in it and in its rate has bounds, and none of them jumps with the state.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import casadi as ca
import numpy as np

from modelgen.lowering.instructions import instructions
from modelgen.lowering.intervals import FAR, enclosure
from modelgen.lowering.switching import Switching
from modelgen.lowering.time_switches import WHOLE_NUMBERS

POLYNOMIAL, ENCLOSED, SAMPLED = "polynomial", "enclosed", "sampled"
WAYS = (POLYNOMIAL, ENCLOSED, SAMPLED)

STEPS = frozenset(
    {*WHOLE_NUMBERS, ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_SIGN, ca.OP_FMOD, ca.OP_REMAINDER, ca.OP_COPYSIGN}
)
"""Operations whose value jumps."""
DERIVATIVE = 6
"""By time, of what is not linear in a guard: it bounds how far the guard is from the quintic through three points of a step."""
_FIXED, _LINEAR, _CURVED, _JUMPS = range(4)


@dataclass(frozen=True, eq=False)
class GuardCounting:
    """``ways``: how each crossing is counted (of ``WAYS``). ``bounds``: the enclosures of all guards, then of their rates.

    ``rest`` (t, x, v, p), called as ``bounds``: of a guard that is linear in the states with fixed coefficients, the enclosure of
    the sixth derivative by time of what else is in it; infinite for any other guard. (Zero for a polynomial.)
    """

    ways: tuple[str, ...]
    bounds: ca.Function
    rest: ca.Function

    def rests(self, first: float, last: float, p: np.ndarray) -> np.ndarray:
        """The largest sixth derivative by time of each guard's rest between two times; infinite where there is no bound."""
        n = self.rest.numel_in(1) // 2
        ends = np.array(self.rest(0.0, np.zeros(2 * n), [*np.zeros(2 * n), first, last], p)).ravel()
        low, high = np.split(ends, 2)
        most = np.maximum(np.abs(low), np.abs(high))
        return np.where(most < FAR / 2, most, np.inf)  # NaN is no bound either


@functools.lru_cache(maxsize=64)
def guard_counting(switching: Switching) -> GuardCounting:
    """How the guards of a model are counted.

    >>> from modelgen.lowering.switching import Crossing
    >>> t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p")
    >>> g = ca.Function("g", [t, x, p], [ca.vertcat(x[0] - p * x[1] - t, x[0] * x[1], ca.sign(x[0]) + x[1])])
    >>> guard_counting(Switching((), (Crossing("a", 0), Crossing("b", 0), Crossing("c", 0)), g, 1)).ways
    ('polynomial', 'enclosed', 'sampled')
    """
    count = len(switching.crossings)
    rates = switching.guard_rates
    symbols = [ca.SX.sym(rates.name_in(index), rates.sparsity_in(index)) for index in range(4)]
    written = ca.Function("guards", symbols, [ca.densify(rates(*symbols))])
    bounds, enclosed = enclosure(written)
    shapes = _shapes(written)
    ways = []
    for index in range(count):
        if shapes[index] <= _LINEAR:
            ways.append(POLYNOMIAL)
        else:
            known = shapes[index] == _CURVED and enclosed[index] and enclosed[count + index]
            ways.append(ENCLOSED if known else SAMPLED)
    return GuardCounting(tuple(ways), bounds, _rest(written, count, ways))


def _rest(written: ca.Function, count: int, ways: list[str]) -> ca.Function:
    t, x, v, p = (ca.SX.sym(written.name_in(index), written.sparsity_in(index)) for index in range(4))
    g = written(t, x, v, p)[:count]
    slopes, here = ca.densify(ca.jacobian(g, x)), ca.vertcat(t, x)
    rows = []
    for index in range(count):
        rest = ca.substitute(g[index], x, ca.SX.zeros(x.numel()))
        for _ in range(DERIVATIVE):
            rest = ca.jacobian(rest, t)
        fixed = ways[index] == POLYNOMIAL or (ways[index] == ENCLOSED and not ca.depends_on(slopes[index, :], here))
        rows.append(ca.densify(rest) if fixed else ca.SX(2 * FAR))
    return enclosure(ca.Function("rest", [t, x, v, p], [ca.densify(ca.vertcat(*rows))]))[0]


def _shapes(function: ca.Function) -> list[int]:
    """Of each row of a function (t, x, v, p): how it depends on time and state."""
    work: dict[int, tuple[int, bool]] = {}  # the shape, and whether the state is in it
    rows = [_FIXED] * int(function.numel_out(0))
    for code, source, target, _ in instructions(function):
        if code == ca.OP_CONST:
            work[target[0]] = _FIXED, False
        elif code == ca.OP_INPUT:
            work[target[0]] = (_FIXED if source[0] == 3 else _LINEAR), source[0] in (1, 2)
        elif code == ca.OP_OUTPUT:
            rows[target[1]] = work[source[0]][0]
        else:
            operands = [work[register] for register in source]
            state = any(each[1] for each in operands)
            work[target[0]] = _shape(code, [each[0] for each in operands], state), state
    return rows


def _shape(code: int, operands: list[int], state: bool) -> int:
    most, last = max(operands), operands[-1]
    if most in (_FIXED, _JUMPS):
        return most
    if code in STEPS:
        return _JUMPS if state else _CURVED  # steps end where time alone makes it jump
    if code == ca.OP_IF_ELSE_ZERO:
        return _CURVED
    linear = code in (ca.OP_ASSIGN, ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE)
    linear |= code == ca.OP_MUL and min(operands) == _FIXED
    linear |= code == ca.OP_DIV and last == _FIXED
    return most if linear else _CURVED
