"""Where laws jump or bend in time: the switches of a function that depend on time and parameters, but not on the state.

Part of the compiler, read by the solvers: no step crosses such a place. They are found in the instructions of the compiled
function (comparisons, floor, absolute value, minimum, ...), so that it does not matter how a law was written: a Piecewise in
time, a ramp of Min and Max, a table over a clock, a square wave.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass

import casadi as ca

from modelgen.lowering.instructions import instructions

ZERO_OF_DIFFERENCE = frozenset({ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_FMIN, ca.OP_FMAX})
ZERO_OF_FIRST = frozenset({ca.OP_FABS, ca.OP_SIGN})
WHOLE_NUMBERS = frozenset({ca.OP_FLOOR, ca.OP_CEIL})
JUMPS = frozenset({*ZERO_OF_DIFFERENCE, *ZERO_OF_FIRST, *WHOLE_NUMBERS, ca.OP_FMOD, ca.OP_REMAINDER, ca.OP_COPYSIGN})
CONSTANT_BETWEEN = frozenset(
    {*WHOLE_NUMBERS, ca.OP_SIGN, ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_NOT, ca.OP_AND, ca.OP_OR}
)
LINEAR_BETWEEN = frozenset(
    {ca.OP_ASSIGN, ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE, ca.OP_FABS, ca.OP_FMIN, ca.OP_FMAX, ca.OP_IF_ELSE_ZERO}
)


@dataclass(frozen=True, eq=False)
class TimeSwitch:
    """A place in time: where ``value`` (t, p) -> s passes zero, or with ``whole`` every whole number.

    ``affine``: s is a straight line in time between the places of the switches before it. ``rate`` (t, p) -> ds/dt.
    """

    value: ca.Function
    rate: ca.Function
    whole: bool
    affine: bool


@functools.lru_cache(maxsize=64)
def time_switches(function: ca.Function) -> tuple[TimeSwitch, ...]:
    """The switches of an SX function (t, x, p) -> column, each after those that it depends on.

    >>> t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p")
    >>> found = time_switches(ca.Function("f", [t, x, p], [ca.floor(2 * t) * ca.fabs(x) + ca.if_else(t < p, 1, 2)]))
    >>> [(each.whole, each.affine) for each in found]
    [(True, True), (False, True)]
    """
    if not function.is_a("SXFunction"):
        return ()
    codes = {function.instruction_id(index) for index in range(function.n_instructions())}
    if not codes & JUMPS:
        return ()
    t, p = ca.SX.sym("t"), ca.SX.sym("p", *function.size_in(2))
    found = []
    for surface, degree, whole in _surfaces(function, t, p):
        if not ca.depends_on(surface, t):
            continue
        rate, affine = ca.jacobian(surface, t), degree <= 1
        value, rates = (ca.Function(name, [t, p], [ca.densify(each)]) for name, each in (("value", surface), ("rate", rate)))
        found.append(TimeSwitch(value, rates, whole, affine))
    return tuple(found)


def _surfaces(function: ca.Function, t: ca.SX, p: ca.SX) -> Iterator[tuple[ca.SX, int, bool]]:
    """What each switch of time compares with zero, or with whole numbers, in the order of the instructions.

    With it its degree in time between the switches before it: 0, 1, or 2 for anything else.
    """
    work: dict[int, tuple[ca.SX, int] | None] = {}  # what a register holds, and its degree, unless it depends on the state
    for code, source, target, number in instructions(function):
        if code == ca.OP_CONST:
            work[target[0]] = ca.SX(number), 0
        elif code == ca.OP_INPUT:
            work[target[0]] = {0: (t, 1), 2: (p[source[1]], 0) if p.numel() else None}.get(source[0])
        elif code != ca.OP_OUTPUT:
            operands = [work[register] for register in source]
            known = [each for each in operands if each is not None]
            if len(known) < len(operands):
                work[target[0]] = None
                continue
            parts, degrees = [each[0] for each in known], [each[1] for each in known]
            if code in JUMPS:
                surface, whole = _surface(code, parts)
                yield surface, max(degrees), whole
            value = ca.SX.binary(code, *parts) if len(parts) == 2 else ca.SX.unary(code, parts[0])
            work[target[0]] = value, _degree(code, degrees)


def _degree(code: int, degrees: list[int]) -> int:
    """The degree in time of what an operation makes, between the places where it switches."""
    if code in CONSTANT_BETWEEN or max(degrees) == 0:
        return 0
    if code == ca.OP_MUL:
        return min(sum(degrees), 2)
    if code == ca.OP_DIV:
        return degrees[0] if degrees[1] == 0 else 2
    return max(degrees) if code in LINEAR_BETWEEN else 2


def _surface(code: int, operands: list[ca.SX]) -> tuple[ca.SX, bool]:
    first, last = operands[0], operands[-1]
    if code in ZERO_OF_DIFFERENCE:
        return first - last, False
    if code in WHOLE_NUMBERS:
        return first, True
    if code in (ca.OP_FMOD, ca.OP_REMAINDER):
        return first / last + (0.5 if code == ca.OP_REMAINDER else 0.0), True
    return (last if code == ca.OP_COPYSIGN else first), False
