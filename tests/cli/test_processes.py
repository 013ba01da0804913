"""The command line as a process of its own: light help, exit codes, signals."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
COMMAND = [sys.executable, "-W", "error", "-m", "modelgen"]


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("delay", [0.0, 0.001, 0.003])  # s; at first CasADi is asked many small things
def test_a_signal_in_the_middle_of_a_run(tmp_path: Path, number: int, code: int, delay: float) -> None:
    arguments = ["run", "fracturing-truck", "--out", str(tmp_path / "deep" / "out"), "--crosscheck", "none"]
    with subprocess.Popen([*COMMAND, *arguments], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        seen = []
        while not any("simulate" in line for line in seen):
            seen.append(process.stderr.readline())
            assert seen[-1], seen
        time.sleep(delay)
        process.send_signal(number)
        out, err = process.communicate(timeout=30)
    assert process.returncode == code, err
    assert out == ""
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


def test_a_wrong_model_as_a_process(tmp_path: Path) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text("format = 1\nname = 3\n", encoding="utf-8")
    done = subprocess.run([*COMMAND, "check", str(path)], cwd=ROOT, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith(f"modelgen: {path}")
    assert done.stderr.count("\n") == 1
