"""What a sweep keeps of a run: statistics of channels and states by name, and whole channels over the output times.

Part of ``sweeps``. ``coupling.torque.highest`` is a statistic over the output times of a channel, ``coupling.torque`` alone is
the channel at all of them. The mean is arithmetic over the output times; ``amplitude`` is half of peak-to-peak.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError, nearest
from modelgen.lowering import Compiled
from modelgen.solvers.lanes import Lanes
from modelgen.solvers.problem import Trajectory

Array = NDArray[np.float64]

STATISTICS: dict[str, Callable[[Array], Array]] = {
    "highest": lambda x: x.max(axis=1),
    "lowest": lambda x: x.min(axis=1),
    "mean": lambda x: x.mean(axis=1),
    "rms": lambda x: np.sqrt(np.square(x).mean(axis=1)),
    "amplitude": lambda x: (x.max(axis=1) - x.min(axis=1)) / 2,
    "final": lambda x: x[:, -1],
}
"""Last part of a name, and what it does with the values over time (channels, samples)."""
SHARE = ".share"
"""Behind the name of a mode, such as ``mesh.flank.drive``: the part of the output times' span in which it held."""
COUNTS: dict[str, Callable[[Trajectory], float]] = {
    "steps": lambda run: run.statistics.steps,
    "rejected": lambda run: run.statistics.rejected,
    "events": lambda run: 0 if run.events is None else int(run.events.counts.sum()),
}
"""Names that stand alone: what a run counted."""


@dataclass(frozen=True)
class Collection:
    """``statistics``: (name as asked, channel or state, statistic), ``counts`` and ``series`` as asked; ``samples`` of a series.

    A record of a point holds the statistics and counts in the order in which they were asked, then one series after the other.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    statistics: tuple[tuple[str, str, str], ...]
    counts: tuple[str, ...]
    series: tuple[str, ...]
    series_units: tuple[str, ...]
    samples: int

    @property
    def width(self) -> int:
        """Numbers that a point leaves behind."""
        return len(self.names) + len(self.series) * self.samples

    @property
    def keeps(self) -> bool:
        """Whether values at the output times are wanted, beside what is left of them all."""
        return bool(self.series) or any(statistic == "final" for _, _, statistic in self.statistics)

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels and states that are looked at, each once."""
        return tuple(dict.fromkeys([*(channel for _, channel, _ in self.statistics), *self.series]))


def collection_of(model: Compiled, collect: Sequence[str], samples: int) -> Collection:
    """What the names ask for. Raises CaseError with the nearest name for one that asks for nothing.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble, lower
    >>> model = lower(assemble(Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])))
    >>> collection_of(model, ["shaft.torque.amplitude", "steps"], samples=100).units
    ('N*m', '1')
    >>> collection_of(model, ["shaft.torque.maximum"], samples=100)
    Traceback (most recent call last):
    ...
    modelgen.errors.CaseError: sweep, collect: 'shaft.torque.maximum' has no statistic 'maximum'; known are highest, ...
    """
    lawful = isinstance(collect, Sequence) and not isinstance(collect, str) and all(isinstance(name, str) for name in collect)
    if not lawful or not collect:
        raise CaseError("sweep, collect", f"is {collect!r:.60}", 'give names, such as ["coupling.torque.highest"]')
    if len(set(collect)) < len(collect):
        twice = next(name for name in collect if list(collect).count(name) > 1)
        raise CaseError("sweep, collect", f"names {twice!r} twice", "name it once")
    names, units, statistics, counts, series = [], [], [], [], []
    for name in collect:
        channel, _, last = name.rpartition(".")
        if name in COUNTS or (name.endswith(SHARE) and channel in _modes(model)):
            counts.append(name)
            names.append(name)
            units.append("1")
        elif _known(model, name):
            series.append(name)
        elif last in STATISTICS and _known(model, channel):
            statistics.append((name, channel, last))
            names.append(name)
            units.append(_unit(model, channel))
        elif _known(model, channel):
            raise CaseError("sweep, collect", f"{name!r} has no statistic {last!r}", nearest(last, STATISTICS))
        else:
            known = [*model.outputs, *model.states, *_modes(model)]
            suffix = f".{last}" if last in STATISTICS else ""
            hint = nearest(channel if suffix else name, known if suffix else [*known, *COUNTS])
            raise CaseError("sweep, collect", f"{name!r} is no statistic of a channel or state", hint)
    series_units = tuple(_unit(model, name) for name in series)
    return Collection(tuple(names), tuple(units), tuple(statistics), tuple(counts), tuple(series), series_units, samples)


