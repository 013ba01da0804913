"""The translator against SymPy's own evaluation at 40 digits, operation by operation, in random trees, and at its limits."""

from __future__ import annotations

import itertools
import math
import random
import time
from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
import sympy
from sympy.core.cache import clear_cache
from sympy.core.function import ArgumentIndexError

from modelgen.errors import LoweringError, ModelError
from modelgen.lowering.visitor import Visitor, operations
from modelgen.model.tables import PeriodicSteps, PeriodicTable

R = sympy.Rational
X, Y, Z = SYMBOLS = sympy.symbols("x y z", real=True)
EXACT = 1e-13


def lowered(expression, symbols=SYMBOLS):
    """The SX symbols as one column, and the translated expression."""
    column = ca.vertcat(*(ca.SX.sym(symbol.name) for symbol in symbols))
    return column, Visitor(dict(zip(symbols, ca.vertsplit(column), strict=True)), "shaft 's'")(expression)


def number(expression, *point):
    column, value = lowered(expression)
    return float(ca.Function("f", [column], [value])([*point, *[0.7] * (3 - len(point))]))


def slope(expression, *point):
    column, value = lowered(expression)
    return float(ca.Function("f", [column], [ca.jacobian(value, column[0])])([*point, *[0.7] * (3 - len(point))]))


def reference(expression, *point, digits=40):
    """SymPy's own evaluation, with every symbol replaced by a Float of many digits."""
    exact = {
        symbol: sympy.Float(value, digits) for symbol, value in zip(SYMBOLS, [*point, *[0.7] * (3 - len(point))], strict=True)
    }
    value = expression.xreplace(exact)
    return sympy.Integer(bool(value)) if value in (sympy.true, sympy.false) else value.evalf(digits)


