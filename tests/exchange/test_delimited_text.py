"""Delimited text as real files have it, and the words that say where a bad one is bad."""

from __future__ import annotations

from pathlib import Path

import pytest

from modelgen.errors import ModelFileError, UnitError
from modelgen.exchange.delimited_text import find_columns, parse_delimited, read_delimited
from modelgen.units import written_out


@pytest.mark.parametrize(
    "text",
    [
        "name,J [kg*m^2]\na,1.5\nb,2\n",
        "name;J [kg*m^2]\na;1,5\nb;2\n",
        "name;J (kg*m^2)\r\na;1.5\r\n;\r\nb;2,0\r\n",
        "# from the maker\nname\tJ [kg*m^2]\n\na\t1,5\n  # half a line\nb\t2\n",
        '"name","J [kg*m^2]"\n"a", "1.5"\n"b", "2"\n',
    ],
)
def test_every_dialect_gives_the_same_table(text: str) -> None:
    table = parse_delimited(text)
    name, inertia = table.columns
    assert (name.name, inertia.name, inertia.unit) == ("name", "J", "kg*m^2")
    assert [table.cell(row, name) for row in table.rows] == ["a", "b"]
    assert [table.number(row, inertia) for row in table.rows] == [1.5, 2.0]


def test_a_byte_order_mark_does_not_hide_the_first_column(tmp_path: Path) -> None:
    path = tmp_path / "excel.csv"
    path.write_bytes("﻿name;J [kg·m²]\na;1\n".encode())
    assert [column.name for column in read_delimited(path).columns] == ["name", "J"]


@pytest.mark.parametrize(
    ("written", "plain"),
    [
        ("MNm/rad", "MN*m/rad"),
        ("kg·m²", "kg*m^2"),
        ("kgm2", "kg*m^2"),
        ("N·m·s/rad", "N*m*s/rad"),
        ("Nms", "N*m*s"),
        ("°", "deg"),
    ],
)
def test_units_as_people_write_them(written: str, plain: str) -> None:
    assert written_out(written) == plain


def test_a_unit_scales_its_column() -> None:
    table = parse_delimited("k [MNm/rad]\n9,775\n".replace(",", "."))
    (column,), (row,) = table.columns, table.rows
    assert table.factor(column, "N*m/rad") * table.number(row, column) == pytest.approx(9.775e6, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "table: is empty; write a header"),
        ("# only words\n", "table: is empty"),
        ("name,J [kg*m^2]\n", "has a header but no rows"),
        ("name,J\na,1,5\n", "line 2: has 3 cells, the header has 2; a decimal comma needs ; between the cells"),
        ("name;J\na;1;2\n", "line 2: has 3 cells, the header has 2; check the separators"),
        ("name,name\na,1\n", "line 1: has two columns 'name'; rename one of them"),
        ('name,J\n"a,1\n', "line 2: cannot be read: .*; close every quote"),
    ],
)
def test_a_text_that_is_no_table(text: str, words: str) -> None:
    with pytest.raises(ModelFileError, match=words):
        parse_delimited(text)


@pytest.mark.parametrize(
    ("cell", "words"),
    [
        ("x", "line 3, column 'J': 'x' is not a number; write a number such as 1.5"),
        ("", "line 3, column 'J': is empty; give a number"),
        ("nan", "'nan' is not a number"),
        ("1_000", "'1_000' is not a number"),
        ("1.234,5", "'1.234,5' is not a number; write it without separators of thousands"),
        ("3 kg*m^2", r"'3 kg\*m\^2' is not a number; write the unit in the header"),
        ("1e999", "'1e999' is out of range"),
    ],
)
def test_a_cell_that_is_no_number(cell: str, words: str) -> None:
    table = parse_delimited(f"# head\nname;J\na;{cell}\n")
    with pytest.raises(ModelFileError, match=words):
        table.number(table.rows[0], table.columns[1])


def test_a_column_without_its_unit_is_refused() -> None:
    table = parse_delimited("J\n1\n")
    with pytest.raises(UnitError, match=r"line 1, column 'J': the header names no unit; write it as J \[kg\*m\^2\]"):
        table.factor(table.columns[0], "kg*m^2")


def test_columns_are_found_by_any_of_their_names() -> None:
    known = {"k": ("torsional stiffness",), "J": ("inertia",)}
    assert find_columns(parse_delimited("Torsional_Stiffness [N*m/rad],INERTIA\n1,2\n"), known).keys() == {"k", "J"}
    with pytest.raises(ModelFileError, match="column 'inertai': is no known column; nearest is 'inertia'"):
        find_columns(parse_delimited("inertai\n1\n"), known)
    with pytest.raises(ModelFileError, match="column 'inertia': is the same as 'J'"):
        find_columns(parse_delimited("J,inertia\n1,2\n"), known)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(ModelFileError, match=r"none.csv: cannot be read: No such file"):
        read_delimited(tmp_path / "none.csv")
    with pytest.raises(ModelFileError, match="is no file"):
        read_delimited(tmp_path)
    (tmp_path / "latin.csv").write_bytes("name;J [kg·m²]\na;1".encode("latin-1"))
    with pytest.raises(ModelFileError, match="is not UTF-8 text at byte 10; save it as CSV in UTF-8"):
        read_delimited(tmp_path / "latin.csv")
