"""Rows under one sum sign, roots in one, waves joined: printed expressions equal what they stand for."""

from __future__ import annotations

import pytest
import sympy

from modelgen.equations.notation import Notation, notation, plain_notation
from modelgen.equations.typesetting import Typesetter
from modelgen.model import PeriodicTable
from modelgen.model.declarations import TIME

angle, w, phase, b, d = sympy.symbols("angle w phase b d", real=True)
cosine = sympy.symbols("cosine_1:7", real=True)
sine = sympy.symbols("sine_1:7", real=True)
SYMBOLS = {w: r"\omega", phase: r"\varphi", **{s: Notation("a").row(str(k)) for k, s in enumerate(cosine, 1)}}
SYMBOLS.update({s: Notation("b").row(str(k)) for k, s in enumerate(sine, 1)})
SYMBOLS.update({TIME: "t", b: "b", d: r"\delta"})


def typesetter() -> Typesetter:
    return Typesetter(SYMBOLS, moving=[d], series={Notation("a"): cosine, Notation("b"): sine}, waves={angle: w * TIME})


def rows(count: int, first: int = 0) -> sympy.Expr:
    return sympy.Add(
        *(cosine[n - 1 + first] * sympy.cos(n * angle) + sine[n - 1] * sympy.sin(n * angle) for n in range(1, count + 1))
    )


def test_four_rows_or_more_become_a_sum() -> None:
    shown = r"\sum_{n=1}^{5} \left(a_{n} \cos{\left(n \omega t \right)} + b_{n} \sin{\left(n \omega t \right)}\right)"
    assert typesetter()(rows(5)) == shown
    assert typesetter()(rows(4)) == shown.replace("5", "4")
    assert r"\sum" not in typesetter()(rows(3))


def test_a_shift_of_rows_is_printed() -> None:
    assert r"a_{n+1} \cos" in typesetter()(rows(5, first=1))


@pytest.mark.parametrize(
    "change",
    [
        cosine[2] * sympy.cos(3 * angle),  # one coefficient counts twice
        2 * sympy.sin(2 * angle),  # a number beside a row
        (cosine[0] - sine[3]) * sympy.cos(4 * angle),  # a row of another order
    ],
)
def test_rows_that_follow_no_pattern_are_written_out(change: sympy.Expr) -> None:
    typeset = typesetter()
    shown = typeset(rows(5) + change)
    assert r"\sum" not in shown
    assert shown.count(r"\cos") + shown.count(r"\sin") >= 10
    assert not typeset.notes


def test_orders_that_skip_run_over_an_index() -> None:
    typeset = typesetter()
    orders = (1, 2, 4, 6)
    total = sympy.Add(*(cosine[k] * sympy.cos(n * (angle + phase)).expand(trig=True) for k, n in enumerate(orders)))
    plain = sympy.Add(*(cosine[k] * sympy.cos(n * angle) for k, n in enumerate(orders)))
    assert typeset(plain) == r"\sum_{i=1}^{4} a_{i} \cos{\left(n_i \omega t \right)}"
    assert typeset.notes == [r"n_1, \ldots, n_{4} = 1, 2, 4, 6"]
    assert r"\sum" not in typeset(total), "powers of waves are no rows"


def test_waves_with_a_phase_are_joined() -> None:
    turned = sympy.sin(angle) * sympy.cos(phase) + sympy.cos(angle) * sympy.sin(phase)
    assert typesetter()(b * turned) == r"b \sin{\left(\omega t + \varphi \right)}"
    half = sympy.sin(angle) * sympy.cos(phase) + 2 * sympy.cos(angle) * sympy.sin(phase)
    assert typesetter()(half).count(r"\sin") + typesetter()(half).count(r"\cos") >= 3


def test_roots_are_gathered() -> None:
    x, y, z = sympy.symbols("x y z", positive=True)
    typeset = Typesetter({x: "x", y: "y", z: "z"})
    assert typeset(2 * sympy.sqrt(x) * sympy.sqrt(y) / sympy.sqrt(x + y)) == r"2 \sqrt{\frac{x y}{x + y}}"
    assert typeset(x * sympy.sqrt(y)) == r"x \sqrt{y}"  # noqa: RUF027 - braces of LaTeX


def test_terms_and_factors_follow_the_given_order() -> None:
    names = [sympy.Symbol(name) for name in "zyxw"]
    typeset = Typesetter({symbol: symbol.name for symbol in names})
    z, y, x, w_last = names
    assert typeset(w_last * x * y * z) == "z y x w"
    assert typeset(-z + y * x - w_last) == "y x - z - w"
    assert typeset.terms(-z + y * x - w_last) == ["y x", "- z", "- w"]


def test_conditions_say_what_moves_on_the_left() -> None:
    gap = sympy.Piecewise((d - b, d > b), (d + b, d < -b), (0, True))
    shown = typesetter()(gap)
    assert r"\delta - b & \text{if } \delta > b \\" in shown
    assert r"\delta + b & \text{if } \delta < - b \\" in shown
    assert r"0 & \text{otherwise} \end{cases}" in shown
    either = sympy.Piecewise((d, sympy.Or(d > b, d < -b)), (0, True))
    assert typesetter()(either).count(r"\text{if }") == 2


def test_functions_that_github_refuses_get_other_names() -> None:
    shown = typesetter()(sympy.sign(d) + sympy.Heaviside(b) + sympy.atan2(d, b))
    assert r"\operatorname" not in shown
    assert r"\mathrm{sign}" in shown


def test_a_table_shows_its_ends() -> None:
    assert typesetter()(PeriodicTable(angle, *cosine)) == r"\mathrm{table}\left(\omega t;\ a_{1}, a_{2}, \ldots, a_{6}\right)"
    assert typesetter()(PeriodicTable(angle, *cosine[:2])) == r"\mathrm{table}\left(\omega t;\ a_{1}, a_{2}\right)"


@pytest.mark.parametrize(
    ("name", "doc", "shown"),
    [
        ("damping_ratio", "", r"\zeta"),
        ("damping_ratio", "xi", r"\xi"),
        ("anything", "omega_ref", r"\omega_{\text{ref}}"),
        ("anything", "k0", "k_{0}"),
        ("sine", "a_h", "a"),
        ("teeth_b", "teeth of the wheel on b", "z_{b}"),  # noqa: RUF027 - braces of LaTeX
        ("radius_2", "", "r_{2}"),
        ("deflection_rate", "", r"\dot{\delta}"),
        ("oil_level", "share of oil", r"\text{oil level}"),
        ("oil_rate", "", r"\text{oil rate}"),
        ("mu", "", r"\mu"),
        ("y12", "", "y_{12}"),
        ("module", "module", "m"),
    ],
)
def test_names_and_their_symbols(name: str, doc: str, shown: str) -> None:
    assert str(notation(name, doc)) == shown


def test_symbols_of_named_things() -> None:
    assert str(notation("radius_a").of("pump_mesh")) == r"r_{a,\text{pump mesh}}"
    assert str(notation("penetration")) == r"f(\delta)"
    assert str(notation("penetration").of("mesh")) == r"f_{\text{mesh}}"
    assert str(notation("twist").dotted().of("s_1")) == r"\dot u_{\text{s 1}}"
    assert str(notation("oil_level").of("tank")) == r"\text{oil level} _{\text{tank}}"
    assert str(plain_notation("stiffness")) == r"\text{stiffness}"
