"""The figures of an answer: what is kept of it, how it is written, and what differs.

JSON is kept whole. A table is kept by its number of rows, the least, largest, mean and root mean square of every column, and,
where ``rows`` are asked for, by some rows evenly apart. Figures are compared per largest magnitude of their kind, so that one
that is zero but for rounding does not trip. Left out: seconds, versions, paths, digests, and counts of steps.
"""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

LEFT_OUT = re.compile(
    r"wall|second|\bsteps?\b|evaluation|tools|files|sha256|version|modelgen|source$|command|digest|fingerprint|residual|^gap$"
    r"|remarks?$|citation|measured_on|title|note|away|rejected|^measurement$|^finding$|^case$|sum_less"
)
"""Keys and columns that say nothing about the model, depend on the machine, or are differences of nearly equal figures."""
FLOORS = (
    (re.compile(r"differences\b|relative|worst_|multiplier|real part|imaginary part|size \[1\]|share|ratio"), 1.0),
    (re.compile(r"phase|_deg$"), 1.0),
)
"""The least magnitude that a kind of figure is compared by: a multiplier by 1, where a motion is stable."""
ROWS, LONG_LIST, LONG_TEXT = 7, 16, 60
TURN = 360.0
MEASURES = ("least", "largest", "mean", "root mean square")
NUMBER = re.compile(r"(?<![A-Za-z_0-9])-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?(?![A-Za-z_0-9])")
KEPT_FILES = re.compile(r"(?!job|points|record).*\.(json|csv)")

Row = dict[str, Any]


def figures_of(printed: str, out: Path, words: bool) -> Row:
    """All that is kept of an answer, with whole tables still."""
    found: Row = {"printed": printed.splitlines()} if words else {}
    files = sorted(path for path in out.iterdir() if KEPT_FILES.fullmatch(path.name)) if out.is_dir() else []
    found["data"] = {path.name: _kept(json.loads(path.read_text("utf-8"))) for path in files if path.suffix == ".json"}
    found["tables"] = {path.name: _table(path) for path in files if path.suffix == ".csv"}
    assert words or found["data"] or found["tables"], f"an answer without figures: {out}"
    return found


def _kept(value: Any) -> Any:
    """JSON without what is left out; a long list of numbers is kept by its summary and some of its entries."""
    if isinstance(value, dict):
        kept = {key: _kept(each) for key, each in value.items() if not LEFT_OUT.search(key)}
        return {key: each for key, each in kept.items() if not (isinstance(each, str) and len(each) > LONG_TEXT)}
    if isinstance(value, list):
        if len(value) > LONG_LIST and all(_is_number(each) for each in value):
            return {"count": len(value), "summary": summary(value), "some": some(value)}
        if len(value) > LONG_LIST and all(isinstance(each, dict) for each in value):
            keys = dict.fromkeys(key for each in value for key in each)
            numbers = {key: [each[key] for each in value if _is_number(each.get(key))] for key in keys}
            summaries = {key: summary(each) for key, each in numbers.items() if each and not LEFT_OUT.search(key)}
            return {"count": len(value), "columns": summaries, "some": [_kept(each) for each in some(value)]}
        return [_kept(each) for each in value]
    return value


def _table(path: Path) -> Row:
    """Columns by name; cells are numbers where every cell of the column is one, or empty."""
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = list(csv.reader(file))
    columns: Row = {}
    for k, name in enumerate(header):
        cells = [row[k] for row in rows]
        with_numbers = [_number(cell) for cell in cells]
        numeric = all(number is not None or not cell for number, cell in zip(with_numbers, cells, strict=True))
        if not LEFT_OUT.search(name):
            columns[name] = with_numbers if numeric else cells
    return {"rows": len(rows), "columns": columns}


def _number(cell: str) -> float | None:
    try:
        number = float(cell)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def summary(values: list[Any]) -> list[float]:
    """Least, largest, mean, root mean square."""
    numbers = [float(each) for each in values if each is not None]
    if not numbers:
        return []
    count = len(numbers)
    return [min(numbers), max(numbers), math.fsum(numbers) / count, math.sqrt(math.fsum(x * x for x in numbers) / count)]


