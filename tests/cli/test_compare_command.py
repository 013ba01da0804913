"""``modelgen compare``: a recording that is the run itself, larger by a tenth; and refusals by their words."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from .conftest import Invoke
from .test_forced_command import torque
from .test_modal_command import rows
from .test_refusals import refused

WINDOW = ("--window", "0.9 s", "1 s")
DAMPED = ("--set", "shaft.damping_coefficient=80 N*m*s/rad")


@pytest.fixture(scope="module")
def recording(two_disks: Path) -> Path:
    """What a strain gauge would show of the settled shaft: its torque by the formula, larger by a tenth."""
    path = two_disks.with_name("recording.csv")
    times = np.linspace(0.9, 1.0, 400)
    omega = 3 * 40 * np.pi
    values = sum((torque(t, w, 80.0) * np.exp(1j * w * times)).real for t, w in ((40.0, omega), (10.0, 2 * omega)))
    lines = [f"{1000 * t!r},{1.1 * x / 1000!r}" for t, x in zip(times.tolist(), values.tolist(), strict=True)]
    path.write_text("\n".join(["t [ms],MD1 [kN*m]", *lines]), encoding="utf-8")
    return path


def test_a_recording_is_laid_over_a_run(invoke: Invoke, two_disks: Path, recording: Path, tmp_path: Path) -> None:
    options = (*WINDOW, *DAMPED, "--channel", "shaft.torque=MD1")
    result = invoke("compare", two_disks, recording, "--out", tmp_path / "out", *options)
    assert result.exit_code == 0, result.output
    assert "correlation 1.0000" in result.stdout
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"comparison.csv", "comparison.json", "comparison.png"}
    found = {row["what"]: row for row in rows(tmp_path / "out" / "comparison.csv")}
    for what in ("peak", "half_pp", "order 3 (firing x 1)", "order 6 (firing x 2)"):
        assert float(found[what]["simulated [unit]"]) * 1.1 == pytest.approx(float(found[what]["measured [unit]"]), rel=5e-3)
    assert float(found["order 3 (firing x 1)"]["frequency [Hz]"]) == pytest.approx(60)
    assert float(found["order 3 (firing x 1)"]["phase difference [deg]"]) == pytest.approx(0, abs=0.1)
    data = json.loads((tmp_path / "out" / "comparison.json").read_text(encoding="utf-8"))
    first = data["channels"]["shaft.torque [N*m]"]["orders"][0]
    assert (first["order"], first["order_per_turn"], first["name"]) == (1, 3.0, "order 3 (firing x 1)")
    assert "  order 3 (firing x 1) " in result.stdout
    assert data["channels"]["shaft.torque [N*m]"]["correlation_coefficient"] == pytest.approx(1, abs=1e-5)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ((), "column 'MD1': is no channel of the run"),
        ((), "pair them with --channel CHANNEL=MD1"),
        (("--channel", "shaft.torque"), "write CHANNEL=COLUMN"),
        (("--channel", "shaft.twist=MD1"), "is in kN*m"),
        (("--channel", "shaft.torque=MD1", "--start", "1"), "has no unit"),
        (("--channel", "shaft.torque=MD1", "--base", "firring"), "nearest is 'firing'"),
    ],
)
def test_a_wrong_option(
    invoke: Invoke, two_disks: Path, recording: Path, tmp_path: Path, options: tuple[str, ...], words: str
) -> None:
    short = ("--window", "0.9 s", "0.95 s")
    assert words in refused(invoke("compare", two_disks, recording, "--out", tmp_path / "out", *short, *options), 2)
    assert list(tmp_path.iterdir()) == []
