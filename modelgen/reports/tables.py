"""Tables and data on their way out: CSV with units in the header, JSON with units in the keys, aligned lines on the terminal.

Part of ``reports``, below every command that answers with tables.
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

RPM = 30 / math.pi
"""Turns per minute of a speed in rad/s."""


def write_table(path: Path, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """A CSV file. Numbers have nine digits; what does not exist (None, not finite) is an empty cell."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows([_cell(value) for value in row] for row in rows)


def write_data(path: Path, data: dict[str, Any]) -> None:
    """A JSON file; a number that is not finite is null."""
    path.write_text(json.dumps(_plain(data), indent=2, allow_nan=False) + "\n", encoding="utf-8")


def aligned(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Lines with columns of equal width, the first one to the left.

    >>> print(aligned(["mode", "f [Hz]"], [["1", "0"], ["2", "45.2"]]))
    mode  f [Hz]
    1          0
    2       45.2
    """
    table = [header, *rows]
    widths = [max(len(row[k]) for row in table) for k in range(len(header))]
    padded = ([cell.rjust(width) for cell, width in zip(row, widths, strict=True)] for row in table)
    return "\n".join("  ".join([row[0].ljust(widths[0]), *cells[1:]]).rstrip() for row, cells in zip(table, padded, strict=True))


def _cell(value: Any) -> Any:
    if isinstance(value, float):
        return f"{float(value):.9g}" if math.isfinite(value) else ""
    return "" if value is None else value


def _plain(value: Any) -> Any:
    """Data as JSON has them."""
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value