# Every operation by itself: its class, an expression, and points (x, y) inside its real domain.
SIGNED = [(-2.3,), (-0.4,), (0.15,), (1.9,), (40.3,)]
INSIDE = [(-0.95,), (-0.2,), (0.3,), (0.999,)]
POSITIVE = [(1e-8,), (0.3,), (2.7,), (1e5,)]
PAIRS = [(-2.3, 1.1), (0.4, 3.3), (5.9, -0.7), (-1.2, -8.5), (0.7, 0.7), (17.0, 2.0)]
OPERATIONS = [
    (sympy.Add, X + Y + 2, PAIRS),
    (sympy.Mul, -3 * X * Y, PAIRS),
    (sympy.Mul, X / Y, PAIRS),
    (sympy.Mul, R(2, 3) * X**2 / (Y**3 * (Y**2 + 1)), PAIRS),
    (sympy.Pow, X**2, SIGNED),
    (sympy.Pow, X**7, SIGNED),
    (sympy.Pow, X**150, INSIDE),
    (sympy.Pow, X**-1, SIGNED),
    (sympy.Pow, X**-5, SIGNED),
    (sympy.Pow, sympy.sqrt(X), POSITIVE),
    (sympy.Pow, 1 / sympy.sqrt(X), POSITIVE),
    (sympy.Pow, X ** R(7, 3), POSITIVE),
    (sympy.Pow, X ** R(-5, 2), POSITIVE),
    (sympy.Pow, X**sympy.pi, POSITIVE),
    (sympy.Pow, X ** sympy.Float(2.0), SIGNED),
    (sympy.Pow, 2**X, SIGNED),
    (sympy.Pow, X**Y, [(0.3, -2.1), (2.7, 3.3), (1.0, 9.0)]),
    (sympy.Pow, sympy.Pow(sympy.E, X, evaluate=False), SIGNED),
    (sympy.exp, sympy.exp(X), SIGNED),
    (sympy.log, sympy.log(X), POSITIVE),
    (sympy.log, sympy.log(X, 3, evaluate=False), POSITIVE),
    (sympy.sin, sympy.sin(X), SIGNED),
    (sympy.cos, sympy.cos(X), SIGNED),
    (sympy.tan, sympy.tan(X), SIGNED),
    (sympy.asin, sympy.asin(X), INSIDE),
    (sympy.acos, sympy.acos(X), INSIDE),
    (sympy.atan, sympy.atan(X), SIGNED),
    (sympy.atan2, sympy.atan2(X, Y), PAIRS),
    (sympy.sinh, sympy.sinh(X), SIGNED),
    (sympy.cosh, sympy.cosh(X), SIGNED),
    (sympy.tanh, sympy.tanh(X), SIGNED),
    (sympy.asinh, sympy.asinh(X), SIGNED),
    (sympy.acosh, sympy.acosh(X), [(1.2,), (3.0,), (1e6,)]),
    (sympy.atanh, sympy.atanh(X), INSIDE),
    (sympy.Abs, sympy.Abs(X), [*SIGNED, (0.0,)]),
    (sympy.sign, sympy.sign(X), [*SIGNED, (0.0,)]),
    (sympy.floor, sympy.floor(X), [*SIGNED, (-3.0,), (3.0,)]),
    (sympy.ceiling, sympy.ceiling(X), [*SIGNED, (-3.0,), (3.0,)]),
    (sympy.Mod, sympy.Mod(X, Y), PAIRS),
    (sympy.Mod, sympy.Mod(X, 1), [*SIGNED, (-3.0,), (123456.789,)]),
    (sympy.Min, sympy.Min(X, Y, Z), PAIRS),
    (sympy.Max, sympy.Max(X, Y, Z), PAIRS),
    (sympy.Heaviside, sympy.Heaviside(X), [*SIGNED, (0.0,)]),
    (sympy.Heaviside, sympy.Heaviside(X, 0), [*SIGNED, (0.0,)]),
    (sympy.Heaviside, sympy.Heaviside(X, R(1, 3)), [*SIGNED, (0.0,)]),
    (sympy.re, sympy.re(X, evaluate=False), SIGNED),
    (sympy.im, 2 + sympy.im(X, evaluate=False), SIGNED),
    (sympy.Piecewise, sympy.Piecewise((X, X < -1), (X**2, X < 1), (Y, True)), PAIRS),
    (sympy.Lt, X < Y, PAIRS),
    (sympy.Le, X <= Y, PAIRS),
    (sympy.Gt, X > Y, PAIRS),
    (sympy.Ge, X >= Y, PAIRS),
    (sympy.Eq, sympy.Eq(X, Y), PAIRS),
    (sympy.Ne, sympy.Ne(X, Y), PAIRS),
    (sympy.And, (X > 0) & (Y > 0) & (X > Y), PAIRS),
    (sympy.Or, (X > 5) | (Y > 1) | (X < Y), PAIRS),
    (sympy.Not, sympy.Not((X > 0) & (Y > 0), evaluate=False), PAIRS),
    (sympy.ITE, sympy.ITE(Y > 1, X > 0, Z > X), PAIRS),
    (PeriodicTable, PeriodicTable(X, 3, Y, R(1, 7), -2), PAIRS),
    (PeriodicSteps, PeriodicSteps(X, 3, Y, R(1, 7), -2), PAIRS),
]


@pytest.mark.parametrize(("kind", "expression", "points"), OPERATIONS, ids=str)
def test_every_operation_agrees_with_sympy(kind, expression, points):
    assert expression.has(kind)
    for point in points:
        expected = float(reference(expression, *point))
        # Mod and tables start by taking whole multiples away from x: their rounding is that of x.
        scale = max(abs(expected), abs(point[0])) if kind in (sympy.Mod, PeriodicTable) else abs(expected)
        assert abs(number(expression, *point) - expected) <= EXACT * scale


def test_every_operation_is_in_the_list_above():
    assert {kind for kind, *_ in OPERATIONS} == set(operations())


@pytest.mark.parametrize("constant", [sympy.pi, sympy.E, sympy.true, sympy.false, sympy.sqrt(2), sympy.cos(R(1, 5))], ids=str)
def test_constants(constant):
    assert number(constant) == pytest.approx(float(sympy.Integer(bool(constant)) if constant.is_Boolean else constant), rel=1e-15)


