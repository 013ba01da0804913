"""``modelgen referee``: files, what it prints, and its refusals."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("mujoco", reason="needs the extra referee")


def test_both_sides_of_every_channel(invoke: Any, small: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    result = invoke("referee", small, "--end", "0.02 s", "--samples", 41, "--step", "2 us", "--out", out)
    assert result.exit_code == 0, result.stderr
    assert "largest difference in time" in result.stdout
    told = json.loads((out / "referee.json").read_text(encoding="utf-8"))
    assert told["worst_relative_difference"] < 1e-4
    assert told["differences_in_modelling"]
    rows = list(csv.reader((out / "referee.csv").read_text(encoding="utf-8").splitlines()))
    assert len(rows) == 42
    assert rows[0][0] == "time [s]"
    assert "mesh.force, referee [N]" in rows[0]
    assert (out / "referee.png").stat().st_size > 10_000


def test_refusals_leave_no_folder(invoke: Any, small: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    for words, told in ((("--step", "3 s"), "give a step smaller"), (("--channel", "mesh.farce"), "mesh.force")):
        result = invoke("referee", small, "--end", "0.01 s", "--out", out, *words)
        assert result.exit_code == 2
        assert told in result.stderr
        assert not out.exists()


def test_two_samples_are_drawn(invoke: Any, small: Path, tmp_path: Path) -> None:
    result = invoke("referee", small, "--end", "0.01 s", "--samples", 2, "--step", "10 us", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "out" / "referee.png").stat().st_size > 10_000


def test_what_does_not_vary_is_not_compared(invoke: Any, tmp_path: Path) -> None:
    path = tmp_path / "still.toml"
    disk = '[elements.disk]\nkind = "inertia"\ninertia = "1 kg*m^2"\n'
    path.write_text(f'format = 1\nname = "still"\n[operation]\nspeed = "100 rpm"\nreference = "disk"\n{disk}', encoding="utf-8")
    result = invoke("referee", path, "--end", "0.01 s", "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "has no channel that varies in this run: there is nothing to compare" in result.stderr
    assert not (tmp_path / "out").exists()
