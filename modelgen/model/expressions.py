"""Expressions of model files: text to SymPy through an allow-list, and back.

Stands in ``model``, between a model file and the parameters whose values it writes as expressions. The text is cut into tokens,
Python's grammar orders them (``ast``), and each node of the tree must be one of those known here: nothing is ever evaluated as
Python, and SymPy is asked to combine only numbers of bounded size. The limits keep its automatic simplification, whose cost
can grow exponentially with nested functions, to a fraction of a second.

Constants are exact where they are a rational number, or that times pi or one root such as sqrt(2), and doubles otherwise, so that
``2*pi*f`` stays readable and no constant grows.
"""

from __future__ import annotations

import ast
import keyword
import math
import operator
import re
import unicodedata
from collections.abc import Callable, Mapping
from typing import Any, NoReturn, TypeAlias

import sympy

from modelgen.errors import ModelFileError, NamingError, nearest

LONGEST_TEXT = 2000
MOST_NODES = 500
DEEPEST = 50
DEEPEST_FUNCTIONS = 6
LARGEST_EXPONENT = 64
MOST_COMPARED = 16
"""Arguments of one ``min`` or ``max``: SymPy compares each with every other."""
_LARGEST_EXACT = 2**53

Numeric: TypeAlias = Callable[..., Any]
_FUNCTIONS: dict[str, tuple[Any, Numeric]] = {
    "sqrt": (sympy.sqrt, math.sqrt),
    "exp": (sympy.exp, math.exp),
    "log": (sympy.log, math.log),
    "abs": (sympy.Abs, abs),
    "sin": (sympy.sin, math.sin),
    "cos": (sympy.cos, math.cos),
    "tan": (sympy.tan, math.tan),
    "asin": (sympy.asin, math.asin),
    "acos": (sympy.acos, math.acos),
    "atan": (sympy.atan, math.atan),
    "atan2": (sympy.atan2, math.atan2),
    "sinh": (sympy.sinh, math.sinh),
    "cosh": (sympy.cosh, math.cosh),
    "tanh": (sympy.tanh, math.tanh),
    "min": (sympy.Min, min),
    "max": (sympy.Max, max),
}
_WRITTEN = {function: name for name, (function, _) in _FUNCTIONS.items() if isinstance(function, type)}
_ALLOWED = "write numbers, names, + - * / **, parentheses, pi and " + ", ".join(_FUNCTIONS)

_NAME = re.compile(r"[A-Za-z]\w*(?:\.[A-Za-z]\w*)*", re.ASCII)
# Possessive quantifiers keep the time linear on a long row of digits.
_TOKEN = re.compile(
    rf"(?P<number>(?!0\d)(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?+(?![\w.]))|(?P<name>{_NAME.pattern}(?![\w.]))|[-+*/(),]", re.ASCII
)
_WORD = re.compile(r"[\w.]+", re.ASCII)
_INSTEAD = {"^": "**", "×": "*", "·": "*", "÷": "/", "−": "-", "²": "**2", "³": "**3", "[": "(", "]": ")"}


