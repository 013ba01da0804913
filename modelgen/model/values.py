"""Values of parameters: what may be given for a number, and how it is read.

Part of the language, beside the declarations that say what is lawful: a number, a text with a unit, the name of a shared
parameter, or a series of those.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from modelgen.errors import ModelError, NamingError, UnitError
from modelgen.model.declarations import Param
from modelgen.model.names import identifier
from modelgen.units import finite, read_quantity

ROW = re.compile(r"(\w+)\[(\d{1,6})\]", re.ASCII)
"""A row of a series, by its name: ``cosine[1]`` is the first."""


@dataclass(frozen=True)
class Shared:
    """A reference to a named parameter of the driveline, which several elements may share."""

    name: str


def read_value(value: Any, param: Param, where: str) -> float | tuple[float, ...] | Shared:
    """SI value of what was given: a number, a text with a unit, the name of a shared parameter, or a series of those."""
    if isinstance(value, Shared):
        return value
    if isinstance(value, str):
        if re.fullmatch(r"[A-Za-z_]\w*", value.strip()):
            return Shared(identifier(value.strip(), where, "parameter"))
        value = read_quantity(value, param.unit, where)
    if param.series:
        if isinstance(value, (int, float)) or not isinstance(value, Iterable):
            raise ModelError(where, f"{value!r} is one number", "give a series of numbers")
        return tuple(check_value(entry, param, f"{where}[{row}]") for row, entry in enumerate(value, 1))
    return check_value(value, param, where)


def check_value(value: Any, param: Param, where: str) -> float:
    """The value as a float, if it is a number within the declared range. Raises ModelError or UnitError."""
    if isinstance(value, str):
        value = read_quantity(value, param.unit, where)
    number = finite(plain_number(value, where, param.unit), where)
    shown = f"is {number:g}" + (f" {param.unit}" if param.unit != "1" else "")
    if param.positive and number <= 0:
        raise ModelError(where, shown, "give a positive value")
    if param.nonnegative and number < 0:
        raise ModelError(where, shown, "give zero or a positive value")
    for limit, beyond, advice in (
        (param.least, param.least is not None and number < param.least, "or more"),
        (param.largest, param.largest is not None and number > param.largest, "or less"),
    ):
        if beyond:
            raise ModelError(where, shown, f"give {limit:g} {advice}")
    if param.integer and not (number == math.floor(number) and abs(number) < 1e9):
        raise ModelError(where, f"is {number:g}", "give a whole number")
    return number


def plain_number(value: Any, where: str, unit: str = "1") -> float:
    """The value as a float. Raises UnitError unless it is one real number."""
    if not isinstance(value, (str, bytes, bool)) and getattr(value, "shape", ()) == ():
        try:
            return float(value)
        except OverflowError:
            raise UnitError(where, "the number is out of range", "give a number between -1e308 and 1e308") from None
        except (TypeError, ValueError):
            pass
    raise UnitError(where, f"{value!r:.60} is not a number", "give a number" + (f" in {unit}" if unit != "1" else ""))


def with_whole_series(changes: Mapping[str, Any], held: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Changes with rows of series put into the series that is held. Raises NamingError for a row that is not there."""
    whole = {key: value for key, value in changes.items() if not ROW.fullmatch(key)}
    for key, value in changes.items():
        if row := ROW.fullmatch(key):
            series = whole.get(row[1], held.get(row[1]))
            if isinstance(series, Shared):
                remedy = f"change {series.name}[{row[2]}] of the driveline"
                raise NamingError(where, f"{row[1]} is the driveline's parameter {series.name!r}", remedy)
            series = series if isinstance(series, (tuple, list)) else ()
            if not 1 <= int(row[2]) <= len(series):
                raise NamingError(where, f"has no row {key!r}; {row[1]!r} has {len(series)} rows", "rows count from 1")
            whole[row[1]] = (*series[: int(row[2]) - 1], value, *series[int(row[2]) :])
    return whole
