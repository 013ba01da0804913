"""The cache of libraries: what is not what was written, or could be somebody else's, is refused and built anew."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from modelgen.lowering.native import cache
from modelgen.lowering.native.compiler import NoCompilerError

pytestmark = pytest.mark.skipif(os.name != "posix", reason="owners and modes are those of POSIX")
CONTENT = b"a library" * 100


class Builder:
    """Writes the same content every time, and counts."""

    def __init__(self) -> None:
        self.count = 0

    def __call__(self, folder: Path, library: Path) -> None:
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        self.count += 1
        library.write_bytes(CONTENT)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("MODELGEN_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def entry(folder: Path) -> Path:
    found = cache.library_for("key", Builder())
    assert found == folder / "key.so"
    return found


def rebuilt(entry: Path) -> bool:
    builder = Builder()
    assert cache.library_for("key", builder) == entry
    assert cache.is_valid(entry)
    assert entry.read_bytes().startswith(CONTENT)
    return builder.count == 1


def test_an_entry_is_built_once_and_private(entry: Path) -> None:
    assert stat.S_IMODE(entry.parent.stat().st_mode) == 0o700
    assert stat.S_IMODE(entry.stat().st_mode) == 0o600
    assert [path.name for path in entry.parent.iterdir()] == ["key.so"]
    assert not rebuilt(entry)


@pytest.mark.parametrize("position", [0, 1, len(CONTENT) // 2, len(CONTENT) - 1, len(CONTENT), len(CONTENT) + 31])
def test_a_flipped_bit_is_seen(entry: Path, position: int) -> None:
    content = bytearray(entry.read_bytes())
    content[position] ^= 0x10
    entry.write_bytes(content)
    assert rebuilt(entry)


@pytest.mark.parametrize("content", [b"", b"short", CONTENT])
def test_a_file_without_its_hash_is_refused(entry: Path, content: bytes) -> None:
    entry.write_bytes(content)
    assert rebuilt(entry)


def test_a_link_is_replaced_and_its_target_left_alone(entry: Path, tmp_path: Path) -> None:
    target = tmp_path / "elsewhere.so"
    entry.rename(target)
    before = target.read_bytes()
    entry.symlink_to(target)
    assert rebuilt(entry)
    assert not entry.is_symlink()
    assert target.read_bytes() == before


def test_a_file_that_others_may_write_is_refused(entry: Path) -> None:
    entry.chmod(0o666)
    assert rebuilt(entry)


@pytest.mark.parametrize("kind", ["folder", "pipe"])
def test_something_that_is_no_file_is_replaced(entry: Path, kind: str) -> None:
    entry.unlink()
    if kind == "folder":
        (entry / "inside").mkdir(parents=True)
    else:
        os.mkfifo(entry)
    assert rebuilt(entry)


def test_a_file_of_another_owner_is_refused(entry: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert cache.is_valid(entry)
    monkeypatch.setattr(os, "geteuid", lambda: entry.stat().st_uid + 1)
    assert not cache.is_valid(entry)
    assert not cache.is_private(entry.parent)


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o755])
def test_a_folder_that_others_may_enter_is_not_used(entry: Path, mode: int) -> None:
    entry.parent.chmod(mode)
    builder = Builder()
    found = cache.library_for("key", builder)
    assert found.parent != entry.parent
    assert builder.count == 1
    assert cache.is_private(found.parent)
    found.unlink()


def test_a_folder_that_is_a_link_is_not_used(entry: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    link = tmp_path / "link"
    link.symlink_to(entry.parent)
    monkeypatch.setenv("MODELGEN_CACHE", str(link))
    assert cache.cache_folder() not in (link, entry.parent)


def test_a_build_that_fails_leaves_nothing(folder: Path) -> None:
    def fails(place: Path, library: Path) -> None:
        library.write_bytes(b"half")
        raise NoCompilerError("native code", "the disk is full")

    with pytest.raises(NoCompilerError, match="the disk is full"):
        cache.library_for("key", fails)
    assert list(folder.iterdir()) == []


MANY = """
import sys, time
from pathlib import Path
from modelgen.lowering.native import cache
def build(folder, library):
    (Path(sys.argv[1]) / "built").open("a").write("x")
    time.sleep(0.2)
    library.write_bytes(b"a library")
print(cache.is_valid(cache.library_for("key", build)))
"""


@pytest.mark.parametrize("count", [6, pytest.param(32, marks=pytest.mark.slow)])
def test_many_processes_build_one_entry(folder: Path, tmp_path: Path, count: int) -> None:
    command = [sys.executable, "-c", MANY, str(tmp_path)]
    runs = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, "CC": "none"}) for _ in range(count)]
    assert [run.communicate(timeout=240)[0] for run in runs] == ["True\n"] * count
    assert [path.name for path in folder.iterdir()] == ["key.so"]
    assert (tmp_path / "built").read_text() == "x"
