"""The translator: one SymPy expression in, one CasADi SX expression out, through an explicit table of operations.

First step of ``lowering``: whatever becomes a number passes here, and what is not in the table is refused by name. Each distinct
subexpression is translated once, and nothing recurses, so neither depth nor sharing costs more than the number of nodes. A
Rational becomes its correctly rounded double. The table, with its conventions where a function is not smooth, is ``operations``.
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Mapping, Sequence

import casadi as ca
import sympy
from sympy.core.function import AppliedUndef

from modelgen.errors import LoweringError, nearest
from modelgen.lowering.operations import OPERATIONS, Quotient, constant_value, operations


class Visitor:
    """Translates scalar SymPy expressions of the given symbols to CasADi SX, remembering what it has translated.

    ``symbols`` gives the SX scalar of each SymPy symbol (SymPy tells symbols with different assumptions apart, and so does this);
    ``where`` opens every error message. Numbers of Python and SymPy pass as constants. Raises LoweringError for an unknown
    symbol, for a class outside :func:`operations`, for a Piecewise without a final True, and for a number that is not finite and
    real.

    >>> x = sympy.Symbol("x")
    >>> lower = Visitor({x: ca.SX.sym("x")}, where="shaft 's'")
    >>> lower(sympy.sqrt(x) / (1 + x**2))
    SX((sqrt(x)/(1+sq(x))))
    """

    def __init__(self, symbols: Mapping[sympy.Symbol, ca.SX], where: str = "expression") -> None:
        self._where = where
        self._symbols = dict(symbols)
        for symbol, value in self._symbols.items():
            if not isinstance(value, ca.SX) or not value.is_scalar():
                raise LoweringError(where, f"symbol {str(symbol)!r} stands for {_kind(value)}", "give a CasADi SX of one element")
        # By identity, so that no hash or comparison walks an expression; the node is kept, or its identity could be reused.
        self._seen: dict[int, tuple[sympy.Basic, ca.SX]] = {}
        # By operation and identities of the translated operands: equal expressions that are distinct objects meet here.
        self._made: dict[tuple[object, ...], ca.SX] = {}

    def __call__(self, expression: sympy.Basic | numbers.Real) -> ca.SX:
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
        if type(node) not in OPERATIONS:
            raise self._unknown(node)
        if isinstance(node, sympy.Piecewise):
            if node.args[-1].args[1] is not sympy.true:
                raise self._refusal("Piecewise has no piece for the remaining case", "end it with (expression, True)")
            return tuple(part for piece in node.args for part in piece.args)
        return node.args

    def _translated(self, node: sympy.Basic) -> ca.SX:
        if isinstance(node, sympy.Symbol):
            return self._symbol(node)
        if isinstance(node, _LEAVES):
            return self._number(node)
        if isinstance(node, sympy.Mul):
            return self._product(node.args)
        operands = [self._value(part) for part in self._operands(node)]
        return self._operation(type(node), *operands)

    def _value(self, node: sympy.Basic) -> ca.SX:
        return self._seen[id(node)][1]

    def _operation(self, kind: type[sympy.Basic], *operands: ca.SX) -> ca.SX:
        """The operation on translated operands, made once."""
        key = (kind, *map(id, operands))
        if key not in self._made:
            value = OPERATIONS[kind](*operands)
            if value.is_constant() and not value.is_regular():
                raise self._refusal(f"{kind.__name__} of constants gives {value}", "keep its arguments in the real domain")
            self._made[key] = value
        return self._made[key]

    def _product(self, factors: Sequence[sympy.Basic]) -> ca.SX:
        """A product; negative powers gather in one denominator, so that x/y is one rounding and not two."""
        above, below = [], []
        for factor in factors:
            if (
                isinstance(factor, sympy.Pow)
                and (exponent := constant_value(self._value(factor.exp))) is not None
                and exponent < 0
            ):
                below.append(self._operation(sympy.Pow, self._value(factor.base), self._number(-exponent)))
            else:
                above.append(self._value(factor))
        numerator = self._operation(sympy.Mul, *above)
        return self._operation(Quotient, numerator, self._operation(sympy.Mul, *below)) if below else numerator

    def _symbol(self, symbol: sympy.Symbol) -> ca.SX:
        if symbol in self._symbols:
            return self._symbols[symbol]
        names = [known.name for known in self._symbols]
        if symbol.name in names:
            raise self._refusal(f"symbol {symbol.name!r} has other assumptions than the known one", "use the declared one")
        raise self._refusal(f"unknown symbol {symbol.name!r}", nearest(symbol.name, names))

    def _number(self, number: sympy.Basic | numbers.Real) -> ca.SX:
        value = _double(number)
        if value is None:  # its digits are not shown: there can be any number of them
            raise self._refusal(f"{_kind(number)} lies beyond the range of double precision", "scale the expression")
        if not math.isfinite(value):
            raise self._refusal(f"{value} is not a finite real number", "give a finite real number")
        return self._made.setdefault((float, value), ca.SX(value))

    def _unknown(self, node: sympy.Basic) -> LoweringError:
        if isinstance(node, _UNREAL):
            return self._refusal(f"{node} is not a finite real number", "give a finite real number")
        name = node.func.__name__
        kind = "undefined function" if isinstance(node, AppliedUndef) else "class"
        known = [operation.__name__ for operation in operations()]
        return self._refusal(f"{kind} {name!r} has no numeric counterpart", nearest(name, known))

    def _refusal(self, problem: str, remedy: str) -> LoweringError:
        return LoweringError(self._where, problem, remedy)


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
    beyond = (value == 0 and not _is_zero(number)) or (math.isinf(value) and isinstance(number, sympy.Float))
    return None if beyond else value


def _is_zero(number: sympy.Basic | numbers.Real) -> bool:
    """Whether a number is 0; SymPy's 0.0 is not equal to its 0."""
    return bool(number.is_zero) if isinstance(number, sympy.Basic) else number == 0


def _kind(thing: object) -> str:
    return f"an object of class {type(thing).__name__!r}"
