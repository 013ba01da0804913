"""The folder of a sweep: a plan, shards of finished points, and at the end a table. Whatever is killed, nothing in it is lost.

Part of ``sweeps``. One process writes. Every file is written beside its place, brought to the disk and moved there, so a name
stands for the whole file or for none; what a shard holds is checked when it is read, and a damaged one is deleted and computed
again. The plan is written before the first point; every shard carries its digest, so a lost plan costs nothing and a shard
of another sweep is noticed: beside our plan it is left out, without a plan the folder is refused. The lock is the operating
system's on the folder itself and ends with the process that holds it.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from modelgen.analysis.sweeps.shard import Batch, DamagedError, decode
from modelgen.errors import CaseError

try:
    import fcntl
except ImportError:  # not on Windows: there nobody hinders two processes from computing the same points
    fcntl = None  # type: ignore[assignment]

PLAN, SHARDS, TABLE = "sweep-plan.json", "shards", "table.csv"
WRITTEN = (PLAN, SHARDS, TABLE, "sweep.png", "sweep.nc")
"""What modelgen writes into the folder of a sweep."""
UNFINISHED = (".unfinished-", ".sweep.png.")
"""How the names of files begin that were never finished; the second one is a figure's."""
ANOTHER = "name another folder, or start over with fresh (--fresh), which deletes its points"


def digest_of(plan: Mapping[str, Any]) -> str:
    """SHA-256 of a plan."""
    return hashlib.sha256(json.dumps(plan, sort_keys=True, allow_nan=False).encode()).hexdigest()


class Store:
    """The folder of one sweep, open for writing; ``notes``: what was found wrong in it, in sentences."""

    def __init__(self, folder: Path, plan: Mapping[str, Any]) -> None:
        self.folder, self.plan, self.digest = folder, plan, digest_of(plan)
        self.where = f"sweep folder {str(folder)!r}"
        self.notes: list[str] = []
        self.planned = False

    def batches(self) -> Iterator[Batch]:
        """Every batch that is kept, one at a time; damaged ones are deleted. Raises CaseError for one of another sweep."""
        for path in sorted((self.folder / SHARDS).glob("*.shard")):
            try:
                batch = decode(path.read_bytes())
            except DamagedError:
                self.notes.append(f"shard {path.name} was damaged; its points were computed again")
                path.unlink()
                continue
            except OSError as error:
                raise CaseError(self.where, f"{path.name} cannot be read: {error.strerror}", "check its permissions") from None
            if batch.plan != self.digest and self.planned:
                self.notes.append(f"shard {path.name} holds points of another sweep and was left out")
                continue
            if batch.plan != self.digest:
                raise CaseError(self.where, "holds points of another sweep", ANOTHER)
            yield batch

    def add(self, raw: bytes, first: int) -> None:
        """Keep an encoded batch; ``first``: its first point. Raises CaseError where the disk does not take it."""
        self.write(f"{SHARDS}/{first:09d}-{hashlib.sha256(raw).hexdigest()[:16]}.shard", raw)

    def write(self, name: str, content: bytes) -> Path:
        """A file in the folder, whole or not at all. Raises CaseError where the disk does not take it."""
        path = self.folder / name
        temporary = path.with_name(f"{UNFINISHED[0]}{path.name}")
        try:
            try:
                with temporary.open("wb") as file:
                    file.write(content)
                    file.flush()
                    os.fsync(file.fileno())
                os.replace(temporary, path)
                _to_disk(path.parent)
            finally:
                temporary.unlink(missing_ok=True)
        except OSError as error:
            remedy = "what is finished is kept; make room or give permission, and run the same sweep again"
            raise CaseError(self.where, f"cannot be written: {error.strerror or error}", remedy) from None
        return path


