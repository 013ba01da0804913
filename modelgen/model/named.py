"""What a driveline names besides its elements: parameters that elements share, and base frequencies.

Part of the language, above ``driveline``. Both are read strictly: a number is finite and has a unit that exists, an order is an
exact fraction.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from modelgen.errors import ModelError, UnitError
from modelgen.model.values import plain_number
from modelgen.units import dimension_of, finite, read_any

_ORDER = re.compile(r"\s*\d{1,6}\s*(?:/\s*\d{1,6}\s*)?", re.ASCII)


@dataclass(frozen=True)
class NamedParameter:
    """A parameter of the driveline that elements may share: a value with its unit, or an expression in other parameters.

    The unit of an expression follows from it; one that is given must agree.
    """

    value: float | tuple[float, ...] = 0.0
    unit: str = "1"
    expression: str | None = None
    note: str = ""


@dataclass(frozen=True)
class BaseFrequency:
    """``order`` cycles per turn of the named shaft (per turn of the reference shaft when none is named); order is exact."""

    order: Fraction
    shaft: str | None = None


def named_parameter(key: str, value: Any) -> NamedParameter:
    """A shared parameter from a number, a text with a unit, or a row of numbers. Raises UnitError for anything else."""
    where = f"parameter {key!r}"
    if isinstance(value, NamedParameter):
        try:
            dimension_of(value.unit)
        except UnitError as error:
            raise UnitError(where, f"{error.where} {error.problem}", error.remedy) from None
        return replace(value, value=_numbers(value.value, where, value.unit))
    if isinstance(value, str):
        number, unit = read_any(value, where)
        return NamedParameter(number, unit)
    return NamedParameter(_numbers(value, where))


def _numbers(value: Any, where: str, unit: str = "1") -> float | tuple[float, ...]:
    if isinstance(value, Iterable) and not isinstance(value, (str, bytes)):
        return tuple(
            finite(plain_number(entry, f"{where}[{row}]", unit), f"{where}[{row}]") for row, entry in enumerate(value, 1)
        )
    return finite(plain_number(value, where, unit), where)


def base_frequency(key: str, value: Any) -> BaseFrequency:
    """A base frequency from an order, or a shaft and an order. Raises ModelError unless the order is a positive fraction."""
    where = f"base frequency {key!r}"
    if isinstance(value, BaseFrequency):
        value = (value.shaft, value.order)
    if isinstance(value, tuple) and len(value) != 2:
        raise ModelError(where, f"is {value!r}", 'give an order, or a shaft and an order such as ("engine", 2)')
    shaft, order = value if isinstance(value, tuple) else (None, value)
    if shaft is not None and not isinstance(shaft, str):
        raise ModelError(where, f"the shaft is {shaft!r}", "give the name of an element")
    exact = _fraction(order)
    if exact is None:
        raise ModelError(where, f"the order is {order!r:.60}", 'give a positive fraction such as 2 or "1/2"')
    return BaseFrequency(exact, shaft)


def _fraction(order: Any) -> Fraction | None:
    """The order as an exact positive fraction of bounded size, or None."""
    try:
        if isinstance(order, str):
            exact = Fraction(order.replace(" ", "")) if _ORDER.fullmatch(order) else Fraction(0)
        elif isinstance(order, float):
            exact = Fraction(order).limit_denominator(1000)
            exact = exact if float(exact) == order else Fraction(0)
        else:
            exact = Fraction(0) if isinstance(order, bool) else Fraction(order)
    except (ValueError, TypeError, ArithmeticError):
        return None
    return exact if 0 < exact < 10**6 and exact.denominator < 10**6 else None
