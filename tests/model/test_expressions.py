"""Expressions: what they mean, what is refused and in which words, and that writing and reading agree."""

from __future__ import annotations

import inspect
import math
import random
import sys
import time

import pytest
import sympy

from modelgen.errors import ModelFileError, NamingError
from modelgen.model.expression_text import FUNCTIONS
from modelgen.model.expressions import read_expression, write_expression

x, y, stiffness = sympy.symbols("x y shaft.stiffness", real=True)
inertia = sympy.Symbol("inertia", positive=True)
TABLE = {"x": x, "y": y, "shaft.stiffness": stiffness, "inertia": inertia}
pi, half = sympy.pi, sympy.Rational(1, 2)


def read(text: str) -> sympy.Expr:
    return read_expression(text, TABLE, "parameter 'k'")


# -- meaning -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("7", sympy.Integer(7)),
        ("1e3", sympy.Integer(1000)),
        (".5", sympy.Float(0.5)),
        ("1/3", sympy.Rational(1, 3)),
        ("-x", -x),
        ("+x", x),
        ("- -x", x),
        ("2*pi*x", 2 * pi * x),
        ("x - y - 1", x - y - 1),
        ("x/y/2", x / (2 * y)),
        ("-x**2", -(x**2)),
        ("(-x)**2", x**2),
        ("2**3**2", sympy.Integer(512)),
        ("x**-y", x ** (-y)),
        ("x**2.0", x**2),
        ("1.0*x", x),
        ("2*(x + y)*inertia", 2 * inertia * (x + y)),
        ("shaft.stiffness/inertia", stiffness / inertia),
        ("sqrt(shaft.stiffness/2)", sympy.sqrt(2) * sympy.sqrt(stiffness) / 2),
        ("x\n + y", x + y),
        ("sin(pi/6)", half),
        ("acos(0)", pi / 2),
        ("0.1 + 0.2", sympy.Float(0.1 + 0.2)),
        ("pi**2", sympy.Float(math.pi**2)),
        ("sqrt(2) + sqrt(3)", sympy.Float(math.sqrt(2) + math.sqrt(3))),
        ("2**60", sympy.Float(2.0**60)),
        ("exp(1)", sympy.Float(math.e)),
        ("max(x, y, 1)", sympy.Max(x, y, 1)),
        ("min(2, pi)", sympy.Integer(2)),
        ("atan2(x, y)", sympy.atan2(x, y)),
        ("tanh(abs(x)/0.25)", sympy.tanh(4 * sympy.Abs(x))),
    ],
)
def test_meaning(text: str, meant: sympy.Expr) -> None:
    assert read(text) == meant


@pytest.mark.parametrize(
    "text",
    [
        "sqrt(x*x + 1)/(1 + exp(-y))",
        "log(inertia)*cos(x) - sin(y)**3",
        "abs(x - y)**1.5",
        "asin(x/9) + acos(y/9) - atan(x*y)",
        "atan2(x, -y)*tan(x)",
        "sinh(x) - cosh(y)*tanh(x - y)",
        "max(x, 2*y, 0)*min(x, y) + shaft.stiffness",
        "2*pi*x/60 - 3e-2*x**-2",
    ],
)
def test_value_is_what_arithmetic_says(text: str) -> None:
    values = {"x": 1.3, "y": 0.7, "inertia": 2.5}
    functions = {name: numeric for name, (_, numeric) in FUNCTIONS.items()}
    expected = eval(text.replace("shaft.stiffness", "4e4"), functions | values | {"pi": math.pi})
    numbers = {TABLE[name]: value for name, value in values.items()} | {stiffness: 4e4}
    assert float(read(text).xreplace({s: sympy.Float(v) for s, v in numbers.items()})) == pytest.approx(expected, rel=1e-13)


def test_symbols_are_those_of_the_table() -> None:
    """A symbol with assumptions is not equal to one without."""
    assert read("inertia*x").free_symbols == {inertia, x}


def test_names_of_functions_are_free_for_parameters() -> None:
    limit = sympy.Symbol("max", real=True)
    assert read_expression("max(max, 1)", {"max": limit}, "here") == sympy.Max(limit, 1)


def test_long_sums_are_not_deep() -> None:
    assert read("x" + " + x*y" * 120) == x + 120 * x * y


# -- refusals ----------------------------------------------------------------------------------------------------------------

