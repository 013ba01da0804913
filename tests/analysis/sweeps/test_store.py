"""The folder of a sweep: resuming, damage of every kind, other plans, foreign folders, full disks, Ctrl-C."""

from __future__ import annotations

import errno
import json
import os
import random
import resource
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from modelgen import Case
from modelgen.analysis import sweep
from modelgen.analysis.sweeps.shard import DamagedError, decode
from modelgen.analysis.sweeps.store import PLAN, SHARDS, TABLE, opened, read_plan
from modelgen.errors import CaseError

from .cases import COLLECT, small_case

OVER = {"zeta": [0.02, 0.05, 0.1], "speed": ["1000 rpm", "1100 rpm", "1200 rpm", "1300 rpm"]}


@pytest.fixture(scope="module")
def case() -> Case:
    return small_case(options={"backend": "vm"}, end=0.02, samples=11)


@pytest.fixture(scope="module")
def table(case: Case) -> bytes:
    return sweep(case, OVER, COLLECT, workers=0).csv_text().encode()


@pytest.fixture
def folder(case: Case, table: bytes, tmp_path: Path) -> Path:
    """A finished sweep."""
    sweep(case, OVER, COLLECT, workers=0, out=tmp_path / "s")
    assert (tmp_path / "s" / TABLE).read_bytes() == table
    return tmp_path / "s"


def shards(folder: Path) -> list[Path]:
    return sorted((folder / SHARDS).iterdir())


def computed(case: Case, folder: Path, monkeypatch: pytest.MonkeyPatch, **options: object) -> int:
    """How many points a sweep in the folder computes."""
    from modelgen.analysis.sweeps import batch

    count = [0]
    prepared = batch._prepared

    def counted(one: Case) -> object:
        count[0] += 1
        return prepared(one)

    with monkeypatch.context() as patch:
        patch.setattr(batch, "_prepared", counted)
        sweep(case, OVER, COLLECT, workers=0, out=folder, **options)  # type: ignore[arg-type]
    return count[0]


