"""A run that ends early is named wherever its result is told: in the text, in the data, in the figure, and by the exit code."""

from __future__ import annotations

import csv
import json
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure

from modelgen import Case, load
from modelgen.analysis import bifurcation, operating_map, poincare
from modelgen.analysis.nonlinear.frequency_sweep import frequency_sweep
from modelgen.cli.commands import commands
from modelgen.errors import CaseError
from modelgen.plots import plot
from modelgen.solvers import Budget
from modelgen.solvers.outcome import Outcome

WORDS = "the budget of 300 steps is used up"


@pytest.fixture(scope="module")
def short() -> Case:
    """A gear pair whose runs may take 300 steps, a twentieth of what a strobe needs."""
    return Case(load("two-disk-gear"), end=1.0, options={"budget": Budget(max_steps=300), "backend": "vm"})


def said(figure: Figure) -> str:
    return " ".join(" ".join(text.get_text() for text in figure.texts).split())


def test_a_section(short: Case) -> None:
    result = poincare(short, count=16, transient=20)
    assert result.outcome is Outcome.MAX_STEPS
    assert WORDS in result.failure
    assert f"the run failed, {result.failure}" in str(result)
    assert "no period up to 16" not in str(result)
    with pytest.raises(CaseError, match=f"holds no points: .*{WORDS}"):
        plot(result)


def test_a_bifurcation_diagram(short: Case) -> None:
    result = bifurcation(short, "speed", ["3000 rpm", "3500 rpm"], count=16, transient=20)
    assert [column.value for column in result.failed] == result.values.tolist()
    assert "2 runs failed, the first at 314.159 rad/s: stopped" in str(result)
    figure = plot(result)
    assert "2 runs failed (crosses below)" in said(figure)
    assert WORDS in said(figure)
    (crosses,) = [line for line in figure.axes[-1].lines if line.get_marker() == "x"]
    assert crosses.get_xdata() == pytest.approx([3000.0, 3500.0])


def test_an_operating_map(short: Case) -> None:
    result = operating_map(short, ("speed", ["3000 rpm", "3500 rpm"]), ("xi", [0.02, 0.05]))
    assert result.largest_angle is None
    assert "4 cells failed, the first in row 1, column 1: stopped" in str(result)
    figure = plot(result, limit="0.5 deg")
    assert "4 cells could not be run (crossed out), the first: stopped" in said(figure)


def test_a_frequency_sweep(short: Case) -> None:
    result = frequency_sweep(short, ["3000 rpm", "3100 rpm", "3500 rpm"], transient=20)
    assert len(result.failed) == 6
    assert result.changes == ()
    assert all(np.isnan(point.rms[0]) and np.isnan(point.separated) for point in result.forward)
    assert "6 runs failed, the first at 1200 Hz: stopped" in str(result)
    assert WORDS in said(plot(result))


COMMANDS: dict[str, tuple[list[str], str]] = {
    "poincare": (["--strobes", "16", "--transient", "2"], ""),
    "bifurcation": (["--over", "xi", "0.02", "0.05", "--count", "2", "--strobes", "16", "--transient", "0"], "columns.csv"),
    "transmission-error": (["--speeds", "3000 rpm", "3500 rpm", "--count", "3", "--transient", "0"], "transmission_error.csv"),
}


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_name_it_and_end_with_1(command: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    from modelgen.analysis.nonlinear import strobes

    whole = strobes.run_all

    def stopped(case: Case, problems: Any, options: Any) -> Any:
        from dataclasses import replace

        return whole(case, problems, replace(options, budget=Budget(max_steps=300)))

    monkeypatch.setattr(strobes, "run_all", stopped)
    options, table = COMMANDS[command]
    out = tmp_path / "out"
    result = CliRunner().invoke(commands, [command, "two-disk-gear", "--out", str(out), *options])
    assert result.exit_code == 1, result.output
    assert WORDS in result.stderr
    if not table:
        assert not out.exists()  # without a point there is nothing to keep
        return
    with (out / table).open(encoding="utf-8", newline="") as file:
        assert all(WORDS in row["ending"] for row in csv.DictReader(file))
    assert WORDS in next(out.glob("*.json")).read_text(encoding="utf-8")
    assert json.loads(next(out.glob("*.json")).read_text(encoding="utf-8"))