HOSTILE = {
    "__import__('os').system('x')": r"'__import__' is no name; write a declared name",
    "().__class__": r"'\.__class__' is no name",
    "x.__class__": r"'x\.__class__' is no name",
    "x .real": r"'\.real' is no name",
    "_": "'_' is no name",
    "lambda: 0": "the word 'lambda' has no place in an expression; write numbers, names",
    "f'{z}'": r"\"'\" \(APOSTROPHE\) at character 2",
    '"x"': r"\(QUOTATION MARK\) at character 1",
    "(x := 1)": r"':' \(COLON\) at character 4",
    "[x for x in y]": r"'\[' \(LEFT SQUARE BRACKET\) at character 1 has no place in an expression; write \(",
    "(x for x in y)": "the word 'for'",
    "x if y else 1": "the word 'if'",
    "not x": "the word 'not'",
    "x and y": "the word 'and'",
    "True": "the word 'True'",
    "shaft.None": "the word 'None'",
    "import os": "the word 'import'",
    "x; y": r"';' \(SEMICOLON\)",
    "x # y": r"'#' \(NUMBER SIGN\)",
    "x\\y": r"\(REVERSE SOLIDUS\)",
    "x < y": r"'<' \(LESS-THAN SIGN\) at character 3",
    "x = 1": r"\(EQUALS SIGN\)",
    "x % y": r"\(PERCENT SIGN\)",
    "x ^ 2": r"'\^' \(CIRCUMFLEX ACCENT\) at character 3 has no place in an expression; write \*\*$",
    "x \u2212 y": r"\(MINUS SIGN\) at character 3 has no place in an expression; write -$",
    "x\u00b2": r"\(SUPERSCRIPT TWO\) at character 2 has no place in an expression; write \*\*2$",
    "x*\u0445": r"\(CYRILLIC SMALL LETTER HA\) at character 3",
    "\uff58": r"\(FULLWIDTH LATIN SMALL LETTER X\)",
    "x\0y": r"'\\x00' \(U\+0000\) at character 2",
    "\ud800": r"U\+D800",
    "...": r"'\.\.\.' is no name",
    "x*.": r"'\.' \(FULL STOP\) at character 3",
    "x // y": "'x // y' has no place in an expression",
    "x, y": "'x, y' has no place in an expression",
    "()": r"'\(\)' has no place",
    "max(*x, y)": r"the arguments of 'max\(\*x, y\)' are not plain",
    "max(**x)": "are not plain",
    "": "the expression is empty",
    " \n\t": "the expression is empty",
    "x +": r"'x \+' is no expression",
    "x y": "'x y' is no expression at 'y'",
    "(x": r"the parenthesis '\(' at character 1 is never closed",
    "x)": r"the parenthesis '\)' at character 2 closes nothing",
    "x(2)": r"'x' is not a function; write \* to multiply",
    "2(x)": r"'2' is not a function; write \* to multiply",
    "pi(2)": "'pi' is not a function",
    "sin": r"the function 'sin' has no arguments; write sin\(\.\.\.\)",
    "sin()": r"'sin\(\)' has 0 arguments; sin takes 1",
    "log(x, 10)": r"'log\(x, 10\)' has 2 arguments; log takes 1",
    "atan2(x)": "has 1 arguments; atan2 takes 2",
    "max(x)": "has 1 arguments; max takes 2 or more",
    "1_000": "'1_000' is no number; write it like 1000, 0.5 or 1.5e-3",
    "0x10": "'0x10' is no number",
    "1j": "'1j' is no number",
    "007": "'007' is no number",
    "2x": "'2x' is no number",
    "1e": "'1e' is no number",
    "1.2.3": "'1.2.3' is no number",
    "1e999": "the number '1e999' is out of range",
    "1e-999": "the number '1e-999' is out of range",
    "9" * 1999: r"the number '9{57}\.\.\.' is out of range",
    "1/0": "'1/0' divides by zero; give a divisor other than zero",
    "x/(y - y)": r"'x/\(y - y\)' divides by zero",
    "0**-1": r"'0\*\*-1' divides by zero",
    "log(0)": r"'log\(0\)' is not a finite real number",
    "sqrt(-1)": r"'sqrt\(-1\)' is not a finite real number",
    "asin(2)": "is not a finite real number",
    "tan(pi/2)": "is not a finite real number",
    "(-8)**(1/3)": "is not a finite real number",
    "sqrt(-exp(x))": "is not a finite real number",
    "exp(710)": "is not a finite real number",
    "1e300*1e300*x": "is not a finite real number",
    "sin(sin(exp(exp(exp(3))) + 3))": r"'exp\(exp\(exp\(3\)\)\)' is not a finite real number",
    "9**9**9": r"'9\*\*9\*\*9' has an exponent beyond 64; write numbers like 1e100, and powers up to 64",
    "9**9**9**9": "has an exponent beyond 64",
    "x**65": "has an exponent beyond 64",
    "x**64*x": r"'x\*\*64\*x' has an exponent beyond 64",
    "x**(pi*21)": "has an exponent beyond 64",
    "2**(x + 9007199254740991)*2**(-x)": r"'2\*\*\(x \+ 9007199254740991\)' has an exponent beyond 64",
    "((((2*x)**64)**64)**64)**64": "is not a finite real number",
    "tan(x + pi/2)": r"'tan\(x \+ pi/2\)' becomes cot\(x\), which cannot be written here",
    "abs(tanh(log((x + y + inertia)**60)))": "has a root or function inside tanh; only",
    "cosh(sqrt(x))": r"'cosh\(sqrt\(x\)\)' has a root or function inside cosh",
    "cos(log((inertia + 1)**64*(inertia + 2)**63 - inertia))": "is of degree 127 in inertia over its common denominator",
    "max(inertia**20, inertia)": "is of degree 20 in inertia",
    "1/log(" + "+".join(f"1/(inertia + {i})" for i in range(20)) + ")": "is of degree 19 in inertia",
    "max(x,1,2*x,3*x,4*x,5*x,6*x,7*x,8*x)": "compares 9 things, 8 are allowed",
    "max(max(x,y,1,2*x,3*x),4*x,5*x,6*x,7*x)": "compares 9 things, 8 are allowed",
    "x" * 2001: "the expression has 2001 characters, 2000 are allowed",
    "(" * 10000 + "1" + ")" * 10000: "20001 characters",
    "-" * 10000 + "1": "10001 characters",
    "(" * 900 + "1" + ")" * 900: "is nested more than 50 deep; name its inner parts",
    "-" * 400 + "1": "nested more than 50 deep",
    "sin(" * 60 + "x" + ")" * 60: "nested more than 50 deep",
    "x" + "**x" * 200: "nested more than 50 deep",
    "-" * 1900 + "1": "has 1901 numbers, names and operations, 500 are allowed",
    "x" + "+x" * 400: "has 801 numbers, names and operations, 500 are allowed",
    "x" + "**x" * 600: "500 are allowed",
}


