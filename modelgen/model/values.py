"""Values of parameters: what may be given for a number, and how it is read.

Part of the language, beside the declarations that say what is lawful: a number, a text with a unit, the name of a shared
parameter, or a series of those.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from modelgen.errors import ModelError, UnitError
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
