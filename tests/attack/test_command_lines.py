"""Command lines drawn from the commands' own declarations, and closed or full streams: an answer or one line."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from modelgen.cli.commands import commands
from strategies.command_lines import command_lines

from .conftest import Attack

MODEL = """
format = 1
name = "small"
[operation]
speed = "1500 rpm"
reference = "motor"
balance = ["load"]
[bases.motor_order]
shaft = "motor"
order = 2
[parameters]
zeta = 0.2
[elements]
motor = { kind = "inertia", inertia = "0.3 kg*m^2" }
pinion = { kind = "inertia", inertia = "0.05 kg*m^2" }
fan = { kind = "inertia", inertia = "1.5 kg*m^2" }
coupling = { kind = "shaft", a = "motor", b = "pinion", stiffness = "20 kN*m/rad", damping_ratio = "zeta" }
load = { kind = "harmonic_torque", flange = "fan", mean = "-150 N*m" }
[elements.mesh]
kind = "gear_pair"
a = "pinion"
b = "fan"
teeth_a = 20
teeth_b = 40
module = "3 mm"
mean_stiffness = "2e8 N/m"
stiffness_cosine = { unit = "N/m", values = [2e7] }
half_backlash = "40 um"
damping_ratio = 0.1
[elements.drive]
kind = "harmonic_torque"
flange = "motor"
base = "motor_order"
mean = "100 N*m"
cosine = { unit = "N*m", values = [30.0] }
"""

ONE_LINE = 30.0  # [s]; a bifurcation of a few columns on a machine that does other things too


@pytest.fixture
def models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[str, ...]:
    """Names of model files in the folder that the process stands in: mostly a sound one, spoiled ones, one that is not there."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    texts = {
        "small.toml": MODEL,
        "stiff.toml": MODEL.replace("20 kN*m/rad", "1e18 N*m/rad"),
        "spoiled.toml": MODEL.replace('"20 kN*m/rad"', "nan"),
        "unbalanced.toml": MODEL.replace('balance = ["load"]', ""),
        "cut.toml": MODEL[:300],
    }
    for name, text in texts.items():
        Path(name).write_text(text, encoding="utf-8")
    return ("small.toml",) * 8 + tuple(texts) + ("none.toml", ".")


def try_line(line: list[str]) -> str:
    """The exit code; a refusal is one line of the program or of click's, and what failed leaves no folder."""
    shutil.rmtree("out", ignore_errors=True)
    result = CliRunner().invoke(commands, line, prog_name="modelgen")
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert "Traceback" not in result.output
    assert result.exit_code in (0, 1, 2)
    if result.exit_code == 2:
        last = result.stderr.splitlines()[-1]
        assert last.startswith(("modelgen: ", "Error: ", "Try ")) or line[:1] == [] or "Usage" in result.stderr, result.stderr
    return f"exit {result.exit_code}"


@pytest.mark.slow
def test_a_sample_of_command_lines(attack: Attack, models: tuple[str, ...]) -> None:
    endings = attack(command_lines(models, "out"), 16, ONE_LINE, try_line)
    assert endings["exit 2"] > 3
    assert endings["exit 0"] > 1


@pytest.mark.proof
def test_every_command_line(attack: Attack, models: tuple[str, ...]) -> None:
    endings = attack(command_lines(models, "out"), 200, ONE_LINE, try_line)
    assert sum(endings.values()) == 200
    assert endings["exit 2"] > 30
    assert endings["exit 0"] > 20


STREAMS = (">&-", "2>&-", ">/dev/full", "2>/dev/full", "<&-", ">&- 2>&-", "| head -c 1")
LINES = ("list", "check small.toml", "show small.toml", "elements", "--help", "check none.toml", "modal small.toml --out out")


def try_streams(line: str, stream: str) -> int:
    """The exit code of a process whose streams the shell has closed, filled or cut off."""
    shutil.rmtree("out", ignore_errors=True)
    program = f'"{sys.executable}" -c "from modelgen.cli import main; main()"'
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run(
        ["sh", "-c", f"{program} {line} {stream}"], capture_output=True, text=True, timeout=ONE_LINE, env=environment, check=False
    )
    assert "Traceback" not in done.stderr + done.stdout, (line, stream, done.stderr)
    assert "Exception ignored" not in done.stderr, (line, stream, done.stderr)
    return done.returncode


@pytest.mark.proof
@pytest.mark.usefixtures("models")
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no device that is always full")
def test_every_stream() -> None:
    codes = {(line, stream): try_streams(line, stream) for line in LINES for stream in STREAMS}
    print(f"\n{len(codes)} processes with closed, full or cut streams")
    assert set(codes.values()) <= {0, 1, 2}
    assert codes["list", ">/dev/full"] == 1
