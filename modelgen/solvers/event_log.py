"""What happened in a run: the events in the order of their times, and how long each mode held.

Part of ``solvers``; the virtual machine, one trajectory in C and lanes all hand on this record.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.lowering.guard_kinds import WAYS
from modelgen.lowering.switching import Crossing, ModeVariable, Switching

_ARRAYS = ("times", "which", "states", "counts", "shares")
_LATER = ("touch_times", "touch_which", "breaks", "roundings")


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
    first output to the last that each mode held, in the order of ``switching.value_names()``. ``start``: the value of each mode
    variable when the run began.

    ``counting``: how the roots of each crossing's guard were counted in every step: "polynomial" (as those of a polynomial on the
    dense output), "enclosed" (by bounds of the guard and its rate), or "sampled" (at three places of a step and where it turns
    between them), which promises nothing. ``touch_times`` [s], ``touch_which``: guards that came within eight ``roundings``
    (number of crossings,) of zero and turned back; they fired nothing. ``breaks`` [s]: times passed at which laws jump or bend by
    the clock alone.
    """

    switching: Switching
    times: NDArray[np.float64]
    which: NDArray[np.int64]
    states: NDArray[np.float64]
    counts: NDArray[np.int64]
    shares: NDArray[np.float64]
    start: tuple[int, ...] = ()
    counting: tuple[str, ...] = ()
    touch_times: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    touch_which: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    breaks: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    roundings: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))

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

    def counted(self) -> dict[str, int]:
        """Number of events of each guard that fired, by name; a name that leads on from several modes says from where."""
        names = [crossing.name for crossing in self.switching.crossings]
        counts: dict[str, int] = {}
        for index, (name, count) in enumerate(zip(names, self.counts.tolist(), strict=True)):
            crossing = self.switching.crossings[index]
            if count and names.count(name) > 1 and crossing.variable is not None and crossing.leave is not None:
                name = f"{name} from {self.switching.modes[crossing.variable].values[crossing.leave]}"
            if count:
                counts[name] = counts.get(name, 0) + count
        return counts

    def touches(self) -> list[tuple[float, str]]:
        """(time, name) of every guard that came within its rounding of zero and turned back."""
        names = [crossing.name for crossing in self.switching.crossings]
        return [(time, names[index]) for time, index in zip(self.touch_times.tolist(), self.touch_which.tolist(), strict=True)]

    def ways(self) -> dict[str, str]:
        """How each guard was counted, by name; of crossings with one name, the weakest way."""
        found: dict[str, str] = {}
        for crossing, way in zip(self.switching.crossings, self.counting, strict=False):
            found[crossing.name] = max(found.get(crossing.name, way), way, key=WAYS.index)
        return found

    def __str__(self) -> str:
        """Counts, touches and shares in one line."""
        total = int(self.counts.sum())
        counts = ", ".join(f"{count} {name}" for name, count in self.counted().items())
        shares = ", ".join(f"{name} {share:.2%}" for name, share in self.share().items())
        touched = [name for _, name in self.touches()]
        touches = ", ".join(f"{touched.count(name)} {name}" for name in dict.fromkeys(touched))
        parts = f"{total} event{'' if total == 1 else 's'}" + f": {counts}" * bool(counts)
        return parts + f"; touched zero: {touches}" * bool(touches) + f"; {shares}" * bool(shares)

    def modes(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """The value of each mode variable (n, variables) at the given increasing times; at an event, that before it."""
        steps = [np.array(self.start, dtype=np.int64)]
        for number in self.which.tolist():
            crossing, values = self.switching.crossings[number], steps[-1]
            if crossing.variable is not None and crossing.enter is not None:
                values = values.copy()
                values[crossing.variable] = crossing.enter
            steps.append(values)
        return np.array(steps).reshape(len(steps), -1)[np.searchsorted(self.times, times, side="left")]

    def head(self) -> dict[str, Any]:
        """Names and directions as plain data, for saving; the rest are ``arrays``."""
        modes, crossings = (list(map(asdict, each)) for each in (self.switching.modes, self.switching.crossings))
        return {"modes": modes, "crossings": crossings, "start": list(self.start), "counting": list(self.counting)}

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The numbers, for saving, by names that ``read`` knows."""
        return {f"event_{name}": getattr(self, name) for name in (*_ARRAYS, *_LATER)}

    @classmethod
    def read(cls, head: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> EventLog:
        """A log from what was saved. Its guards have names, but no function any more."""
        modes = tuple(ModeVariable(**{**each, "values": tuple(each["values"])}) for each in head["modes"])
        crossings = tuple(Crossing(**each) for each in head["crossings"])
        switching = Switching(modes, crossings, ca.Function("guards", [], []), p_size=0)
        known: dict[str, Any] = {name: arrays[f"event_{name}"] for name in (*_ARRAYS, *_LATER) if f"event_{name}" in arrays}
        told: dict[str, Any] = {"start": tuple(head["start"]), "counting": tuple(head.get("counting", ()))}
        return cls(switching, **told, **known)  # older files have no touches
