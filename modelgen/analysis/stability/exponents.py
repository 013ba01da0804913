"""Question: do neighboring motions part or meet, and how fast? The Lyapunov exponents, with their uncertainty.

Over a motion that has settled: the propagators of short stretches (``propagators``) applied to a frame that is made
orthonormal again after each (QR); the logarithms of what it was stretched by, per time, are the exponents. The rigid rotation is
left out (its exponents are exactly 0). By Liouville the exponents sum up to the mean of tr J; that is checked, not used.
Sources: G. Benettin et al., Meccanica 15 (1980) 9; P. Frederickson et al., J. Diff. Eq. 49 (1983) 185 (Kaplan-Yorke dimension).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.nonlinear.common_period import acting_bases, strobe_of
from modelgen.analysis.stability.coordinates import Vibration, vibration_of
from modelgen.analysis.stability.course import Course, stretch_length
from modelgen.analysis.stability.frames import all_directions, one_direction, tamed
from modelgen.analysis.stability.interval import half_width
from modelgen.errors import CaseError
from modelgen.solvers.case import Case
from modelgen.solvers.problem import SolverOptions
from modelgen.solvers.registry import solver_named, solver_options

Array = NDArray[np.float64]
FEWEST = 16
"""Stretches below which there is no interval to speak of."""
TURNING = 0.1
"""Share of the stretches in which the frame turns into its place, before any is counted."""
CURVE = 400
"""Points of the curves that show how the estimates settle."""


@dataclass(frozen=True, eq=False)
class ExponentsResult:
    """Lyapunov exponents [1/s, natural logarithms], largest first.

    ``half_width``: half their 95 % intervals, from the scatter in time and the tolerance of a stretch. ``complete``: none is
    missing. ``times`` [s] (from ``begin``), ``running`` (times, exponents): estimates so far. ``neutral``: states of the rigid
    rotation, whose exponents are exactly 0 and are not in the list. ``flow``: number of the exponent along the motion of an
    autonomous system, 0 in theory; None where there is none, or the list is not complete. ``divergence`` [1/s]: mean of tr J;
    ``trace_gap``: sum of exponents minus that (nan unless complete). ``period`` [s] of the excitation, 0 without one.
    ``stretch`` [s] between two QR, ``stretches`` counted.
    """

    model: str
    exponents: Array
    half_width: Array
    complete: bool
    neutral: tuple[str, ...]
    flow: int | None
    autonomous: bool
    divergence: float
    trace_gap: float
    begin: float
    times: Array
    running: Array
    period: float
    stretch: float
    stretches: int
    tolerance: float

    @property
    def duration(self) -> float:
        """Time over which the exponents are means [s]."""
        return self.stretch * self.stretches

    @property
    def dimension(self) -> float:
        """Kaplan-Yorke dimension of the attractor (of its section by the strobe, where the excitation is periodic).

        j + (sum of the first j exponents) / |exponent j + 1|, with the last j whose sum is not negative; the exponent of the flow
        counts as 0. Not a number where the list is not complete.
        """
        if not self.complete:
            return float("nan")
        values = self.exponents.copy()
        if self.flow is not None:
            values[self.flow] = 0.0
        sums = np.cumsum(np.sort(values)[::-1])
        count = int(np.count_nonzero(sums >= 0)) if sums[0] >= 0 else 0
        if count in (0, len(values)):
            return float(count)
        return count + float(sums[count - 1]) / -float(np.sort(values)[::-1][count])

    @property
    def sign(self) -> str:
        """What the largest exponent, besides that of the flow, says: "positive", "negative" or "undecided"."""
        others = [k for k in range(len(self.exponents)) if k != self.flow]
        if not others:
            return "undecided"
        low, high = (float(self.exponents[others[0]] + side * self.half_width[others[0]]) for side in (-1, 1))
        return "positive" if low > 0 else "negative" if high < 0 else "undecided"

    def __str__(self) -> str:
        kind = "all" if self.complete else "the largest"
        head = f"Lyapunov exponents of {self.model!r} over {self.duration:.6g} s: {kind} {len(self.exponents)}, {self.sign}"
        rows = [head]
        for k, (value, half) in enumerate(zip(self.exponents, self.half_width, strict=True)):
            rows.append(f"  {k + 1:3d} {value:14.6g} +- {half:.2g} 1/s{'  (along the motion)' if k == self.flow else ''}")
        if self.neutral:
            rows.append(f"  apart, exactly 0: {', '.join(self.neutral)}")
        if self.complete:
            rows.append(f"  sum - mean divergence {self.trace_gap:.2g} 1/s, Kaplan-Yorke dimension {self.dimension:.4g}")
        return "\n".join(rows)

    __repr__ = __str__


def lyapunov_exponents(case: Case, *, largest: bool = False, stretch: float | None = None) -> ExponentsResult:
    """The exponents of the motion of a case, over whole stretches from its ``record_from`` to its ``end``.

    What lies before ``record_from`` is a transient. ``largest``: the largest exponent only, with one tangent vector that rides
    along (some times cheaper for a driveline). ``stretch`` [s] between two QR, by default from the spread of the rates of
    decay. Raises CaseError for a motion that ends before, or a span of fewer than 16 stretches.

    >>> from modelgen import lower, system
    >>> model = lower(system({"x": 1.0, "v": 0.0}, {"x": "v", "v": "-2*x - 3*v"}))  # roots -1 and -2
    >>> lyapunov_exponents(Case(model, end=20.0)).exponents.round(4).tolist()
    [-1.0, -2.0]
    """
    vibration = vibration_of(case)
    given = dict(case.options)
    progress = given.pop("progress", None)
    backend = {"backend": "auto"} if "backend" in solver_named(case.solver).extra_options else {}
    course = Course(vibration.problem, case.solver, solver_options(case.tolerance, backend | given))
    begin, span = float(case.record_from or 0.0), case.end - float(case.record_from or 0.0)
    course.advance(np.array([begin]))
    period = _period(vibration)
    runs = SolverOptions(case.tolerance, backend=str(given.get("backend", "auto")))
    if stretch is not None:
        length = _positive(stretch)
    else:
        length = stretch_length(course, span, period, largest)
        if not largest:
            length = tamed(course, length, span, runs)
    cycle = round(period / length)  # stretches in a period: where it is a whole number of them, only whole periods are averaged
    if cycle == 0 or abs(cycle * length - period) > 1e-9 * period:
        cycle = 1
    count = int(span / (cycle * length) * (1 + 1e-12)) * cycle
    if count < FEWEST:
        what = f"holds {count} stretches of {length:.4g} s, of which at least {FEWEST} are needed"
        raise CaseError(
            "Lyapunov exponents", f"the span from {begin:.6g} to {case.end:.6g} s {what}", "give the case a later end"
        )
    turning = ceil(TURNING * count / cycle) * cycle
    if turning == count:
        turning = count // 2
    frame = one_direction if largest else all_directions
    ends = np.asarray(begin + length * np.arange(1, count + 1), dtype=float)
    found = frame(course, ends, length, runs, np.random.default_rng(case.seed), progress)
    logs, volumes = (each[turning:] / length for each in found)
    exponents = logs.mean(axis=0)
    order = np.argsort(-exponents, kind="stable")
    exponents, logs = exponents[order], logs[:, order]
    autonomous, complete = vibration.autonomous, len(exponents) == len(vibration.kept)
    taken = np.unique(np.linspace(1, len(logs), min(CURVE, len(logs))).astype(int))
    running = np.cumsum(logs, axis=0)[taken - 1] / taken[:, None]
    divergence = float(volumes.mean())
    return ExponentsResult(
        model=vibration.model.name,
        exponents=exponents,
        half_width=np.hypot(_scatter(logs, cycle), case.tolerance / length),
        complete=complete,
        neutral=vibration.neutral_names,
        flow=int(np.abs(exponents).argmin()) if autonomous and complete and course.moves() else None,
        autonomous=autonomous,
        divergence=divergence,
        trace_gap=float(exponents.sum()) - divergence if complete else float("nan"),
        begin=begin + turning * length,
        times=taken * length,
        running=running,
        period=period,
        stretch=length,
        stretches=len(logs),
        tolerance=case.tolerance,
    )


def _scatter(logs: Array, cycle: int) -> Array:
    """Half widths from the means over whole periods where there are enough of them, else over stretches."""
    whole = len(logs) // cycle
    if whole >= FEWEST and whole * cycle == len(logs):
        logs = logs.reshape(whole, cycle, -1).mean(axis=1)
    return half_width(logs)


def _period(vibration: Vibration) -> float:
    """The common period of the excitation [s], or 0 where there is none that is worth waiting for."""
    if not vibration.model.equations.clocks or not acting_bases(vibration.model, vibration.point):
        return 0.0
    try:
        return strobe_of(vibration.model, vibration.point).period
    except CaseError:
        return 0.0


def _positive(stretch: float) -> float:
    if not 0 < stretch < np.inf:
        raise CaseError("Lyapunov exponents, stretch", f"is {stretch!r}", "give a positive time")
    return float(stretch)
