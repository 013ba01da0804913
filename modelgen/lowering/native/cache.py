"""A private cache of built libraries: found by what they were built from, loaded only if they are what was written.

Part of the compiler. The folder belongs to the user alone (0700). An entry is one file, the library followed by its SHA-256, put
in place in one move, so that any number of processes may build at once and a killed one leaves nothing half done. A link, a file
of another owner or one that others may write, and a flipped bit are refused and built anew. A folder that is not private is not
used at all: then a folder of this process alone takes its place.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import hashlib
import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from modelgen.errors import LoweringError

try:
    import fcntl
except ImportError:  # not on Windows: then two processes may build the same, and the last one stays
    fcntl = None  # type: ignore[assignment]

DIGEST = hashlib.sha256().digest_size
ENVIRONMENT = "MODELGEN_CACHE"  # a folder to use instead of the user's

Build = Callable[[Path, Path], None]  # (an empty private folder, the library to write)


def cache_folder() -> Path:
    """Where libraries are kept: $MODELGEN_CACHE, or the user's cache folder, if it is private; else a folder of this process."""
    if os.environ.get(ENVIRONMENT):
        wanted = Path(os.environ[ENVIRONMENT]).absolute()
    else:
        try:
            wanted = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "modelgen" / "native"
        except RuntimeError:  # no home
            return _own_folder()
    try:
        wanted.parent.mkdir(parents=True, exist_ok=True)
        wanted.mkdir(mode=0o700, exist_ok=True)
        return wanted if is_private(wanted) else _own_folder()
    except OSError:
        return _own_folder()


def is_private(folder: Path) -> bool:
    """Whether a folder is a real one, of this user, closed to all others."""
    status = os.lstat(folder)
    return stat.S_ISDIR(status.st_mode) and _is_ours(status) and not (_has_modes() and status.st_mode & 0o077)


def library_for(key: str, build: Build) -> Path:
    """The library of a key, built if there is none that can be trusted. Raises what ``build`` raises."""
    folder = cache_folder()
    entry = folder / f"{key}.so"
    if is_valid(entry):
        return entry
    with _one_builder(folder):
        if not is_valid(entry):  # somebody else may have built it while we waited
            _build(folder, entry, build)
    if not is_valid(entry):
        raise LoweringError(
            "native code", f"the library in {folder} is not what was written", "look for what changes files there"
        )
    return entry


def is_valid(entry: Path) -> bool:
    """Whether an entry is a plain file of this user that holds what was written."""
    try:
        descriptor = os.open(
            entry, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_NONBLOCK", 0)
        )
    except OSError:
        return False
    status = os.fstat(descriptor)
    if not stat.S_ISREG(status.st_mode) or not _is_ours(status) or (_has_modes() and status.st_mode & 0o022):
        os.close(descriptor)
        return False
    with os.fdopen(descriptor, "rb") as file:
        content = file.read()
    return len(content) > DIGEST and hashlib.sha256(content[:-DIGEST]).digest() == content[-DIGEST:]


def _build(folder: Path, entry: Path, build: Build) -> None:
    place = Path(tempfile.mkdtemp(prefix=".build-", dir=folder))  # mkdtemp makes it private
    try:
        library = place / "library.so"
        build(place, library)
        content = library.read_bytes()
        sealed = place / "sealed"
        with open(os.open(sealed, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
            file.write(content + hashlib.sha256(content).digest())
            file.flush()
            os.fsync(file.fileno())
        if entry.is_dir() and not entry.is_symlink():
            shutil.rmtree(entry)
        os.replace(sealed, entry)
    finally:
        shutil.rmtree(place, ignore_errors=True)


@contextlib.contextmanager
def _one_builder(folder: Path) -> Iterator[None]:
    """One build at a time in a folder; the lock lies on the folder itself and ends with the process that holds it."""
    if fcntl is None:
        yield
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


@functools.cache
def _own_folder() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="modelgen-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _is_ours(status: os.stat_result) -> bool:
    return not hasattr(os, "geteuid") or status.st_uid == os.geteuid()


def _has_modes() -> bool:
    return os.name == "posix"
