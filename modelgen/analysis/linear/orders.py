"""How an order is told, wherever it is printed: per turn of the reference shaft, with the base that it comes from in brackets.

Below every question about orders. "order 3 (engine_half_order x 6)" is three cycles per turn of the reference shaft, the sixth
multiple of the base ``engine_half_order``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction

Source = tuple[str, int]
"""A base frequency by name, and the multiple of it."""


def order_number(order: Fraction | float, digits: int = 6) -> str:
    """An order per turn of the reference shaft in decimals.

    >>> order_number(Fraction(3, 2)), order_number(Fraction(221, 2484)), order_number(Fraction(3))
    ('1.5', '0.0889694', '3')
    """
    return f"{float(order):.{digits}g}"


def source_name(sources: Iterable[Source], named: Callable[[str], str] = str, times: str = "x") -> str:
    """The bases of an order, each with its multiple.

    >>> source_name([("engine_half_order", 6)])
    'engine_half_order x 6'
    """
    return ", ".join(f"{named(base)} {times} {multiple}" for base, multiple in sources)


def order_name(
    order: Fraction | float, sources: Iterable[Source], named: Callable[[str], str] = str, times: str = "x", digits: int = 6
) -> str:
    """The order in words.

    >>> order_name(Fraction(3), [("engine_half_order", 6)])
    'order 3 (engine_half_order x 6)'
    """
    return f"order {order_number(order, digits)} ({source_name(sources, named, times)})"
