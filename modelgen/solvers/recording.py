"""Channels over a trajectory: made in pieces within the budget of time, checked for memory before and for finite values after.

Part of ``solvers``, the last step of ``simulate``. Every number of a solution is finite: where a channel is not, as the energy of
a twist of 1e160 rad, the solution ends before it and says which.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Trajectory

Array = NDArray[np.float64]
Channels = Callable[[slice], dict[str, Array]]
PIECE = 1 << 14  # samples between two looks at the clock
SMALL = 1 << 28  # bytes that are not worth a look at the memory


@dataclass(frozen=True, eq=False)
class Recording:
    """Times, states and channels as far as they go, and how the run ended."""

    times: Array
    states: Array
    channels: dict[str, Array]
    outcome: Outcome
    message: str


def check_memory(samples: int, values: int) -> None:
    """Raises CaseError for a case whose outputs do not fit into the free memory; ``values`` of each sample are kept."""
    wanted = 3 * 8 * samples * values  # what is kept, and what making it takes beside
    free = free_memory()
    if wanted > SMALL and free is not None and wanted > free:
        problem = f"is {samples}, and {values} values of each take {wanted / 1e9:.3g} GB; {free / 1e9:.3g} GB are free"
        raise CaseError("case, samples", problem, "take fewer samples, or name the channels to keep")


def free_memory() -> int | None:
    """Bytes of memory that this machine has free; None where it does not tell."""
    try:
        with open("/proc/meminfo", encoding="ascii") as file:
            rows = dict(line.split(":", 1) for line in file)
        return int(rows["MemAvailable"].split()[0]) * 1024
    except (OSError, KeyError, ValueError):
        pass
    try:
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return None


def recorded(
    trajectory: Trajectory, states: Array, names: Sequence[str], channels: Channels, began: float, max_seconds: float
) -> Recording:
    """The channels of a trajectory; ``channels`` makes those of some samples, ``began`` is when the run did (perf_counter)."""
    count, outcome, message = len(trajectory.times), trajectory.outcome, trajectory.message
    found = {name: np.empty(count) for name in names}
    for first in range(0, count, PIECE):
        part = slice(first, min(first + PIECE, count))
        with np.errstate(all="ignore"):
            made = channels(part)
        for name, values in made.items():
            found[name][part] = values
        if (late := time.perf_counter() - began > max_seconds) and part.stop < count:
            count, outcome = part.stop, Outcome.MAX_TIME
            message = (
                f"stopped while its channels were made, at t = {float(trajectory.times[count - 1]):.9g} s: the budget of "
                f"{max_seconds:.6g} s of computing time is used up; raise max_seconds, or name fewer channels or samples"
            )
        if late:
            break
    wrong = {name: int(np.argmin(np.isfinite(values[:count]))) for name, values in found.items() if _breaks(values[:count])}
    if wrong:
        name = min(wrong, key=lambda each: wrong[each])
        count = wrong[name]
        if outcome.is_good:
            value = float(found[name][count])
            outcome = Outcome.NON_FINITE_STATE
            message = outcome.sentence(time=float(trajectory.times[count]), state=name, value=value)
            message = message.replace("state", "channel", 1)
    kept = {name: values[:count] for name, values in found.items()}
    return Recording(trajectory.times[:count], states[:count], kept, outcome, message)


def _breaks(values: Array) -> bool:
    return not np.all(np.isfinite(values))
