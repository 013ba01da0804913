"""``modelgen sweep``: ranges with units, the folder, going on, and refusals by their words."""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from modelgen import assemble, lower
from modelgen.analysis.sweeps.store import SHARDS
from modelgen.cli.sweep import _usual, _values
from modelgen.drivelines import load

from .conftest import Invoke
from .test_refusals import refused

ROOT = Path(__file__).resolve().parents[2]
QUICK = ("--window", "0 s", "0.02 s", "--samples", "11", "--backend", "vm", "--workers", "0")


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "table.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_sweep_in_a_folder(invoke: Invoke, two_disks: Path, tmp_path: Path) -> None:
    command = ("sweep", two_disks, "--over", "shaft.stiffness=200:300:3 kN*m/rad", "--out", tmp_path / "s", *QUICK)
    done = invoke(*command)
    assert done.exit_code == 0, done.output
    assert "3 points, 3 success" in done.stdout
    assert "table.csv, sweep.png in " in done.stdout
    assert {path.name for path in (tmp_path / "s").iterdir()} == {"sweep-plan.json", "shards", "table.csv", "sweep.png"}
    table = rows(tmp_path / "s")
    assert [float(row["shaft.stiffness [N*m/rad]"]) for row in table] == [2e5, 2.5e5, 3e5]
    assert all(float(row["shaft.torque.highest [N*m]"]) > 0 for row in table)
    again = invoke(*command)
    assert again.exit_code == 0
    assert "compute 3 points, 3 of them finished before" in again.stderr


def test_ranges_and_their_units() -> None:
    model = lower(assemble(load("fracturing-truck")))
    rpm = 3.141592653589793 / 30
    assert _values(model, "zeta", "0:0.05:3", "grid") == ("zeta", [0.0, 0.025, 0.05])
    assert _values(model, "zeta", "0.01, 0.02", "grid") == ("zeta", [0.01, 0.02])
    for text in ("1500 rpm:2100 rpm:3", "1500:2100:3 rpm"):
        assert _values(model, "speed", text, "grid")[1] == pytest.approx([1500 * rpm, 1800 * rpm, 2100 * rpm])
    assert _values(model, "speed", "1500:2100 rpm", "sobol")[1] == pytest.approx([1500 * rpm, 2100 * rpm])
    assert {"coupling.torque.highest", "pump_mesh.force.amplitude"} <= set(_usual(model))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--over", "zeta"), "is no assignment; write NAME=START:STOP:COUNT"),
        (("--over", "stifness=1,2"), "parameter 'stifness': is not known"),
        (("--over", "shaft.stiffness=1:2"), "write START:STOP:COUNT"),
        (("--over", "shaft.stiffness=1:2:0 N*m/rad"), "write START:STOP:COUNT"),
        (("--over", "shaft.stiffness=1:2:3"), "shaft.stiffness"),
        (("--over", "shaft.stiffness=1,2 kN*m/rad", "--collect", "shaft.torque.higest"), "nearest is 'highest'"),
        (
            ("--over", "shaft.stiffness=1:2:9 N*m/rad", "--sampling", "sobol", "--count", "4"),
            "random points lie between LOW:HIGH",
        ),
        (("--over", "shaft.stiffness=-1,2 N*m/rad"), "give a positive value"),
        (("--over", "shaft.stiffness=1,2 N*m/rad", "--over", "shaft.stiffness=3 N*m/rad"), "is given twice"),
        (("--over", "shaft.stiffness=1:2:999999999 N*m/rad"), "has 999999999 points; take at most"),
    ],
)
def test_refusals(invoke: Invoke, two_disks: Path, tmp_path: Path, options: tuple[str, ...], words: str) -> None:
    assert words in refused(invoke("sweep", two_disks, *options, "--out", tmp_path / "s", *QUICK), 2)
    assert not (tmp_path / "s").exists()


def test_another_sweep_in_the_folder(invoke: Invoke, two_disks: Path, tmp_path: Path) -> None:
    command = ("sweep", two_disks, "--out", tmp_path / "s", *QUICK)
    assert invoke(*command, "--over", "shaft.stiffness=2,3 kN*m/rad").exit_code == 0
    assert "--fresh" in refused(invoke(*command, "--over", "shaft.stiffness=2,4 kN*m/rad"), 2)
    assert invoke(*command, "--over", "shaft.stiffness=2,4 kN*m/rad", "--fresh").exit_code == 0


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
def test_ctrl_c_keeps_what_is_done(two_disks: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-W", "error", "-m", "modelgen", "sweep", two_disks, "--out", tmp_path / "s", "--backend", "vm"]
    command += ["--over", "shaft.stiffness=200:300:400 kN*m/rad", "--window", "0 s", "0.2 s", "--workers", "1"]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        while process.poll() is None and not list((tmp_path / "s" / SHARDS).glob("*.shard")):
            pass
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=30)
    assert process.returncode == 130, err
    assert "of 400 points are kept in" in err
    assert "Traceback" not in err
    assert not list((tmp_path / "s").rglob(".unfinished*"))