# Random trees: operations of one or two branches that keep any argument in their domain and their value moderate.
ONE = [
    sympy.sin,
    sympy.cos,
    sympy.atan,
    sympy.tanh,
    sympy.asinh,
    sympy.Abs,
    sympy.sign,
    lambda a: sympy.floor(3 * a),
    lambda a: sympy.ceiling(3 * a),
    lambda a: sympy.tan(sympy.tanh(a)),
    lambda a: sympy.sinh(sympy.sin(a)),
    lambda a: sympy.cosh(sympy.sin(a)),
    lambda a: sympy.asin(sympy.cos(a) * R(9, 10)),
    lambda a: sympy.acos(sympy.cos(a) * R(9, 10)),
    lambda a: sympy.atanh(sympy.sin(a) * R(9, 10)),
    lambda a: sympy.acosh(2 + sympy.Abs(a)),
    lambda a: sympy.exp(-sympy.Abs(a)),
    lambda a: sympy.log(1 + a**2),
    lambda a: sympy.sqrt(1 + a**2),
    lambda a: 1 / sympy.sqrt(1 + a**2),
    lambda a: a / (1 + a**4),
]
TWO = [
    lambda a, b: a + b,
    lambda a, b: a - b,
    lambda a, b: a * b / 3,
    lambda a, b: a / (1 + b**2),
    lambda a, b: (1 + sympy.Abs(a)) ** sympy.tanh(b),
    lambda a, b: sympy.atan2(a, 1 + b**2),
    lambda a, b: sympy.Mod(a, 1 + sympy.Abs(b)),
    sympy.Min,
    sympy.Max,
    lambda a, b: sympy.Heaviside(a - b, R(2, 7)),
    lambda a, b: sympy.Piecewise((a, (a < b) & sympy.Ne(b, 2)), (b, (a > 1) | sympy.Eq(a, 3) | ~(b < 2)), (a - b, True)),
    lambda a, b: PeriodicTable(a, b, a, 1, R(2, 7)),
    lambda a, b: PeriodicSteps(a, b, R(2, 7), a),
]


def random_tree(draw: random.Random, depth: int):
    if depth == 0:
        return draw.choice([*SYMBOLS, R(draw.randint(-300, 300), 97)])
    if draw.random() < 0.5:
        return draw.choice(ONE)(random_tree(draw, depth - 1))
    return draw.choice(TWO)(random_tree(draw, depth - 1), random_tree(draw, depth - 1))


@pytest.mark.parametrize("seed", range(36))
def test_random_trees_agree_with_sympy(seed):
    draw = random.Random(seed)
    expression = random_tree(draw, 5)
    for _ in range(2):
        point = [draw.uniform(-2.5, 2.5) for _ in SYMBOLS]
        expected = float(reference(expression, *point))
        assert number(expression, *point) == pytest.approx(expected, rel=EXACT, abs=EXACT)


SMOOTH = {sympy.Add, sympy.Mul, sympy.Pow, sympy.Mod, PeriodicTable} | {
    kind for kind in operations() if issubclass(kind, sympy.Function) and kind.__module__.startswith("sympy.functions.elementary")
} - {sympy.Max, sympy.Min, sympy.floor, sympy.ceiling, sympy.sign, sympy.Piecewise}


@pytest.mark.parametrize(("kind", "expression", "points"), [case for case in OPERATIONS if case[0] in SMOOTH], ids=str)
def test_derivatives_agree_with_central_differences_at_fifty_digits(kind, expression, points):
    step = sympy.Float("1e-16", 50)
    for x, *others in points:
        if kind in (sympy.Abs, sympy.Mod) and x in (0.0, -3.0, 0.7):
            continue  # a kink; see below
        ends = [reference(expression, sympy.Float(x, 50) + sign * step, *others, digits=50) for sign in (1, -1)]
        expected = float((ends[0] - ends[1]) / (2 * step))
        # asin and its like divide by sqrt(1 - x**2), which loses digits near 1: hence not 1e-13 here.
        assert slope(expression, x, *others) == pytest.approx(expected, rel=1e-12, abs=1e-14)


