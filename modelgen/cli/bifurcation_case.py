"""The case that ``bifurcation``, ``poincare`` and ``map`` ask about, and the values of a parameter over a range.

Part of ``cli``. Times of the case are not used: strobes and windows follow from the base frequencies.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from modelgen.lowering import Compiled
    from modelgen.solvers import Case


def strobed_case(model: str, assignments: tuple[str, ...], speed: str | None, mesh_reading: str | None, tolerance: float) -> Case:
    """The case of a model with its options applied. Raises what reading, setting and assembling raise."""
    from modelgen.drivelines import load
    from modelgen.equations import assemble
    from modelgen.lowering import lower
    from modelgen.reports.settings import settle
    from modelgen.solvers import Case

    line = settle(load(model), assignments, speed, mesh_reading=mesh_reading)
    return Case(lower(assemble(line)), end=1.0, tolerance=tolerance)


def stepped(model: Compiled, axis: tuple[str, str, str], count: int, option: str) -> tuple[str, list[float]]:
    """A parameter and ``count`` values of it from first to last, in its SI unit.

    Raises NamingError for an unknown one, CaseError unless the range rises, UnitError for another unit.
    """
    from modelgen.errors import CaseError, NamingError, nearest
    from modelgen.units import read_quantity

    name, first, last = axis
    where = f"{option} {name}"
    if name.partition("[")[0] not in model.parameters.parameters:
        problem = f"driveline {model.name!r} has no parameter {name!r}"
        raise NamingError(where, problem, nearest(name, model.parameters.names))
    unit = model.parameters.unit_of_number(name, option)
    low, high = (read_quantity(text, unit, where) for text in (first, last))
    if not low < high:
        raise CaseError(where, f"goes from {first} to {last}", "give the lower value first")
    return name, [low + (high - low) * k / (count - 1) for k in range(count)]
