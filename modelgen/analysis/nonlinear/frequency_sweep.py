"""Question: how much does a mesh vibrate at every mesh frequency, swept upward and downward, and where does it jump?

The gear researcher's plot: root mean square of the dynamic transmission error (the approach of the flanks r_a theta_a - r_b
theta_b, less its mean) over one or more common periods of the settled motion, against the mesh frequency. Each column starts
from the last state of its neighbor, so the branches of a softening resonance (tooth separation) part, and each ends in a jump,
which is closed in on by ever smaller steps along its own branch.
Source: A. Kahraman, R. Singh, J. Sound Vib. 142 (1990) 49-75.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.nonlinear.motion import motion_of
from modelgen.analysis.nonlinear.runs import options_of, parameter_values, restarted, run_all, setting
from modelgen.analysis.nonlinear.strobes import Patience, Strobed, strobed
from modelgen.errors import CaseError, nearest
from modelgen.lowering import Compiled
from modelgen.solvers.asked_case import asked_case
from modelgen.solvers.case import Case
from modelgen.solvers.problem import Trajectory

Array = NDArray[np.float64]
DIRECTIONS = ("forward", "backward")
FEWEST, PER_CYCLE = 256, 32  # samples of a common period, and of a mesh period
LOOSE = 16  # common periods that are averaged over where the motion does not come back
JUMP = 3.0  # times the median slope of log(rms) over log(frequency): what may be a jump
LEAST = 0.05  # of the rms: smaller steps are no jump
TINY = 1e-300
CLOSE = 1e-4  # of the frequency: how near a jump is closed in on


@dataclass(frozen=True)
class SweepPoint:
    """The settled motion at one speed of one branch: ``rms``, ``least``, ``largest`` of each channel, ``separated``: its share of
    time out of contact, ``back``: on the back flank; ``period``, ``residual``, ``settled`` as in ``strobes``. ``failure``: why
    the run did not reach its end, empty where it did; its sizes are nan.
    """

    speed: float
    frequency: float
    rms: tuple[float, ...]
    least: tuple[float, ...]
    largest: tuple[float, ...]
    separated: float
    back: float
    period: int
    residual: float
    settled: bool
    failure: str = ""


@dataclass(frozen=True)
class Change:
    """Where a branch changes, between two mesh frequencies ``stays`` and ``changes`` [Hz] in the direction of the sweep.

    ``kind``: "jump" (to another branch), "parts" (flanks begin to part within a period), "joins" (they begin to stay in contact).
    ``before`` and ``after``: rms of the first channel on both sides.
    """

    direction: str
    kind: str
    stays: float
    changes: float
    before: float
    after: float

    @property
    def frequency(self) -> float:
        """The middle [Hz]."""
        return (self.stays + self.changes) / 2


@dataclass(frozen=True, eq=False)
class FrequencySweepResult:
    """Branches over the mesh frequency of ``mesh``; ``channels`` with ``units``, the first the dynamic transmission error."""

    model: str
    mesh: str
    channels: tuple[str, ...]
    units: tuple[str, ...]
    forward: tuple[SweepPoint, ...]
    backward: tuple[SweepPoint, ...]
    changes: tuple[Change, ...]

    @property
    def jumps(self) -> tuple[Change, ...]:
        """The jumps, upward ones first."""
        return tuple(each for each in self.changes if each.kind == "jump")

    @property
    def failed(self) -> tuple[SweepPoint, ...]:
        """The points whose runs did not reach their end."""
        return tuple(point for point in (*self.forward, *self.backward) if point.failure)

    def __str__(self) -> str:
        low, high = self.forward[0].frequency, self.forward[-1].frequency
        said = ", ".join(f"{each.direction} at {each.frequency:.6g} Hz" for each in self.jumps) or "none"
        return (
            f"frequency sweep of {self.mesh!r} in {self.model!r}: {len(self.forward)} mesh frequencies from {low:.5g} to "
            f"{high:.5g} Hz; jumps: {said}{self._failed_text()}"
        )

    def _failed_text(self) -> str:
        if not self.failed:
            return ""
        first = self.failed[0]
        return f"; {len(self.failed)} runs failed, the first at {first.frequency:.6g} Hz: {first.failure}"

    __repr__ = __str__


def frequency_sweep(
    case: Any,
    speeds: Sequence[Any],
    mesh: str | None = None,
    channels: Sequence[str] = (),
    *,
    transient: int = 400,
    still: float | None = None,
    close: float = CLOSE,
    tolerance: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> FrequencySweepResult:
    """Sweeps the operating speed (rad/s, or texts such as "1500 rpm") up and down and measures the vibration of a ``mesh``.

    ``mesh``: name of a gear pair, by default the only one. ``channels``: further channels whose rms is kept. ``transient``: most
    strobes that a column is waited for; ``close``: how near jumps are closed in on, relative to the frequency (0: not at all).
    ``tolerance`` of a step, per scale of each state: by default that of a case, 1e-5 for any other model.
    Raises CaseError, NamingError, or BalanceError for what cannot be.
    """
    question = "frequency sweep"
    case = asked_case(case, question, {"tolerance": 1e-5}, tolerance=tolerance)
    model = case.model
    mesh = chosen_mesh(model, mesh)
    listed = sorted(set(parameter_values(model, "speed", speeds, question)))
    if len(listed) < 3:
        raise CaseError(question, f"has {len(listed)} speeds", "give at least three")
    if not 0 <= close < 0.1:
        raise CaseError(f"{question}, close", f"is {close!r}", "give a share of the frequency, such as 1e-4")
    names = (f"{mesh}.approach", f"{mesh}.penetration", *channels)
    for name in channels:
        model.output_index(name)
    branch = _Branches(case, mesh, names, Patience(count=16, transient=transient, still=still))
    orders = {"forward": listed, "backward": listed[::-1]}
    states: list[Array] | None = None
    found: dict[str, list[tuple[SweepPoint, Array]]] = {way: [] for way in DIRECTIONS}
    for step in range(len(listed)):
        done = branch.at([orders[way][step] for way in DIRECTIONS], states)
        for way, each in zip(DIRECTIONS, done, strict=True):
            found[way].append(each)
        states = [state for _, state in done]
        if progress is not None:
            progress((step + 1) / len(listed))
    changes = [change for way in DIRECTIONS for change in _changes(branch, way, found[way], close)]
    kept = (names[0], *channels)
    return FrequencySweepResult(
        model=model.name,
        mesh=mesh,
        channels=kept,
        units=tuple(model.unit(name) for name in kept),
        forward=tuple(point for point, _ in found["forward"]),
        backward=tuple(point for point, _ in found["backward"][::-1]),
        changes=tuple(changes),
    )


def chosen_mesh(model: Compiled, mesh: str | None) -> str:
    """The gear pair that is asked for. Raises CaseError where there is none of the name, or no only one."""
    known = [name.removesuffix(".penetration") for name in model.outputs if name.endswith(".penetration")]
    where = f"driveline {model.name!r}"
    if mesh is None and len(known) == 1:
        return known[0]
    if not known:
        raise CaseError(where, "has no elastic gear pair", "ask a driveline with one")
    if mesh not in known:
        problem = f"has no gear pair {mesh!r}" if mesh is not None else f"has {len(known)} gear pairs"
        raise CaseError(where, problem, nearest(mesh, known) if mesh is not None else f"name one of {', '.join(known)}")
    return mesh


class _Branches:
    """Settled motion at speeds, from given states."""

    def __init__(self, case: Case, mesh: str, names: tuple[str, ...], patience: Patience) -> None:
        self.case, self.mesh, self.names, self.patience = case, mesh, names, patience

    def at(self, speeds: Sequence[float], states: list[Array] | None) -> list[tuple[SweepPoint, Array]]:
        """The motion at each speed, with its last state."""
        found = strobed([setting(self.case, speed=speed) for speed in speeds], self.patience, starts=states)
        counts = {self._samples(each) for each in found}
        problems = []
        for each in found:
            periods = each.period or LOOSE
            times = each.strobe.period * periods * np.arange(max(counts) + 1) / max(counts)
            problems.append(restarted(each.setting.problem, each.final, times))
        runs = run_all(self.case, problems, options_of(self.case))
        return [(self._point(each, run), each.final) for each, run in zip(found, runs, strict=True)]

    def _samples(self, found: Strobed) -> int:
        cycles = float(found.strobe.cycles.get(f"{self.mesh}.contact", 1))
        return (found.period or LOOSE) * max(FEWEST, int(PER_CYCLE * cycles))

    def _point(self, found: Strobed, run: Trajectory) -> SweepPoint:
        model, p = self.case.model, found.setting.point.p
        values = motion_of(model, run.times, run.states, p, self.names)[0]
        failure = next((each.message for each in (found, run) if not each.outcome.is_good), "")
        if failure:
            values = np.full((2, len(self.names)), np.nan)
        speed = float(model.parameters.value(p, "speed"))
        cycles = found.strobe.cycles
        mesh_cycles = float(cycles[f"{self.mesh}.contact"]) if f"{self.mesh}.contact" in cycles else 1.0
        pressed, kept = values[:-1, 1], np.delete(values[:-1], 1, axis=1)
        return SweepPoint(
            speed=speed,
            frequency=mesh_cycles / found.strobe.period,
            rms=tuple(kept.std(axis=0).tolist()),
            least=tuple(kept.min(axis=0).tolist()),
            largest=tuple(kept.max(axis=0).tolist()),
            separated=float("nan") if failure else float(np.mean(pressed == 0)),
            back=float("nan") if failure else float(np.mean(pressed < 0)),
            period=found.period,
            residual=found.residual,
            settled=found.settled,
            failure=failure,
        )


def _changes(branch: _Branches, way: str, points: list[tuple[SweepPoint, Array]], close: float) -> Iterator[Change]:
    """Jumps, and where flanks begin or cease to part, each closed in on along the branch."""
    steps = np.array([_step(one, other) for (one, _), (other, _) in pairwise(points)])
    slopes = steps / np.abs([np.log(one.speed / other.speed) for (one, _), (other, _) in pairwise(points)])
    known = slopes[np.isfinite(slopes)]
    steep = (slopes > JUMP * float(np.median(known))) & (steps > LEAST) if known.size else np.zeros(len(slopes), dtype=bool)
    for k, ((before, state), (after, _)) in enumerate(pairwise(points)):
        if before.failure or after.failure:
            continue
        if (before.separated > 0) != (after.separated > 0):
            kind = "parts" if after.separated else "joins"
            ends = _closed_in(branch, before, after, state, close, lambda x, y, z: (x.separated > 0) == (y.separated > 0))
            yield _change(way, kind, *ends)
        if steep[k]:
            ends = _closed_in(branch, before, after, state, close, lambda x, y, z: _step(x, y) < _step(y, z))
            # A steep slope is no jump: a smaller step changes less.
            if not close or _step(*ends) > LEAST:
                yield _change(way, "jump", *ends)


def _change(way: str, kind: str, before: SweepPoint, after: SweepPoint) -> Change:
    return Change(way, kind, before.frequency, after.frequency, before.rms[0], after.rms[0])


def _step(one: SweepPoint, other: SweepPoint) -> float:
    """Change of the logarithm of the rms."""
    if one.failure or other.failure:
        return float("nan")
    return abs(float(np.log(max(one.rms[0], TINY) / max(other.rms[0], TINY))))


def _closed_in(
    branch: _Branches,
    before: SweepPoint,
    after: SweepPoint,
    state: Array,
    close: float,
    stays: Callable[[SweepPoint, SweepPoint, SweepPoint], bool],
) -> tuple[SweepPoint, SweepPoint]:
    """The last point that ``stays`` (before, middle, after) and the first that does not, by halving from the branch's side."""
    while 0 < close * after.speed < abs(after.speed - before.speed):
        middle, final = branch.at([(before.speed + after.speed) / 2], [state])[0]
        if middle.failure:
            break
        if stays(before, middle, after):
            before, state = middle, final
        else:
            after = middle
    return before, after