def read_expression(text: str, symbols: Mapping[str, sympy.Symbol], where: str) -> sympy.Expr:
    """The SymPy expression that a text of a model file stands for.

    Numbers, names of ``symbols`` (dotted ones too), ``+ - * / **``, parentheses, ``pi`` and the functions ``sqrt exp log abs sin
    cos tan asin acos atan atan2 sinh cosh tanh min max``. The symbols should be declared ``real=True``.

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
    return _Reader(text, symbols, where).expression()


def write_expression(expression: sympy.Expr) -> str:
    """The text of an expression; reading what was read and written gives an equal expression.

    Raises ModelFileError for an operation and NamingError for a symbol that ``read_expression`` does not know.

    >>> x, y = sympy.symbols("x y", real=True)
    >>> write_expression(x / sympy.sqrt(2 * y) - 0.5)
    'sqrt(2)*x/2/sqrt(y) - 0.5'
    """
    return _write(expression)[0]


class _Reader:
    """One text on its way to one expression."""

    def __init__(self, text: object, symbols: Mapping[str, sympy.Symbol], where: str) -> None:
        self.symbols, self.where = symbols, where
        if not isinstance(text, str):
            self.refuse(f"{text!r:.60} is not a text", 'write the expression in quotes, such as "2*pi*ratio"')
        if len(text) > LONGEST_TEXT:
            self.refuse(f"the expression has {len(text)} characters, {LONGEST_TEXT} are allowed", "name its parts as parameters")
        self.text = " ".join(text.split())
        # Parts of SymPy trees that are known to be in order, so that each is looked at once.
        self.settled: set[sympy.Expr] = set()

    def refuse(self, problem: str, remedy: str) -> NoReturn:
        raise ModelFileError(self.where, problem, remedy)

    def expression(self) -> sympy.Expr:
        self.scan()
        try:
            tree = ast.parse(self.text, mode="eval").body
        except SyntaxError as error:
            place = (error.offset or 1) - 1
            near = f" at {self.text[place:][:20]!r}" if 0 < place < len(self.text) else ""
            self.refuse(f"{self.text[:60]!r} is no expression{near}", _ALLOWED)
        except (MemoryError, RecursionError, ValueError):
            self.refuse_depth()
        nodes = sum(isinstance(node, ast.expr) for node in ast.walk(tree))
        if nodes > MOST_NODES:
            self.refuse(f"the expression has {nodes} numbers, names and operations, {MOST_NODES} are allowed", "name its parts as parameters")
        try:
            return self.read(tree, 0, 0)
        except RecursionError:
            self.refuse_depth()

    def refuse_depth(self) -> NoReturn:
        self.refuse(f"{self.text[:40]!r}... is nested more than {DEEPEST} deep", "name its inner parts as parameters")

    # -- text to tokens ------------------------------------------------------------------------------------------------------

    def scan(self) -> None:
        """Refuses whatever is no token of the language before Python's parser sees it."""
        if not self.text:
            self.refuse("the expression is empty", _ALLOWED)
        position, opened = 0, []
        while position < len(self.text):
            if self.text[position] == " ":
                position += 1
                continue
            token = _TOKEN.match(self.text, position)
            if token is None:
                self.refuse_character(position)
            if token["name"] and (words := [word for word in token["name"].split(".") if keyword.iskeyword(word)]):
                self.refuse(f"the word {words[0]!r} has no place in an expression", _ALLOWED)
            if token[0] == "(":
                opened.append(position)
            elif token[0] == ")":
                if not opened:
                    self.refuse(f"the parenthesis ')' at character {position + 1} closes nothing", "remove it or open one before")
                opened.pop()
            if len(opened) > DEEPEST:
                self.refuse_depth()
            position = token.end()
        if opened:
            self.refuse(f"the parenthesis '(' at character {opened[-1] + 1} is never closed", "close it")

    def refuse_character(self, position: int) -> NoReturn:
        word, character = _WORD.match(self.text, position), self.text[position]
        if word is not None and word[0] != ".":
            number = word[0].lstrip(".")[:1].isdigit()
            good = "write it like 1000, 0.5 or 1.5e-3" if number else "write a declared name, such as shaft.stiffness"
            self.refuse(f"{word[0][:40]!r} is no {'number' if number else 'name'}", good)
        named = unicodedata.name(character, "") or f"U+{ord(character):04X}"
        remedy = f"write {_INSTEAD[character]}" if character in _INSTEAD else _ALLOWED
        self.refuse(f"{character!r} ({named}) at character {position + 1} has no place in an expression", remedy)

    # -- tokens to SymPy -----------------------------------------------------------------------------------------------------

    def read(self, node: ast.expr, depth: int, functions: int) -> sympy.Expr:
        """The expression of a node that is ``depth`` operations and ``functions`` functions below the top."""
        if depth > DEEPEST:
            self.refuse_depth()
        if functions > DEEPEST_FUNCTIONS:
            problem = f"functions are nested more than {DEEPEST_FUNCTIONS} deep around {self.piece(node)}"
            self.refuse(problem, "name the inner ones as parameters")
        match node:
            case ast.Constant():
                return self.literal(node)
            case ast.Name() | ast.Attribute():
                return self.symbol(self.source(node))
            case ast.BinOp(op=ast.Add() | ast.Sub()):
                return self.sum(node, depth, functions)
            case ast.BinOp(op=ast.Mult() | ast.Div()) | ast.UnaryOp(op=ast.USub()):
                return self.product(node, depth, functions)
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                exponent = self.read(right, depth + 1, functions)
                base = self.read(left, depth + 1, functions + (not exponent.is_Integer))
                return self.power(base, exponent, node)
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return self.read(operand, depth + 1, functions)
            case ast.Call():
                return self.call(node, depth, functions)
        self.refuse(f"{self.piece(node)} has no place in an expression", _ALLOWED)

    def sum(self, node: ast.expr, depth: int, functions: int) -> sympy.Expr:
        """A whole chain ``a + b - c`` at once: long sums are not deep, and SymPy sorts the terms once."""
        terms, whole = [], node
        while isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
            term = self.read(node.right, depth + 1, functions)
            terms.append(-term if isinstance(node.op, ast.Sub) else term)
            node = node.left
        terms.append(self.read(node, depth + 1, functions))
        return self.settle(sympy.Add(*reversed(terms)), whole)

    def product(self, node: ast.expr, depth: int, functions: int) -> sympy.Expr:
        """A whole chain ``-a*b/c`` at once: taken two by two, SymPy would multiply out 2*(x + y)*z but not z*(x + y)*2."""
        factors, whole = [], node
        while True:
            match node:
                case ast.BinOp(left=left, op=ast.Mult(), right=right):
                    factors.append(self.read(right, depth + 1, functions))
                case ast.BinOp(left=left, op=ast.Div(), right=right):
                    factors.append(self.power(self.read(right, depth + 1, functions), sympy.S.NegativeOne, node))
                case ast.UnaryOp(op=ast.USub(), operand=left):
                    factors.append(sympy.S.NegativeOne)
                    depth += 1
                    if depth > DEEPEST:
                        self.refuse_depth()
                case _:
                    break
            node = left
        factors.append(self.read(node, depth + 1, functions))
        return self.settle(sympy.Mul(*reversed(factors)), whole)

    def power(self, base: sympy.Expr, exponent: sympy.Expr, node: ast.expr) -> sympy.Expr:
        if base.is_zero and exponent.is_negative:
            self.refuse(f"{self.piece(node)} divides by zero", "give a divisor other than zero")
        self.check_exponent(exponent, node)
        return self.combine(sympy.Pow, operator.pow, (base, exponent), node)

    def call(self, node: ast.Call, depth: int, functions: int) -> sympy.Expr:
        name = self.source(node.func)
        if name not in _FUNCTIONS:
            if not isinstance(node.func, ast.Name) or name in self.symbols or name == "pi":
                self.refuse(f"{self.piece(node.func)} is not a function", "write * to multiply")
            raise NamingError(self.where, f"there is no function {name!r}", nearest(name, _FUNCTIONS))
        if node.keywords or any(isinstance(argument, ast.Starred) for argument in node.args):
            self.refuse(f"the arguments of {self.piece(node)} are not plain", "write them one by one, separated by commas")
        count, least = len(node.args), 2 if name in ("min", "max", "atan2") else 1
        if count < least or (count > least and name not in ("min", "max")):
            self.refuse(f"{self.piece(node)} has {count} arguments", f"{name} takes {least}" + " or more" * (name in ("min", "max")))
        arguments = tuple(self.read(argument, depth + 1, functions + 1) for argument in node.args)
        if name in ("min", "max"):
            compared = sum(len(each.args) if isinstance(each, sympy.Min | sympy.Max) else 1 for each in arguments)
            if compared > MOST_COMPARED:
                self.refuse(f"{self.piece(node)} compares {compared} things, {MOST_COMPARED} are allowed", "name some of them as parameters")
        return self.combine(*_FUNCTIONS[name], arguments, node)

    def symbol(self, name: str) -> sympy.Expr:
        if name in self.symbols:
            return self.symbols[name]
        if name == "pi":
            return sympy.pi
        if name in _FUNCTIONS:
            self.refuse(f"the function {name!r} has no arguments", f"write {name}(...)")
        raise NamingError(self.where, f"there is no {name[:80]!r}", nearest(name[:80], self.symbols))

    def literal(self, node: ast.Constant) -> sympy.Expr:
        text = self.source(node)
        value = float(text)
        if math.isinf(value) or (value == 0 and re.search("[1-9]", text.lower().partition("e")[0])):
            self.refuse(f"the number {self.piece(node)} is out of range", "give a number between 1e-308 and 1e308")
        return _number(value)

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
                return _number(value)
        try:
            result = symbolic(*arguments)
        except (ValueError, TypeError, ArithmeticError, NotImplementedError) as error:
            self.refuse(f"{self.piece(node)} cannot be formed ({error})", "write it another way")
        if constant and result.is_finite is not False:
            return result if _is_plain(result) else _number(value)
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
                if not _is_plain(part):
                    exchanged[part] = self.number(part, node)
                continue
            if isinstance(part, sympy.Add | sympy.Mul):
                constant = part.func(*(each for each in part.args if each.is_number))
                if not _is_plain(constant):
                    rest = (each for each in part.args if not each.is_number)
                    exchanged[part] = part.func(self.number(constant, node), *rest)
            elif part.is_Pow:
                self.check_exponent(part.exp, node)
            elif not part.is_Symbol and type(part) not in _WRITTEN:
                self.refuse(f"{self.piece(node)} becomes {str(part)[:60]}, which cannot be written here", "write it another way")
            waiting += part.args
        if not exchanged:
            self.settled |= seen
        return exchanged

    def number(self, constant: sympy.Expr, node: ast.expr) -> sympy.Expr:
        try:
            value = float(constant)
        except (TypeError, ValueError, ArithmeticError):
            value = math.nan
        if not math.isfinite(value):
            self.refuse(f"{self.piece(node)} is not a finite real number", "give values for which it is one")
        return _number(value)

    def check_exponent(self, exponent: sympy.Expr, node: ast.expr) -> None:
        """Bounds the constant part: 2**(x + n)*2**-x is 2**n, which SymPy would write out in full."""
        constant = exponent if exponent.is_number else exponent.as_coeff_Add()[0]
        if abs(float(constant)) > LARGEST_EXPONENT:
            problem = f"{self.piece(node)} has an exponent beyond {LARGEST_EXPONENT}"
            self.refuse(problem, f"write numbers like 1e100, and powers up to {LARGEST_EXPONENT}")

    def source(self, node: ast.expr) -> str:
        return self.text[node.col_offset : node.end_col_offset]

    def piece(self, node: ast.expr) -> str:
        text = self.source(node)
        return repr(text if len(text) <= 60 else text[:57] + "...")


