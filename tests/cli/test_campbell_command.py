"""``modelgen campbell``: crossings of two disks where they must be, margins, and refusals by their words."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from .conftest import SMALL, Invoke
from .test_modal_command import FREQUENCY, rows
from .test_refusals import refused

CRITICAL = 60 * FREQUENCY / 6  # rpm, of the second harmonic of three firings a turn


@pytest.fixture(scope="module")
def out(invoke: Invoke, two_disks: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("campbell") / "out"
    result = invoke("campbell", two_disks, "--out", folder, "--speeds", "600 rpm", "2400 rpm", "--count", "5")
    assert result.exit_code == 0, result.output
    assert "1006.58 rpm    -16.1%  mode 1 (100.7 Hz), order 6 (firing x 2)" in result.stdout
    return folder


def test_the_files(out: Path) -> None:
    assert {path.name for path in out.iterdir()} == {"campbell.csv", "critical_speeds.csv", "campbell.json", "campbell.png"}


def test_natural_frequencies_by_speed(out: Path) -> None:
    found = rows(out / "campbell.csv")
    assert [float(row["speed [rpm]"]) for row in found] == pytest.approx([600, 1050, 1500, 1950, 2400])
    assert {row["rigid [Hz]"] for row in found} == {"0"}
    assert [float(row["mode 1 [Hz]"]) for row in found] == pytest.approx([FREQUENCY] * 5)


def test_critical_speeds_with_their_margins(out: Path) -> None:
    near, far = rows(out / "critical_speeds.csv")
    assert float(near["critical speed [rpm]"]) == pytest.approx(CRITICAL)
    assert float(near["margin [percent]"]) == pytest.approx(100 * (CRITICAL / 1200 - 1))
    assert (near["mode"], near["exact order"], near["sources"]) == ("1", "6", "firing x 2")
    assert float(near["harmonic torque [N*m]"]) == pytest.approx(10)
    assert float(far["critical speed [rpm]"]) == pytest.approx(2 * CRITICAL)


def test_the_summary(out: Path) -> None:
    data = json.loads((out / "campbell.json").read_text(encoding="utf-8"))
    assert data["operating_rpm"] == pytest.approx([1200, 1200])
    assert [order["order_per_turn"] for order in data["orders"]] == [3, 6]
    assert [each["mode"] for each in data["critical_speeds"]] == [1, 1]
    assert [each["speed_rpm"] for each in data["critical_speeds"]] == pytest.approx([CRITICAL, 2 * CRITICAL])


def test_margins_from_a_range_and_fewer_orders(invoke: Invoke, two_disks: Path, tmp_path: Path) -> None:
    options = (
        "--operating",
        "1100 rpm",
        "1500 rpm",
        "--speeds",
        "100 rad/s",
        "240 rad/s",
        "--count",
        "3",
        "--highest-order",
        "4",
    )
    assert invoke("campbell", two_disks, "--out", tmp_path / "out", *options).exit_code == 0
    (only,) = rows(tmp_path / "out" / "critical_speeds.csv")
    assert float(only["margin [percent]"]) == pytest.approx(100 * (2 * CRITICAL / 1500 - 1))
    data = json.loads((tmp_path / "out" / "campbell.json").read_text(encoding="utf-8"))
    assert data["operating_rpm"] == pytest.approx([1100, 1500])
    assert data["speeds_rpm"] == pytest.approx([v * 30 / math.pi for v in (100, 170, 240)])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--speeds", "600", "900 rpm"), "has no unit"),
        (("--speeds", "900 rpm", "600 rpm"), "--speeds: goes from 900 rpm to 600 rpm; give two positive speeds"),
        (("--operating", "0 rpm", "600 rpm"), "--operating: goes from 0 rpm"),
        (("--set", "shaft.stiffness=3"), "has no unit"),
    ],
)
def test_a_wrong_option(invoke: Invoke, two_disks: Path, tmp_path: Path, options: tuple[str, ...], words: str) -> None:
    assert words in refused(invoke("campbell", two_disks, "--out", tmp_path / "out", *options), 2)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", ["campbell", "forced"])
def test_a_driveline_without_a_speed(invoke: Invoke, tmp_path: Path, command: str) -> None:
    text = (
        SMALL.replace('speed = "1500 rpm"\n', "").replace('base = "motor_order"\n', "").replace('cosine = "drive_cosine"\n', "")
    )
    text = text.replace('[bases.motor_order]\nshaft = "motor"\norder = 2\n', "")
    (tmp_path / "still.toml").write_text(text, encoding="utf-8")
    line = refused(invoke(command, tmp_path / "still.toml", "--out", tmp_path / "out"), 2)
    assert 'has no operating speed; give one, such as --speed "1500 rpm"' in line
