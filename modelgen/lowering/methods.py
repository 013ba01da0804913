"""Where the tables of explicit methods are found, and how one is read: in the package, and in folders of the user.

Part of ``lowering``, on ``tableau`` and ``rooted_trees``. A file NAME.toml in a folder that the environment variable
``MODELGEN_METHODS`` lists is a method like those of the package: for virtual machine, C and lanes, in cross-checks and in every
command. It holds numbers only; none is believed before its order conditions hold.
"""

from __future__ import annotations

import functools
import os
import re
import tomllib
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

from modelgen.errors import LoweringError, nearest
from modelgen.lowering.rooted_trees import check_orders
from modelgen.lowering.tableau import ONE, ZERO, Row, Tableau

FOLDER = Path(__file__).parent / "tableaus"
VARIABLE = "MODELGEN_METHODS"
HIGHEST_ORDER, MOST_STAGES = 10, 40
MOST_POWERS = 7  # of theta in a dense output on which events are located
_NUMBER = re.compile(r"[+-]?(\d{1,200}/\d{1,200}|\d{0,200}\.?\d{0,200}([eE][+-]?\d{1,3})?)")
_KEYS = {
    **dict.fromkeys(("name", "description"), str),
    **dict.fromkeys(("order", "dense_order"), int),
    **dict.fromkeys(("c", "a", "b", "errors", "error_orders", "dense", "extra_c", "extra_a"), list),
    "locates_events": bool,
    "crosscheck_tolerance": float,
}
_NEEDED = ("name", "order", "c", "a", "b")


def method_files() -> dict[str, Path]:
    """The file of every method by its name, those of the package first.

    Raises LoweringError for a folder of ``MODELGEN_METHODS`` that is none, and for a name that stands twice.
    """
    files = dict(package_files())
    for text in filter(None, os.environ.get(VARIABLE, "").split(os.pathsep)):
        folder = Path(text).expanduser()
        if not folder.is_dir():
            raise LoweringError(f"${VARIABLE}", f"{text[:200]!r} is no folder", "list folders with files NAME.toml")
        for path in sorted(folder.glob("*.toml")):
            if path.stem in files and not path.samefile(files[path.stem]):
                what = f"the name {path.stem!r} belongs to {_where(files[path.stem])}"
                raise LoweringError(f"method file {str(path)!r}", what, "give the file another name")
            files[path.stem] = path
    return files


def read_tableau(name: str) -> Tableau:
    """The method of a name. Raises LoweringError for an unknown name, a file out of shape, and one of a lower order than it says.

    >>> method = read_tableau("rk4")
    >>> method.order, [str(weight) for weight in method.b]
    (4, ['1/6', '1/3', '1/3', '1/6'])
    """
    if name in package_files():
        return _of_package(name)
    files = method_files()
    if name not in files:
        raise LoweringError("method", f"there is none named {name!r}", nearest(str(name), files))
    path = files[name]
    try:
        state = path.stat()
        return _read(path, state.st_mtime_ns, state.st_size)
    except OSError as error:
        raise LoweringError(f"method file {str(path)!r}", f"cannot be read: {error.strerror}", "check the path") from None


