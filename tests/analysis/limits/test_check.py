"""Values against rules: verdicts, margins, words of provenance, and what cannot be judged."""

from __future__ import annotations

import math

import pytest

from modelgen.analysis.limits.check import angle_values, check_limits
from modelgen.analysis.limits.rulebook import rule
from modelgen.analysis.time_domain.angles import AnglesResult, InertiaAngles, MeshForces, Swing
from modelgen.analysis.time_domain.window import Window
from modelgen.errors import CaseError, UnitError

DEGREE = math.pi / 180


def measured(peak: float = 0.5863, settled: bool = True) -> AnglesResult:
    """Two inertias, in degrees, one of them at the largest angle that the paper reports."""
    big = InertiaAngles(Swing(peak * DEGREE, 0.55 * DEGREE), Swing(0.3 * DEGREE, 0.2 * DEGREE), 1.0)
    small = InertiaAngles(Swing(0.2 * DEGREE, 0.19 * DEGREE), Swing(0.1 * DEGREE, 0.1 * DEGREE), 0.5)
    mesh = MeshForces(-9.0, 5.0, 1.0, 1.0, 0.0, 0.0)
    window = Window(0.0, 1.0, 8, "crank", 0.125, settled)
    return AnglesResult("truck", window, {"flywheel": big, "pump": small}, {"coupling": Swing(0.01, 0.01)}, {"mesh": mesh})


def test_the_angle_limit_of_the_paper() -> None:
    result = check_limits(measured(), "syt_5211_angle")
    by_name = {row.element: row for row in result.rows}
    assert result.model == "truck"
    assert by_name["flywheel"].verdict == "fail"
    assert by_name["flywheel"].value == pytest.approx(0.5863, rel=1e-14)
    assert by_name["flywheel"].limits == (0.5,)
    assert by_name["flywheel"].margin == pytest.approx(1 - 0.5863 / 0.5, rel=1e-12)
    assert by_name["flywheel"].beside == pytest.approx(0.55)
    assert by_name["pump"].verdict == "pass"
    assert by_name["pump"].margin == pytest.approx(0.6)
    assert not result.ok


def test_a_rule_whose_text_was_not_seen_says_so_in_its_output() -> None:
    result = check_limits(measured(), ["syt_5211_angle"])
    assert result.unverified == ("syt_5211_angle",)
    assert all(not row.verified and "text of the rule was not seen" in row.provenance for row in result.rows)
    text = str(result)
    assert text.count("[syt_5211_angle, not verified]") == 2
    assert "not verified, the text of the rule was not seen" in text
    assert "0.5863 deg (half peak to peak 0.55 deg): at most 0.5 deg, 17.3 % beyond it" in text


def test_a_rule_whose_text_was_seen_does_not() -> None:
    stress = rule("kr_crankshaft_continuous").given(engine="four_stroke", speed_ratio=0.5)
    result = check_limits({"crank_1.vibratory_stress": "30 N/mm^2"}, stress, "engine")
    assert result.ok
    assert result.unverified == ()
    assert "not verified" not in str(result)
    assert "at most 39 MPa = (45 - engine*speed_ratio**2)" in str(result)
    assert "(45 - 24*0.5**2)" in result.rows[0].inserted


def test_a_start_that_is_still_in_the_values_is_remarked() -> None:
    assert check_limits(measured(), "syt_5211_angle").remarks == ()
    assert "not settled" in str(check_limits(measured(settled=False), "syt_5211_angle"))


def test_values_of_angles_have_names_and_units() -> None:
    values = angle_values(measured())
    assert values["pump.elastic_angle"] == (pytest.approx(0.1 * DEGREE), "rad")
    assert values["mesh.mesh_force"] == (9.0, "N")
    assert values["coupling.twist_half_pp"] == (0.01, "rad")


def test_a_rule_for_some_elements_leaves_the_others() -> None:
    limit = rule("coupling_vibratory_torque")
    rules = [
        limit.given("front", continuous_vibratory_torque="2 kN*m"),
        limit.given("rear", continuous_vibratory_torque="1 kN*m"),
    ]
    result = check_limits({"front.vibratory_torque": (1500.0, "N*m"), "rear.vibratory_torque": "1.5 kN*m"}, rules)
    found = [(row.element, row.verdict, row.limits[0]) for row in result.rows]
    assert found == [("front", "pass", 2000.0), ("rear", "fail", 1000.0)]


def test_at_least_and_outside() -> None:
    result = check_limits({"a.separation_margin": 0.12, "b.separation_margin": 0.08}, "api_617_separation")
    assert [(row.verdict, row.margin) for row in result.rows] == [("pass", pytest.approx(0.2)), ("fail", pytest.approx(-0.2))]
    values = {f"{name}.critical_speed_ratio": value for name, value in {"low": 0.6, "inside": 1.0, "high": 1.21}.items()}
    rows = check_limits(values, "kr_major_critical_propulsion").rows
    assert [(row.verdict, row.margin) for row in rows] == [
        ("pass", pytest.approx(0.25)),
        ("fail", pytest.approx(-0.1 / 1.1)),
        ("pass", pytest.approx(0.1)),
    ]
    assert rows[0].limits == (0.8, 1.1)


def test_a_value_on_the_limit_passes() -> None:
    limit = rule("coupling_vibratory_torque").given(continuous_vibratory_torque="2 kN*m")
    assert check_limits({"c.vibratory_torque": "-2 kN*m"}, limit).rows[0].verdict == "pass"


def test_beyond_the_range_of_a_rule_nothing_is_judged() -> None:
    transient = rule("kr_crankshaft_transient").given(engine="other", speed_ratio=0.95)
    result = check_limits({"crank.vibratory_stress": "30 MPa"}, transient)
    (row,) = result.rows
    assert (row.verdict, row.margin, row.remark) == ("not judged", None, "the rule holds for speed_ratio 0 to 0.8 only")
    assert not result.ok
    assert "not judged crank.vibratory_stress 30 MPa: the rule holds for" in str(result)


@pytest.mark.parametrize(
    ("values", "rules", "words"),
    [
        ({"a.vibration_angel": "1 deg"}, "syt_5211_angle", "judges 'vibration_angle', of which there is no value; nearest is"),
        ({"vibration_angle": "1 deg"}, "syt_5211_angle", "value 'vibration_angle': does not name an element and a quantity"),
        ({"a.vibration_angle": "1 deg"}, "syt_angle", "rule 'syt_angle': is unknown"),
        ({"pump.vibration_angle": "1 deg"}, rule("syt_5211_angle").given("pmup"), "no pmup.vibration_angle; nearest is 'pump'"),
        ({"a.vibratory_torque": "1 N*m"}, "coupling_vibratory_torque", r"needs continuous_vibratory_torque \(T_KW"),
    ],
)
def test_what_cannot_be_checked(values: dict[str, str], rules: object, words: str) -> None:
    with pytest.raises(CaseError, match=words):
        check_limits(values, rules)  # type: ignore[arg-type]


def test_what_holds_no_values_is_refused() -> None:
    with pytest.raises(
        CaseError, match=r"values: are list; give an AnglesResult, or values by name; for modes, separation_margins"
    ):
        check_limits([1.0], "syt_5211_angle")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (12.0, "value 'a.vibratory_torque': 12.0 has no unit"),
        ("12 rad/s", "is asked for"),
        ("much", "is not a number with a unit"),
    ],
)
def test_a_value_must_fit_its_rule(value: object, words: str) -> None:
    with pytest.raises(UnitError, match=words):
        check_limits({"a.vibratory_torque": value}, rule("coupling_vibratory_torque").given(continuous_vibratory_torque="1 N*m"))
