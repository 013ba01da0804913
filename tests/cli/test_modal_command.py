"""``modelgen modal``: frequencies, damping, shapes, energy shares and sensitivities in files, and refusals by their words."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import pytest

from .conftest import Invoke
from .test_refusals import refused

FREQUENCY = math.sqrt(3e5 * (1 / 3 + 1)) / (2 * math.pi)  # two disks on a spring


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def out(invoke: Invoke, two_disks: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("modal") / "out"
    result = invoke("modal", two_disks, "--out", folder)
    assert result.exit_code == 0, result.output
    assert ["1", "100.658", f"{60 * FREQUENCY:.2f}", "100.636", "0.02108", "1", "load", "75%", "shaft", "100%"] in [
        line.split() for line in result.stdout.splitlines()
    ]
    return folder


def test_the_files(out: Path) -> None:
    tables = {"modal.csv", "energy.csv", "sensitivities.csv", "modal.json"}
    figures = {"modes.png", "energy.png", "sensitivities.png"}
    assert {path.name for path in out.iterdir()} == tables | figures
    assert all((out / name).read_bytes().startswith(b"\x89PNG") for name in figures)


def test_frequencies_damping_and_shapes(out: Path) -> None:
    rigid, mode = rows(out / "modal.csv")
    assert rigid["undamped [Hz]"] == "0"
    assert rigid["damped [Hz]"] == rigid["damping ratio [1]"] == ""
    ratio = 20 / (2 * math.sqrt(3e5 * 0.75))
    assert float(mode["undamped [Hz]"]) == pytest.approx(FREQUENCY, rel=1e-8)
    assert float(mode["damped [Hz]"]) == pytest.approx(FREQUENCY * math.sqrt(1 - ratio**2), rel=1e-8)
    assert float(mode["damping ratio [1]"]) == pytest.approx(ratio, rel=1e-8)
    assert float(mode["engine physical [1]"]) == pytest.approx(-1 / 3)
    assert float(mode["modal inertia [kg*m^2]"]) == pytest.approx(3 / 9 + 1)


def test_referred_shapes_are_divided_by_the_speed_ratio(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    assert (
        invoke("modal", small, "--out", tmp_path / "out", "--count", "2", "--set", "coupling.stiffness=40 kN*m/rad").exit_code
        == 0
    )
    found = rows(tmp_path / "out" / "modal.csv")
    assert len(found) == 2
    for mode in found:
        assert float(mode["fan referred [1]"]) == pytest.approx(2 * float(mode["fan physical [1]"]))
        assert float(mode["motor referred [1]"]) == pytest.approx(float(mode["motor physical [1]"]))


def test_energy_shares_sum_to_one(out: Path) -> None:
    for mode, potential in (("rigid", 0), ("1", 1)):
        own = [row for row in rows(out / "energy.csv") if row["mode"] == mode]
        assert sum(float(row["kinetic share [1]"]) for row in own) == pytest.approx(1)
        assert sum(float(row["potential share [1]"]) for row in own) == pytest.approx(potential)


def test_sensitivities_are_those_of_two_disks(out: Path) -> None:
    found = {row["parameter"]: row for row in rows(out / "sensitivities.csv")}
    assert set(found) == {"engine.inertia", "load.inertia", "shaft.stiffness"}
    assert float(found["shaft.stiffness"]["slope [Hz/unit]"]) == pytest.approx(FREQUENCY / 2 / 3e5)
    assert [float(found[name]["relative slope [1]"]) for name in ("engine.inertia", "load.inertia")] == pytest.approx(
        [-1 / 8, -3 / 8]
    )
    assert found["load.inertia"]["unit"] == "kg*m^2"


def test_the_summary(out: Path) -> None:
    data = json.loads((out / "modal.json").read_text(encoding="utf-8"))
    assert (data["model"], data["rigid_modes"], data["complete"]) == ("two-disks", 1, True)
    mode = data["modes"][1]
    assert mode["undamped_hz"] == pytest.approx(FREQUENCY)
    assert mode["kinetic_energy_shares"] == pytest.approx({"engine": 0.25, "load": 0.75, "shaft": 0})
    assert mode["largest_relative_sensitivities"]["shaft.stiffness"] == pytest.approx(0.5)
    assert [each["mode"] for each in data["modes"]] == [None, 1]
    assert (mode["undamped_vibrations_per_min"], mode["nodes"]) == (pytest.approx(60 * FREQUENCY), 1)
    assert data["damped_modes"][0]["damped_hz"] == mode["damped_hz"]


def test_a_lone_disk_has_no_figures(invoke: Invoke, tmp_path: Path) -> None:
    lone = 'format = 1\nname = "lone"\n[elements.disk]\nkind = "inertia"\ninertia = "1 kg*m^2"\n'
    (tmp_path / "lone.toml").write_text(lone, encoding="utf-8")
    assert invoke("modal", tmp_path / "lone.toml", "--out", tmp_path / "out").exit_code == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"modal.csv", "energy.csv", "sensitivities.csv", "modal.json"}


def test_an_overdamped_mode_is_told_by_its_two_rates(invoke: Invoke, two_disks: Path, tmp_path: Path) -> None:
    heavy = ("--set", "shaft.damping_coefficient=1000 N*m*s/rad")
    result = invoke("modal", two_disks, "--out", tmp_path / "out", *heavy)
    assert result.exit_code == 0
    decay, omega = 1000 / (2 * 0.75), 2 * math.pi * FREQUENCY
    rates = [decay - math.sqrt(decay**2 - omega**2), decay + math.sqrt(decay**2 - omega**2)]
    assert f"mode 1 does not oscillate: it decays with the two rates {rates[0]:.6g} and {rates[1]:.6g} 1/s" in result.stdout
    mode = rows(tmp_path / "out" / "modal.csv")[1]
    assert mode["damped [Hz]"] == ""
    assert [float(mode["slow rate [1/s]"]), float(mode["fast rate [1/s]"])] == pytest.approx(rates)
    told = json.loads((tmp_path / "out" / "modal.json").read_text(encoding="utf-8"))["modes"][1]
    assert [told["slow_rate_per_s"], told["fast_rate_per_s"]] == pytest.approx(rates)
    assert told["damping_ratio"] is None


def test_a_wrong_request(invoke: Invoke, two_disks: Path, tmp_path: Path) -> None:
    line = refused(invoke("modal", two_disks, "--out", tmp_path / "out", "--set", "shaft.stifness=1 N*m/rad"), 2)
    assert "nearest is 'stiffness'" in line
    assert invoke("modal", two_disks, "--out", tmp_path / "out", "--count", "0").exit_code == 2
    assert list(tmp_path.iterdir()) == []


def test_a_folder_is_replaced_only_if_wanted(invoke: Invoke, two_disks: Path, out: Path) -> None:
    assert "exists and is not empty" in refused(invoke("modal", two_disks, "--out", out), 2)
    assert invoke("modal", two_disks, "--out", out, "--replace").exit_code == 0
