"""What happened in a run: the events in the order of their times, and how long each mode held.

Part of ``solvers``; the virtual machine, one trajectory in C and lanes all hand on this record.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.lowering.switching import Switching


@dataclass(frozen=True, eq=False)
class Event:
    """One event: time [s], name of the guard, modes from and to (empty for a section), state before a reset (nx,)."""

    time: float
    name: str
    leave: str
    enter: str
    state: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class EventLog:
    """Events as arrays: ``times`` (n,) [s], ``which`` (n,) the crossing's number, ``states`` (n, nx) just before a reset.

    ``counts`` (number of crossings,) of all events, logged or not; ``shares`` (number of flags,) the part of the time from the
    first output to the last that each mode held, in the order of ``switching.value_names()``.
    """

    switching: Switching
    times: NDArray[np.float64]
    which: NDArray[np.int64]
    states: NDArray[np.float64]
    counts: NDArray[np.int64]
    shares: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.times)

    def __getitem__(self, index: int) -> Event:
        crossing = self.switching.crossings[int(self.which[index])]
        leave = enter = ""
        if crossing.variable is not None and crossing.leave is not None and crossing.enter is not None:
            values = self.switching.modes[crossing.variable].values
            leave, enter = values[crossing.leave], values[crossing.enter]
        return Event(float(self.times[index]), crossing.name, leave, enter, self.states[index])

    def share(self) -> Mapping[str, float]:
        """Part of the time that each mode held, by names such as ``mesh.flank.drive``."""
        return dict(zip(self.switching.value_names(), self.shares.tolist(), strict=True))

    def rows(self) -> list[tuple[Any, ...]]:
        """(time, name, from, to) of every event, for tables."""
        return [(event.time, event.name, event.leave, event.enter) for event in (self[k] for k in range(len(self)))]
