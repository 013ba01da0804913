"""The translator: one SymPy expression in, one CasADi SX expression out, through an explicit table of operations.

First step of ``lowering``: whatever becomes a number passes here, and what is not in the table is refused by name. Each distinct
subexpression is translated once, and nothing recurses, so neither depth nor sharing costs more than the number of nodes.

Everything is real double precision: a logarithm or root of a negative number is NaN at run time, never complex. A Rational is its
correctly rounded double. Conventions where a function is not smooth (value; derivative as CasADi takes it, measured, 3.8.2):

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
import numbers
import operator
from collections.abc import Callable, Mapping, Sequence
from functools import reduce

import casadi
import sympy
from sympy.core.function import AppliedUndef

from modelgen.errors import LoweringError, nearest
from modelgen.model.tables import PeriodicSteps, PeriodicTable

SX = casadi.SX


class Visitor:
    """Translates scalar SymPy expressions of the given symbols to CasADi SX, remembering what it has translated.

    ``symbols`` gives the SX scalar of each SymPy symbol (SymPy tells symbols with different assumptions apart, and so does this);
    ``where`` opens every error message. Numbers of Python and SymPy pass as constants. Raises LoweringError for an unknown
    symbol, for a class outside :func:`operations`, for a Piecewise without a final True, and for a number that is not finite and
    real.

    >>> x = sympy.Symbol("x")
    >>> lower = Visitor({x: SX.sym("x")}, where="shaft 's'")
    >>> lower(sympy.sqrt(x) / (1 + x**2))
    SX((sqrt(x)/(1+sq(x))))
    """

    def __init__(self, symbols: Mapping[sympy.Symbol, SX], where: str = "expression") -> None:
        self._where = where
        self._symbols = dict(symbols)
        for symbol, value in self._symbols.items():
            if not isinstance(value, SX) or not value.is_scalar():
                raise LoweringError(where, f"symbol {str(symbol)!r} stands for {_kind(value)}", "give a CasADi SX of one element")
        # By identity, so that no hash or comparison walks an expression; the node is kept, or its identity could be reused.
        self._seen: dict[int, tuple[sympy.Basic, SX]] = {}
        # By operation and identities of the translated operands: equal expressions that are distinct objects meet here.
        self._made: dict[tuple[object, ...], SX] = {}

    def __call__(self, expression: sympy.Basic | numbers.Real) -> SX:
        """The SX expression of a scalar SymPy expression or of a real number. Raises LoweringError."""
        if isinstance(expression, numbers.Real) and not isinstance(expression, sympy.Basic):
            return self._number(expression)
        if not isinstance(expression, sympy.Basic):
            raise self._refusal(f"got {_kind(expression)}", "give a scalar SymPy expression or a real number")
        stack = [expression]
        while stack:
            node = stack[-1]
            waiting = [] if id(node) in self._seen else [part for part in self._operands(node) if id(part) not in self._seen]
            if waiting:
                stack.extend(waiting)
                continue
            stack.pop()
            if id(node) not in self._seen:
                self._seen[id(node)] = node, self._translated(node)
        return self._value(expression)

    def _operands(self, node: sympy.Basic) -> Sequence[sympy.Basic]:
        """What must be translated before the node; a class outside the table is refused here, before its parts are looked at."""
        if isinstance(node, _LEAVES):
            return ()
        if type(node) not in _OPERATIONS:
            raise self._unknown(node)
        if isinstance(node, sympy.Piecewise):
            if node.args[-1].args[1] is not sympy.true:
                raise self._refusal("Piecewise has no piece for the remaining case", "end it with (expression, True)")
            return tuple(part for piece in node.args for part in piece.args)
        return node.args

    def _translated(self, node: sympy.Basic) -> SX:
        if isinstance(node, sympy.Symbol):
            return self._symbol(node)
        if isinstance(node, _LEAVES):
            return self._number(node)
        if isinstance(node, sympy.Mul):
            return self._product(node.args)
        operands = [self._value(part) for part in self._operands(node)]
        return self._operation(type(node), *operands)

    def _value(self, node: sympy.Basic) -> SX:
        return self._seen[id(node)][1]

    def _operation(self, kind: type[sympy.Basic], *operands: SX) -> SX:
        """The operation on translated operands, made once."""
        key = (kind, *map(id, operands))
        if key not in self._made:
            value = _OPERATIONS[kind](*operands)
            if value.is_constant() and not value.is_regular():
                raise self._refusal(f"{kind.__name__} of constants gives {value}", "keep its arguments in the real domain")
            self._made[key] = value
        return self._made[key]

    def _product(self, factors: Sequence[sympy.Basic]) -> SX:
        """A product; negative powers gather in one denominator, so that x/y is one rounding and not two."""
        above, below = [], []
        for factor in factors:
            if isinstance(factor, sympy.Pow) and (exponent := _constant(self._value(factor.exp))) is not None and exponent < 0:
                below.append(self._operation(sympy.Pow, self._value(factor.base), self._number(-exponent)))
            else:
                above.append(self._value(factor))
        numerator = self._operation(sympy.Mul, *above)
        return self._operation(_Quotient, numerator, self._operation(sympy.Mul, *below)) if below else numerator

    def _symbol(self, symbol: sympy.Symbol) -> SX:
        if symbol in self._symbols:
            return self._symbols[symbol]
        names = [known.name for known in self._symbols]
        if symbol.name in names:
            raise self._refusal(f"symbol {symbol.name!r} has other assumptions than the known one", "use the declared one")
        raise self._refusal(f"unknown symbol {symbol.name!r}", nearest(symbol.name, names))

    def _number(self, number: sympy.Basic | numbers.Real) -> SX:
        value = _double(number)
        if value is None:  # its digits are not shown: there can be any number of them
            raise self._refusal(f"{_kind(number)} lies beyond the range of double precision", "scale the expression")
        if not math.isfinite(value):
            raise self._refusal(f"{value} is not a finite real number", "give a finite real number")
        return self._made.setdefault((float, value), SX(value))

    def _unknown(self, node: sympy.Basic) -> LoweringError:
        if isinstance(node, _UNREAL):
            return self._refusal(f"{node} is not a finite real number", "give a finite real number")
        name = node.func.__name__
        kind = "undefined function" if isinstance(node, AppliedUndef) else "class"
        known = [operation.__name__ for operation in operations()]
        return self._refusal(f"{kind} {name!r} has no numeric counterpart", nearest(name, known))

    def _refusal(self, problem: str, remedy: str) -> LoweringError:
        return LoweringError(self._where, problem, remedy)


def operations() -> tuple[type[sympy.Basic], ...]:
    """The SymPy classes that can be translated, besides symbols and real numbers.

    >>> sympy.tanh in operations(), sympy.gamma in operations()
    (True, False)
    """
    return tuple(kind for kind in _OPERATIONS if kind is not _Quotient)


class _Quotient(sympy.Basic):
    """Name of the division in the table: SymPy has none of its own."""


def _power(base: SX, exponent: SX) -> SX:
    """Power; CasADi turns whole exponents up to 100 into repeated squaring."""
    constant = _constant(exponent)
    if constant is None:
        return casadi.exp(exponent) if _constant(base) == math.e else base**exponent
    if constant < 0:
        return 1 / _power(base, -exponent)
    return casadi.sqrt(base) if constant == 0.5 else base**constant


def _logarithm(value: SX, base: SX | None = None) -> SX:
    return casadi.log(value) if base is None else casadi.log(value) / casadi.log(base)


def _modulo(dividend: SX, divisor: SX) -> SX:
    return dividend - divisor * casadi.floor(dividend / divisor)


def _heaviside(value: SX, at_zero: SX) -> SX:
    return (1 + casadi.sign(value)) / 2 + (value == 0) * (at_zero - 0.5)


def _piecewise(*parts: SX) -> SX:
    """``parts`` alternate between values and conditions; the last condition is true."""
    pieces = list(zip(parts[:-2:2], parts[1:-2:2], strict=True))
    return reduce(lambda otherwise, piece: casadi.if_else(piece[1], piece[0], otherwise), reversed(pieces), parts[-2])


def _position(phase: SX, count: int) -> SX:
    """Place in a table of ``count`` samples, from -1/2 to count - 1/2: whole turns go exactly, and no sample lies at the cut."""
    return count * (phase - casadi.floor(phase + 1 / (2 * count)))


def _periodic_table(phase: SX, *values: SX) -> SX:
    """Σ v_k max(0, 1 - |s - k|), with one sample repeated beyond each end."""
    position = _position(phase, len(values))
    hats = ((casadi.fmax(0, 1 - casadi.fabs(position - k)), k) for k in range(-1, len(values) + 1))
    return reduce(operator.add, (values[k % len(values)] * hat for hat, k in hats))


def _periodic_steps(phase: SX, *values: SX) -> SX:
    """Σ m_k (sign(s - k) - sign(s - k - 1))/2, with the last interval also before the first."""
    position = _position(phase, len(values))
    signs = [casadi.sign(position - k) for k in range(-1, len(values) + 1)]
    boxes = ((before - after) / 2 for before, after in itertools.pairwise(signs))
    return reduce(operator.add, (values[k % len(values)] * box for k, box in enumerate(boxes, start=-1)))


def _folded(operation: Callable[[SX, SX], SX], start: float) -> Callable[..., SX]:
    return lambda *operands: reduce(operation, operands) if operands else SX(start)


_OPERATIONS: dict[type[sympy.Basic], Callable[..., SX]] = {
    sympy.Add: _folded(operator.add, 0),
    sympy.Mul: _folded(operator.mul, 1),
    _Quotient: operator.truediv,
    sympy.Pow: _power,
    sympy.exp: casadi.exp,
    sympy.log: _logarithm,
    sympy.sin: casadi.sin,
    sympy.cos: casadi.cos,
    sympy.tan: casadi.tan,
    sympy.asin: casadi.asin,
    sympy.acos: casadi.acos,
    sympy.atan: casadi.atan,
    sympy.atan2: casadi.atan2,
    sympy.sinh: casadi.sinh,
    sympy.cosh: casadi.cosh,
    sympy.tanh: casadi.tanh,
    sympy.asinh: casadi.asinh,
    sympy.acosh: casadi.acosh,
    sympy.atanh: casadi.atanh,
    sympy.Abs: casadi.fabs,
    sympy.sign: casadi.sign,
    sympy.floor: casadi.floor,
    sympy.ceiling: casadi.ceil,
    sympy.Mod: _modulo,
    sympy.Min: _folded(casadi.fmin, math.inf),
    sympy.Max: _folded(casadi.fmax, -math.inf),
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
    sympy.And: _folded(casadi.logic_and, 1),
    sympy.Or: _folded(casadi.logic_or, 0),
    sympy.Not: casadi.logic_not,
    sympy.ITE: casadi.if_else,  # what SymPy makes of a comparison of a Piecewise
    PeriodicTable: _periodic_table,
    PeriodicSteps: _periodic_steps,
}

_CONSTANTS = {type(sympy.pi): math.pi, type(sympy.E): math.e, type(sympy.true): 1.0, type(sympy.false): 0.0}
_LEAVES = (sympy.Symbol, sympy.Rational, sympy.Float, *_CONSTANTS)
_UNREAL = tuple(map(type, (sympy.I, sympy.oo, -sympy.oo, sympy.nan, sympy.zoo)))


def _double(number: sympy.Basic | numbers.Real) -> float | None:
    """The nearest double; None where the number is too large, or too small to be told from 0."""
    if type(number) in _CONSTANTS:
        return _CONSTANTS[type(number)]
    try:
        # The division of Python's integers rounds once, however long they are.
        value = number.p / number.q if isinstance(number, sympy.Rational) else float(number)
    except OverflowError:
        return None
    beyond = (value == 0 and number != 0) or (math.isinf(value) and isinstance(number, sympy.Float))
    return None if beyond else value


def _constant(value: SX) -> float | None:
    return float(value) if value.is_constant() else None


def _kind(thing: object) -> str:
    return f"an object of class {type(thing).__name__!r}"
