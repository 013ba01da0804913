"""``modelgen new`` and ``modelgen equivalent``: a maker's table in, the equivalent system out and in again, and refusals."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from modelgen.drivelines import load

from .conftest import Invoke
from .test_refusals import refused

TABLE = "name, J [kg*m^2], k [kN*m/rad], ratio\nengine, 3, 300, 1\nload, 1, , 1\n"


@pytest.fixture
def table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "maker.csv").write_text(TABLE, encoding="utf-8")
    return tmp_path / "maker.csv"


def test_a_model_from_a_table(invoke: Invoke, table: Path) -> None:
    result = invoke("new", "my-train", "--from", table)
    assert result.exit_code == 0, result.output
    frequency = math.sqrt(3e5 * (1 / 3 + 1)) / (2 * math.pi)
    assert f"natural frequencies [Hz]: 0, {frequency:.3f}\nmodel file: my-train.toml\n" in result.stdout
    line = load("my-train.toml")
    assert (line.name, list(line.names)) == ("my-train", ["engine", "load", "engine_to_load"])


def test_a_file_that_exists(invoke: Invoke, table: Path) -> None:
    path = table.with_name("old.toml")
    path.write_text("mine", encoding="utf-8")
    assert "old.toml': exists; take --replace" in refused(invoke("new", "train", "--from", table, "--out", path), 2)
    assert path.read_text(encoding="utf-8") == "mine"
    assert invoke("new", "train", "--from", table, "--out", path, "--replace").exit_code == 0
    assert load(path).name == "train"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("train",), "new 'train': is given no table; name it with --from TABLE.csv"),
        (("train", "--from", "none.csv"), "none.csv"),
        (("my train", "--from", "maker.csv"), "write 'my_train'"),
        (("../train", "--from", "maker.csv"), "starts with '.'"),
        (("train", "--from", "maker.csv", "--out", "train.csv"), "has the ending '.csv'; model files end in .toml"),
        (("train", "--from", "maker.csv", "--out", "no/folder/train.toml"), "cannot be written"),
        (("train", "--from", "wrong.csv"), "line 2, column 'J'"),
    ],
)
def test_a_wrong_request(invoke: Invoke, table: Path, arguments: tuple[str, ...], words: str) -> None:
    table.with_name("wrong.csv").write_text(TABLE.replace(" 3,", " three,"), encoding="utf-8")
    before = sorted(path.name for path in table.parent.iterdir())
    result = invoke("new", *arguments)
    assert words in refused(result, 2)
    assert sorted(path.name for path in table.parent.iterdir()) == before


def test_the_equivalent_system_reads_back(invoke: Invoke, small: Path, tmp_path: Path) -> None:
    out = tmp_path / "small.csv"
    result = invoke("equivalent", small, "--out", out)
    assert result.exit_code == 0, result.output
    assert ["fan", "1.500", "0.500000", "0.3750"] in [line.split() for line in result.stdout.splitlines()]
    again = invoke("new", "small", "--from", out, "--out", tmp_path / "small.toml")
    checked = invoke("check", small).stdout
    frequencies = [line for line in checked.splitlines() if "natural frequencies" in line]
    assert frequencies[0].strip() in again.stdout
    assert "exists; take --replace" in refused(invoke("equivalent", small, "--out", out), 2)
    assert "is a folder" in refused(invoke("equivalent", small, "--out", tmp_path), 2)