@pytest.mark.parametrize(
    ("expression", "x", "value", "derivative"),
    [
        (sympy.Abs(X), 0, 0, 0),
        (sympy.sign(X), 0, 0, 0),
        (sympy.floor(X), 2, 2, 0),
        (sympy.ceiling(X), 2, 2, 0),
        (sympy.Mod(X, 2), 4, 0, 1),
        (sympy.Mod(7, X), 2, 1, -3),
        (sympy.Mod(X, -2), 3, -1, 1),
        (sympy.Max(X, 3 * X - 2), 1, 1, 2),
        (sympy.Min(X, 3 * X - 2), 1, 1, 2),
        (sympy.Max(X, 0), 0, 0, 0.5),
        (sympy.Heaviside(X), 0, 0.5, 0),
        (sympy.Heaviside(X, 1), 0, 1, 0),
        (sympy.Piecewise((3 * X, X > 0), (5 * X, True)), 0, 0, 5),
        (sympy.Piecewise((3 * X, X >= 0), (5 * X, True)), 0, 0, 3),
        (PeriodicTable(X, 0, 1, 5), 0, 0, 3 * (1 - 5) / 2),
        (PeriodicTable(X, 0, 1, 5, 2), 0.25, 1, 4 * (1 + 4) / 2),
        (PeriodicSteps(X, 2, 4), 0.5, 3, 0),
    ],
    ids=str,
)
def test_conventions_at_a_kink(expression, x, value, derivative):
    assert number(expression, x) == value
    assert slope(expression, x) == pytest.approx(derivative, rel=1e-15)


def test_atan2_at_the_origin_has_a_value_but_no_derivative():
    assert number(sympy.atan2(X, Y), 0, 0) == 0
    assert math.isnan(slope(sympy.atan2(X, Y), 0, 0))


def test_max_passes_over_nan_and_heaviside_hands_it_on():
    assert number(sympy.Max(X, Y), math.nan, 2) == 2
    assert math.isnan(number(sympy.Heaviside(X), math.nan))


@pytest.mark.parametrize("x", [-1.0, 0.0])
@pytest.mark.parametrize(
    "expression",
    [
        sympy.Piecewise((sympy.sqrt(X), X > 0), (0, True)),
        sympy.Piecewise((sympy.log(X) * sympy.sin(sympy.sqrt(X)), X > 0), (0, True)),
        sympy.Piecewise((sympy.Piecewise((1 / X, Y > 0), (sympy.log(X), True)), X > 0), (0, True)),
        sympy.Piecewise((sympy.sqrt(sympy.Max(X, 1e-12)), X > 0), (0, True))
        + sympy.Piecewise((Y * sympy.sqrt(sympy.Max(X, 1e-12)), X > 0), (0, True)),
    ],
    ids=str,
)
def test_nan_in_a_piece_not_taken_stays_there(expression, x):
    column, value = lowered(expression)
    hessian, gradient = ca.hessian(value, column)
    for each in (value, ca.jacobian(value, column), ca.jtimes(value, column, ca.DM.ones(3)), gradient, hessian):
        assert np.array_equal(ca.Function("f", [column], [each])([x, 0.7, 0.7]).full(), np.zeros(each.shape))


def test_nan_reaches_no_jacobian_where_two_pieces_share_a_root():
    root = sympy.sqrt(X)
    expression = sympy.Piecewise((root, X > 0), (0, True)) + sympy.Piecewise((Y * root, X > 0), (0, True))
    assert (number(expression, -1), slope(expression, -1)) == (0, 0)


# Numbers.


def test_a_float_keeps_its_seventeen_digits():
    draw = random.Random(1)
    for value in (draw.uniform(-1, 1) * 10 ** draw.randint(-300, 300) for _ in range(200)):
        assert number(sympy.Float(value)) == number(value) == value
        assert number(sympy.Float(repr(value), 17)) == value


def test_a_long_float_and_a_rational_are_the_nearest_double():
    draw = random.Random(2)
    for _ in range(200):
        p, q = draw.randint(-(10**60), 10**60), draw.randint(1, 10**50)
        for given, exact in (
            (R(p, q), Fraction(p, q)),
            (sympy.Float(p, 80) / 2**180, Fraction(p, 2**180)),
            (sympy.Integer(p), p),
        ):
            found = number(given)
            beside = (math.nextafter(found, math.inf), math.nextafter(found, -math.inf))
            assert abs(Fraction(found) - exact) <= min(abs(Fraction(other) - exact) for other in beside)


