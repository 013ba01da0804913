"""Tables as instruments, spreadsheets and vendors write them: text with a header, units in it, and separators of either kind.

Part of ``exchange``, the border where foreign tables come in; measurements and mass-elastic tables are read through it. Follows
RFC 4180 as far as real files do: separators ``,`` ``;`` or a tab, a decimal comma only with the latter two, quotes, a byte order
mark, comment lines from ``#``. Every refusal names file, line and column.
"""

from __future__ import annotations

import csv
import difflib
import re
import stat
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from modelgen.errors import ModelFileError, UnitError, nearest
from modelgen.units import to_si

LARGEST_FILE = 256 * 1024 * 1024
_HEAD = re.compile(r"\s*(.*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\s*")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
NEAR = 0.75
"""How alike (0 to 1) the name of an unknown column may be to a known one before it counts as a slip of the pen."""


@dataclass(frozen=True)
class Column:
    """A column: its name and unit text as the header gives them, and its place, counted from 1."""

    name: str
    unit: str
    place: int


@dataclass(frozen=True)
class Row:
    """A row: the line it stands on, counted from 1, and its cells."""

    line: int
    cells: tuple[str, ...]


@dataclass(frozen=True)
class DelimitedText:
    """A table of texts that knows where each of them stands."""

    source: str
    separator: str
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]
    header_line: int

    def at(self, row: Row | None, column: Column | None = None) -> str:
        """File, line and column for a message; the header where ``row`` is None."""
        line = self.header_line if row is None else row.line
        return f"{self.source}, line {line}" + (f", column {column.name!r}" if column else "")

    def cell(self, row: Row, column: Column) -> str:
        """The text of a cell, empty where the row is shorter than the header."""
        return row.cells[column.place - 1].strip() if column.place <= len(row.cells) else ""

    def number(self, row: Row, column: Column) -> float:
        """The number in a cell, in the column's own unit. Raises ModelFileError for anything else, an empty cell too."""
        text = self.cell(row, column)
        plain = text.replace(",", ".") if self.separator != "," and text.count(",") == 1 and "." not in text else text
        if not _NUMBER.fullmatch(plain):
            what = f"{text[:40]!r} is not a number" if text else "is empty"
            raise ModelFileError(self.at(row, column), what, self._advice(text))
        value = float(plain)
        if value in (float("inf"), float("-inf")):
            raise ModelFileError(self.at(row, column), f"{text[:40]!r} is out of range", "give a number between -1e308 and 1e308")
        return value

    def _advice(self, text: str) -> str:
        if not text:
            return "give a number, or take the row out"
        if re.fullmatch(r"[+-]?\d{1,3}([., ]\d{3})*[.,]?\d*", text):
            return "write it without separators of thousands, with one decimal sign"
        if re.match(r"[+-]?[\d.,]+\s*[A-Za-z]", text):
            return "write the unit in the header, as in J [kg*m^2], and numbers below it"
        return "write a number such as 1.5 or 1.5e-3" + (", with ; between the cells also 1,5" if self.separator == "," else "")

    def factor(self, column: Column, declared: str) -> float:
        """What the numbers of a column are multiplied by to be in the declared SI unit. Raises UnitError."""
        if not column.unit and declared != "1":
            raise UnitError(self.at(None, column), "the header names no unit", f"write it as {column.name} [{declared}]")
        return to_si(1.0, column.unit or "1", declared, self.at(None, column))


def read_delimited(path: str | Path) -> DelimitedText:
    """The table in a file. Raises ModelFileError for a file that is none."""
    path = Path(path)
    try:
        # A pipe or a device could be endless, or wait for ever.
        if not stat.S_ISREG(path.stat().st_mode):
            raise ModelFileError(str(path), "is no file", "give a table as text (CSV)")
        with path.open("rb") as file:
            raw = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise ModelFileError(str(path), f"cannot be read: {error.strerror}", "check the path") from None
    if len(raw) > LARGEST_FILE:
        raise ModelFileError(str(path), f"has more than {LARGEST_FILE} bytes", "take out the part that is wanted")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ModelFileError(str(path), f"is not UTF-8 text at byte {error.start}", "save it as CSV in UTF-8") from None
    return parse_delimited(text, str(path))


def parse_delimited(text: str, source: str = "table") -> DelimitedText:
    """The table in a text; ``source`` opens the error messages."""
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip(" \t,;")]
    kept = [(number, line) for number, line in lines if not line.lstrip().startswith("#")]
    if not kept:
        raise ModelFileError(source, "is empty", "write a header such as name; J [kg*m^2]; k [N*m/rad], and rows below it")
    header_line, header = kept[0]
    separator = max(";\t,", key=header.count)
    records = list(_records(kept, separator, source))
    columns = tuple(_column(name, place) for place, name in enumerate(records[0].cells, 1) if name.strip())
    names = [column.name.lower() for column in columns]
    for column in columns:
        if names.count(column.name.lower()) > 1:
            raise ModelFileError(f"{source}, line {header_line}", f"has two columns {column.name!r}", "rename one of them")
    width = len(records[0].cells)
    for row in records[1:]:
        if any(cell.strip() for cell in row.cells[width:]):
            what = f"has {len(row.cells)} cells, the header has {width}"
            advice = "a decimal comma needs ; between the cells" if separator == "," else "check the separators"
            raise ModelFileError(f"{source}, line {row.line}", what, advice)
    if len(records) == 1:
        raise ModelFileError(source, "has a header but no rows", "write one row for each entry")
    return DelimitedText(source, separator, columns, tuple(records[1:]), header_line)


def find_columns(table: DelimitedText, known: Mapping[str, Iterable[str]]) -> dict[str, Column]:
    """Columns by key of ``known``, which lists further names for each; capitals and underscores do not count.

    Makers' tables have further columns ("No", "Remarks"): they are left out (``further_columns`` names them). Raises
    ModelFileError for one whose name is nearly a known one, and for one that is there twice.
    """
    keys = {_folded(name): key for key, names in known.items() for name in (key, *names)}
    found: dict[str, Column] = {}
    for column in table.columns:
        key = keys.get(_folded(column.name))
        if key is None:
            if difflib.get_close_matches(_folded(column.name), keys, n=1, cutoff=NEAR):
                raise ModelFileError(table.at(None, column), "is no known column", nearest(column.name, sorted(keys)))
            continue
        if key in found:
            raise ModelFileError(table.at(None, column), f"is the same as {found[key].name!r}", "take one of them out")
        found[key] = column
    return found


def further_columns(table: DelimitedText, found: Mapping[str, Column]) -> tuple[str, ...]:
    """Names of the columns that are not read."""
    read = {column.place for column in found.values()}
    return tuple(column.name for column in table.columns if column.place not in read)


def _folded(name: str) -> str:
    return re.sub(r"[\s_]+", " ", name.strip().lower())


def _column(head: str, place: int) -> Column:
    match = _HEAD.fullmatch(head)
    assert match is not None  # the pattern takes any text
    return Column(match[1], match[2] or "", place)


def _records(kept: list[tuple[int, str]], separator: str, source: str) -> Iterator[Row]:
    for number, line in kept:
        try:
            cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True))
        except (csv.Error, StopIteration) as error:
            where = f"{source}, line {number}"
            raise ModelFileError(where, f"cannot be read: {error}", "close every quote on its line") from None
        yield Row(number, tuple(cells))
