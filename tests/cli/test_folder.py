"""The output folder: whole or not at all, and never at the cost of somebody else's files."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from modelgen.errors import CaseError
from modelgen.reports import results
from modelgen.reports.folder import output_folder

from .conftest import Invoke


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """The folder of an earlier run."""
    folder = tmp_path / "old"
    (folder / "figures").mkdir(parents=True)
    (folder / "report.md").write_text("old", encoding="utf-8")
    (folder / "figures" / "angles.png").write_text("old", encoding="utf-8")
    return folder


def everything(folder: Path) -> dict[str, str]:
    files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {str(path.relative_to(folder)): path.read_text(encoding="utf-8") for path in files}


def write(folder: Path, replace: bool = False) -> None:
    with output_folder(folder, replace) as temporary:
        assert temporary.parent == folder.parent
        (temporary / "report.md").write_text("new", encoding="utf-8")


def test_a_new_folder_and_its_parents(tmp_path: Path) -> None:
    write(tmp_path / "a" / "b")
    assert everything(tmp_path) == {"a/b/report.md": "new"}


def test_an_empty_folder_is_used(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    write(tmp_path / "empty")
    assert everything(tmp_path) == {"empty/report.md": "new"}


def test_a_full_folder_is_refused(old: Path, tmp_path: Path) -> None:
    before = everything(tmp_path)
    with pytest.raises(CaseError, match="exists and is not empty; take --replace"):
        write(old)
    assert everything(tmp_path) == before


def test_an_old_run_is_replaced_whole(old: Path, tmp_path: Path) -> None:
    write(old, replace=True)
    assert everything(tmp_path) == {"old/report.md": "new"}


@pytest.mark.parametrize("name", ["thesis.doc", "figures/photo.jpg", ".git"])
def test_foreign_files_are_nobodys_to_replace(old: Path, tmp_path: Path, name: str) -> None:
    (old / name).write_text("mine", encoding="utf-8")
    before = everything(tmp_path)
    with pytest.raises(CaseError, match=f"holds '{name}', which modelgen did not write"):
        write(old, replace=True)
    assert everything(tmp_path) == before


def test_foreign_files_that_come_during_the_run(old: Path, tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"holds 'notes.txt'"), output_folder(old, replace=True):
        (old / "notes.txt").write_text("mine", encoding="utf-8")
    assert sorted(everything(tmp_path)) == ["old/figures/angles.png", "old/notes.txt", "old/report.md"]


def test_a_link_is_followed(old: Path, tmp_path: Path) -> None:
    link = tmp_path / "link"
    link.symlink_to(old, target_is_directory=True)
    write(link, replace=True)
    assert link.is_symlink()
    assert everything(old) == {"report.md": "new"}


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    with pytest.raises(CaseError, match="is a file; name a folder"):
        write(tmp_path / "file", replace=True)
    with pytest.raises(CaseError, match="check the path"):
        write(tmp_path / "file" / "below")
    assert everything(tmp_path) == {"file": "mine"}


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may write everywhere")
def test_a_place_where_nothing_can_be_written(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(CaseError, match="cannot be written: Permission denied"):
        write(tmp_path / "out")


def fail_halfway(folder: Path, failure: type[BaseException]) -> None:
    (folder / "report.md").write_text("half", encoding="utf-8")
    raise failure


@pytest.mark.parametrize("failure", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_a_failure_leaves_what_was_there(old: Path, tmp_path: Path, failure: type[BaseException]) -> None:
    before = everything(tmp_path)
    for target, replace in ((old, True), (tmp_path / "new" / "deep", False)):
        with pytest.raises(failure), output_folder(target, replace) as temporary:
            fail_halfway(temporary, failure)
    assert everything(tmp_path) == before
    assert list(tmp_path.iterdir()) == [old]


def test_a_disk_that_is_full(old: Path, tmp_path: Path) -> None:
    before = everything(tmp_path)
    with pytest.raises(CaseError, match="No space left on device; check the path"), output_folder(old, replace=True):
        raise OSError(28, "No space left on device")
    assert everything(tmp_path) == before


def test_a_run_whose_computing_time_is_up(invoke: Invoke, small: Path, old: Path, tmp_path: Path) -> None:
    """The simulation fails midway: exit code 1, its sentence, and the old folder as it was."""
    before = everything(tmp_path)
    result = invoke("run", small, "--out", old, "--replace", "--crosscheck", "none", "--max-seconds", "1e-3")
    assert result.exit_code == 1
    assert result.stderr.splitlines()[-1].startswith("modelgen: run of 'small': stopped at t = ")
    assert "s of computing time is used up" in result.stderr
    assert everything(tmp_path) == before


@pytest.mark.parametrize("step", ["write_responses", "draw_figures", "report_text"])
def test_ctrl_c_while_writing(
    invoke: Invoke, small: Path, old: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(results, step, interrupted)
    monkeypatch.setattr(results, "draw_figures", interrupted if step == "draw_figures" else lambda *_: [])
    before = everything(tmp_path)
    short = ("--window", "0 s", "5 ms", "--crosscheck", "none")
    for target in (("--out", old, "--replace"), ("--out", tmp_path / "new")):
        result = invoke("run", small, *short, *target)
        assert result.exit_code == 130
        assert result.stderr.splitlines()[-1] == "modelgen: interrupted; nothing was written"
    assert everything(tmp_path) == before
    assert list(tmp_path.iterdir()) == [old]