def write(found: Row, folder: Path, name: str, rows: bool) -> None:
    """``name``.json, and where ``rows`` are asked for one CSV file for every table."""
    digest = {**found, "tables": {key: _digest(table) for key, table in found["tables"].items()}}
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps({key: each for key, each in digest.items() if each}, indent=0, ensure_ascii=False, separators=(",", ":"))
    text = re.sub(r"\n(?=[-\d\]n])|(?<=\[)\n", "", text)  # numbers of a list stand on one line
    (folder / f"{name}.json").write_text(text + "\n", encoding="utf-8")
    for key, table in found["tables"].items() if rows else ():
        with (folder / f"{name}.{key}").open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(table["columns"])
            writer.writerows(zip(*(some(values) for values in table["columns"].values()), strict=True))


def some(values: list[Any]) -> list[Any]:
    """At most seven entries, evenly apart."""
    return values[:: max(1, -(-len(values) // ROWS))]


def _digest(table: Row) -> Row:
    columns = {name: summary(values) for name, values in table["columns"].items() if _is_numeric(values)}
    return {"rows": table["rows"], "columns": columns}


def _is_numeric(values: list[Any]) -> bool:
    return not any(isinstance(each, str) for each in values)


def differences(found: Row, folder: Path, name: str, within: float) -> Iterator[str]:
    """One line for every figure that is not the kept one; new keys and columns are no difference."""
    kept = json.loads((folder / f"{name}.json").read_text("utf-8"))
    if "printed" in kept:
        yield from _words("\n".join(kept["printed"]), "\n".join(found["printed"]), within)
    for file, data in kept.get("data", {}).items():
        if file not in found["data"]:
            yield f"{file}: is no longer written"
            continue
        scales: dict[Any, float] = {}
        _collect_scales(data, (), scales)
        yield from _compare(data, found["data"][file], (file,), (), scales, within)
    for file, digest in kept.get("tables", {}).items():
        if file not in found["tables"]:
            yield f"{file}: is no longer written"
            continue
        yield from _compare_table(file, digest, found["tables"][file], folder / f"{name}.{file}", within)


def _words(kept: str, found: str, within: float) -> Iterator[str]:
    """Texts agree word by word, and number by number within a tolerance."""
    for line, (old, new) in enumerate(zip(kept.splitlines(), found.splitlines(), strict=False), 1):
        if NUMBER.sub("#", old) != NUMBER.sub("#", new):
            yield f"line {line} was {old!r} and is {new!r}"
            return
        for was, now in zip(NUMBER.findall(old), NUMBER.findall(new), strict=True):
            if abs(float(was) - float(now)) > within * max(1.0, abs(float(was))):
                yield f"line {line}: {was} is now {now}"
    if len(kept.splitlines()) != len(found.splitlines()):
        yield f"{len(kept.splitlines())} lines were printed, and now {len(found.splitlines())}"


def _kind(path: tuple[str, ...], holder: Any) -> tuple[Any, ...]:
    """What a figure is compared with: others under the same first and last key, of the same quantity and unit."""
    middle = tuple(re.sub(r"^[^.]*\.", "", key) for key in path[1:-1] if "." in key)
    told = holder if isinstance(holder, dict) else {}
    named = [str(told[key]) for key in ("unit", "quantity", "parameter") if key in told]
    last = "value" if named and path[-1] in ("value", "limit", "limits", "half_pp", "margin") else path[-1] if path else ""
    return (path[:1], middle, last, *named)


def _collect_scales(value: Any, path: tuple[str, ...], scales: dict[Any, float], holder: Any = None) -> None:
    if isinstance(value, dict):
        for key, each in value.items():
            _collect_scales(each, path if key in ("summary", "columns", "some") else (*path, key), scales, value)
    elif isinstance(value, list):
        for each in value:
            _collect_scales(each, path, scales, holder)
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        kind = _kind(path, holder)
        scales[kind] = max(scales.get(kind, 0.0), abs(value))


def _compare(
    old: Any, new: Any, shown: tuple[str, ...], path: tuple[str, ...], scales: dict[Any, float], within: float, holder: Any = None
) -> Iterator[str]:
    where = " > ".join(shown)
    if isinstance(old, dict) and isinstance(new, dict):
        for key, each in old.items():
            if key not in new:
                yield f"{where}: {key!r} is missing"
                continue
            deeper = path if key in ("summary", "columns", "some") else (*path, key)
            yield from _compare(each, new[key], (*shown, key), deeper, scales, within, old)
    elif isinstance(old, list) and isinstance(new, list):
        if len(old) != len(new):
            yield f"{where}: held {len(old)} entries, and now {len(new)}"
            return
        for k, (was, now) in enumerate(zip(old, new, strict=True)):
            yield from _compare(was, now, (*shown, str(k)), path, scales, within, holder)
    elif _is_number(old) and _is_number(new):
        largest = _floored(" ".join(path), scales.get(_kind(path, holder), 0.0))
        yield from _difference(where, old, new, largest, within)
    elif old != new:
        yield f"{where}: was {old!r} and is {new!r}"


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _floored(name: str, largest: float) -> float:
    return max([largest, *(floor for pattern, floor in FLOORS if pattern.search(name))])


def _difference(where: str, old: float, new: float, largest: float, within: float, angle: bool = False) -> Iterator[str]:
    apart = abs(new - old)
    if angle:
        apart = min(apart % TURN, -apart % TURN)
    if not apart <= within * largest:
        yield f"{where}: was {old!r} and is {new!r}, {apart / largest if largest else apart:.1e} of the largest apart"


def _compare_table(file: str, digest: Row, table: Row, rows: Path, within: float) -> Iterator[str]:
    if table["rows"] != digest["rows"]:
        yield f"{file}: had {digest['rows']} rows, and now {table['rows']}"
        return
    largest: dict[str, float] = {}
    for name, (*found,) in digest["columns"].items():
        kind = _column_kind(name)
        largest[kind] = max([largest.get(kind, 0.0), *map(abs, found)])
    for name, was in digest["columns"].items():
        if name not in table["columns"]:
            yield f"{file}: column {name!r} is missing"
            continue
        scale = _floored(name, largest[_column_kind(name)])
        if "phase" in name:
            continue  # where there is no amplitude there is no phase either: rows are looked at one by one
        now = summary(table["columns"][name])
        if len(was) != len(now):
            yield f"{file}, {name}: is {'filled' if now else 'empty'} now"
        for what, old, new in zip(MEASURES, was, now, strict=False):
            yield from _difference(f"{file}, {name}, {what}", old, new, scale, within)
    if rows.exists():
        yield from _compare_rows(file, rows, table, largest, within)


def _column_kind(name: str) -> str:
    """The quantity and unit of a column, whatever element and whichever measure of it."""
    return re.sub(r"^[^. ]*\.|\b(mean|0-peak|half p-p|least|largest|lowest|highest)\b|^.*(?=\[W\]| physical| referred)", "", name)


def _compare_rows(file: str, path: Path, table: Row, largest: dict[str, float], within: float) -> Iterator[str]:
    """The kept rows; in a table that mixes units, a cell is compared by the largest in its own unit."""
    kept = _table(path)["columns"]
    new = {name: some(values) for name, values in table["columns"].items()}
    per_unit = _largest_per_unit(table["columns"])
    for name, olds in kept.items():
        for k, old in enumerate(olds):
            now = new[name][k] if name in new else "no column"
            where = f"{file}, {name}, kept row {k + 1}"
            if not (_is_number(old) and _is_number(now)):
                if old != now:
                    yield f"{where}: was {old!r} and is {now!r}"
                continue
            if "phase" in name and "amplitude [unit]" in kept:
                unit = kept["unit"][k]
                if kept["amplitude [unit]"][k] < 1e-6 * per_unit[unit, "amplitude [unit]"]:
                    continue
                yield from _difference(where, old, now, TURN, 1e6 * within, angle=True)
                continue
            scale = largest.get(_column_kind(name), 0.0)
            if "[unit]" in name:
                scale = per_unit[kept["unit"][k], name] if "slope" not in name else scale
            yield from _difference(where, old, now, _floored(name, scale), within)


def _largest_per_unit(columns: Row) -> dict[tuple[str, str], float]:
    largest: dict[tuple[str, str], float] = {}
    for name, values in columns.items():
        if "[unit]" in name and "unit" in columns and _is_numeric(values):
            for unit, value in zip(columns["unit"], values, strict=True):
                largest[unit, name] = max(largest.get((unit, name), 0.0), abs(value or 0.0))
    return largest