@pytest.mark.parametrize(("text", "said"), HOSTILE.items(), ids=lambda value: ascii(value[:30]))
def test_refusal_says_where_what_and_what_to_do(text: str, said: str) -> None:
    start = time.perf_counter()
    with pytest.raises(ModelFileError, match=r"^parameter 'k': .*" + said) as refusal:
        read(text)
    assert refusal.value.remedy
    assert len(str(refusal.value)) < 400
    assert time.perf_counter() - start < 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("2*inertai", "there is no 'inertai'; nearest is 'inertia'"),
        ("shaft.stifness", r"there is no 'shaft\.stifness'; nearest is 'shaft\.stiffness'"),
        ("sine(x)", "there is no function 'sine'; nearest is 'sin'"),
        ("eval(x)", "there is no function 'eval'; "),
        ("os.system(x)", r"'os\.system' is not a function"),
        ("e**x", "there is no 'e'; known are x, y, "),
        ("nan", "there is no 'nan'"),
        ("a" * 2000, "there is no 'a{80}'; "),
    ],
)
def test_unknown_names(text: str, said: str) -> None:
    with pytest.raises((NamingError, ModelFileError), match=r"^parameter 'k': " + said):
        read(text)


@pytest.mark.parametrize("value", [None, 3, 2.5, True, b"x", ["x"]])
def test_only_text_is_read(value: object) -> None:
    with pytest.raises(ModelFileError, match="is not a text; write the expression in quotes"):
        read_expression(value, TABLE, "here")  # type: ignore[arg-type]


@pytest.mark.parametrize("symbol", [sympy.Symbol("z"), sympy.Symbol("other", real=True)])
def test_symbols_must_be_real_and_under_their_own_name(symbol: sympy.Symbol) -> None:
    with pytest.raises(ModelFileError, match=r"is not real or has another name; declare Symbol\('z', real=True\)"):
        read_expression("z + 1", {"z": symbol}, "here")


def test_little_room_on_the_stack_is_a_refusal_too() -> None:
    def descend(frames: int) -> sympy.Expr:
        return descend(frames - 1) if frames else read("sin(x+" * 24 + "y" + ")" * 24)

    expected = descend(0)
    assert expected.has(sympy.sin)
    room = sys.getrecursionlimit() - len(inspect.stack())
    outcomes = []
    for left in range(60, 600, 20):
        sympy.core.cache.clear_cache()
        try:
            outcomes.append(descend(room - left))
        except ModelFileError as refusal:
            outcomes.append(refusal.problem.partition(" is ")[2])
    assert set(outcomes) == {expected, "nested more than 50 deep"}