@functools.cache
def package_files() -> Mapping[str, Path]:
    """The files of the package, whose numbers its tests vouch for."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.toml"))}


@functools.cache
def _of_package(name: str) -> Tableau:
    return tableau_from(tomllib.loads(package_files()[name].read_text(encoding="utf-8")))


def _where(path: Path) -> str:
    return "the package" if path.parent == FOLDER else repr(str(path))


@functools.lru_cache(maxsize=64)
def _read(path: Path, changed: int, size: int) -> Tableau:
    where = f"method file {str(path)!r}"
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise LoweringError(where, f"is no TOML file: {str(error)[:160]}", "correct it there") from None
    method = tableau_from(data, where)
    if method.name != path.stem:
        raise LoweringError(where, f"holds the method {method.name!r}", "give the file the name of its method")
    check_orders(method)
    return method


def tableau_from(data: Mapping[str, Any], where: str = "method") -> Tableau:
    """A tableau from the tables of a file: numbers are texts, "35/384" or "0.5".

    A method with an error of its own and without a dense output has Hermite's cubic through both ends of a step.
    Raises LoweringError for what is missing, unknown, or no number, and for a table out of shape.
    """
    _check_keys(data, where)

    def rows(name: str) -> tuple[Row, ...]:
        return tuple(_numbers(row, f"{where}, {name}") for row in data.get(name, ()))

    if data.get("locates_events") and max(map(len, data.get("dense", ())), default=0) > MOST_POWERS:
        what = f"locates events on a dense output with powers above theta^{MOST_POWERS}"
        raise LoweringError(where, what, "leave locates_events = false")
    b, errors, dense = _numbers(data["b"], f"{where}, b"), rows("errors"), rows("dense")
    dense_order = data.get("dense_order", 0)
    if errors and not dense:
        dense, dense_order = _cubic(b), min(3, data["order"])
    found = Tableau(
        name=data["name"],
        description=data.get("description", f"Runge-Kutta of order {data['order']}, a table of the user"),
        order=data["order"],
        c=_numbers(data["c"], f"{where}, c"),
        a=rows("a"),
        b=b,
        errors=errors,
        error_orders=tuple(data.get("error_orders", ())),
        dense=dense,
        dense_order=dense_order,
        extra_c=_numbers(data.get("extra_c", ()), f"{where}, extra_c"),
        extra_a=rows("extra_a"),
        locates_events=data.get("locates_events", False),
        crosscheck_tolerance=float(data.get("crosscheck_tolerance", 1e-8)),
    )
    if found.stages < 2:
        raise LoweringError(where, f"has {found.stages} stage", "give a method of two stages or more")
    return found


def _check_keys(data: Mapping[str, Any], where: str) -> None:
    for key, value in data.items():
        if key not in _KEYS:
            raise LoweringError(where, f"has the key {key!r:.60}", nearest(key, _KEYS))
        kind = _KEYS[key]
        if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
            raise LoweringError(where, f"{key} is {value!r:.60}", f"give a {kind.__name__}")
    for key in _NEEDED:
        if key not in data:
            raise LoweringError(where, f"has no {key}", f"a table needs {', '.join(_NEEDED)}")
    if not data["name"].isidentifier() or len(data["name"]) > 40:
        raise LoweringError(where, f"names the method {data['name']!r:.60}", "give a name of letters, digits and underscores")
    if not 1 <= data["order"] <= HIGHEST_ORDER or len(data["b"]) > MOST_STAGES:
        limits = f"orders 1 to {HIGHEST_ORDER} with at most {MOST_STAGES} stages"
        raise LoweringError(where, f"is of order {data['order']} with {len(data['b'])} stages", f"known are {limits}")
    if not 0 < data.get("crosscheck_tolerance", 1e-8) < 1:
        raise LoweringError(where, f"crosscheck_tolerance is {data['crosscheck_tolerance']!r}", "give a number such as 1e-8")


def _numbers(texts: Any, where: str) -> Row:
    """Exact numbers from texts. Raises LoweringError."""
    if not isinstance(texts, (list, tuple)) or len(texts) > MOST_STAGES + 1:
        raise LoweringError(where, f"is {texts!r:.60}", "give a row of numbers")
    for text in texts:
        if not isinstance(text, str) or not _NUMBER.fullmatch(text.strip()) or not any(each.isdigit() for each in text):
            raise LoweringError(where, f"holds {text!r:.60}", 'give numbers as texts, such as "35/384" or "0.5"')
    try:
        return tuple(Fraction(text.strip()) for text in texts)
    except (ValueError, ZeroDivisionError) as error:
        raise LoweringError(where, f"holds no number: {error!s:.60}", 'give "35/384" or "0.5"') from None


def _cubic(b: Row) -> tuple[Row, ...]:
    """Hermite's cubic through both ends of a step, as weights of all slopes for theta, theta^2, theta^3."""
    rows = [[ZERO, 3 * weight, -2 * weight] for weight in (*b, ZERO)]
    for stage, slope in ((0, (1, -2, 1)), (len(b), (0, -1, 1))):
        rows[stage] = [each + ONE * more for each, more in zip(rows[stage], slope, strict=True)]
    return tuple(map(tuple, rows))
