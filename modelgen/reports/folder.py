"""The output folder of a run: whole or not at all, and never at the cost of somebody else's files.

Part of ``reports``. Everything is written into a temporary sibling, which takes the folder's name by one rename at the end; until
then the old folder stands untouched, and after a failure or Ctrl-C nothing new stands there.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from modelgen.errors import CaseError

WRITTEN = (
    *("report.md", "equations.md", "equations.tex", "model.toml", "responses.csv", "summary.json", "paper.md", "figures"),
    *("crosscheck.csv", "crosscheck.json", "crosscheck.png"),
    *("modal.csv", "energy.csv", "sensitivities.csv", "modal.json", "modes.png", "energy.png", "sensitivities.png"),
    *("campbell.csv", "critical_speeds.csv", "campbell.json", "campbell.png"),
    *("forced.csv", "orders.csv", "power.csv", "gears.csv", "forced.json", "forced.png", "power.png", "gears.png"),
    *("exponents.csv", "exponents.json", "exponents.png", "multipliers.csv", "orbit_start.csv", "orbit.json", "multipliers.png"),
    *("limits.csv", "limits.json", "limits.png", "comparison.csv", "comparison.json", "comparison.png"),
    *("referee.csv", "referee.json", "referee.png"),
)
"""What modelgen writes; a folder that holds anything else is nobody's to replace."""


@contextmanager
def output_folder(out: Path, replace: bool, written: Collection[str] = WRITTEN) -> Iterator[Path]:
    """A temporary folder to write into, which becomes ``out`` if the block ends well.

    ``written``: names of what modelgen writes there.

    Raises CaseError for a folder that may not be replaced, before anything is computed, and again at the end.
    """
    where = f"output folder {str(out)!r}"
    target = Path(os.path.realpath(out))
    refuse_unless_free(target, replace, where, written)
    made = _missing_parents(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(prefix=f".{target.name[:60]}.", dir=target.parent))
    except OSError as error:
        raise CaseError(where, f"cannot be written: {error.strerror}", "check the path and its permissions") from None
    try:
        yield temporary
        refuse_unless_free(target, replace, where, written)
        _take_name(temporary, target)
    except OSError as error:
        remedy = "check the path, its permissions and the free space"
        raise CaseError(where, f"cannot be written: {error.strerror or error}", remedy) from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
        for folder in made:
            with suppress(OSError):
                folder.rmdir()  # only the empty ones, that is after a failure


def refuse_unless_free(target: Path, replace: bool, where: str, written: Collection[str] = WRITTEN) -> None:
    """Raises CaseError unless the folder is missing, empty, or may be replaced because a run wrote all of it."""
    try:
        held = sorted(entry.name for entry in target.iterdir()) if target.exists() else []
        figures = target / "figures"
        held += sorted(f"figures/{each.name}" for each in figures.iterdir()) if figures.is_dir() else []
    except NotADirectoryError:
        raise CaseError(where, "is a file", "name a folder") from None
    except OSError as error:
        raise CaseError(where, f"cannot be read: {error.strerror}", "check the path and its permissions") from None
    if not held:
        return
    if not replace:
        raise CaseError(where, "exists and is not empty", "take --replace, or name another folder")
    foreign = [name for name in held if not _is_ours(target / name, name, written)]
    if foreign:
        raise CaseError(where, f"holds {foreign[0]!r}, which modelgen did not write", "move it away, or name another folder")


def _is_ours(entry: Path, name: str, written: Collection[str]) -> bool:
    """Whether modelgen writes such an entry: a plain file of a known name or figure, or the folder of figures; never a link."""
    if name == "figures":
        return name in written and entry.is_dir() and not entry.is_symlink()
    known = name in written or (name.startswith("figures/") and name.endswith(".png"))
    return known and entry.is_file() and not entry.is_symlink()


def _missing_parents(target: Path) -> list[Path]:
    """Parents that do not exist yet, the innermost first."""
    return [parent for parent in target.parents if not os.path.exists(parent)]


def _take_name(temporary: Path, target: Path) -> None:
    """Gives the temporary folder its name; an old folder of that name steps aside first and goes last."""
    temporary.chmod(0o777 & ~_umask())
    if not target.exists():
        temporary.rename(target)
        return
    aside = temporary.with_name(f"{temporary.name}.old")
    target.rename(aside)
    try:
        temporary.rename(target)
    except BaseException:
        aside.rename(target)
        raise
    shutil.rmtree(aside, ignore_errors=True)


def _umask() -> int:
    """The mask of new files; it can only be read by setting it. Temporary folders are made for their owner alone."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
