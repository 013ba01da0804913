"""What the commands share that ask one question of a model: options, the model as it is asked, a range of speeds, pairs.

Part of ``cli``, between ``settings`` and the commands such as ``modal`` or ``forced``.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from modelgen.lowering import Compiled
    from modelgen.model import Driveline

SET = 'A parameter (zeta=0.02), or a value or switch of an element or kind (coupling.stiffness="4e5 N*m/rad"). Repeatable.'
Command = Callable[..., Any]


def asks_a_model(command: Command) -> Command:
    """MODEL, ``--set`` and ``--speed``."""
    command = click.option("--speed", metavar="SPEED", help='Operating speed, such as "1900 rpm".')(command)
    command = click.option("--set", "assignments", multiple=True, metavar="NAME=VALUE", help=SET)(command)
    return click.argument("model")(command)


def fills_a_folder(command: Command) -> Command:
    """``--out`` and ``--replace``."""
    command = click.option("--replace", is_flag=True, help="Replace the folder if it holds results of modelgen.")(command)
    return click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder for the results.")(command)


def opened(model: str, assignments: tuple[str, ...], speed: str | None, turning: bool = False) -> tuple[Driveline, Compiled]:
    """The driveline as it is asked, and compiled. Raises what reading, setting and assembling raise.

    ``turning``: raises CaseError for one without an operating speed.
    """
    from modelgen.drivelines import load
    from modelgen.equations import assemble
    from modelgen.errors import CaseError
    from modelgen.lowering import lower
    from modelgen.reports.settings import settle

    line = settle(load(model), assignments, speed)
    if turning and line.speed is None:
        raise CaseError(f"driveline {line.name!r}", "has no operating speed", 'give one, such as --speed "1500 rpm"')
    return line, lower(assemble(line))


def speed_range(ends: tuple[str, str] | None, option: str) -> tuple[float, float] | None:
    """Two speeds [rad/s] from texts. Raises CaseError unless they are positive and rising, UnitError for another unit."""
    from modelgen.errors import CaseError
    from modelgen.units import read_quantity

    if ends is None:
        return None
    low, high = (read_quantity(text, "rad/s", option) for text in ends)
    if not 0 < low < high:
        raise CaseError(option, f"goes from {ends[0]} to {ends[1]}", "give two positive speeds, the lower one first")
    return low, high


def speed_steps(ends: tuple[str, str] | None, count: int) -> list[float] | None:
    """``count`` speeds [rad/s] from the first to the last; None where no range is given."""
    found = speed_range(ends, "--speeds")
    if found is None:
        return None
    low, high = found
    return [low + (high - low) * k / (count - 1) for k in range(count)]
