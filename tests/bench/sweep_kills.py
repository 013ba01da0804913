"""A sweep under ``kill -9``: workers and parent, at random moments; the table must be that of an undisturbed run, byte for byte.

    python tests/bench/sweep_kills.py [kills] [points] [seconds simulated per point] [seed of the moments]

Run by hand; ``tests/analysis/sweeps/test_kills.py`` does the same in small. Needs /proc to find the workers of a parent.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from modelgen import Case
from modelgen.analysis import sweep
from modelgen.analysis.sweeps.shard import decode
from modelgen.analysis.sweeps.store import SHARDS, TABLE
from modelgen.model.files import parse_model

ROOT = Path(__file__).resolve().parents[2]
MODEL = """
format = 1
name = "two_disks"
[operation]
speed = "1200 rpm"
reference = "engine"
[bases.firing]
order = 3
[parameters]
zeta = 0.05
[elements.engine]
kind = "inertia"
inertia = "3 kg*m^2"
[elements.load]
kind = "inertia"
inertia = "1 kg*m^2"
[elements.shaft]
kind = "shaft"
a = "engine"
b = "load"
stiffness = "3e5 N*m/rad"
damping_ratio = "zeta"
[elements.torque]
kind = "harmonic_torque"
flange = "engine"
base = "firing"
cosine = { unit = "N*m", values = [40.0, 10.0] }
"""


def run(folder: Path, points: int, seconds: float, workers: int = 2) -> None:
    """The sweep itself, as the process that is killed."""
    case = Case(parse_model(MODEL), end=seconds, samples=101)
    over = {"zeta": np.linspace(0.01, 0.2, points)}
    sweep(case, over, ["shaft.torque.highest", "shaft.torque.rms", "shaft.twist.final", "steps"], out=folder, workers=workers)


def start(folder: Path, points: int, seconds: float) -> subprocess.Popen[bytes]:
    code = "import sys; from sweep_kills import run, Path; run(Path(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]))"
    path = os.pathsep.join([str(ROOT), str(Path(__file__).parent)])
    return subprocess.Popen(
        [sys.executable, "-c", code, str(folder), str(points), str(seconds)], env={**os.environ, "PYTHONPATH": path}
    )


def workers_of(parent: int) -> list[int]:
    """The worker processes of a parent."""
    found: list[int] = []
    for children in Path(f"/proc/{parent}/task").glob("*/children"):
        try:
            found += map(int, children.read_text().split())
        except OSError:
            continue
    return found


def kill_often(folder: Path, kills: int, points: int, seconds: float, chance: random.Random) -> tuple[int, int, bool]:
    """Kills parent and workers at random moments until so many are dead, then lets it finish.

    Returns how many parents and how many workers were killed, and whether the sweep was still at work at the last kill.
    """
    parents = workers = 0
    process = start(folder, points, seconds)
    while parents + workers < kills:
        one_of_them = chance.random() < 0.7
        time.sleep(chance.uniform(0.05, 2.5))
        while one_of_them and process.poll() is None and not workers_of(process.pid):
            time.sleep(0.01)
        time.sleep(chance.uniform(0.0, 0.5))
        if process.poll() is not None:
            assert process.returncode == 0, process.returncode
            return parents, workers, False
        candidates = workers_of(process.pid)
        if one_of_them and candidates:
            os.kill(chance.choice(candidates), signal.SIGKILL)
            workers += 1
        else:
            process.kill()
            process.wait()
            parents += 1
            process = start(folder, points, seconds)
    busy = process.poll() is None
    assert process.wait() == 0
    return parents, workers, busy


def stored(folder: Path) -> list[int]:
    """The points of all shards, as often as they are there."""
    return [point for path in (folder / SHARDS).iterdir() for point in decode(path.read_bytes()).points.tolist()]


def main(kills: int, points: int, seconds: float, seed: int) -> None:
    with tempfile.TemporaryDirectory() as place:
        quiet, loud = Path(place, "quiet"), Path(place, "loud")
        begun = time.perf_counter()
        run(quiet, points, seconds)
        print(f"undisturbed: {points} points in {time.perf_counter() - begun:.1f} s", flush=True)
        begun = time.perf_counter()
        parents, workers, busy = kill_often(loud, kills, points, seconds, random.Random(seed))
        print(f"killed: {parents} parents, {workers} workers in {time.perf_counter() - begun:.1f} s; at work to the last: {busy}")
        tables = [(folder / TABLE).read_text().splitlines() for folder in (quiet, loud)]
        same = tables[0] == tables[1]
        for lines in [pair for pair in zip(*tables, strict=True) if pair[0] != pair[1]][:5]:
            print("not the same:", *lines, sep="\n  ")
        kept = stored(loud)
        print(f"table the same bytes: {same}; points stored: {len(kept)}, of them different: {len(set(kept))}")
        assert busy, "the sweep ended before the last kill: simulate longer"
        assert same
        assert sorted(kept) == list(range(points))


if __name__ == "__main__":
    given = sys.argv[1:]
    kills, points, seconds, seed = (*given, *("100", "2000", "100", "2026")[len(given) :])
    main(int(kills), int(points), float(seconds), int(seed))
