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
        result = invoke("limits", two_disks, "--out", tmp_path / name, *options, *damped)
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
        (("--operating", "900 rpm", "800 rpm"), "give two positive speeds"),
        (("--set", "shaking.scale=0"), "does not vibrate, nothing excites it"),
    ],
)
def test_a_wrong_option(invoke: Invoke, two_disks: Path, tmp_path: Path, options: tuple[str, ...], words: str) -> None:
    assert words in refused(invoke("limits", two_disks, "--out", tmp_path / "out", "--response", "forced", *options), 2)
    assert list(tmp_path.iterdir()) == []
