"""modelgen run, end to end on a small geared driveline: every file, every figure's unit, and a report that hangs together."""

from __future__ import annotations

import csv
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modelgen.drivelines import load

from .conftest import Invoke

QUICK = ("--crosscheck", "cvodes")


@pytest.fixture(scope="module")
def folder(invoke: Invoke, small: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("runs") / "made" / "small"
    result = invoke("run", small, "--out", out, "--set", "coupling.stiffness=25 kN*m/rad", *QUICK)
    assert result.exit_code == 0, result.stderr
    assert "largest vibration angle" in result.stdout
    assert f"{out / 'report.md'}" in result.stdout
    assert "modelgen: simulate" in result.stderr  # progress in plain lines, because this is no terminal
    return out


@pytest.fixture(scope="module")
def summary(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def test_the_folder_holds_everything_and_nothing_else(folder: Path) -> None:
    assert sorted(each.name for each in folder.iterdir()) == [
        *("equations.md", "equations.tex", "figures", "model.toml", "report.md", "responses.csv", "summary.json"),
    ]
    assert list(folder.parent.iterdir()) == [folder]  # no temporary folder beside it
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in (folder / "figures").iterdir())
    assert folder.stat().st_mode & 0o777 != 0o700  # others may read it, as far as the mask of new files allows


def test_the_summary_has_its_keys(summary: dict[str, Any]) -> None:
    assert list(summary) == [
        *("model", "natural_frequencies_hz", "angles_deg", "twist_half_pp_deg", "mesh", "window_s", "damping", "limit"),
        *("limits", "crosscheck", "wall_s"),
    ]
    assert summary["model"] == "small"
    assert list(summary["angles_deg"]) == ["motor", "pinion", "fan"]
    for angles in summary["angles_deg"].values():
        assert list(angles) == ["vibration_peak", "vibration_half_pp", "elastic_peak", "elastic_half_pp", "referred_ratio"]
        assert 0 < angles["vibration_half_pp"] <= angles["vibration_peak"]
        assert 0 < angles["elastic_half_pp"] <= angles["elastic_peak"]
    assert list(summary["twist_half_pp_deg"]) == ["coupling"]
    assert list(summary["mesh"]["mesh"]) == ["force_min_n", "force_max_n", "mean_stiffness_n_per_m", "contact_ratio"]
    assert summary["damping"] == {"shaft": "per_shaft", "zeta": 0.2, "mesh_form": "corrected", "xi": 0.1, "mesh_reading": "fixed"}
    assert list(summary["limit"]) == ["name", "quantity", "element", "deg", "value_deg", "ok"]
    assert list(summary["crosscheck"]) == ["solvers", "worst_relative_difference", "horizon_s"]


def test_the_natural_frequencies_are_in_hertz(summary: dict[str, Any]) -> None:
    """Against the eigenvalues of the three disks, written down here: M, and K = k g g^T + k_mesh r r^T."""
    stiffness = summary["mesh"]["mesh"]["mean_stiffness_n_per_m"]
    r_a = 0.5 * 0.003 * 20 * math.cos(math.radians(20))
    twist, line_of_action = np.array([1.0, -1.0, 0.0]), np.array([0.0, r_a, -2 * r_a])
    k = 25e3 * np.outer(twist, twist) + stiffness * np.outer(line_of_action, line_of_action)
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(np.diag([0.3, 0.05, 1.5]), k)).real)
    expected = np.sqrt(np.abs(squares)) / (2 * np.pi)
    assert summary["natural_frequencies_hz"][0] < 1e-3
    assert summary["natural_frequencies_hz"][1:] == pytest.approx(expected[1:], rel=1e-9)


def test_the_angles_are_in_degrees_and_the_forces_in_newtons(summary: dict[str, Any], folder: Path) -> None:
    mesh, mean_force = summary["mesh"]["mesh"], 100 / (0.5 * 0.003 * 20 * math.cos(math.radians(20)))
    assert mesh["force_min_n"] < mean_force < mesh["force_max_n"]
    rows = list(csv.DictReader((folder / "responses.csv").read_text(encoding="utf-8").splitlines()))
    twist = np.degrees([float(row["coupling.twist [rad]"]) for row in rows])
    # The file holds one period of the motion, the summary looks at eight, in which a thousandth still decays.
    assert summary["twist_half_pp_deg"]["coupling"] == pytest.approx(np.ptp(twist) / 2, rel=1e-2)
    motor = np.degrees([float(row["motor.vibration_angle [rad]"]) for row in rows])
    assert summary["angles_deg"]["motor"]["vibration_peak"] == pytest.approx(np.abs(motor).max(), rel=1e-2)
    assert summary["angles_deg"]["fan"]["referred_ratio"] == pytest.approx(0.5, abs=1e-12)


