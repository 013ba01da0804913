"""The printed form of discrete modes: where each holds, what leads from one to another, what is reset or held.

Part of the grammar's printed form, under ``printed_law``. The laws themselves are printed case by case.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

import sympy

from modelgen.equations.discrete_modes import WrittenModes, held_where
from modelgen.equations.document import Block, Paragraph, Table
from modelgen.equations.mode_records import DiscreteModes, Transition
from modelgen.equations.typesetting import Typesetter

PASSES = {1: "rises through zero", -1: "falls through zero", 0: "passes zero"}


def mode_blocks(modes: WrittenModes, typeset: Typesetter, constants: Collection[sympy.Symbol]) -> Iterator[Block]:
    """Paragraphs on the modes and a table of the guards that an element gives itself."""
    for each in modes.modes:
        yield Paragraph(_memory(each) if each.memory else _regions(each, typeset, constants))
    if modes.guards:
        yield Table(("guard", "leads", "where", "and sets"), tuple(_row(guard, typeset) for guard in modes.guards))
    for hold in modes.holds:
        yield Paragraph(f"In the mode `{hold.flag.name}` ${typeset(hold.multiplier)}$ keeps ${typeset(hold.speed)}$ as it is.")


def _regions(modes: DiscreteModes, typeset: Typesetter, constants: Collection[sympy.Symbol]) -> str:
    held = [f"`{value}` where ${typeset(held_where(modes, value, constants))}$" for value in modes.regions]
    return f"Modes `{modes.name}`: {', '.join(held)}, else `{modes.values[0]}`."


def _memory(modes: DiscreteModes) -> str:
    names = ", ".join(f"`{value}`" for value in modes.values)
    return f"Modes `{modes.name}`: {names}. A run is taken to begin in `{modes.values[modes.start]}`, unless a guard leads on."


def _row(guard: Transition, typeset: Typesetter) -> tuple[str, ...]:
    leads = "" if guard.enter is None else f"`{guard.leave}` to `{guard.enter}`"
    if guard.stops:
        leads = f"{leads}, the run ends" if leads else "the run ends"
    sets = ", ".join(f"${typeset(reset.present)} = {typeset(reset.value)}$" for reset in guard.resets)
    return f"`{guard.name}`", leads or "—", f"${typeset(guard.expression)}$ {PASSES[guard.direction]}", sets or "—"