def test_numbers_of_python():
    assert [number(given) for given in (3, 0.1, Fraction(1, 3), np.float64(0.1), True, 2**70)] == [3, 0.1, 1 / 3, 0.1, 1, 2**70]


def test_a_quotient_is_rounded_once():
    draw = random.Random(3)
    column, value = lowered(X / Y)
    divide = ca.Function("f", [column], [value])
    for x, y in ((draw.uniform(-9, 9), draw.uniform(1, 9)) for _ in range(200)):
        assert float(divide([x, y, 0])) == x / y


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (X / (Y * Z), "(x/(y*z))"),
        (1 / (X * Y**2), "(1./(x*sq(y)))"),
        (X / sympy.sqrt(Y), "(x/sqrt(y))"),
        (1 / sympy.sqrt(X), "(1./sqrt(x))"),
        (X**-3, "(1./(x*sq(x)))"),
        (X - Y, "(x-y)"),
        (sympy.Mod(X, 1), "(x-floor(x))"),
    ],
    ids=str,
)
def test_the_cheapest_form_is_chosen(expression, text):
    assert str(lowered(expression)[1]) == text


# Sharing, depth and width.


def nested(levels: int):
    expression = X
    for _ in range(levels):
        expression = sympy.sin(expression) * sympy.cos(expression) + 1
    return expression


def test_a_subexpression_shared_two_to_the_thirty_times_is_translated_once():
    expression = nested(30)
    start = time.perf_counter()
    column, value = lowered(expression)
    assert time.perf_counter() - start < 0.5  # 3 ms; without memory it would take hours
    assert ca.Function("f", [column], [value]).n_instructions() < 4 * 30 + 10
    expected = 0.3
    for _ in range(30):
        expected = math.sin(expected) * math.cos(expected) + 1
    assert number(expression, 0.3) == pytest.approx(expected, rel=1e-14)


def test_equal_expressions_that_are_distinct_objects_become_one():
    first = nested(30)
    clear_cache()
    second = nested(30)
    assert first is not second
    visitor = Visitor({X: ca.SX.sym("x")})
    assert visitor(first) is visitor(second)


def test_a_nesting_of_two_thousand_levels():
    expression, expected = X, 0.3
    for _ in range(2000):
        expression = sympy.Add(sympy.sin(expression, evaluate=False), 1, evaluate=False)
        expected = math.sin(expected) + 1
    assert number(expression, 0.3) == pytest.approx(expected, rel=1e-12)


def test_a_piecewise_of_four_hundred_nested_levels():
    expression = sympy.Integer(-1)
    for k in range(400):
        expression = sympy.Piecewise((k, sympy.Eq(X, k)), (expression, True), evaluate=False)
    assert [number(expression, x) for x in (0, 217, 399, 0.5)] == [0, 217, 399, -1]


def test_a_sum_of_five_thousand_terms():
    symbols = sympy.symbols("s:5000")
    column, value = lowered(sympy.Add(*(k * symbol for k, symbol in enumerate(symbols))), symbols)
    total = ca.Function("f", [column], [value])
    assert float(total(np.ones(5000))) == 5000 * 4999 / 2
    assert float(total(np.arange(5000))) == 5000 * 4999 * 9999 / 6


