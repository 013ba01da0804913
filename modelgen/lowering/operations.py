"""The table of operations: what each SymPy class becomes in CasADi. What is not here has no numeric counterpart.

Part of ``lowering``, under ``visitor``, which walks an expression and asks here for one operation at a time.

Everything is real double precision: a logarithm or root of a negative number is NaN at run time, never complex.
Conventions where a function is not smooth (value; derivative as CasADi takes it, measured, 3.8.2):

=====================  ======================================  ===============================================================
Abs, sign at 0         0                                       0
floor, ceiling         as SymPy                                0 everywhere
Mod(a, b)              a - b floor(a/b), sign of b             1 and -floor(a/b) everywhere, jumps not counted. Exact for b = 1,
                                                               else within the rounding of a (C's fmod is 20 times slower)
Max, Min at a tie      the common value                        mean of both sides (more than two: pair by pair, in order).
                                                               A NaN argument is passed over, as in C's fmax
Heaviside(x, H0) at 0  H0, which is 1/2 unless given           0 everywhere
Piecewise              first piece whose condition holds       that of the piece taken, also on its border
PeriodicTable          linear interpolation                    mean of both sides at a sample
PeriodicSteps          mean of both sides at a jump            0 everywhere
atan2(0, 0)            0 (SymPy: NaN)                          NaN
Pow(x, y)              C's pow unless y is whole or ±1/2       symbolic y: contains log(x), so NaN for x <= 0
=====================  ======================================  ===============================================================

Piecewise becomes nested selections: every piece is evaluated, one is selected. A NaN or infinity in a piece not taken does not
reach the value, nor forward derivatives, nor (as far as measured) CasADi's Jacobian. It can reach a reverse derivative, so also a
Hessian, where two pieces share a singular subexpression such as sqrt(x): the adjoint then multiplies 0 with infinity. If
Hessians are asked for, keep the argument of such a subexpression off the singular point, as in sqrt(Max(x, 1e-12)).

Source: SymPy's documentation of each class (principal values); CasADi's of ``if_else``, ``fmax``, ``fmod``.
"""

from __future__ import annotations

import itertools
import math
import operator
from collections.abc import Callable
from functools import reduce

import casadi as ca
import sympy

from modelgen.model.tables import PeriodicSteps, PeriodicTable


def operations() -> tuple[type[sympy.Basic], ...]:
    """The SymPy classes that can be translated, besides symbols and real numbers.

    >>> sympy.tanh in operations(), sympy.gamma in operations()
    (True, False)
    """
    return tuple(kind for kind in OPERATIONS if kind is not Quotient)


class Quotient(sympy.Basic):
    """Name of the division in the table: SymPy has none of its own."""


def constant_value(value: ca.SX) -> float | None:
    """The number that a scalar expression is; None if it depends on a symbol."""
    return float(value) if value.is_constant() else None


def _power(base: ca.SX, exponent: ca.SX) -> ca.SX:
    """Power; CasADi turns whole exponents up to 100 into repeated squaring."""
    constant = constant_value(exponent)
    if constant is None:
        return ca.exp(exponent) if constant_value(base) == math.e else base**exponent
    if constant < 0:
        return 1 / _power(base, -exponent)
    return ca.sqrt(base) if constant == 0.5 else base**constant


def _logarithm(value: ca.SX, base: ca.SX | None = None) -> ca.SX:
    return ca.log(value) if base is None else ca.log(value) / ca.log(base)


def _modulo(dividend: ca.SX, divisor: ca.SX) -> ca.SX:
    return dividend - divisor * ca.floor(dividend / divisor)


def _heaviside(value: ca.SX, at_zero: ca.SX) -> ca.SX:
    return (1 + ca.sign(value)) / 2 + (value == 0) * (at_zero - 0.5)


def _piecewise(*parts: ca.SX) -> ca.SX:
    """``parts`` alternate between values and conditions; the last condition is true."""
    pieces = list(zip(parts[:-2:2], parts[1:-2:2], strict=True))
    return reduce(lambda otherwise, piece: ca.if_else(piece[1], piece[0], otherwise), reversed(pieces), parts[-2])


def _position(phase: ca.SX, count: int) -> ca.SX:
    """Place in a table of ``count`` samples, from -1/2 to count - 1/2: whole turns go exactly, and no sample lies at the cut."""
    return count * (phase - ca.floor(phase + 1 / (2 * count)))


def _periodic_table(phase: ca.SX, *values: ca.SX) -> ca.SX:
    """Σ v_k max(0, 1 - |s - k|), with one sample repeated beyond each end."""
    position = _position(phase, len(values))
    hats = ((ca.fmax(0, 1 - ca.fabs(position - k)), k) for k in range(-1, len(values) + 1))
    return reduce(operator.add, (values[k % len(values)] * hat for hat, k in hats))


def _periodic_steps(phase: ca.SX, *values: ca.SX) -> ca.SX:
    """Σ m_k (sign(s - k) - sign(s - k - 1))/2, with the last interval also before the first."""
    position = _position(phase, len(values))
    signs = [ca.sign(position - k) for k in range(-1, len(values) + 1)]
    boxes = ((before - after) / 2 for before, after in itertools.pairwise(signs))
    return reduce(operator.add, (values[k % len(values)] * box for k, box in enumerate(boxes, start=-1)))


def _folded(operation: Callable[[ca.SX, ca.SX], ca.SX], start: float) -> Callable[..., ca.SX]:
    return lambda *operands: reduce(operation, operands) if operands else ca.SX(start)


OPERATIONS: dict[type[sympy.Basic], Callable[..., ca.SX]] = {
    sympy.Add: _folded(operator.add, 0),
    sympy.Mul: _folded(operator.mul, 1),
    Quotient: operator.truediv,
    sympy.Pow: _power,
    sympy.exp: ca.exp,
    sympy.log: _logarithm,
    sympy.sin: ca.sin,
    sympy.cos: ca.cos,
    sympy.tan: ca.tan,
    sympy.asin: ca.asin,
    sympy.acos: ca.acos,
    sympy.atan: ca.atan,
    sympy.atan2: ca.atan2,
    sympy.sinh: ca.sinh,
    sympy.cosh: ca.cosh,
    sympy.tanh: ca.tanh,
    sympy.asinh: ca.asinh,
    sympy.acosh: ca.acosh,
    sympy.atanh: ca.atanh,
    sympy.Abs: ca.fabs,
    sympy.sign: ca.sign,
    sympy.floor: ca.floor,
    sympy.ceiling: ca.ceil,
    sympy.Mod: _modulo,
    sympy.Min: _folded(ca.fmin, math.inf),
    sympy.Max: _folded(ca.fmax, -math.inf),
    sympy.Heaviside: _heaviside,
    # SymPy puts these two where it cannot prove an argument real; here everything is.
    sympy.re: lambda value: value,
    sympy.im: lambda value: 0 * value,
    sympy.Piecewise: _piecewise,
    sympy.Lt: operator.lt,
    sympy.Le: operator.le,
    sympy.Gt: operator.gt,
    sympy.Ge: operator.ge,
    sympy.Eq: operator.eq,
    sympy.Ne: operator.ne,
    sympy.And: _folded(ca.logic_and, 1),
    sympy.Or: _folded(ca.logic_or, 0),
    sympy.Not: ca.logic_not,
    sympy.ITE: ca.if_else,  # what SymPy makes of a comparison of a Piecewise
    PeriodicTable: _periodic_table,
    PeriodicSteps: _periodic_steps,
}