def test_the_contact_ratio_follows_from_the_teeth(summary: dict[str, Any]) -> None:
    """ISO 21771: the length of the path of contact over the base pitch, addendum 1, no profile shift."""
    alpha, base, tip = math.radians(20), [30 * math.cos(math.radians(20)), 60 * math.cos(math.radians(20))], [33.0, 63.0]
    path = sum(math.sqrt(a * a - b * b) for a, b in zip(tip, base, strict=True)) - 90 * math.sin(alpha)
    assert summary["mesh"]["mesh"]["contact_ratio"] == pytest.approx(path / (3 * math.pi * math.cos(alpha)), rel=1e-9)


def test_the_window_is_eight_periods_after_settling(summary: dict[str, Any]) -> None:
    first, last = summary["window_s"]
    assert last - first == pytest.approx(8 / 50, rel=1e-12)  # order 2 of 1500 rpm is 50 Hz
    assert first * 50 == pytest.approx(round(first * 50), abs=1e-9)


def test_the_limit_is_held_against_the_largest_angle(summary: dict[str, Any]) -> None:
    limit, angles = summary["limit"], summary["angles_deg"]
    assert limit["deg"] == 0.5
    assert limit["quantity"] == "vibration_peak"
    assert limit["value_deg"] == pytest.approx(max(each["vibration_peak"] for each in angles.values()), rel=1e-12)
    assert limit["value_deg"] == pytest.approx(angles[limit["element"]]["vibration_peak"], rel=1e-12)
    assert limit["ok"] is (limit["value_deg"] <= 0.5)
    assert [(row["rule"], row["element"]) for row in summary["limits"]] == [("syt_5211_angle", name) for name in angles]


def test_without_a_chosen_rule_no_limit_is_named(invoke: Invoke, two_disks: Path, tmp_path: Path) -> None:
    options = ("--window", "0.5 s", "0.6 s", "--crosscheck", "none")
    result = invoke("run", two_disks, "--out", tmp_path / "out", *options)
    assert result.exit_code == 0, result.output
    report = (tmp_path / "out" / "report.md").read_text(encoding="utf-8")
    found = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert (found["limit"], found["limits"]) == (None, [])
    assert re.search(r"Largest vibration angle: [0-9.]+° at `(engine|load)`\*\* \(0-peak, physical\)\n", report)
    assert not re.search(r"\blimit|0\.5°|5211", report)
    assert not re.search(r"within|above 0", result.stdout)


