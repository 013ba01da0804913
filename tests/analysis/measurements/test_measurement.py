"""Measurements from tables, and the tables that are none."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from modelgen.analysis.measurements.measurement import Measurement, read_measurement
from modelgen.errors import CaseError, ModelFileError, ModelgenError, UnitError


def table(tmp_path: Path, header: str, rows: list[str] | None = None) -> Path:
    path = tmp_path / "measured.csv"
    path.write_text("\n".join([header, *(rows or [f"{i};{i * i}" for i in range(10)])]), encoding="utf-8")
    return path


def test_a_recording_over_time(tmp_path: Path) -> None:
    rows = [f"{0.5 * i:.1f};{0.1 * i:.3f};{-2 * i}".replace(".", ",") for i in range(12)]
    found = read_measurement(table(tmp_path, "# recorder\nt [ms]; twist [°]; torque [kNm]", rows))
    assert (found.kind, found.name) == ("time", "t")
    assert found.abscissa == pytest.approx(0.5e-3 * np.arange(12))
    assert found.channel("twist", "rad", "shaft.twist") == pytest.approx(math.radians(0.1) * np.arange(12))
    assert found.channel("torque", "N*m", "shaft.torque") == pytest.approx(-2000.0 * np.arange(12))
    assert found.written == {"twist": "°", "torque": "kNm"}


def test_a_recording_over_crank_angle(tmp_path: Path) -> None:
    found = read_measurement(table(tmp_path, "crank angle [deg];force [kN]"))
    assert found.kind == "angle"
    assert found.abscissa == pytest.approx(np.radians(np.arange(10)))


@pytest.mark.parametrize(
    ("header", "words"),
    [
        ("t;x [deg]", r"line 1, column 't': the header names no unit; write it as t \[unit\]"),
        ("t [s];x", r"line 1, column 'x': the header names no unit"),
        ("t [kg];x [deg]", r"column 't': is in kg; the first column is a time \[s\] or a crank angle \[deg\]"),
        ("t [s];x [dge]", "column 'x': 'dge' is not a known unit"),
    ],
)
def test_units_must_be_there_and_fit(tmp_path: Path, header: str, words: str) -> None:
    with pytest.raises(UnitError, match=words):
        read_measurement(table(tmp_path, header))


@pytest.mark.parametrize(
    ("header", "rows", "words"),
    [
        ("t [s]", [str(i) for i in range(9)], "has the column 't' only; give channels beside it"),
        ("t [s];x [1]", ["0;1", "1;2"], "has 2 samples; give 8 or more"),
        ("t [s];x [1]", ["0;1", "1;2", "1;3"], "line 4, column 't': 1 does not lie beyond the value before; sort"),
        ("phi [deg];x [1]", ["0;1", "719;2", "1;3"], "column 'phi': 1 does not lie beyond .*; let the angle grow through turns"),
    ],
)
def test_samples_must_make_a_signal(tmp_path: Path, header: str, rows: list[str], words: str) -> None:
    with pytest.raises(CaseError, match=words):
        read_measurement(table(tmp_path, header, rows))


@pytest.mark.parametrize(
    ("row", "words"), [("2;", "line 4, column 'x': is empty"), ("2;nan", "line 4, column 'x': 'nan' is not a number")]
)
def test_every_sample_is_a_number(tmp_path: Path, row: str, words: str) -> None:
    with pytest.raises(ModelFileError, match=words):
        read_measurement(table(tmp_path, "t [s];x [deg]", ["0;1", "1;1", row]))


def test_a_measurement_made_in_python_is_checked_too() -> None:
    t = np.arange(10.0)
    with pytest.raises(CaseError, match="channel 'x': is not one finite number for each sample"):
        Measurement("bench", "time", "t", t, {"x": t[:5]}, {"x": "1"}, {"x": "1"})
    with pytest.raises(CaseError, match="'t' does not grow from sample to sample"):
        Measurement("bench", "time", "t", t[::-1], {"x": t}, {"x": "1"}, {"x": "1"})
    with pytest.raises(CaseError, match="the kind of its abscissa is 'distance'"):
        Measurement("bench", "distance", "s", t, {"x": t}, {"x": "1"}, {"x": "1"})


def test_a_channel_of_another_dimension_or_name() -> None:
    t = np.arange(10.0)
    bench = Measurement("bench", "time", "t", t, {"torque": t}, {"torque": "N*m"}, {"torque": "kNm"})
    with pytest.raises(
        UnitError, match=r"column 'torque': is in kNm, 'shaft.twist' is in rad; compare channels of one dimension"
    ):
        bench.channel("torque", "rad", "shaft.twist")
    with pytest.raises(ModelgenError, match="column 'torke': there is none; nearest is 'torque'"):
        bench.channel("torke", "N*m", "shaft.torque")
