"""``kill -9`` of workers and of the parent: the table is that of an undisturbed run, nothing finished is computed twice."""

from __future__ import annotations

import contextlib
import functools
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from modelgen.analysis import sweep
from modelgen.analysis.sweeps.batch import settled
from modelgen.analysis.sweeps.crew import Crew
from modelgen.analysis.sweeps.shard import decode
from modelgen.analysis.sweeps.store import SHARDS, TABLE

from .cases import COLLECT, small_case

ROOT = Path(__file__).parents[3]
POINTS = 240
KILLS = {3: "worker", 8: "worker", 13: "parent", 18: "worker", 23: "worker"}  # when so many shards are there
SWEEP = f"""
import sys
from modelgen import Case
from modelgen.analysis import sweep
from modelgen.analysis.sweeps import work
from modelgen.model.files import parse_model
import numpy as np
work.TARGET = 0.0  # batches of one round of lanes
case = Case(parse_model(open(sys.argv[1]).read()), end=1.0, samples=41)
sweep(case, {{"zeta": np.linspace(0.01, 0.2, {POINTS})}}, {COLLECT!r}, out=sys.argv[2], workers=2)
"""
linux = pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="workers are found through /proc")


def start(model: Path, folder: Path) -> subprocess.Popen[bytes]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen([sys.executable, "-c", SWEEP, model, folder], env=environment)


def workers_of(parent: int) -> list[int]:
    found: list[int] = []
    for children in Path(f"/proc/{parent}/task").glob("*/children"):
        with contextlib.suppress(OSError):  # a thread that has just ended
            found += map(int, children.read_text().split())
    return found


def gone(process: int) -> bool:
    """Whether a process has ended, even if nobody has asked how."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def has_shards(folder: Path, count: int) -> bool:
    return len(list((folder / SHARDS).glob("*.shard"))) >= count


def wait_for(what: str, condition: object, seconds: float = 30.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < deadline, f"waited in vain for {what}"
        time.sleep(0.01)


@linux
def test_five_kills(tmp_path: Path) -> None:
    from .test_sweep import _text

    model, folder, chance = tmp_path / "model.toml", tmp_path / "s", random.Random(5)
    model.write_text(_text())
    process = start(model, folder)
    orphans: list[int] = []
    try:
        for count, victim in KILLS.items():
            wait_for("shards", functools.partial(has_shards, folder, count), 60)
            wait_for("workers", lambda: workers_of(process.pid) or process.poll() is not None)  # noqa: B023 - asked here only
            workers = workers_of(process.pid)
            if victim == "parent":
                orphans = workers
                process.kill()
                process.wait()
                process = start(model, folder)
            else:
                with contextlib.suppress(ProcessLookupError, IndexError):  # it has just ended
                    os.kill(chance.choice(workers), signal.SIGKILL)
        assert process.wait(60) == 0
    finally:
        process.kill()
        process.wait()
    case = small_case(end=1.0)
    quiet = sweep(case, {"zeta": np.linspace(0.01, 0.2, POINTS)}, COLLECT, workers=0)
    assert (folder / TABLE).read_text() == quiet.csv_text()
    kept = [point for path in (folder / SHARDS).iterdir() for point in decode(path.read_bytes()).points.tolist()]
    assert sorted(kept) == list(range(POINTS))
    for worker in orphans:
        wait_for("the end of orphans", functools.partial(gone, worker))


@linux
def test_a_point_that_no_worker_survives(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers are killed whenever they are given the bad point."""
    from modelgen.analysis.sweeps import crew

    bad, give = 13, crew._Worker.give

    def deadly(self: crew._Worker, batch: np.ndarray, values: np.ndarray) -> None:
        if bad in batch:
            self.batch = batch
            self.process.kill()
        else:
            give(self, batch, values)

    monkeypatch.setattr(crew._Worker, "give", deadly)
    found = sweep(small_case(), {"zeta": np.linspace(0.01, 0.2, 24)}, COLLECT, workers=2, out=tmp_path / "s")
    assert found.outcomes[bad] == "SOLVER_ERROR"
    assert found.messages[bad].startswith("not finished: the worker died 3 times on this point (ended by signal 9);")
    assert [k for k, outcome in enumerate(found.outcomes) if outcome != "SUCCESS"] == [bad]
    assert found.keys[bad]
    monkeypatch.setattr(crew._Worker, "give", give)
    mended = sweep(small_case(), {"zeta": np.linspace(0.01, 0.2, 24)}, COLLECT, workers=2, out=tmp_path / "s")
    assert mended.succeeded.all()
    assert mended.csv_text() == sweep(small_case(), {"zeta": np.linspace(0.01, 0.2, 24)}, COLLECT, workers=0).csv_text()


@linux
def test_workers_that_are_stopped_and_forgotten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from modelgen.analysis.sweeps import crew

    monkeypatch.setattr(crew, "STOPPED", 0.2)
    held, give = [0], crew._Worker.give

    def stopping(self: crew._Worker, batch: np.ndarray, values: np.ndarray) -> None:
        if held[0] < 5:
            os.kill(self.process.pid, signal.SIGSTOP)
            held[0] += 1
        give(self, batch, values)

    monkeypatch.setattr(crew._Worker, "give", stopping)
    found = sweep(small_case(), {"zeta": np.linspace(0.01, 0.2, 24)}, COLLECT, workers=2, out=tmp_path / "s")
    assert held[0] == 5
    assert found.succeeded.all()


@pytest.mark.skipif(settled(small_case())[1]["backend"] != "c", reason="needs a C compiler")
def test_a_compiler_that_is_killed_does_not_change_the_engine(monkeypatch: pytest.MonkeyPatch) -> None:
    from modelgen.analysis.sweeps import batch
    from modelgen.lowering.native import NoCompilerError

    deaths, there = [2], batch.native_solver

    def killed(*given: object, **options: object) -> object:
        if deaths[0]:
            deaths[0] -= 1
            raise NoCompilerError("native code", "cc --version ends with code -9", "correct $CC or PATH")
        return there(*given, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(batch, "native_solver", killed)
    assert settled(small_case())[1]["backend"] == "c"


def test_workers_that_cannot_start_are_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    from modelgen.analysis.sweeps import crew
    from modelgen.errors import CaseError

    monkeypatch.setattr(crew, "STILLBORN", 1)
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(CaseError, match=r"workers end before they are ready: ended with code 1"):
        sweep(small_case(), {"zeta": np.linspace(0.01, 0.2, 24)}, COLLECT, workers=1)


def test_a_worker_that_makes_another_model_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    from modelgen.errors import CaseError

    started = Crew.__init__

    def other(self: Crew, job: str, *rest: object) -> None:
        started(self, job.replace('stiffness = \\"300000.0 ', 'stiffness = \\"300001.0 '), *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(Crew, "__init__", other)
    with pytest.raises(CaseError, match="a worker makes another model of 'two_disks' than was sent"):
        sweep(small_case(), {"zeta": np.linspace(0.01, 0.2, 24)}, COLLECT, workers=1)
