"""Expressions of model files: text to SymPy through an allow-list, and back.

Stands in ``model``, between a model file and the parameters whose values it writes as expressions. The text is cut into tokens,
Python's grammar orders them (``ast``), and each node of the tree must be one of those known here: nothing is ever evaluated as
Python, and SymPy is asked to combine only numbers of bounded size. The limits below keep its automatic simplification, which
else can take hours over one line, to milliseconds, or to seconds for a text made to be slow.

Constants are exact where they are a rational number, or that times pi or one root such as sqrt(2), and doubles otherwise, so that
``2*pi*f`` stays readable and no constant grows.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Mapping
from typing import Any

import sympy

from modelgen.errors import NamingError, nearest
from modelgen.model.expression_limits import HYPERBOLIC, degrees_of_sum, is_plain, is_rational_function, number
from modelgen.model.expression_text import ALLOWED, DEEPEST, FUNCTIONS, WRITTEN, ExpressionText, Numeric
from modelgen.model.expression_writing import write_expression

MOST_NODES = 500
LARGEST_EXPONENT = 64
LARGEST_DEGREE = 12
"""Of a sum in one name of known sign, over its common denominator: SymPy looks for its roots to learn the sign of the sum."""
MOST_COMPARED = 8
"""Arguments of one ``min`` or ``max``: SymPy compares each with every other."""


def read_expression(text: str, symbols: Mapping[str, sympy.Symbol], where: str) -> sympy.Expr:
    """The SymPy expression that a text of a model file stands for.

    Numbers, names of ``symbols`` (dotted ones too), ``+ - * / **``, parentheses, ``pi`` and the functions ``sqrt exp log abs sin
    cos tan asin acos atan atan2 sinh cosh tanh min max``. The symbols are real, each under its own name.

    Raises NamingError for an unknown name, ModelFileError for everything else that cannot be read.

    >>> inertia, ratio = sympy.symbols("disk.inertia ratio", real=True)
    >>> table = {"disk.inertia": inertia, "ratio": ratio}
    >>> read_expression("3*disk.inertia/ratio**2", table, "parameter 'referred'")
    3*disk.inertia/ratio**2
    >>> read_expression("disk.inertai/2", table, "parameter 'referred'")
    Traceback (most recent call last):
    ...
    modelgen.errors.NamingError: parameter 'referred': there is no 'disk.inertai'; nearest is 'disk.inertia'
    """
    reader = _Reader(text, symbols, where)
    try:
        expression = reader.expression()
        # SymPy may simplify a large expression further when it meets it again: what is returned has come to rest, so that a
        # model that is written and read again is the same model.
        for _ in range(4):
            again = _Reader(write_expression(expression), symbols, f"{where}, simplified").expression()
            if again == expression:
                return expression
            expression = again
    except (RecursionError, MemoryError):
        reader.refuse_depth()
    reader.refuse(f"{text[:60]!r} has no settled form", "write it another way")


class _Reader(ExpressionText):
    """One text on its way to one expression."""

    def __init__(self, text: object, symbols: Mapping[str, sympy.Symbol], where: str) -> None:
        super().__init__(text, where)
        self.symbols = symbols
        # Parts of SymPy trees that are known to be in order, so that each is looked at once.
        self.settled: set[sympy.Expr] = set()

    def expression(self) -> sympy.Expr:
        self.scan()
        try:
            tree = ast.parse(self.text, mode="eval").body
        except SyntaxError as error:
            place = (error.offset or 1) - 1
            near = f" at {self.text[place:][:20]!r}" if 0 < place < len(self.text) else ""
            self.refuse(f"{self.text[:60]!r} is no expression{near}", ALLOWED)
        nodes = sum(isinstance(node, ast.expr) for node in ast.walk(tree))
        if nodes > MOST_NODES:
            problem = f"the expression has {nodes} numbers, names and operations, {MOST_NODES} are allowed"
            self.refuse(problem, "name its parts as parameters")
        return self.read(tree, 0)

    # -- tokens to SymPy -----------------------------------------------------------------------------------------------------

    def read(self, node: ast.expr, depth: int) -> sympy.Expr:
        """The expression of a node that stands ``depth`` operations below the top."""
        if depth > DEEPEST:
            self.refuse_depth()
        match node:
            case ast.Constant():
                return self.literal(node)
            case ast.Name() | ast.Attribute():
                return self.symbol(self.source(node))
            case ast.BinOp(op=ast.Add() | ast.Sub()):
                return self.sum(node, depth)
            case ast.BinOp(op=ast.Mult() | ast.Div()) | ast.UnaryOp(op=ast.USub()):
                return self.product(node, depth)
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                exponent = self.read(right, depth + 1)
                base = self.read(left, depth + 1)
                return self.power(base, exponent, node)
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return self.read(operand, depth + 1)
            case ast.Call():
                return self.call(node, depth)
        self.refuse(f"{self.piece(node)} has no place in an expression", ALLOWED)

    def sum(self, node: ast.expr, depth: int) -> sympy.Expr:
        """A whole chain ``a + b - c`` at once: long sums are not deep, and SymPy sorts the terms once."""
        terms, whole = [], node
        while isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
            term = self.read(node.right, depth + 1)
            terms.append(-term if isinstance(node.op, ast.Sub) else term)
            node = node.left
        terms.append(self.read(node, depth + 1))
        return self.settle(sympy.Add(*reversed(terms)), whole)

    def product(self, node: ast.expr, depth: int) -> sympy.Expr:
        """A whole chain ``-a*b/c`` at once: taken two by two, SymPy would multiply out 2*(x + y)*z but not z*(x + y)*2."""
        factors, whole = [], node
        while True:
            match node:
                case ast.BinOp(left=left, op=ast.Mult(), right=right):
                    factors.append(self.read(right, depth + 1))
                case ast.BinOp(left=left, op=ast.Div(), right=right):
                    factors.append(self.power(self.read(right, depth + 1), sympy.S.NegativeOne, node))
                case ast.UnaryOp(op=ast.USub(), operand=left):
                    factors.append(sympy.S.NegativeOne)
                    depth += 1
                    if depth > DEEPEST:
                        self.refuse_depth()
                case _:
                    break
            node = left
        factors.append(self.read(node, depth + 1))
        return self.settle(sympy.Mul(*reversed(factors)), whole)

    def power(self, base: sympy.Expr, exponent: sympy.Expr, node: ast.expr) -> sympy.Expr:
        if base.is_zero and exponent.is_negative:
            self.refuse(f"{self.piece(node)} divides by zero", "give a divisor other than zero")
        self.check_exponent(exponent, node)
        return self.combine(sympy.Pow, operator.pow, (base, exponent), node)

    def call(self, node: ast.Call, depth: int) -> sympy.Expr:
        name = self.source(node.func)
        if name not in FUNCTIONS:
            if not isinstance(node.func, ast.Name) or name in self.symbols or name == "pi":
                self.refuse(f"{self.piece(node.func)} is not a function", "write * to multiply")
            raise NamingError(self.where, f"there is no function {name!r}", nearest(name, FUNCTIONS))
        if node.keywords or any(isinstance(argument, ast.Starred) for argument in node.args):
            self.refuse(f"the arguments of {self.piece(node)} are not plain", "write them one by one, separated by commas")
        count, least, more = len(node.args), 2 if name in ("min", "max", "atan2") else 1, name in ("min", "max")
        if count < least or (count > least and not more):
            self.refuse(f"{self.piece(node)} has {count} arguments", f"{name} takes {least}" + " or more" * more)
        arguments = tuple(self.read(argument, depth + 1) for argument in node.args)
        if more:
            compared = sum(len(each.args) if isinstance(each, sympy.Min | sympy.Max) else 1 for each in arguments)
            if compared > MOST_COMPARED:
                problem = f"{self.piece(node)} compares {compared} things, {MOST_COMPARED} are allowed"
                self.refuse(problem, "name some of them as parameters")
            self.check_degree(arguments, node)
        if name in HYPERBOLIC and not all(is_rational_function(each) for each in arguments):
            problem = f"{self.piece(node)} has a root or function inside {name}"
            self.refuse(problem, "only + - * /, whole powers, abs, min and max are allowed there")
        return self.combine(*FUNCTIONS[name], arguments, node)

    def symbol(self, name: str) -> sympy.Expr:
        if name in self.symbols:
            symbol = self.symbols[name]
            if not symbol.is_real or symbol.name != name:
                problem = f"the symbol {symbol} of {name!r} is not real or has another name"
                self.refuse(problem, f"declare Symbol({name!r}, real=True)")
            return symbol
        if name == "pi":
            return sympy.pi
        if name in FUNCTIONS:
            self.refuse(f"the function {name!r} has no arguments", f"write {name}(...)")
        raise NamingError(self.where, f"there is no {name[:80]!r}", nearest(name[:80], self.symbols))

    def literal(self, node: ast.Constant) -> sympy.Expr:
        text = self.source(node)
        value = float(text)
        if math.isinf(value) or (value == 0 and re.search("[1-9]", text.lower().partition("e")[0])):
            self.refuse(f"the number {self.piece(node)} is out of range", "give a number between 1e-308 and 1e308")
        return number(value)

    # -- numbers of bounded size ---------------------------------------------------------------------------------------------

    def combine(self, symbolic: Any, numeric: Numeric, arguments: tuple[sympy.Expr, ...], node: ast.expr) -> sympy.Expr:
        """The operation on its arguments; constants are computed as numbers first, so that SymPy never meets a huge one."""
        constant = all(argument.is_number for argument in arguments)
        if constant:
            try:
                value = numeric(*map(float, arguments))
            except (ValueError, ArithmeticError):
                value = math.nan
            if isinstance(value, complex) or not math.isfinite(value):
                self.refuse(f"{self.piece(node)} is not a finite real number", "give values for which it is one")
            if any(argument.is_Float for argument in arguments):
                return number(value)
        try:
            result = symbolic(*arguments)
        except (ValueError, TypeError, ArithmeticError, NotImplementedError) as error:
            self.refuse(f"{self.piece(node)} cannot be formed ({error})", "write it another way")
        if constant and result.is_finite is not False:
            return result if is_plain(result) else number(value)
        return self.settle(result, node)

    def settle(self, expression: sympy.Expr, node: ast.expr) -> sympy.Expr:
        """The expression with its constants in plain form, refused when it is not real, finite and of allowed operations."""
        for _ in range(10):
            exchanged = self.unsettled(expression, node)
            if not exchanged:
                return expression
            expression = expression.xreplace(exchanged)
        self.refuse(f"{self.piece(node)} has no simple form", "write it another way")

    def unsettled(self, expression: sympy.Expr, node: ast.expr) -> dict[sympy.Expr, sympy.Expr]:
        """Constants that are not plain yet, each with the number to put in its place."""
        exchanged: dict[sympy.Expr, sympy.Expr] = {}
        seen, waiting = set(), [expression]
        while waiting:
            part = waiting.pop()
            if part in self.settled or part in seen:
                continue
            seen.add(part)
            if part.is_number:
                if not is_plain(part):
                    exchanged[part] = self.finite(part, node)
                continue
            if isinstance(part, sympy.Add):
                self.check_degree(part.args, node)
            if isinstance(part, sympy.Add | sympy.Mul):
                constant = part.func(*(each for each in part.args if each.is_number))
                if not is_plain(constant):
                    rest = (each for each in part.args if not each.is_number)
                    exchanged[part] = part.func(self.finite(constant, node), *rest)
            elif part.is_Pow:
                self.check_exponent(part.exp, node)
            elif not part.is_Symbol and type(part) not in WRITTEN:
                self.refuse(f"{self.piece(node)} becomes {str(part)[:60]}, which cannot be written here", "write it another way")
            waiting += part.args
        if not exchanged:
            self.settled |= seen
        return exchanged

    def finite(self, constant: sympy.Expr, node: ast.expr) -> sympy.Expr:
        try:
            value = float(constant)
        except (TypeError, ValueError, ArithmeticError):
            value = math.nan
        if not math.isfinite(value):
            self.refuse(f"{self.piece(node)} is not a finite real number", "give values for which it is one")
        return number(value)

    def check_exponent(self, exponent: sympy.Expr, node: ast.expr) -> None:
        """Bounds the constant part: 2**(x + n)*2**-x is 2**n, which SymPy would write out in full."""
        constant = exponent if exponent.is_number else exponent.as_coeff_Add()[0]
        if abs(float(constant)) > LARGEST_EXPONENT:
            problem = f"{self.piece(node)} has an exponent beyond {LARGEST_EXPONENT}"
            self.refuse(problem, f"write numbers like 1e100, and powers up to {LARGEST_EXPONENT}")

    def check_degree(self, parts: tuple[sympy.Expr, ...], node: ast.expr) -> None:
        names = set().union(*(part.free_symbols for part in parts))
        if len(names) == 1 and any(name.is_nonnegative or name.is_nonpositive for name in names):
            degrees = degrees_of_sum(parts)
            if degrees is not None and degrees[0] > LARGEST_DEGREE:
                problem = f"{self.piece(node)} is of degree {degrees[0]} in {names.pop()} over its common denominator"
                self.refuse(problem, f"degree {LARGEST_DEGREE} is allowed in one name: write a product, or lower powers")
