"""``modelgen limits``: values against rules, with formula, margin and what is known of the rule, and refusals by their words."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from .conftest import Invoke
from .test_campbell_command import FREQUENCY
from .test_forced_command import torque
from .test_modal_command import rows
from .test_refusals import refused

MIL = "mil_std_167_2_steel shaft tensile_strength='600 MPa'"
COUPLING = "coupling_vibratory_torque shaft continuous_vibratory_torque='0.1 kN*m'"


@pytest.fixture(scope="module")
def out(invoke: Invoke, two_disks: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("limits") / "out"
    options = (
        "--response",
        "forced",
        "--rule",
        "syt_5211_angle",
        "--rule",
        "api_617_separation",
        "--rule",
        MIL,
        "--rule",
        COUPLING,
    )
    result = invoke("limits", two_disks, "--out", folder, *options)
    assert result.exit_code == 0, result.output
    assert "not verified, the text of the rule was not seen: known is one sentence of the paper" in result.stdout
    assert "at most 24 MPa = tensile_strength/25 = 600/25" in result.stdout
    return folder


def test_the_files(out: Path) -> None:
    assert {path.name for path in out.iterdir()} == {"limits.csv", "limits.json", "limits.png"}


def test_every_row_is_judged_as_it_should(out: Path) -> None:
    found = {(row["rule"], row["element"]): row for row in rows(out / "limits.csv")}
    omega = 3 * 40 * math.pi
    angle = found["syt_5211_angle", "engine"]
    assert (angle["unit"], angle["verdict"], angle["verified"], angle["limit [unit]"]) == ("deg", "pass", "no", "0.5")
    assert float(angle["margin [percent]"]) == pytest.approx(100 * (1 - float(angle["value [unit]"]) / 0.5))
    (separation,) = [row for (rule, _), row in found.items() if rule == "api_617_separation"]
    assert separation["element"] == "mode 1 (100.7 Hz) / order 6 (firing x 2)"
    assert float(separation["value [unit]"]) == pytest.approx(100 * (1 - FREQUENCY / 120))
    assert separation["verdict"] == "pass"
    stress, coupling = found["mil_std_167_2_steel", "shaft"], found["coupling_vibratory_torque", "shaft"]
    assert (stress["formula"], stress["formula with numbers"]) == ("tensile_strength/25", "600/25")
    assert float(stress["value [unit]"]) == pytest.approx(16 / (math.pi * 0.08**3) * float(coupling["value [unit]"]) / 1e6)
    # Both orders together are at least as large as the larger one and at most their sum.
    one, two = abs(torque(40, omega)), abs(torque(10, 2 * omega))
    assert max(one, two) <= float(coupling["value [unit]"]) <= one + two
    assert coupling["verdict"] == ("fail" if float(coupling["value [unit]"]) > 100 else "pass")


def test_the_summary(out: Path) -> None:
    data = json.loads((out / "limits.json").read_text(encoding="utf-8"))
    assert data["pass"] + data["fail"] == len(data["rows"]) == 5
    assert data["ok"] is (data["fail"] == 0)
    assert data["unverified"] == ["syt_5211_angle", "api_617_separation", "mil_std_167_2_steel", "coupling_vibratory_torque"]
    assert "linear forced response" in data["remarks"][0]


def test_settled_angles_are_the_default(invoke: Invoke, two_disks: Path, out: Path, tmp_path: Path) -> None:
    found = []
    for name, options in (("settled", ()), ("linear", ("--response", "forced"))):
        damped = ("--set", "shaft.damping_coefficient=80 N*m*s/rad")
        result = invoke("limits", two_disks, "--out", tmp_path / name, "--rule", "syt_5211_angle", *options, *damped)
        assert result.exit_code == 0, result.output
        assert ("simulate" in result.stderr) == (name == "settled")
        found.append([row for row in rows(tmp_path / name / "limits.csv") if row["quantity"] == "vibration_angle"])
    settled, linear = found
    assert len(settled) == 2
    for one, other in zip(settled, linear, strict=True):
        # The best straight line through eight periods of a sine is not quite level.
        assert float(one["half p-p [unit]"]) == pytest.approx(float(other["half p-p [unit]"]), rel=1e-2)


def test_a_rule_for_nothing_but_separation_needs_no_run(invoke: Invoke, two_disks: Path, tmp_path: Path) -> None:
    options = ("--rule", "agreed_separation required_margin='20 percent'", "--operating", "900 rpm", "1100 rpm")
    result = invoke("limits", two_disks, "--out", tmp_path / "out", *options)
    assert result.exit_code == 0, result.output
    assert "simulate" not in result.stderr
    (row,) = rows(tmp_path / "out" / "limits.csv")
    assert (row["verdict"], row["value [unit]"]) == ("fail", "0")  # order 6 runs through the mode


SHIP = "kr_propulsion_shaft_continuous shaft tensile_strength='600 MPa' shape_factor=integral_flange"


def test_speed_ratio_and_diameter_come_from_the_model_and_the_command(invoke: Invoke, two_disks: Path, tmp_path: Path) -> None:
    """Korean Register 2025, Part 5, Ch. 4, 202.1(1), at lambda = 1020/1200 of a shaft of 80 mm, and of 120 mm."""
    for diameter, options in ((80.0, ()), (120.0, ("--diameter", "shaft=120 mm"))):
        out = tmp_path / f"{diameter:g}"
        result = invoke(
            "limits", two_disks, "--out", out, "--response", "forced", "--rule", SHIP, "--speed", "1020 rpm", *options
        )
        assert result.exit_code == 0, result.output
        (row,) = rows(out / "limits.csv")
        expected = 760 / 18 * (0.35 + 0.93 * diameter**-0.2) * (3 - 2 * 0.85**2)
        assert float(row["limit [unit]"]) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize(
    ("rule", "words"),
    [
        (SHIP.replace("600", "750"), "tensile_strength: is 750 MPa, the rule's text goes up to 600 MPa for carbon steel"),
        (SHIP.replace("600", "750").replace("integral_flange", "propeller_shaft") + " steel=low_alloy", "600 MPa for propeller"),
        (SHIP + " speed_ratio=0.5", "speed_ratio: is given as 0.5, and the values that are judged belong to 1"),
        (SHIP + " diameter='300 mm'", "diameter: is given as 300 mm, and the values that are judged belong to 80 mm"),
        ("kr_major_critical_propulsion", "needs cylinders"),
        ("iacs_m68 shaft tensile='600 MPa'", "rule 'iacs_m68': has no input 'tensile'; nearest is 'tensile_strength'"),
    ],
)
def test_a_rule_is_refused_beyond_its_own_text(invoke: Invoke, two_disks: Path, tmp_path: Path, rule: str, words: str) -> None:
    options = ("--response", "forced", "--rule", rule)
    assert words in refused(invoke("limits", two_disks, "--out", tmp_path / "out", *options), 2)


def test_major_critical_speeds_of_the_one_node_mode_only(invoke: Invoke, two_disks: Path, tmp_path: Path) -> None:
    options = ("--rule", "kr_major_critical_propulsion cylinders=6", "--operating", "600 rpm", "1200 rpm")
    result = invoke("limits", two_disks, "--out", tmp_path / "out", *options)
    assert result.exit_code == 0, result.output
    found = rows(tmp_path / "out" / "limits.csv")
    assert [row["element"] for row in found] == [
        f"mode 1 (100.7 Hz) / {name}" for name in ("order 3 (firing x 1)", "order 6 (firing x 2)")
    ]
    assert float(found[1]["value [unit]"]) == pytest.approx(FREQUENCY / (6 * 20))
    assert "judged for modes with 1 node and orders 6 and 3 only" in result.stdout


def test_a_model_chooses_its_own_rules(invoke: Invoke, two_disks: Path, tmp_path: Path) -> None:
    chosen = '[[limits]]\nrule = "mil_std_167_2_steel"\nelements = ["shaft"]\ninputs = { tensile_strength = "600 MPa" }\n'
    model = tmp_path / "chosen.toml"
    model.write_text(two_disks.read_text(encoding="utf-8") + chosen, encoding="utf-8")
    assert invoke("limits", model, "--out", tmp_path / "out", "--response", "forced").exit_code == 0
    (row,) = rows(tmp_path / "out" / "limits.csv")
    assert (row["rule"], row["element"], row["limit [unit]"]) == ("mil_std_167_2_steel", "shaft", "24")
    model.write_text(model.read_text(encoding="utf-8").replace("mil_std_167_2_steel", "mil_std_steel"), encoding="utf-8")
    for command in (("check",), ("limits", "--out", tmp_path / "no"), ("run", "--out", tmp_path / "no")):
        result = invoke(command[0], model, *command[1:])
        assert "rule 'mil_std_steel': is unknown; nearest is 'mil_std_167_2_steel'" in result.stderr
        assert result.exit_code in (1, 2)


def test_the_rules_are_listed(invoke: Invoke) -> None:
    listed = invoke("limits", "--list")
    assert listed.exit_code == 0
    assert "iacs_m68_continuous: propulsion shaft, continuous operation; judges vibratory_stress [MPa]" in listed.stdout
    assert "tensile_strength [MPa]: ultimate tensile strength" in listed.stdout
    assert "text seen: the paragraph and its table 5.4.1" in listed.stdout


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--rule", "syt_5211"), "rule 'syt_5211': is unknown; nearest is 'syt_5211_angle'"),
        (("--rule", "mil_std_167_2_steel shaft"), "needs tensile_strength"),
        (("--rule", "mil_std_167_2_steel shaft tensile_strength=600"), "has no unit"),
        (("--rule", "mil_std_167_2_steel shaft strength='600 MPa'"), "has no input 'strength'"),
        (("--rule", MIL.replace("shaft", "shaff")), "there is no shaff.vibratory_stress"),
        (("--rule", "mil_std_167_2_steel 'shaft"), "has a quotation mark without its partner"),
        (("--rule", ""), "modelgen limits --list names them"),
        ((), "driveline 'two-disks': chooses no rule to be held against; name one with --rule"),
        (("--operating", "900 rpm", "800 rpm"), "give two positive speeds"),
        (("--rule", "syt_5211_angle", "--set", "shaking.scale=0"), "does not vibrate, nothing excites it"),
    ],
)
def test_a_wrong_option(invoke: Invoke, two_disks: Path, tmp_path: Path, options: tuple[str, ...], words: str) -> None:
    assert words in refused(invoke("limits", two_disks, "--out", tmp_path / "out", "--response", "forced", *options), 2)
    assert list(tmp_path.iterdir()) == []