# Refusals.


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        (2 * sympy.Symbol("twist_rat"), r"shaft 's': unknown symbol 'twist_rat'; nearest is 'twist_rate'"),
        (sympy.Symbol("x"), r"shaft 's': symbol 'x' has other assumptions than the known one; use the declared one"),
        (sympy.Function("tork")(X), r"shaft 's': undefined function 'tork' has no numeric counterpart"),
        (sympy.Function("sinn")(X), r"undefined function 'sinn' has no numeric counterpart; nearest is 'sin'"),
        (1 + sympy.gamma(X), r"shaft 's': class 'gamma' has no numeric counterpart"),
        (sympy.Integral(sympy.gamma(X), X), r"class 'Integral' has no numeric counterpart"),
        (sympy.Derivative(sympy.Function("f")(X), X), r"class 'Derivative' has no numeric counterpart"),
        (sympy.Xor(X > 0, Y > 0), r"class 'Xor' has no numeric counterpart"),
        (sympy.ImmutableMatrix([X]), r"class 'ImmutableDenseMatrix' has no numeric counterpart"),
        (sympy.Matrix([X]), r"got an object of class 'MutableDenseMatrix'; give a scalar SymPy expression or a real number"),
        ("x", r"got an object of class 'str'; give a scalar"),
        (1j, r"got an object of class 'complex'; give a scalar"),
        (X + 2 * sympy.I, r"shaft 's': I is not a finite real number"),
        (X * sympy.exp(sympy.oo, evaluate=False), r"oo is not a finite real number"),
        (X - sympy.oo, r"-oo is not a finite real number"),
        (sympy.nan, r"nan is not a finite real number"),
        (sympy.zoo, r"zoo is not a finite real number"),
        (math.nan, r"nan is not a finite real number"),
        (-math.inf, r"-inf is not a finite real number"),
        (10**5000, r"an object of class 'int' lies beyond the range of double precision; scale"),
        (X + sympy.Integer(10) ** 5000, r"an object of class 'Integer' lies beyond the range of double precision"),
        (X + R(1, 10**400), r"an object of class 'Rational' lies beyond the range of double precision"),
        (X + sympy.Float("1e400"), r"an object of class 'Float' lies beyond the range of double precision"),
        (X + sympy.Float("1e-400"), r"an object of class 'Float' lies beyond the range of double precision"),
        (X * sympy.asin(2), r"asin of constants gives nan; keep its arguments in the real domain"),
        (X * sympy.exp(1000), r"exp of constants gives inf; keep"),
        (sympy.Pow(0, -1, evaluate=False), r"Pow of constants gives inf; keep"),
        (
            sympy.Piecewise((X, X > 0)),
            r"shaft 's': Piecewise has no piece for the remaining case; end it with \(expression, True\)",
        ),
        (sympy.Piecewise((X, X > 0), (Y, X < 0)), r"Piecewise has no piece for the remaining case"),
    ],
    ids=lambda given: None if isinstance(given, str) else type(given).__name__,
)
def test_refusals(expression, message):
    with pytest.raises(LoweringError, match=message):
        lowered(expression, (X, sympy.Symbol("twist_rate")))


def test_a_table_of_symbols_must_hold_scalars():
    with pytest.raises(
        LoweringError, match=r"shaft 's': symbol 'x' stands for an object of class 'float'; give a CasADi SX of one"
    ):
        Visitor({X: 1.0}, "shaft 's'")
    with pytest.raises(LoweringError, match=r"symbol 'x' stands for an object of class 'SX'; give a CasADi SX of one element"):
        Visitor({X: ca.SX.sym("x", 2)})


# Periodic tables (modelgen/model/tables.py), as symbols and as numbers.


@pytest.mark.parametrize("count", [1, 2, 3, 8])
@pytest.mark.parametrize("kind", [PeriodicTable, PeriodicSteps])
def test_a_table_agrees_with_its_symbolic_form_everywhere(kind, count):
    draw = random.Random(count)
    values = [R(draw.randint(-99, 99), 7) for _ in range(count)]
    curve = kind(X, *values)
    for phase in (
        *(R(k, 2 * count) for k in range(-3 * count, 3 * count)),
        *(R(draw.randint(-(10**6), 10**6), 4096) for _ in range(20)),
    ):
        if kind is PeriodicSteps and phase.q & (phase.q - 1):
            continue  # a jump at a phase that is no double
        assert number(curve, float(phase)) == pytest.approx(float(curve.subs(X, phase)), rel=EXACT, abs=1e-12)


def test_a_table_passes_through_its_samples_and_repeats():
    samples = (0.1, 0.7, -0.3, 1e6)
    curve = PeriodicTable(X, *samples)
    for k, turn in itertools.product(range(4), (-(2**40), -1, 0, 1, 2**40)):
        assert number(curve, turn + k / 4) == samples[k]
    assert number(curve, -1e-20) == samples[0]


