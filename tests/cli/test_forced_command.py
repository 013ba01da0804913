"""``modelgen forced``: the response of two disks by their formula, misfire, stress, gear loads, and refusals by their words."""

from __future__ import annotations

import cmath
import json
import math
from pathlib import Path

import pytest

from .conftest import Invoke
from .test_modal_command import rows
from .test_refusals import refused

J_ENGINE, J_LOAD, K, C = 3.0, 1.0, 3e5, 20.0


def torque(amplitude: float, omega: float, damping: float = C) -> complex:
    """Shaft torque under a torque on the engine: (k + i w c) u, u the twist of two disks."""
    joined = J_ENGINE * J_LOAD / (J_ENGINE + J_LOAD)
    stiffness = K + 1j * omega * damping
    return stiffness * amplitude / J_ENGINE / (stiffness / joined - omega**2)


@pytest.fixture(scope="module")
def out(invoke: Invoke, two_disks: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("forced") / "out"
    options = (
        "--speeds",
        "900 rpm",
        "1200 rpm",
        "--count",
        "3",
        "--limit",
        "shaft.torque=1 kN*m",
        "--show",
        "shaft.shear_stress",
    )
    result = invoke("forced", two_disks, "--out", folder, *options)
    assert result.exit_code == 0, result.output
    assert "3 speeds from 900 to 1200 rpm, 2 orders" in result.stdout
    return folder


def test_the_files(out: Path) -> None:
    tables = {"forced.csv", "orders.csv", "power.csv", "forced.json"}
    assert {path.name for path in out.iterdir()} == tables | {"forced.png", "power.png"}


def test_every_order_is_that_of_the_formula(out: Path) -> None:
    found = [row for row in rows(out / "orders.csv") if row["channel"] == "shaft.torque"]
    assert len(found) == 6
    for row in found:
        omega = float(row["order [1/turn]"]) * float(row["speed [rpm]"]) * math.pi / 30
        wanted = torque({"3": 40.0, "6": 10.0}[row["exact order"]], omega)
        assert (row["bases"], row["unit"]) == ("firing", "N*m")
        assert float(row["amplitude [unit]"]) == pytest.approx(abs(wanted), rel=1e-7)
        assert float(row["phase [deg]"]) == pytest.approx(math.degrees(cmath.phase(wanted)), abs=1e-5)


def test_the_orders_are_summed_with_their_phases(out: Path) -> None:
    last = rows(out / "forced.csv")[-1]
    omega = 3 * 40 * math.pi
    one, two = torque(40, omega), torque(10, 2 * omega)
    turn = [2 * math.pi * k / 5000 for k in range(5000)]
    sums = [(one * cmath.exp(1j * x) + two * cmath.exp(2j * x)).real for x in turn]
    assert float(last["speed [rpm]"]) == pytest.approx(1200)
    # The command samples the cycle at 64 points of the highest order.
    assert float(last["shaft.torque half p-p [N*m]"]) == pytest.approx((max(sums) - min(sums)) / 2, rel=3e-3)
    assert float(last["shaft.torque 0-peak [N*m]"]) == pytest.approx(max(map(abs, sums)), rel=3e-3)
    assert float(last["shaft.torque mean [N*m]"]) == pytest.approx(0, abs=1e-9)


def test_the_diameter_in_the_model_gives_the_stress(out: Path) -> None:
    factor = 16 / (math.pi * 0.08**3)
    for row in rows(out / "forced.csv"):
        assert float(row["shaft.shear_stress 0-peak [Pa]"]) == pytest.approx(
            factor * float(row["shaft.torque 0-peak [N*m]"]), rel=1e-6
        )


def test_the_power_lost_in_the_shaft(out: Path) -> None:
    for row in rows(out / "power.csv"):
        omega = 3 * float(row["speed [rpm]"]) * math.pi / 30
        twists = ((w, torque(t, w) / (K + 1j * w * C)) for t, w in ((40.0, omega), (10.0, 2 * omega)))
        assert float(row["shaft [W]"]) == pytest.approx(sum(C * abs(w * u) ** 2 / 2 for w, u in twists), rel=1e-6)


def test_the_summary(out: Path) -> None:
    data = json.loads((out / "forced.json").read_text(encoding="utf-8"))
    assert data["speeds_rpm"] == pytest.approx([900, 1050, 1200])
    assert (data["orders_per_turn"], data["cycle_turns"], data["gear_hammer"]) == ([3, 6], "1/3", {})
    largest = max(rows(out / "forced.csv"), key=lambda row: float(row["shaft.torque half p-p [N*m]"]))
    assert data["largest"]["shaft.torque [N*m]"]["half_pp"] == pytest.approx(float(largest["shaft.torque half p-p [N*m]"]))
    assert data["largest"]["shaft.torque [N*m]"]["at_rpm"] == pytest.approx(1050)


def test_speeds_are_added_at_resonances_unless_told_otherwise(invoke: Invoke, two_disks: Path, tmp_path: Path) -> None:
    """Order 6 meets 100.658 Hz at 1006.58 rpm."""
    speeds = ("--speeds", "900 rpm", "1200 rpm", "--count", "13")
    result = invoke("forced", two_disks, "--out", tmp_path / "fine", *speeds)
    assert "13 speeds from 900 to 1200 rpm" in result.stdout
    assert " speeds added at resonances" in result.stdout
    data = json.loads((tmp_path / "fine" / "forced.json").read_text(encoding="utf-8"))
    assert min(abs(each - 1006.58) for each in data["added_speeds_rpm"]) < 0.01
    assert {900, 1000, 1100, 1200} <= {round(each, 9) for each in data["speeds_rpm"]}
    assert invoke("forced", two_disks, "--out", tmp_path / "plain", *speeds, "--no-refine").exit_code == 0
    few = ("--speeds", "900 rpm", "1200 rpm", "--count", "4", "--refine")
    assert "speeds added at resonances" in invoke("forced", two_disks, "--out", tmp_path / "few", *few).stdout
    data = json.loads((tmp_path / "plain" / "forced.json").read_text(encoding="utf-8"))
    assert (data["added_speeds_rpm"], len(data["speeds_rpm"])) == ([], 13)


def test_half_a_misfire_halves_the_response(invoke: Invoke, two_disks: Path, tmp_path: Path) -> None:
    half = []
    for name, options in (("whole", ()), ("half", ("--misfire", "shaking=0.5"))):
        assert invoke("forced", two_disks, "--out", tmp_path / name, *options).exit_code == 0
        half.append(float(rows(tmp_path / name / "forced.csv")[0]["shaft.torque half p-p [N*m]"]))
    assert half[1] == pytest.approx(half[0] / 2)
    data = json.loads((tmp_path / "half" / "forced.json").read_text(encoding="utf-8"))
    assert data["changed_parameters"] == {"shaking.scale": 0.5}


def test_gears_are_told(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    result = invoke("forced", small, "--out", tmp_path / "out", "--set", "zeta=0.02", "--highest-order", "4")
    assert result.exit_code == 0, result.output
    (row,) = rows(tmp_path / "out" / "gears.csv")
    assert (row["gear"], row["unit"]) == ("mesh", "N")
    assert float(row["mean [unit]"]) == pytest.approx(100 / (0.03 * math.cos(math.radians(20))))
    data = json.loads((tmp_path / "out" / "forced.json").read_text(encoding="utf-8"))
    assert data["gear_hammer"]["mesh"]["hammers"] is (row["hammer"] == "yes")
    assert row["hammer"] == ("yes" if float(row["alternating per mean [1]"]) >= 1 else "no")
    assert "stiffness varies with time in mesh" in result.stdout
    assert (tmp_path / "out" / "gears.png").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--misfire", "shakin=0"), "--misfire shakin: driveline 'two-disks' has no source 'shakin'"),
        (("--misfire", "shakin=0"), "nearest is 'shaking'"),
        (("--misfire", "shaking"), "is no assignment; write ELEMENT=FACTOR"),
        (("--misfire", "shaking=none"), "'none' is not a number"),
        (("--misfire", "shaking=inf"), "give a finite factor"),
        (("--diameter", "shaff=80 mm"), "nearest is 'shaft'"),
        (("--diameter", "shaft=80"), "has no unit"),
        (("--diameter", "shaft=80 mm/90 mm"), "a smaller inner one"),
        (("--limit", "shaft.torque=5 mm"), "'mm' has the dimension"),
        (("--limit", "shaft.torque"), "write CHANNEL=VALUE"),
        (("--show", "shaft.torqe"), "nearest is 'shaft.torque'"),
        (("--misfire", "shaking=0"), "nothing excites it"),
    ],
)
def test_a_wrong_option(invoke: Invoke, two_disks: Path, tmp_path: Path, options: tuple[str, ...], words: str) -> None:
    assert words in refused(invoke("forced", two_disks, "--out", tmp_path / "out", *options), 2)
    assert list(tmp_path.iterdir()) == []
