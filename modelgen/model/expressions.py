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
LARGEST_EXPONENT = 64
LARGEST_DEGREE = 12
"""Of a sum in one name of known sign, over its common denominator: SymPy looks for its roots to learn the sign of the sum."""
MOST_COMPARED = 8
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
    rf"(?!0\d)(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?+(?![\w.])|(?P<name>{_NAME.pattern}(?![\w.]))|[-+*/(),]", re.ASCII
)
_WORD = re.compile(r"[\w.]+", re.ASCII)
# The cross, the dot, the division sign, the minus sign, and raised 2 and 3, as a text editor may put them.
_INSTEAD = {"\u00d7": "*", "\u00b7": "*", "\u00f7": "/", "\u2212": "-", "\u00b2": "**2", "\u00b3": "**3"}
_INSTEAD |= {"^": "**", "[": "(", "]": ")"}

# To learn whether one of these is real, SymPy splits its argument into real and imaginary part and multiplies out whatever roots
# and functions it holds: tanh(log((x + y)**60)) never ends.
_HYPERBOLIC = frozenset(["sinh", "cosh", "tanh"])
_WITHIN_HYPERBOLIC = (sympy.Add, sympy.Mul, sympy.Symbol, sympy.Abs, sympy.Min, sympy.Max)


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
        nodes = sum(isinstance(node, ast.expr) for node in ast.walk(tree))
        if nodes > MOST_NODES:
            problem = f"the expression has {nodes} numbers, names and operations, {MOST_NODES} are allowed"
            self.refuse(problem, "name its parts as parameters")
        return self.read(tree, 0)

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
        self.refuse(f"{self.piece(node)} has no place in an expression", _ALLOWED)

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
        if name not in _FUNCTIONS:
            if not isinstance(node.func, ast.Name) or name in self.symbols or name == "pi":
                self.refuse(f"{self.piece(node.func)} is not a function", "write * to multiply")
            raise NamingError(self.where, f"there is no function {name!r}", nearest(name, _FUNCTIONS))
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
        if name in _HYPERBOLIC and not all(_is_rational_function(each) for each in arguments):
            problem = f"{self.piece(node)} has a root or function inside {name}"
            self.refuse(problem, "only + - * /, whole powers, abs, min and max are allowed there")
        return self.combine(*_FUNCTIONS[name], arguments, node)

    def symbol(self, name: str) -> sympy.Expr:
        if name in self.symbols:
            symbol = self.symbols[name]
            if not symbol.is_real or symbol.name != name:
                problem = f"the symbol {symbol} of {name!r} is not real or has another name"
                self.refuse(problem, f"declare Symbol({name!r}, real=True)")
            return symbol
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
            if isinstance(part, sympy.Add):
                self.check_degree(part.args, node)
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

    def check_degree(self, parts: tuple[sympy.Expr, ...], node: ast.expr) -> None:
        names = set().union(*(part.free_symbols for part in parts))
        if len(names) == 1 and any(name.is_nonnegative or name.is_nonpositive for name in names):
            degrees = _degrees_of_sum(parts)
            if degrees is not None and degrees[0] > LARGEST_DEGREE:
                problem = f"{self.piece(node)} is of degree {degrees[0]} in {names.pop()} over its common denominator"
                self.refuse(problem, f"degree {LARGEST_DEGREE} is allowed in one name: write a product, or lower powers")

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


def _is_rational_function(argument: sympy.Expr) -> bool:
    """Whether nothing stands in it that a hyperbolic function cannot bear inside."""
    if argument.is_number:
        return True
    if isinstance(argument, sympy.Pow):
        return bool(argument.exp.is_Integer) and _is_rational_function(argument.base)
    return isinstance(argument, _WITHIN_HYPERBOLIC) and all(_is_rational_function(each) for each in argument.args)


def _degrees_of_sum(parts: tuple[sympy.Expr, ...]) -> tuple[int, int] | None:
    """Degrees of numerator and denominator, as large as they can be, of a sum of rational functions; None if it is not one."""
    degrees = [_degrees(part) for part in parts]
    known = [each for each in degrees if each is not None]
    if len(known) < len(degrees):
        return None
    below = sum(under for _, under in known)
    return max(above + below - under for above, under in known), below


def _degrees(expression: sympy.Expr) -> tuple[int, int] | None:
    if expression.is_number:
        return 0, 0
    if expression.is_Symbol:
        return 1, 0
    if expression.is_Add:
        return _degrees_of_sum(expression.args)
    if expression.is_Mul:
        known = [each for each in map(_degrees, expression.args) if each is not None]
        complete = len(known) == len(expression.args)
        return (sum(above for above, _ in known), sum(below for _, below in known)) if complete else None
    if expression.is_Pow and expression.exp.is_Integer and (base := _degrees(expression.base)) is not None:
        power = abs(int(expression.exp))
        return (base[0] * power, base[1] * power) if expression.exp.is_positive else (base[1] * power, base[0] * power)
    return None


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