def _number(value: float) -> sympy.Expr:
    """A whole number is an Integer, so that x**2.0 is x**2 and 1.0*x is x."""
    return sympy.Integer(int(value)) if value.is_integer() and abs(value) <= _LARGEST_EXACT else sympy.Float(value)


def _is_plain(constant: sympy.Expr) -> bool:
    """Whether a constant is a rational number of bounded size, that times pi or one root, or a double that is not whole."""
    coefficient, rest = constant.as_coeff_Mul()
    if coefficient.is_Rational:
        root = rest.is_Pow and rest.base.is_Integer and rest.base.is_positive and rest.exp.is_Rational
        numbers = (coefficient, rest.base, rest.exp) if root else (coefficient,)
        bounded = all(max(abs(number.p), number.q) <= _LARGEST_EXACT for number in numbers)
        return bounded and (root or rest in (sympy.S.One, sympy.pi))
    return coefficient.is_Float and rest is sympy.S.One and coefficient == _number(float(coefficient))


# -- SymPy to text -----------------------------------------------------------------------------------------------------------

_SUM, _PRODUCT, _POWER, _ATOM = range(4)


def _write(expression: sympy.Expr) -> tuple[str, int]:
    """The text and how tightly its outermost operation binds."""
    if expression.is_Symbol:
        if not _NAME.fullmatch(expression.name):
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
    if type(expression) in _WRITTEN:
        return f"{_WRITTEN[type(expression)]}({', '.join(_write(argument)[0] for argument in expression.args)})", _ATOM
    raise ModelFileError("expression", f"{str(expression)[:60]!r} has no form in a model file", _ALLOWED)


def _write_product(expression: sympy.Expr) -> tuple[str, int]:
    coefficient, rest = expression.as_coeff_Mul()
    above = [factor for factor in sympy.Mul.make_args(rest) if factor is not sympy.S.One and not _is_inverse(factor)]
    below = [1 / factor for factor in sympy.Mul.make_args(rest) if _is_inverse(factor)]
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