def _modes(model: Compiled) -> list[str]:
    """Names of the values of all modes."""
    return [] if model.switching is None else model.switching.value_names()


def _count(name: str, run: Trajectory) -> float:
    """What a run counted, or the share of a mode."""
    if name in COUNTS:
        return float(COUNTS[name](run))
    if run.events is None:
        raise CaseError(f"sweep, {name!r}", "events were not located", 'give the case the option events "on"')
    return run.events.share()[name.removesuffix(SHARE)]


def _known(model: Compiled, name: str) -> bool:
    return name in model.outputs or name in model.states


def _unit(model: Compiled, name: str) -> str:
    """Unit of a channel or a state."""
    return model.unit(name) if name in model.outputs else model.equations.states[model.state_index(name)].unit


def measured(wanted: Collection, run: Trajectory, values: Mapping[str, Array]) -> Array:
    """The record (width,) of a run from its channels and states at the output times that it reached.

    Where an event ended the run on purpose, statistics are those until then, and series end in NaN. Raises CaseError for a
    channel that is not finite.
    """
    rows = np.array([values[name] for name in wanted.channels]).reshape(len(wanted.channels), len(run.times))
    _refuse_unmeasured(wanted, rows)
    asked = {statistic for _, _, statistic in wanted.statistics}
    found = {name: dict(zip(wanted.channels, STATISTICS[name](rows), strict=True)) for name in asked}
    return _record(wanted, run, found, dict(zip(wanted.channels, rows, strict=True)))


def gathered(wanted: Collection, run: Trajectory, lanes: Lanes, row: int) -> Array:
    """The same of a run in lanes, from what they gathered; the columns of their channels are those of the collection.

    Means are summed up in another order than NumPy's, which shows in the last digits.
    """
    names = wanted.channels
    if not names:
        return _record(wanted, run, {}, {})
    low, high, mean, square = (
        np.asarray(each)[row]
        for each in (lanes.channel_lowest, lanes.channel_highest, lanes.channel_mean, lanes.channel_mean_square)
    )
    _refuse_unmeasured(wanted, np.stack([low, high, mean, square], axis=1))
    found = {"highest": high, "lowest": low, "mean": mean, "rms": np.sqrt(square), "amplitude": (high - low) / 2}
    series: dict[str, Array] = {}
    if lanes.channels is not None:
        reached = int(np.count_nonzero(np.isfinite(lanes.channels[row, :, 0])))
        series = dict(zip(names, lanes.channels[row, :reached].T, strict=True))
        found["final"] = lanes.channels[row, reached - 1]
    return _record(wanted, run, {name: dict(zip(names, each, strict=True)) for name, each in found.items()}, series)


def _refuse_unmeasured(wanted: Collection, rows: Array) -> None:
    if rows.size == 0 and wanted.channels:
        raise CaseError("sweep", "the run ended before its first output", "record from an earlier time")
    for name, row in zip(wanted.channels, rows, strict=True):
        if not np.all(np.isfinite(row)):
            raise CaseError(f"sweep, {name!r}", "is not finite", "look at this point with simulate()")


def _record(wanted: Collection, run: Trajectory, found: Mapping[str, Mapping[str, Any]], series: Mapping[str, Array]) -> Array:
    record = np.full(wanted.width, np.nan)
    numbers = {name: _count(name, run) for name in wanted.counts}
    numbers |= {name: float(found[statistic][channel]) for name, channel, statistic in wanted.statistics}
    record[: len(wanted.names)] = [numbers[name] for name in wanted.names]
    for k, name in enumerate(wanted.series):
        first = len(wanted.names) + k * wanted.samples
        record[first : first + len(series[name])] = series[name]
    return record
