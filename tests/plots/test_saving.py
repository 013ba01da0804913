from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from modelgen.errors import CaseError
from modelgen.plots import backlash, plot, save

SIGNATURES = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}


@pytest.mark.parametrize("ending", SIGNATURES)
def test_formats_are_what_they_say_and_carry_no_date(ending: str, results: Any, tmp_path: Path) -> None:
    files = [save(backlash(results.meshes), tmp_path / f"{index}.{ending}") for index in range(2)]
    data = files[0].read_bytes()
    assert data.startswith(SIGNATURES[ending])
    assert data == files[1].read_bytes()
    assert b"Date>" not in data
    assert b"matplotlib.org" not in data or ending == "svg"  # svg names it in a comment
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(path.name for path in files)


def test_png_has_200_dots_per_inch(results: Any, tmp_path: Path) -> None:
    data = save(backlash(results.meshes), tmp_path / "figure.png").read_bytes()
    assert int.from_bytes(data[16:20], "big") == pytest.approx(16 / 2.54 * 200, abs=1)


def test_threads_do_not_disturb_each_other(results: Any, tmp_path: Path) -> None:
    def run(index: int) -> bytes:
        figure = backlash(results.meshes) if index % 2 else plot(results.modes, count=2)
        return save(figure, tmp_path / f"{index}.png").read_bytes()

    alone = [run(index) for index in range(2)]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(run, range(2, 6))) == alone * 2


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("figure.jpg", r"has the ending '.jpg'; nearest is '.png'"),
        ("figure.sgv", r"has the ending '.sgv'; nearest is '.svg'"),
        ("figure", r"has the ending ''; known are .png, .pdf, .svg"),
        ("no_folder/figure.png", r"cannot be written \(No such file or directory\); choose a folder"),
    ],
)
def test_wrong_path_is_refused(name: str, words: str, results: Any, tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=words):
        save(backlash(results.meshes), tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_failed_save_leaves_what_was_there(results: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = save(backlash(results.meshes), tmp_path / "figure.png")
    before = path.read_bytes()

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Figure, "savefig", full)
    with pytest.raises(CaseError, match=r"cannot be written \(No space left on device\)"):
        save(backlash(results.meshes), path)
    assert path.read_bytes() == before
    assert [each.name for each in tmp_path.iterdir()] == ["figure.png"]


def test_only_figures_are_saved(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"is given a str; give what plot\(\) or draw\(\) returns"):
        save("a figure", tmp_path / "figure.png")  # type: ignore[arg-type]
