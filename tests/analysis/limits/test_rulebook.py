"""Rules as data: their figures against the printed formulas, their provenance, and rule files that are not whole."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from modelgen.analysis.limits.rulebook import Rule, in_unit, read_rules, rule, rules
from modelgen.errors import CaseError, ModelgenError, UnitError

SHAFT = {"tensile_strength": "600 MPa", "diameter": "340 mm"}


def value(bound: Rule, **inputs: object) -> float:
    limit = bound.limit(**inputs)
    assert limit is not None
    return limit.values[0]


def test_every_rule_says_where_it_is_from_and_what_was_seen() -> None:
    assert len(rules()) >= 10
    for each in rules().values():
        assert each.citation
        assert each.applies
        assert each.seen
        words = "text seen" if each.verified else "not verified, the text of the rule was not seen"
        assert each.provenance.startswith(words)


def test_what_was_not_seen_is_not_called_verified() -> None:
    verified = {name for name, each in rules().items() if each.verified}
    assert verified == {name for name in rules() if name.startswith("kr_")}
    assert not rule("syt_5211_angle").verified


@pytest.mark.parametrize("name", ["kr_propulsion_shaft_continuous", "iacs_m68_continuous"])
def test_propulsion_shaft_in_continuous_operation(name: str) -> None:
    """Korean Register 2025, Part 5, Ch. 4, 202.1(1): (T_s + 160)/18 C_k C_d (3 - 2 lambda^2), C_d = 0.35 + 0.93 d^-0.2."""
    bound = rule(name).given(**SHAFT, shape_factor="keyway_tapered")
    size = 0.35 + 0.93 * math.exp(-0.2 * math.log(340.0))
    assert value(bound, speed_ratio=0.5) == pytest.approx(760 / 18 * 0.6 * size * 2.5, rel=1e-14)
    assert value(bound, speed_ratio=1.0) == pytest.approx(760 / 18 * 0.6 * size * 1.38, rel=1e-14)
    assert value(bound, speed_ratio=0.9) == pytest.approx(value(bound, speed_ratio=0.9 + 1e-12), rel=1e-10)
    assert bound.limit(speed_ratio=1.06) is None


@pytest.mark.parametrize("family", ["kr_propulsion_shaft", "iacs_m68"])
def test_passing_a_range_allows_1_7_over_the_root_of_the_shape_factor(family: str) -> None:
    """Same rules, 202.1(2): tau_2 = 1.7 tau_1 / sqrt(C_k) up to lambda = 0.8."""
    given = {**SHAFT, "shape_factor": "propeller_shaft", "speed_ratio": 0.7}
    continuous, transient = value(rule(f"{family}_continuous"), **given), value(rule(f"{family}_transient"), **given)
    assert transient == pytest.approx(1.7 * continuous / math.sqrt(0.55), rel=1e-14)
    assert rule(f"{family}_transient").limit(**{**given, "speed_ratio": 0.81}) is None


def test_crankshaft_limits() -> None:
    """Same rules, 201: 45 - 24 (or 29) lambda^2, 21 (or 16) + 237 (lambda - 0.8) sqrt(lambda - 1), f_m for T_s > 440."""
    four, other = (rule("kr_crankshaft_continuous").given(engine=kind) for kind in ("four_stroke", "other"))
    assert value(four, speed_ratio=0.5) == pytest.approx(39.0)
    assert value(other, speed_ratio=1.0) == pytest.approx(16.0)
    assert value(four, speed_ratio=1.1) == pytest.approx(21 + 237 * 0.3 * math.sqrt(0.1))
    assert value(four, speed_ratio=1.0, tensile_strength="660 MPa", steel="low_alloy") == pytest.approx(21 * (1 + 2 / 3 * 0.5))
    assert value(four, speed_ratio=1.0, tensile_strength="400 MPa") == pytest.approx(21.0)
    assert value(rule("kr_crankshaft_transient").given(engine="four_stroke"), speed_ratio=0.5) == pytest.approx(78.0)


def test_the_other_limits() -> None:
    assert value(rule("syt_5211_angle")) == 0.5
    assert value(rule("mil_std_167_2_steel"), tensile_strength="500 N/mm^2") == pytest.approx(20.0)
    assert value(rule("api_617_separation")) == 10.0
    assert value(rule("agreed_separation"), required_margin=0.15) == pytest.approx(15.0)
    assert value(rule("kr_generator_shaft")) == pytest.approx(31.0)
    limit = rule("kr_major_critical_generator").limit()
    assert limit is not None
    assert limit.values == (0.9, 1.1)


def test_the_formula_is_shown_with_its_numbers() -> None:
    limit = rule("mil_std_167_2_steel").limit(tensile_strength="500 MPa")
    assert limit is not None
    assert (limit.formula, limit.inserted) == ("tensile_strength/25", "500/25")


@pytest.mark.parametrize(
    ("inputs", "words"),
    [
        ({"tensile": 1}, "rule 'kr_propulsion_shaft_continuous': has no input 'tensile'; nearest is 'tensile_strength'"),
        ({"shape_factor": "keyway_conical"}, "shape_factor: is 'keyway_conical'; nearest is 'keyway_cylindrical'"),
        ({"tensile_strength": "900 MPa"}, "is 900 MPa, the rule counts at most 800; it is: T_s"),
        ({"diameter": "-3 mm"}, "diameter: is -3 mm; give a positive value"),
        ({"speed_ratio": -0.1}, "speed_ratio: is -0.1; give 0 or more"),
        ({"diameter": 340}, "340.0 has no unit"),
        ({"diameter": "340 MPa"}, "diameter: .*'m' .* is asked for"),
    ],
)
def test_inputs_are_read_strictly(inputs: dict[str, object], words: str) -> None:
    with pytest.raises(ModelgenError, match=words):
        rule("kr_propulsion_shaft_continuous").given(**inputs)


def test_a_missing_input_is_asked_for() -> None:
    words = r"needs shape_factor \(C_k of table 5.4.1\); write rule.given\(shape_factor=...\) with a number or integral"
    with pytest.raises(CaseError, match=words):
        rule("kr_propulsion_shaft_continuous").given(**SHAFT).limit(speed_ratio=0.5)


def test_an_unknown_rule_names_the_nearest() -> None:
    with pytest.raises(CaseError, match="rule 'syt_5211': is unknown; nearest is 'syt_5211_angle'"):
        rule("syt_5211")


def test_numbers_in_a_unit() -> None:
    assert in_unit("0.01 rad", "deg", "x") == pytest.approx(math.degrees(0.01), rel=1e-14)
    assert in_unit((2.0, "kN*m"), "N*m", "x") == pytest.approx(2000.0)
    assert in_unit("12 percent", "1", "x") == pytest.approx(0.12)
    with pytest.raises(UnitError, match=r"x: 2.0 has no unit"):
        in_unit(2.0, "N*m", "x")
    with pytest.raises(UnitError, match="is not a number"):
        in_unit([1.0], "1", "x")


RULE = """
format = 1
[rules.own]
title = "t"
quantity = "q"
measure = "m"
unit = "MPa"
comparison = "at most"
limit = "2*a"
applies = "here"
citation = "a report"
verified = true
seen = "all"
[rules.own.inputs]
a = { unit = "MPa", doc = "a stress" }
"""


def test_a_rule_file_of_ones_own(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(RULE, encoding="utf-8")
    assert value(read_rules(path)["own"], a="3 MPa") == 6.0


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("format = 1", "format = 2", "own.toml: is no rule file; write format = 1"),
        ('citation = "a report"', "", r"\[rules.own\]: has no citation; every rule says"),
        ("verified = true", 'verified = "yes"', "verified is 'yes'; write true where the rule's text was seen"),
        ("at most", "less than", "comparison is 'less than'"),
        ("2*a", "2*b", "uses 'b', which is no input of it; known are a"),
        ('limit = "2*a"', "", "does not hold one of limit and cases"),
        ('limit = "2*a"', 'limit = ["1", "2"]', "has 2 limits for 'at most'"),
        ('unit = "MPa"\ncomp', 'unit = "MPaa"\ncomp', "'MPaa' is not a known unit"),
        ('title = "t"', "title = 3", "title is 3; write a text"),
        ('doc = "a stress"', 'doc = "a", lowest = 1', "input a: has an unknown key 'lowest'; nearest"),
        ("format = 1", "format =", "cannot be read"),
    ],
)
def test_a_rule_file_that_is_not_whole(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = tmp_path / "own.toml"
    path.write_text(RULE.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ModelgenError, match=words):
        read_rules(path)


def test_a_rule_that_divides_by_zero_says_so(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(RULE.replace("2*a", "2/(a - 3)"), encoding="utf-8")
    with pytest.raises(ModelgenError, match=r"rule 'own': .* divides by zero"):
        read_rules(path)["own"].limit(a="3 MPa")