def test_the_modes_of_the_report_have_their_own_damping(invoke: Invoke, tmp_path: Path) -> None:
    """Two disks on shafts to a heavy one: 10.0 Hz hardly damped, 11.0 Hz by 0.6, so that its damped frequency is the lower."""
    disks = "".join(f'[elements.{n}]\nkind = "inertia"\ninertia = "{j} kg*m^2"\n' for n, j in (("a", 1), ("b", 1000), ("c", 1)))
    shafts = "".join(
        f'[elements.s{n}]\nkind = "shaft"\na = "{n}"\nb = "b"\nstiffness = "{k} N*m/rad"\ndamping = "value"\n'
        f'damping_coefficient = "{c} N*m*s/rad"\n'
        for n, k, c in (("a", 3948, 0.01), ("c", 4777, 82.9))
    )
    (tmp_path / "pair.toml").write_text(f'format = 1\nname = "pair"\n{disks}{shafts}', encoding="utf-8")
    options = ("--window", "0 s", "0.1 s", "--crosscheck", "none")
    assert invoke("run", tmp_path / "pair.toml", "--out", tmp_path / "out", *options).exit_code == 0
    report = (tmp_path / "out" / "report.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.strip("| \n").split("|")] for line in report.splitlines() if line.startswith("| ")]
    modes = {row[0]: row[1:4] for row in rows if row[0] in ("rigid", "1", "2")}
    for mode, k, c in (("1", 3948, 0.01), ("2", 4777, 82.9)):
        omega, decay = math.sqrt(k), c / 2
        frequency, ratio, rate = map(float, modes[mode])
        assert (frequency, ratio, rate) == pytest.approx((omega / (2 * math.pi), decay / omega, decay), rel=1e-2)
    assert modes["rigid"] == ["0", "—", "—"]


def test_the_solvers_agree(summary: dict[str, Any]) -> None:
    assert summary["crosscheck"]["solvers"] == ["rk4", "cvodes"]
    assert 0 < summary["crosscheck"]["worst_relative_difference"] < 1e-5
    assert summary["crosscheck"]["horizon_s"] == pytest.approx(min(1.0, summary["window_s"][1]))
    assert 0 < summary["wall_s"] < 60


def test_the_model_as_run_can_be_run_again(folder: Path, small: Path) -> None:
    again = load(folder / "model.toml")
    assert again == load(small).change("coupling", stiffness=25e3)


def test_the_report_hangs_together(folder: Path, summary: dict[str, Any]) -> None:
    report = (folder / "report.md").read_text(encoding="utf-8")
    links = re.findall(r"\]\(([^)]+)\)", report)
    assert len([link for link in links if link.startswith("figures/")]) == len(list((folder / "figures").iterdir())) > 0
    assert all((folder / link).exists() for link in links)
    assert not re.search(r"\b(nan|inf|None|undefined)\b", report)
    for words in ("physical", "referred", "0-peak", "half p-p", "The standard's own text was not seen", "as the paper quotes it"):
        assert words in report
    assert r"estimate \| of ours" in report  # the note of the motor, in a table
    assert "--set 'coupling.stiffness=25 kN*m/rad'" in report
    assert f"{summary['natural_frequencies_hz'][1]:.6g}" in report
    for line in report.splitlines():
        assert not line.startswith("|") or line.rstrip().endswith("|"), line


def test_the_equations_are_written_out(folder: Path) -> None:
    assert "ddot" in (folder / "equations.md").read_text(encoding="utf-8")
    assert r"\begin{" in (folder / "equations.tex").read_text(encoding="utf-8")


FREE = """
format = 1
name = "free"
[elements.left]
kind = "inertia"
inertia = "0.3 kg*m^2"
[elements.right]
kind = "inertia"
inertia = "0.6 kg*m^2"
[elements.bar]
kind = "shaft"
a = "left"
b = "right"
stiffness = "20 kN*m/rad"
[elements.kick]
kind = "stepped_torque"
flange = "left"
after = "10 N*m"
[elements.answer]
kind = "stepped_torque"
flange = "right"
after = "-10 N*m"
"""


def test_a_driveline_without_gears_speed_or_bases(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "free.toml").write_text(FREE, encoding="utf-8")
    result = invoke("run", tmp_path / "free.toml", "--out", tmp_path / "out", "--crosscheck", "none")
    assert result.exit_code == 0, result.stderr
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["mesh"] == {}
    assert summary["crosscheck"] is None
    assert summary["damping"] == {"shaft": "per_shaft", "zeta": 0.0, "mesh_form": None, "xi": None, "mesh_reading": None}
    frequency = math.sqrt(20e3 * (1 / 0.3 + 1 / 0.6)) / (2 * math.pi)
    assert summary["natural_frequencies_hz"] == pytest.approx([0.0, frequency], abs=1e-9)
    # Without a base frequency: the first twenty periods. A step twists an undamped shaft to twice T/k and back; the torque
    # in the shaft is that share of the step which the far disk needs, and so is its answer.
    assert summary["window_s"] == pytest.approx([0.0, 20 / frequency])
    assert summary["twist_half_pp_deg"]["bar"] == pytest.approx(math.degrees(10 / 20e3), rel=1e-4)
    report = (tmp_path / "out" / "report.md").read_text(encoding="utf-8")
    assert "no base frequency" in report
    assert "Gear meshes" not in report


def test_one_disk_alone(invoke: Invoke, tmp_path: Path) -> None:
    lone = 'format = 1\nname = "lone"\n[elements.disk]\nkind = "inertia"\ninertia = "1 kg*m^2"\n'
    (tmp_path / "lone.toml").write_text(lone, encoding="utf-8")
    result = invoke("run", tmp_path / "lone.toml", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["natural_frequencies_hz"] == [0.0]
    assert summary["angles_deg"]["disk"]["vibration_peak"] == 0.0


def test_a_given_window_and_a_zero_start(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    options = ("--window", "0 s", "20 ms", "--start", "zero", "--crosscheck", "none")
    assert invoke("run", small, "--out", tmp_path / "out", *options).exit_code == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["window_s"] == [0.0, 0.02]
    assert summary["mesh"]["mesh"]["force_min_n"] <= 0  # nothing is twisted at first, so the flanks do not touch


BELT = """format = 1
name = "belt"
[elements.disk]
kind = "inertia"
inertia = "2 kg*m^2"
[elements.wire]
kind = "ground_spring"
flange = "disk"
stiffness = "8 N*m/rad"
[elements.brake]
kind = "brake"
flange = "disk"
sliding_torque = "1 N*m"
holding_torque = "1.5 N*m"
other_speed = "0.1 rad/s"
"""


def test_events_are_counted_with_the_time_in_each_mode(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "belt.toml").write_text(BELT, encoding="utf-8")
    options = ("--start", "zero", "--window", "0 s", "20 s", "--crosscheck", "none", "--solver", "dop853")
    result = invoke("run", tmp_path / "belt.toml", "--out", tmp_path / "out", *options)
    assert result.exit_code == 0, result.stderr
    lines = dict(line.rsplit(maxsplit=1) for line in result.stdout.splitlines() if not line.startswith("report"))
    assert lines["events"] == "12"
    assert lines["  brake.break_backward"] == "6"
    assert lines["  time in brake.contact.stick"] == "40.10%"
    report = (tmp_path / "out" / "report.md").read_text(encoding="utf-8")
    assert "| events | 12 events: 6 brake.break_backward, 6 brake.stick_backward; brake.contact.stick 40.10%," in report
    refused = invoke("run", tmp_path / "belt.toml", "--out", tmp_path / "other", "--events", "off", *options)
    assert refused.exit_code == 2
    assert "has events switched off, which the model needs" in refused.stderr
    assert not (tmp_path / "other").exists()