@contextmanager
def opened(folder: str | Path, plan: Mapping[str, Any], fresh: bool = False) -> Iterator[Store]:
    """The store of a sweep in a folder, new or as it was left; ``fresh`` deletes what an earlier sweep left.

    Raises CaseError for a folder that holds anything else, another sweep, or that another process is filling.
    """
    store = Store(Path(os.path.realpath(folder)), plan)
    refuse_foreign(store.folder, store.where)
    try:
        store.folder.mkdir(parents=True, exist_ok=True)
        with _alone(store.folder, store.where):
            if fresh:
                _clear(store.folder)
            _check_plan(store)
            (store.folder / SHARDS).mkdir(exist_ok=True)
            for left in [*store.folder.iterdir(), *(store.folder / SHARDS).iterdir()]:
                if left.name.startswith(UNFINISHED):
                    left.unlink()
            text = json.dumps({"digest": store.digest, "plan": plan}, indent=1).encode()
            if not (store.folder / PLAN).exists() or (store.folder / PLAN).read_bytes() != text:
                store.write(PLAN, text)
            yield store
    except OSError as error:
        raise CaseError(store.where, f"cannot be used: {error.strerror or error}", "check the path and its permissions") from None


def refuse_foreign(out: str | Path, where: str) -> None:
    """Raises CaseError for a file, and for a folder with anything that modelgen did not write there."""
    try:
        folder = Path(out)
        held = sorted(entry.name for entry in folder.iterdir() if not entry.name.startswith(UNFINISHED))
        shards = folder / SHARDS
        held += sorted(f"{SHARDS}/{each.name}" for each in shards.iterdir()) if shards.is_dir() else []
    except FileNotFoundError:
        return
    except (TypeError, ValueError):
        raise CaseError(where, "is no name of a folder", "name a folder") from None
    except NotADirectoryError:
        raise CaseError(where, "is a file", "name a folder") from None
    except OSError as error:
        raise CaseError(where, f"cannot be read: {error.strerror}", "check the path and its permissions") from None
    shard = tuple(f"{SHARDS}/{start}" for start in (*"0123456789", UNFINISHED[0]))
    foreign = [name for name in held if name not in WRITTEN and not name.startswith(shard)]
    if held and not {PLAN, SHARDS} & set(held):
        foreign = held
    if foreign:
        raise CaseError(where, f"holds {foreign[0]!r} and is no folder of a sweep", "name another folder")


def read_plan(folder: Path) -> dict[str, Any] | None:
    """The plan in a folder; None where there is none that is whole."""
    with contextlib.suppress(OSError, ValueError, KeyError, TypeError, RecursionError):
        held = json.loads((folder / PLAN).read_bytes())
        if digest_of(held["plan"]) == held["digest"]:
            return dict(held["plan"])
    return None


def _check_plan(store: Store) -> None:
    held = read_plan(store.folder)
    store.planned = held is not None
    if held is not None and digest_of(held) != store.digest:
        raise CaseError(store.where, f"holds another sweep: {_difference(held, store.plan)}", ANOTHER)


def _difference(held: Mapping[str, Any], wanted: Mapping[str, Any], path: str = "") -> str:
    """The first thing in which two plans differ, in words."""
    for name in [*held, *(each for each in wanted if each not in held)]:
        old, new = held.get(name), wanted.get(name)
        if old != new:
            if isinstance(old, dict) and isinstance(new, dict):
                return _difference(old, new, f"{path}{name}, ")
            return f"{path}{name} was {old!s:.60}, now {new!s:.60}"
    return "its plan differs"


def _clear(folder: Path) -> None:
    """Delete what sweeps write, and nothing else; the plan last, which says whose folder it is."""
    shutil.rmtree(folder / SHARDS, ignore_errors=True)
    for name in (*(each for each in WRITTEN if each not in (SHARDS, PLAN)), PLAN):
        (folder / name).unlink(missing_ok=True)


@contextmanager
def _alone(folder: Path, where: str) -> Iterator[None]:
    """The only process that fills the folder."""
    if fcntl is None:
        yield
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise CaseError(where, "is being filled by another process", "wait for it, or end it") from None
        yield
    finally:
        os.close(descriptor)


def _to_disk(folder: Path) -> None:
    """The names in a folder brought to the disk, where folders can be opened."""
    if fcntl is None:
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
