"""What SymPy can be asked without taking hours: bounds on constants, degrees and nesting of functions.

Stands in ``model``, below ``expressions``.
"""

from __future__ import annotations

import sympy

LARGEST_EXACT = 2**53

# To learn whether one of these is real, SymPy splits its argument into real and imaginary part and multiplies out whatever roots
# and functions it holds: tanh(log((x + y)**60)) never ends.
HYPERBOLIC = frozenset(["sinh", "cosh", "tanh"])
_WITHIN_HYPERBOLIC = (sympy.Add, sympy.Mul, sympy.Symbol, sympy.Abs, sympy.Min, sympy.Max)


def number(value: float) -> sympy.Expr:
    """A whole number is an Integer, so that x**2.0 is x**2 and 1.0*x is x."""
    return sympy.Integer(int(value)) if value.is_integer() and abs(value) <= LARGEST_EXACT else sympy.Float(value)


def is_plain(constant: sympy.Expr) -> bool:
    """Whether a constant is a rational number of bounded size, that times pi or one root, or a double that is not whole."""
    coefficient, rest = constant.as_coeff_Mul()
    if coefficient.is_Rational:
        root = rest.is_Pow and rest.base.is_Integer and rest.base.is_positive and rest.exp.is_Rational
        numbers = (coefficient, rest.base, rest.exp) if root else (coefficient,)
        bounded = all(max(abs(number.p), number.q) <= LARGEST_EXACT for number in numbers)
        return bounded and (root or rest in (sympy.S.One, sympy.pi))
    return coefficient.is_Float and rest is sympy.S.One and coefficient == number(float(coefficient))


def is_rational_function(argument: sympy.Expr) -> bool:
    """Whether nothing stands in it that a hyperbolic function cannot bear inside."""
    if argument.is_number:
        return True
    if isinstance(argument, sympy.Pow):
        return bool(argument.exp.is_Integer) and is_rational_function(argument.base)
    return isinstance(argument, _WITHIN_HYPERBOLIC) and all(is_rational_function(each) for each in argument.args)


def degrees_of_sum(parts: tuple[sympy.Expr, ...]) -> tuple[int, int] | None:
    """Degrees of numerator and denominator, as large as they can be, of a sum of rational functions; None if it is not one."""
    found = [degrees(part) for part in parts]
    known = [each for each in found if each is not None]
    if len(known) < len(found):
        return None
    below = sum(under for _, under in known)
    return max(above + below - under for above, under in known), below


def degrees(expression: sympy.Expr) -> tuple[int, int] | None:
    """Degrees of numerator and denominator, as large as they can be; None where it is no rational function."""
    if expression.is_number:
        return 0, 0
    if expression.is_Symbol:
        return 1, 0
    if expression.is_Add:
        return degrees_of_sum(expression.args)
    if expression.is_Mul:
        known = [each for each in map(degrees, expression.args) if each is not None]
        complete = len(known) == len(expression.args)
        return (sum(above for above, _ in known), sum(below for _, below in known)) if complete else None
    if expression.is_Pow and expression.exp.is_Integer and (base := degrees(expression.base)) is not None:
        power = abs(int(expression.exp))
        return (base[0] * power, base[1] * power) if expression.exp.is_positive else (base[1] * power, base[0] * power)
    return None
