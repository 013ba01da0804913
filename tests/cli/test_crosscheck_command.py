"""``modelgen crosscheck``: a table, a figure, files, and refusals by their words."""

from __future__ import annotations

import json
from pathlib import Path

from click.testing import CliRunner

from modelgen.cli.commands import commands

MODEL = """
format = 1
name = "two-disks"
[operation]
speed = "600 rpm"
reference = "engine"
[bases.once]
order = 1
[elements.engine]
kind = "inertia"
inertia = "5 kg*m^2"
[elements.load]
kind = "inertia"
inertia = "2 kg*m^2"
[elements.shaft]
kind = "shaft"
a = "engine"
b = "load"
stiffness = "10 kN*m/rad"
damping_ratio = 0.02
[elements.shaking]
kind = "harmonic_torque"
flange = "engine"
base = "once"
sine = { unit = "N*m", values = [20.0] }
"""


def run(folder: Path, *words: str) -> tuple[int, str]:
    model = folder / "two_disks.toml"
    model.write_text(MODEL, encoding="utf-8")
    result = CliRunner().invoke(commands, ["crosscheck", str(model), "--out", str(folder / "out"), *words])
    return result.exit_code, result.output


def test_the_folder_holds_table_figure_and_data(tmp_path: Path) -> None:
    code, output = run(tmp_path, "--solvers", "rk4,cvodes", "--tolerances", "1e-6,1e-8", "--end", "0.3 s")
    assert code == 0, output
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"crosscheck.csv", "crosscheck.json", "crosscheck.png"}
    data = json.loads((tmp_path / "out" / "crosscheck.json").read_text(encoding="utf-8"))
    assert [(each["solver"], each["tolerance"]) for each in data["runs"]] == [
        (solver, tolerance) for solver in ("rk4", "cvodes") for tolerance in (1e-6, 1e-8)
    ]
    assert 0 < data["worst_relative_difference"] < 1e-5
    assert "does not grow exponentially" in output


def test_wrong_words_are_refused(tmp_path: Path) -> None:
    for words, said in (
        (("--solvers", "rk4,cvode"), "nearest is 'cvodes'"),
        (("--tolerances", "tight"), "--tolerances: is 'tight'; give numbers such as 1e-6,1e-8"),
        (("--end", "0.3"), "has no unit"),
        (("--solvers", ","), "names none"),
    ):
        code, output = run(tmp_path, *words)
        assert (code, said in output) == (2, True), output
        assert not (tmp_path / "out").exists()
