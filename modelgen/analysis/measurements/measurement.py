"""Measured channels over time or over crank angle, read from a table as recorders export it; ``compare`` lays them over a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError, UnitError, nearest
from modelgen.exchange.delimited_text import Column, DelimitedText, read_delimited
from modelgen.units import dimension_of, read_any, written_out

Array = NDArray[np.float64]
FEWEST = 8  # samples; below that nothing can be said about a vibration


@dataclass(frozen=True, eq=False)
class Measurement:
    """Channels over ``abscissa``, which is a time [s] or, with ``kind`` "angle", an angle [rad] that grows from sample to sample.

    ``channels`` are in the SI units ``units`` (angles in "1" or "rad"); ``written`` are the units as the file gives them.
    """

    source: str
    kind: str
    name: str
    abscissa: Array
    channels: Mapping[str, Array]
    units: Mapping[str, str]
    written: Mapping[str, str]

    def __post_init__(self) -> None:
        if self.kind not in ("time", "angle"):
            raise CaseError(self.source, f"the kind of its abscissa is {self.kind!r}", 'give "time" or "angle"')
        if len(self.abscissa) < FEWEST:
            raise CaseError(self.source, f"has {len(self.abscissa)} samples", f"give {FEWEST} or more")
        for name, values in {self.name: self.abscissa, **self.channels}.items():
            if np.shape(values) != np.shape(self.abscissa) or not np.all(np.isfinite(values)):
                raise CaseError(f"{self.source}, channel {name!r}", "is not one finite number for each sample", "give them all")
        if np.any(np.diff(self.abscissa) <= 0):
            raise CaseError(self.source, f"{self.name!r} does not grow from sample to sample", "sort the samples")

    def channel(self, name: str, unit: str, wanted: str) -> Array:
        """A channel, which must have the dimension of ``unit``, that of the channel ``wanted``. Raises CaseError or UnitError."""
        where = f"{self.source}, column {name!r}"
        if name not in self.channels:
            raise CaseError(where, "there is none", nearest(name, self.channels))
        if dimension_of(self.units[name]) != dimension_of(unit):
            raise UnitError(where, f"is in {self.written[name]}, {wanted!r} is in {unit}", "compare channels of one dimension")
        return self.channels[name]


def read_measurement(path: str | Path) -> Measurement:
    """A measurement from a table: the first column is the time or the crank angle, the others are channels, each with its unit.

    A header such as ``t [ms]; flywheel.angle_deviation [deg]; coupling.torque [kN*m]``. Raises ModelFileError with line and
    column for what cannot be read, UnitError for a missing or unfit unit.
    """
    table = read_delimited(path)
    first, *others = table.columns
    if not others:
        raise CaseError(table.at(None), f"has the column {first.name!r} only", "give channels beside it")
    factor, unit = _unit(table, first)
    if unit not in ("s", "1", "rad"):
        raise UnitError(table.at(None, first), f"is in {first.unit}", "the first column is a time [s] or a crank angle [deg]")
    abscissa = _values(table, first) * factor
    back = np.flatnonzero(np.diff(abscissa) <= 0)
    if len(back):
        row = table.rows[int(back[0]) + 1]
        advice = "sort the samples by time" if unit == "s" else "let the angle grow through turns and cycles, without jumps back"
        raise CaseError(table.at(row, first), f"{table.cell(row, first)} does not lie beyond the value before", advice)
    units = {column.name: _unit(table, column) for column in others}
    return Measurement(
        source=table.source,
        kind="time" if unit == "s" else "angle",
        name=first.name,
        abscissa=abscissa,
        channels={column.name: _values(table, column) * units[column.name][0] for column in others},
        units={name: each[1] for name, each in units.items()},
        written={column.name: column.unit for column in others},
    )


def _unit(table: DelimitedText, column: Column) -> tuple[float, str]:
    where = table.at(None, column)
    if not column.unit:
        raise UnitError(where, "the header names no unit", f"write it as {column.name} [unit], with [1] for a plain number")
    unit = written_out(column.unit)
    return (1.0, "1") if unit == "1" else read_any(f"1 {unit}", where)


def _values(table: DelimitedText, column: Column) -> Array:
    return np.array([table.number(row, column) for row in table.rows])
