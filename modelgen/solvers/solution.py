"""A solution: named channels with units, how the run ended, and the case it answers. Fifth of the seven records.

It holds data only, so it can be saved, loaded and sent anywhere without loss.
"""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError, nearest
from modelgen.lowering import Section
from modelgen.solvers.case import Case
from modelgen.solvers.event_log import EventLog
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Statistics

Array = NDArray[np.float64]
FORMAT = 2
READABLE = (1, FORMAT)  # the first had no events


@dataclass(frozen=True, eq=False)
class Solution:
    """Channels over ``times`` [s]: ``solution["coupling.torque"]`` is an array, ``solution.unit("coupling.torque")`` its unit.

    ``states`` (n, number of states) with ``state_names``; ``outcome`` and ``message`` say how the run ended; ``events``
    is the log of what was located, if anything was looked for. ``final`` is the last state, to continue from.
    """

    case: Case
    times: Array
    states: Array
    state_names: tuple[str, ...]
    channels: Mapping[str, Array]
    units: Mapping[str, str]
    outcome: Outcome
    message: str
    statistics: Statistics
    events: EventLog | None = None

    def __getitem__(self, name: str) -> Array:
        if name in self.channels:
            return self.channels[name]
        if name in self.state_names:
            return self.states[:, self.state_names.index(name)]
        known = [*self.channels, *self.state_names]
        raise CaseError(f"solution of {self.model_name!r}", f"no output {name!r}", nearest(name, known))

    def unit(self, name: str) -> str:
        """Unit of a channel."""
        if name not in self.units:
            raise CaseError(f"solution of {self.model_name!r}", f"no output {name!r}", nearest(name, self.units))
        return self.units[name]

    @property
    def model_name(self) -> str:
        """Name of the driveline."""
        return "?" if self.case.model is None else self.case.model.name

    @property
    def succeeded(self) -> bool:
        """Whether the run did what was asked."""
        return self.outcome.is_good

    @property
    def final(self) -> dict[str, float]:
        """The last state by name [SI]; another case may start from it: ``Case(line, start=solution, ...)``."""
        return dict(zip(self.state_names, self.states[-1].tolist(), strict=True)) if len(self.times) else {}

    @property
    def shares(self) -> Mapping[str, float]:
        """Part of the time from the first output to the last that each mode held, by names such as ``mesh.flank.drive``."""
        return {} if self.events is None else self.events.share()

    def between(self, first: float, last: float) -> Solution:
        """The part from ``first`` to ``last`` [s]."""
        inside = (self.times >= first) & (self.times <= last)
        channels = {name: values[inside] for name, values in self.channels.items()}
        return replace(self, times=self.times[inside], states=self.states[inside], channels=channels)

    def save(self, path: str | Path) -> Path:
        """Writes everything to one file (NumPy's zip format), whole or not at all; reading it again loses nothing."""
        path = Path(path)
        head = {
            "format": FORMAT,
            "case": self.case.data(),
            "units": dict(self.units),
            "names": list(self.channels),
            "state_names": list(self.state_names),
            "outcome": self.outcome.name,
            "message": self.message,
            "statistics": vars(self.statistics),
            "events": None if self.events is None else self.events.head(),
        }
        arrays = {
            "head": np.frombuffer(json.dumps(head).encode(), dtype=np.uint8),
            "times": self.times,
            "states": self.states,
            "channels": np.array(list(self.channels.values())).reshape(len(self.channels), len(self.times)),
        }
        if self.events is not None:
            arrays.update(self.events.arrays())
        temporary = path.with_name(f".{path.name}.{os.getpid()}")
        with temporary.open("wb") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]  # NumPy's stub takes the names for its own options
        os.replace(temporary, path)
        return path

    @classmethod
    def load(cls, path: str | Path) -> Solution:
        """Reads what ``save`` wrote. Its case has no compiled model. Raises CaseError for a file that is something else."""
        try:
            with Path(path).open("rb") as file, np.load(file, allow_pickle=False) as data:
                head = json.loads(bytes(data["head"]).decode())
                times, states, channels = data["times"], data["states"], data["channels"]
                if head["format"] not in READABLE:
                    known = " and ".join(map(str, READABLE))
                    raise CaseError(str(path), f"has format {head['format']!r}", f"this version reads formats {known}")
                events = EventLog.read(head["events"], data) if head["format"] > 1 and head["events"] is not None else None
            return cls(
                case=_case(head["case"]),
                times=times,
                states=states,
                state_names=tuple(head["state_names"]),
                channels=dict(zip(head["names"], channels, strict=True)),
                units=head["units"],
                outcome=Outcome[head["outcome"]],
                message=head["message"],
                statistics=Statistics(**head["statistics"]),
                events=events,
            )
        except CaseError:
            raise
        except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile, EOFError) as error:
            raise CaseError(
                str(path), f"is no saved solution ({type(error).__name__})", "give a file that Solution.save wrote"
            ) from None

    def __str__(self) -> str:
        s = self.statistics
        span = f"{self.times[0]:g} to {self.times[-1]:g} s" if len(self.times) else "no times"
        cost = f"{s.steps} steps ({s.rejected} rejected), {s.evaluations} evaluations, {s.seconds:.3g} s ({s.backend})"
        head = f"solution of {self.model_name!r}: {len(self.times)} times, {span}, {len(self.channels)} channels"
        happened = "" if self.events is None else f"\n  {self.events}"
        return f"{head}\n  {self.message}\n  {cost}{happened}"

    __repr__ = __str__


def _case(data: dict[str, Any]) -> Case:
    known = {key: value for key, value in data.items() if key not in ("model", "fingerprint")}
    known["sections"] = tuple(Section(**section) for section in known.get("sections", ()))
    known["channels"] = None if known["channels"] is None else tuple(known["channels"])
    return Case(model=None, **known)  # type: ignore[arg-type]  # a loaded case cites its model by fingerprint only
