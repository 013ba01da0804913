"""Elements as tables of a model file, drawn from the declarations of their kind alone."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

import laws.joints  # noqa: F401  # linear constraints over three and more flanges join the vocabulary
import modelgen.elements  # noqa: F401  # as do the elements of the package
from modelgen import Choice, Clock, Element, Orders, Param
from modelgen.model import Flange
from strategies.values import written

OWN_KINDS = tuple(sorted(kind for kind, cls in Element.vocabulary.items() if cls.__module__.startswith("modelgen.elements.")))
KINDS = (*OWN_KINDS, "joint3", "planetary_set")


def kinds(flanges: int) -> tuple[str, ...]:
    """The kinds that have so many flanges."""
    return tuple(kind for kind in KINDS if len(Element.vocabulary[kind].declared(Flange)) == flanges)


@st.composite
def element_tables(draw: st.DrawFn, kind: str, joined: tuple[str, ...], bases: tuple[str, ...] = ()) -> dict[str, Any]:
    """The table of an element of a kind whose flanges are joined to the given names: a lawful value for all that it asks for."""
    cls = Element.vocabulary[kind]
    table: dict[str, Any] = {"kind": kind, **dict(zip(cls.declared(Flange), joined, strict=False))}
    chosen = {}
    for key, choice in cls.declared(Choice).items():
        chosen[key] = draw(st.sampled_from(choice.options))
        if chosen[key] != choice.default:
            table[key] = chosen[key]
    rows = draw(st.integers(1, 3))
    for key, orders in cls.declared(Orders).items():
        if orders.exists(chosen) and draw(st.booleans()):
            table[key] = draw(st.lists(st.integers(1, 12), min_size=rows, max_size=rows, unique=True))
    for key, clock in cls.declared(Clock).items():
        if clock.flange is None and bases:
            table[key] = draw(st.sampled_from(bases))
    for key, param in cls.declared(Param).items():
        if param.exists(chosen) and (param.default is None or draw(st.booleans())):
            table[key] = draw(written(param, rows if param.series else None))
    return table