def test_nothing_is_evaluated(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither Python's evaluators nor SymPy's see a text."""

    def forbidden(*_: object, **__: object) -> None:
        raise AssertionError("a text reached an evaluator")

    for home, name in (("builtins", "eval"), ("builtins", "exec"), ("sympy.parsing.sympy_parser", "parse_expr")):
        monkeypatch.setattr(f"{home}.{name}", forbidden)
    meant = sympy.sqrt(2) * x + sympy.Float(0.1) * sympy.Max(y, sympy.Rational(1, 3)) * stiffness
    assert read("sqrt(2)*x + 0.1*max(y, 1/3)*shaft.stiffness") == meant


def test_random_characters_never_escape() -> None:
    """Whatever is written, it is read or refused in words."""
    source = random.Random(7)
    language = [*"xy01.+-*/()e, ", "**", "sin(", "max(", "pi", "1e9", "shaft.stiffness", "inertia"]
    pieces = [*language, *language, *"^[]{}'\"\\#:;=<>!@%&|~_\n\0é", "lambda ", "if "]
    read_count, starts = 0, set()
    for _ in range(1500):
        text = "".join(source.choices(pieces, k=source.randint(1, 9)))
        try:
            assert isinstance(read(text), sympy.Expr)
            read_count += 1
        except (ModelFileError, NamingError) as refusal:
            starts.add(refusal.where)
    assert starts == {"parameter 'k'"}
    assert read_count > 20


# -- writing -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (x - y, "x - y"),
        (-x - 2 * y, "-x - 2*y"),
        (-3 * x / (2 * y), "-3*x/2/y"),
        (x ** sympy.Rational(-1, 2), "1/sqrt(x)"),
        ((x + y) ** 2 / inertia**3, "(x + y)**2/inertia**3"),
        (2**x, "2**x"),
        (x ** (-y), "x**(-y)"),
        ((x**y) ** inertia, "(x**y)**inertia"),
        (sympy.Rational(1, 3) ** x, "(1/3)**x"),
        (sympy.Float(-1.5) * x, "-1.5*x"),
        (sympy.Float(0.1) + x * sympy.Float(1e-7), "1e-07*x + 0.1"),
        (-sympy.sqrt(2) * pi * x, "-sqrt(2)*pi*x"),
        (sympy.Abs(x) * sympy.Max(x, -1), "abs(x)*max(-1, x)"),
        (stiffness * sympy.atan2(x, y), "shaft.stiffness*atan2(x, y)"),
    ],
)
def test_written_form(expression: sympy.Expr, text: str) -> None:
    assert write_expression(expression) == text


def test_what_has_no_form_is_refused() -> None:
    with pytest.raises(ModelFileError, match=r"^expression: 'sign\(x\)' has no form in a model file; write numbers"):
        write_expression(1 + sympy.sign(x))
    with pytest.raises(NamingError, match=r"^expression: symbol '1; exit' cannot be written; use identifiers"):
        write_expression(sympy.Symbol("1; exit") + 1)


_LEAVES = [*TABLE, *TABLE, *TABLE, "pi", "0", "1", "2", "7", "30", "(1/3)", "(9/4)", "0.1", "2.0", "3.71", "1e-7", "1e20"]
_FORMS = [
    "(? + ?)", "(? - ?)", "(? + ? - ?)", "?*?", "?*?*?", "?/(?)", "(-?)", "(?)**2", "(?)**3", "(?)**(-1)", "sqrt(?)",
    "(?)**(-1/2)", "(?)**(2/3)", "(?)**1.5", "(?)**pi", "(?)**(-20)", "(?)**(?)", "min(?, ?)", "max(?, ?)", "atan2(?, ?)",
    *(f"{name}(?)" for name in FUNCTIONS if name not in ("min", "max", "atan2")),
]  # fmt: skip


def _random_text(source: random.Random, depth: int) -> str:
    if depth == 0 or source.random() < 0.15:
        return source.choice(_LEAVES)
    first, *rest = source.choice(_FORMS).split("?")
    return first + "".join(_random_text(source, depth - 1) + text for text in rest)


@pytest.mark.parametrize("seed", range(4))
def test_round_trip(seed: int) -> None:
    """Writing what was read and reading it again gives an equal expression, and the same text."""
    source = random.Random(seed)
    count = 0
    while count < 150:
        try:
            expression = read(_random_text(source, source.randint(1, 5)))
        except ModelFileError:
            continue
        written = write_expression(expression)
        assert read(written) == expression, written
        assert write_expression(read(written)) == written
        count += 1


def test_what_is_read_has_come_to_rest() -> None:
    """SymPy's own rebuilding, which any later substitution brings about, changes nothing."""
    source = random.Random(99)
    count = 0
    while count < 150:
        try:
            expression = read(_random_text(source, 3))
        except ModelFileError:
            continue
        rebuilt = expression.replace(lambda part: bool(part.args), lambda part: part.func(*part.args))
        assert rebuilt == expression
        assert not expression.has(sympy.I, sympy.nan, sympy.zoo, sympy.oo, -sympy.oo)
        count += 1
