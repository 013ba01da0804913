"""Expressions back to text, so that a model file that was read can be written.

Stands in ``model``, beside ``expressions``.
"""

from __future__ import annotations

import sympy

from modelgen.errors import ModelFileError, NamingError
from modelgen.model.expression_text import ALLOWED, NAME, WRITTEN

_SUM, _PRODUCT, _POWER, _ATOM = range(4)


def write_expression(expression: sympy.Expr) -> str:
    """The text of an expression; reading what was read and written gives an equal expression.

    Raises ModelFileError for an operation and NamingError for a symbol that ``read_expression`` does not know.

    >>> x, y = sympy.symbols("x y", real=True)
    >>> write_expression(x / sympy.sqrt(2 * y) - 0.5)
    'sqrt(2)*x/2/sqrt(y) - 0.5'
    """
    return _write(expression)[0]


def _write(expression: sympy.Expr) -> tuple[str, int]:
    """The text and how tightly its outermost operation binds."""
    if expression.is_Symbol:
        if not NAME.fullmatch(expression.name):
            raise NamingError("expression", f"symbol {expression.name!r} cannot be written", "use identifiers, joined by dots")
        return expression.name, _ATOM
    if expression is sympy.pi:
        return "pi", _ATOM
    if expression.is_Integer or expression.is_Float:
        text = str(expression) if expression.is_Integer else repr(float(expression))
        return text, _SUM if expression.is_negative else _ATOM
    if expression.is_Add:
        terms = [_write(term)[0] for term in expression.as_ordered_terms()]
        rest = (f" - {term[1:]}" if term.startswith("-") else f" + {term}" for term in terms[1:])
        return terms[0] + "".join(rest), _SUM
    if expression.is_Mul or expression.is_Rational or _is_inverse(expression):
        return _write_product(expression)
    if expression.is_Pow:
        if expression.exp == sympy.S.Half:
            return f"sqrt({_write(expression.base)[0]})", _ATOM
        return f"{_tight(expression.base, _ATOM)}**{_tight(expression.exp, _ATOM)}", _POWER
    if type(expression) in WRITTEN:
        return f"{WRITTEN[type(expression)]}({', '.join(_write(argument)[0] for argument in expression.args)})", _ATOM
    raise ModelFileError("expression", f"{str(expression)[:60]!r} has no form in a model file", ALLOWED)


def _write_product(expression: sympy.Expr) -> tuple[str, int]:
    coefficient, rest = expression.as_coeff_Mul()
    factors = rest.as_ordered_factors()
    above = [factor for factor in factors if factor is not sympy.S.One and not _is_inverse(factor)]
    below = [1 / factor for factor in factors if _is_inverse(factor)]
    number = abs(coefficient)
    if number.is_Rational:
        above = [sympy.Integer(number.p)] * (number.p != 1 or not above) + above
        below = [sympy.Integer(number.q)] * (number.q != 1) + below
    else:
        above = [number, *above]
    text = "*".join(_tight(factor, _POWER) for factor in above) + "".join(f"/{_tight(factor, _POWER)}" for factor in below)
    return (f"-{text}", _SUM) if coefficient.is_negative else (text, _PRODUCT)


def _tight(expression: sympy.Expr, least: int) -> str:
    text, level = _write(expression)
    return text if level >= least else f"({text})"


def _is_inverse(expression: sympy.Expr) -> bool:
    return bool(expression.is_Pow and expression.exp.is_Number and expression.exp.is_negative)