def test_a_table_is_as_its_definition_says():
    assert PeriodicTable(R(5, 12), 3, 7, 2) == R(3, 4) * 7 + R(1, 4) * 2
    assert PeriodicTable(R(11, 12), X, Y, Z) == R(1, 4) * Z + R(3, 4) * X
    assert PeriodicSteps(R(5, 12), 3, 7, 2) == 7
    assert PeriodicSteps(R(2, 3), 3, 7, 2) == R(9, 2)
    assert PeriodicTable(R(5, 12), 3) == 3


def test_evalf_of_a_table_gives_the_digits_asked_for():
    phase = sympy.pi * 10**20  # 314159265358979323846.26433832795...
    part = sympy.Rational("0.26433832795028841971693993751058209749445923078164")
    expected = 1 + 4 * 3 * part
    assert abs(PeriodicTable(phase, 1, 5, 2).evalf(30) - expected) < sympy.Float("1e-28")
    weight = 2 * (sympy.pi - 3)
    expected = 3 * ((1 - weight) * sympy.pi + weight * sympy.E)
    assert abs((3 * PeriodicTable(sympy.pi, sympy.pi, sympy.E)).evalf(30) - expected.evalf(40)) < sympy.Float("1e-28")
    assert float(PeriodicTable(X, 1, 5, 2).evalf(subs={X: 0.5})) == 3.5
    assert PeriodicTable(X, 0.5, sympy.pi).evalf() == PeriodicTable(X, 0.5, sympy.pi)


def test_derivatives_of_a_table():
    curve = PeriodicTable(X**2, Y, Z, 5)
    assert curve.diff(Y) == PeriodicTable(X**2, 1, 0, 0)
    assert curve.diff(X) == 2 * X * PeriodicSteps(X**2, 3 * Z - 3 * Y, 15 - 3 * Z, 3 * Y - 15)
    assert curve.diff(X).diff(Z) == 2 * X * (3 * PeriodicSteps(X**2, 1, 0, 0) - 3 * PeriodicSteps(X**2, 0, 1, 0))
    assert PeriodicSteps(X, Y, Z).diff(X) == 0
    column, value = lowered(curve)
    gradient = ca.Function("f", [column], [ca.jacobian(value, column)])
    for point in ([0.4, 1.1, -2], [1.3, 0.2, 9], [0.0, 0.2, 9], [-2.0, 3, 4]):
        expected = [number(curve.diff(symbol), *point) for symbol in SYMBOLS]
        assert np.asarray(gradient(point)).ravel() == pytest.approx(expected, rel=1e-14, abs=1e-13)


def test_a_table_of_parameters_has_no_branches():
    column, value = lowered(PeriodicTable(X, Y, Z, Y))
    for result in (value, ca.jacobian(value, column)):
        function = ca.Function("f", [column], [result])
        used = {function.instruction_id(k) for k in range(function.n_instructions())}
        assert ca.OP_FABS in used or ca.OP_SIGN in used
        assert ca.OP_IF_ELSE_ZERO not in used


def test_a_real_table_is_known_to_be_real():
    a, b = sympy.symbols("a b", real=True)
    assert PeriodicTable(a, b, 1).is_real is True
    assert PeriodicTable(a, sympy.Symbol("c"), 1).is_real is None


@pytest.mark.parametrize("kind", [PeriodicTable, PeriodicSteps])
def test_refusals_of_a_table(kind):
    with pytest.raises(ModelError, match=rf"{kind.__name__}: has a phase but no values; give one value or more after the phase"):
        kind(X)
    for unlawful in (sympy.oo, sympy.nan, sympy.zoo, sympy.I):
        with pytest.raises(ModelError, match=rf"{kind.__name__}: {unlawful} is not a finite real number"):
            kind(X, 1, unlawful)
        with pytest.raises(ModelError, match=rf"{kind.__name__}: {unlawful} is not a finite real number"):
            kind(unlawful, 1, 2)
    with pytest.raises(ArgumentIndexError):
        kind(X, 1, 2).fdiff(4)
