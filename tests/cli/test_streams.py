"""The command line where its streams are closed or lead to a full disk, and where the surroundings are wrong."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

FULL = Path("/dev/full")


def called(words: str, streams: str, **more: str) -> subprocess.CompletedProcess[str]:
    command = f"{sys.executable} -m modelgen {words} {streams}"
    return subprocess.run(command, shell=True, capture_output=True, text=True, env={**os.environ, **more}, check=False)


@pytest.mark.skipif(os.name != "posix", reason="closes streams as a POSIX shell does")
@pytest.mark.parametrize("words", ["list", "show two-disk-gear"])
@pytest.mark.parametrize("streams", [">&-", "2>&-", "<&-", ">&- 2>&- <&-"])
def test_a_closed_stream_is_no_mistake(words, streams):
    done = called(words, streams)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(not FULL.exists(), reason="the machine has no /dev/full")
def test_a_full_disk_is_one_line():
    done = called("list", "> /dev/full")
    assert done.returncode == 1
    assert done.stderr == "modelgen: the standard output cannot be written: No space left on device; free some space\n"
    assert called("list", "2> /dev/full").returncode == 0


@pytest.mark.skipif(not FULL.exists(), reason="the machine has no /dev/full")
def test_a_full_stderr_does_not_stop_the_results(tmp_path):
    done = called(f"modal two-disk-gear --out {tmp_path / 'out'}", "2> /dev/full")
    assert (done.returncode, (tmp_path / "out" / "modal.json").exists()) == (0, True)
    assert "tables, figures and modal.json" in done.stdout
    refused = called(f"modal nowhere --out {tmp_path / 'none'}", "2> /dev/full")
    assert (refused.returncode, refused.stdout) == (2, "")


def test_a_back_end_of_windows_is_nobodys_business_here(tmp_path):
    done = called(f"modal two-disk-gear --out {tmp_path / 'out'}", "", MPLBACKEND="nosuch")
    assert (done.returncode, (tmp_path / "out" / "modes.png").exists()) == (0, True)
