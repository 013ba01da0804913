"""What a command refuses, it says in words of the command line and not of Python."""

from __future__ import annotations

import re

import numpy as np
import pytest
from click.testing import CliRunner

from modelgen.cli.commands import commands
from modelgen.cli.wording import WORDS, in_words_of_the_command_line

PYTHON = re.compile(r"\w\(\w*=|\.given\(|align=|longest_lag|balance\(")


def refused(*words: str) -> str:
    done = CliRunner().invoke(commands, list(words))
    assert done.exit_code == 2, done.output
    said = done.output.splitlines()[-1]
    assert not PYTHON.search(said), said
    return said


def test_a_rule_without_its_input_is_told_as_an_option(tmp_path):
    words = ("limits", "two-disk-gear", "--out", str(tmp_path / "out"), "--rule")
    said = refused(*words, "iacs_m68")
    assert """write --rule "iacs_m68_continuous tensile_strength='... MPa'", or in the model's [[limits]] inputs""" in said
    # What it says to write is understood: the next input is asked for.
    found = re.search(r'--rule "([^"]+)"', said)
    assert found is not None
    assert 'write --rule "iacs_m68_continuous shape_factor=..."' in refused(*words, found[1].replace("...", "600"))


def test_a_recording_elsewhere_in_time_is_told_the_options(tmp_path):
    times = np.linspace(0.0, 0.5, 500) - 100.0
    rows = "\n".join(f"{time:.6f}; {np.sin(50 * time):.6f}" for time in times)
    (tmp_path / "recording.csv").write_text(f"t [s]; wheel.angle_deviation [rad]\n{rows}\n")
    words = ("compare", "two-disk-gear", str(tmp_path / "recording.csv"), "--out", str(tmp_path / "out"))
    said = refused(*words, "--window", "0 s", "0.05 s")
    assert "give --start TIME (time of the run at the measured zero), --align, or --window around the recording" in said


@pytest.mark.parametrize(
    ("library", "command"),
    [
        ("a: b; record longer, or give a shorter longest_lag", "a: b; record longer, or give --start TIME instead of --align"),
        ("a: b; use balance(load), change a torque, or declare that it drifts",
         'a: b; write balance = ["load"] into the model file, change a torque, or drifts = true'),
        ("a: b; use balance(load, ...), one load for each given speed",
         'a: b; write balance = ["load", ...] into the model file, one load for each given speed'),
        ("a: b; check the path", "a: b; check the path"),
    ],
)  # fmt: skip
def test_words(library, command):
    assert in_words_of_the_command_line(library) == command
    assert len(WORDS) > 5