def test_a_finished_sweep_computes_nothing(case: Case, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert computed(case, folder, monkeypatch) == 0
    assert computed(case, folder, monkeypatch, fresh=True) == 12


def test_what_is_missing_is_computed(case: Case, folder: Path, table: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    lost = shards(folder)[0]
    points = len(decode(lost.read_bytes()).points)
    lost.unlink()
    (folder / TABLE).unlink()
    assert computed(case, folder, monkeypatch) == points
    assert (folder / TABLE).read_bytes() == table


def test_shards_truncated_anywhere_are_found(folder: Path) -> None:
    for path in shards(folder):
        raw = path.read_bytes()
        decode(raw)
        for length in range(len(raw)):
            with pytest.raises(DamagedError, match="is damaged"):
                decode(raw[:length])


def test_flipped_bits_are_found(folder: Path) -> None:
    chance = random.Random(7)
    whole = [path.read_bytes() for path in shards(folder)]
    for _ in range(500):
        raw = bytearray(chance.choice(whole))
        raw[chance.randrange(len(raw))] ^= 1 << chance.randrange(8)
        with pytest.raises(DamagedError, match="is damaged"):
            decode(bytes(raw))


def test_a_damaged_shard_is_computed_again(case: Case, folder: Path, table: bytes) -> None:
    path = shards(folder)[-1]
    raw = bytearray(path.read_bytes())
    raw[len(raw) // 2] ^= 4
    path.write_bytes(raw)
    result = sweep(case, OVER, COLLECT, workers=0, out=folder)
    assert result.notes == (f"shard {path.name} was damaged; its points were computed again",)
    assert (folder / TABLE).read_bytes() == table
    assert sweep(case, OVER, COLLECT, workers=0, out=folder).notes == ()


@pytest.mark.parametrize("content", [None, b"", b"{}", b'{"digest": "0", "plan": {}}', b"\xff" * 40, b"[" * 5000])
def test_a_lost_plan_costs_nothing(
    case: Case, folder: Path, table: bytes, content: bytes | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / PLAN).unlink()
    if content is not None:
        (folder / PLAN).write_bytes(content)
    assert computed(case, folder, monkeypatch) == 0
    assert read_plan(folder) is not None


def test_unfinished_files_are_cleared_away(case: Case, folder: Path) -> None:
    (folder / SHARDS / ".unfinished-000000000-aa.shard").write_bytes(b"half")
    (folder / ".unfinished-table.csv").write_bytes(b"half")
    (folder / ".sweep.png.17.4711").write_bytes(b"half")  # as a figure is written
    sweep(case, OVER, COLLECT, workers=0, out=folder)
    assert not [path for path in folder.rglob("*") if path.name.startswith(".")]


@pytest.mark.parametrize(
    ("change", "over", "collect", "words"),
    [
        ({"tolerance": 1e-7}, OVER, COLLECT, "another sweep: case, tolerance was 1e-06, now 1e-07"),
        ({"end": 0.03}, OVER, COLLECT, "case, end was 0.02, now 0.03"),
        ({"options": {"backend": "c"}}, OVER, COLLECT, r"case, options, backend was vm, now c"),
        ({}, {"zeta": [0.02]}, COLLECT, r"points, names was \['zeta', 'speed'\], now \['zeta'\]"),
        ({}, OVER, COLLECT[:2], "collect was"),
    ],
)
def test_another_sweep_is_refused(case: Case, folder: Path, change: dict, over: dict, collect: tuple, words: str) -> None:
    held = (folder / PLAN).read_bytes()
    with pytest.raises(CaseError, match=words + r".*; name another folder, or start over with fresh \(--fresh\)"):
        sweep(case.change(**change), over, collect, workers=0, out=folder)
    assert (folder / PLAN).read_bytes() == held


def test_points_of_another_sweep_without_their_plan_are_refused(case: Case, folder: Path) -> None:
    (folder / PLAN).unlink()
    with pytest.raises(CaseError, match="holds points of another sweep"):
        sweep(case.change(tolerance=1e-7), OVER, COLLECT, workers=0, out=folder)


def test_a_shard_of_another_sweep_beside_our_plan_is_left_out(case: Case, folder: Path, table: bytes, tmp_path: Path) -> None:
    sweep(case.change(tolerance=1e-7), OVER, COLLECT, workers=0, out=tmp_path / "other")
    strange = shards(tmp_path / "other")[0]
    shards(folder)[0].write_bytes(strange.read_bytes())  # over one of ours
    (folder / SHARDS / strange.name).write_bytes(strange.read_bytes())  # and beside them
    result = sweep(case, OVER, COLLECT, workers=0, out=folder)
    assert len(result.notes) == 2
    assert result.notes[0].endswith("holds points of another sweep and was left out")
    assert (folder / TABLE).read_bytes() == table
    assert (folder / SHARDS / strange.name).exists()


def test_fresh_starts_over(case: Case, folder: Path) -> None:
    result = sweep(case, {"zeta": [0.02]}, COLLECT, workers=0, out=folder, fresh=True)
    assert len(result) == 1
    assert len(shards(folder)) == 1


def test_foreign_folders_are_left_alone(case: Case, tmp_path: Path) -> None:
    for name in ("notes.txt", TABLE, "sweep.png"):
        folder = tmp_path / f"of_{name}"
        folder.mkdir()
        (folder / name).write_text("mine")
        for fresh in (False, True):
            with pytest.raises(CaseError, match=f"holds '{name}' and is no folder of a sweep; name another folder"):
                sweep(case, OVER, COLLECT, workers=0, out=folder, fresh=fresh)
        assert (folder / name).read_text() == "mine"
    (tmp_path / "file").write_text("mine")
    with pytest.raises(CaseError, match="is a file; name a folder"):
        sweep(case, OVER, COLLECT, workers=0, out=tmp_path / "file")


def test_something_else_among_the_shards(case: Case, folder: Path) -> None:
    (folder / SHARDS / "photo.jpg").write_text("mine")
    with pytest.raises(CaseError, match=r"holds 'shards/photo.jpg'"):
        sweep(case, OVER, COLLECT, workers=0, out=folder, fresh=True)


def test_one_process_at_a_time(case: Case, folder: Path) -> None:
    plan = read_plan(folder)
    assert plan is not None
    with opened(folder, plan), pytest.raises(CaseError, match="is being filled by another process; wait for it, or end it"):
        sweep(case, OVER, COLLECT, workers=0, out=folder)
    sweep(case, OVER, COLLECT, workers=0, out=folder)


def test_a_full_disk_keeps_what_is_finished(case: Case, table: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    room, put = [1], os.replace

    def full(source: object, target: object) -> None:
        if str(target).endswith(".shard"):
            room[0] -= 1
            if room[0] < 0:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        put(source, target)  # type: ignore[arg-type]

    monkeypatch.setattr("modelgen.analysis.sweeps.work.Work.size", lambda self: 3)
    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", full)
        with pytest.raises(CaseError, match=r"cannot be written: No space left on device; what is finished is kept; make room"):
            sweep(case, OVER, COLLECT, workers=0, out=tmp_path / "s")
    assert len(shards(tmp_path / "s")) == 1
    assert computed(case, tmp_path / "s", monkeypatch) == 9
    assert (tmp_path / "s" / TABLE).read_bytes() == table


@pytest.fixture
def small_files() -> Iterator[None]:
    """No file may be longer than 2 kB, as on a disk that is full in the middle of a file."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2048, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.usefixtures("small_files")
def test_a_file_that_does_not_fit(case: Case, tmp_path: Path) -> None:
    many = {"zeta": np.linspace(0.01, 0.1, 40)}
    with pytest.raises(CaseError, match="cannot be written: File too large; what is finished is kept"):
        sweep(case, many, COLLECT, workers=0, out=tmp_path / "s")
    assert [len(decode(path.read_bytes()).points) for path in shards(tmp_path / "s")]


def test_ctrl_c_keeps_what_is_done(case: Case, table: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("modelgen.analysis.sweeps.work.Work.size", lambda self: 5)

    def interrupt(done: int, total: int) -> None:
        if done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(case, OVER, COLLECT, workers=0, out=tmp_path / "s", progress=interrupt)
    assert len(shards(tmp_path / "s")) == 1
    assert not (tmp_path / "s" / TABLE).exists()
    assert computed(case, tmp_path / "s", monkeypatch) == 7
    assert (tmp_path / "s" / TABLE).read_bytes() == table


def test_the_plan_says_what_is_swept(folder: Path) -> None:
    plan = json.loads((folder / PLAN).read_text())["plan"]
    assert plan["points"]["axes"][0] == [0.02, 0.05, 0.1]
    assert plan["collect"] == list(COLLECT)
    assert plan["case"]["fingerprint"]
    assert plan["engine"] == {"solver": "rk4", "backend": "vm"}
