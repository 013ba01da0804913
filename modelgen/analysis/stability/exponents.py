"""Question: do neighboring motions part or meet, and how fast? The Lyapunov exponents, with their uncertainty.

Over a motion that has settled: the propagators of short stretches (``propagators``) applied to a frame that is made
orthonormal again after each (QR); the logarithms of what it was stretched by, per time, are the exponents. The rigid rotation is
left out (its exponents are exactly 0). By Liouville the exponents sum up to the mean of tr J; that is checked, not used.
Sources: G. Benettin et al., Meccanica 15 (1980) 9; P. Frederickson et al., J. Diff. Eq. 49 (1983) 185 (Kaplan-Yorke dimension).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.nonlinear.common_period import acting_bases, strobe_of
from modelgen.analysis.stability.coordinates import Vibration, vibration_of
from modelgen.analysis.stability.course import Course, stretch_length
from modelgen.analysis.stability.ending import exponents_of
from modelgen.analysis.stability.frames import all_directions, one_direction
from modelgen.analysis.stability.orbits import PeriodicOrbit
from modelgen.analysis.stability.records import FEWEST, Part, Record, drifted, joined, scatter, settled_part, widened
from modelgen.analysis.time_domain.window import settled_window
from modelgen.errors import CaseError
from modelgen.solvers.asked_case import asked_case
from modelgen.solvers.bound_model import bind
from modelgen.solvers.case import Case
from modelgen.solvers.problem import SolverOptions
from modelgen.solvers.registry import solver_named, solver_options

Array = NDArray[np.float64]
TURNING, LEFT_OUT = 0.1, 0.05
"""Shares of the stretches in which the frame turns into its place: those before the span, and those of it, if none are before."""
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
    ``stretch`` [s] of a local mean, ``stretches`` counted. ``left_out`` [s] of the span asked for. ``stationary``: whether the
    record is one and the same all the way; if not, ``transient`` [s] of it came before what the exponents are of, with
    ``transient_exponents`` (and the half width of the largest), and ``ends_in`` says what the motion comes to, as far as shooting
    found it. ``beside``: an attractor that exists as well; ``known``: whether the sign of the largest can be told.
    ``drift``: what has not settled even at the end of the record; the exponents are then no long-run values.
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
    left_out: float = 0.0
    stationary: bool = True
    transient: float = 0.0
    transient_exponents: Array = field(default_factory=lambda: np.zeros(0))
    transient_half_width: Array = field(default_factory=lambda: np.zeros(0))
    ends_in: str = ""
    beside: str = ""
    known: bool = True
    drift: str = ""

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
        if not others or not self.known:
            return "undecided"
        low, high = (float(self.exponents[others[0]] + side * self.half_width[others[0]]) for side in (-1, 1))
        return "positive" if low > 0 else "negative" if high < 0 else "undecided"

    @property
    def transient_chaos(self) -> bool:
        """Whether neighbors parted during the transient, and no longer do."""
        if self.stationary or not len(self.transient_exponents) or self.sign != "negative":
            return False
        return bool(self.transient_exponents[0] > self.transient_half_width[0] >= 0)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is to be said beside the numbers: stationarity, attractors, and what was left out of the span."""
        said = []
        if self.drift:
            said.append(f"not stationary: {self.drift}; what it comes to in the long run is not known")
        if not self.stationary and (self.transient or not self.drift):
            then = f"then {self.ends_in}" if self.ends_in else "then another motion, whose end is not known"
            of = f" (largest exponent {self.transient_exponents[0]:.3g} 1/s)" if len(self.transient_exponents) else ""
            said.append(f"not stationary: {self.transient:.6g} s of transient{of}, {then}")
        if self.beside:
            said.append(f"beside it: {self.beside}; this motion may be a transient toward it, and the intervals hold both")
        if self.left_out:
            said.append(f"{self.left_out:.4g} s of the span are left out, in which the frame of deviations turns into its place")
        return tuple(said)

    def __str__(self) -> str:
        kind = "all" if self.complete else "the largest"
        head = f"Lyapunov exponents of {self.model!r} over {self.duration:.6g} s: {kind} {len(self.exponents)}, {self.sign}"
        rows = [head, *self.remarks]
        for k, (value, half) in enumerate(zip(self.exponents, self.half_width, strict=True)):
            rows.append(f"  {k + 1:3d} {value:14.6g} +- {half:.2g} 1/s{'  (along the motion)' if k == self.flow else ''}")
        if self.neutral:
            rows.append(f"  apart, exactly 0: {', '.join(self.neutral)}")
        if self.complete:
            rows.append(f"  sum - mean divergence {self.trace_gap:.2g} 1/s, Kaplan-Yorke dimension {self.dimension:.4g}")
        return "\n".join(rows)

    __repr__ = __str__


def lyapunov_exponents(
    case: Any,
    *,
    largest: bool = False,
    stretch: float | None = None,
    revolutions: int = 100,
    transient: int | None = None,
    tolerance: float | None = None,
) -> ExponentsResult:
    """The exponents of the motion of a case, over whole stretches from its ``record_from`` to its ``end``.

    Of anything else that is a model, a case is made: from the static state, over so many ``revolutions`` of its slowest base
    frequency after ``transient`` of them, by default until its slowest mode has decayed to a thousandth.

    What lies before ``record_from`` is a transient, in which the frame of deviations turns into its place; where it is shorter
    than a twentieth of the span, the rest of that is left out of the means (``left_out``). ``largest``: the largest exponent
    only, with one tangent vector that rides along (some times cheaper for a driveline). ``stretch`` [s] over which local means
    are kept, by default from the spread of the rates of decay; deviations are made orthonormal as often as they need. A record
    that is not stationary says so, and its exponents are those of what comes after the transient; where a stable orbit is found
    beside what looks like chaos, the intervals hold both. Raises CaseError for a motion that ends before, or a span of fewer than
    16 stretches.

    >>> from modelgen import lower, system
    >>> model = lower(system({"x": 1.0, "v": 0.0}, {"x": "v", "v": "-2*x - 3*v"}))  # roots -1 and -2
    >>> lyapunov_exponents(Case(model, end=20.0)).exponents.round(4).tolist()
    [-1.0, -2.0]
    """
    case = _asked(case, revolutions, transient, tolerance)
    vibration = vibration_of(case)
    given = dict(case.options)
    progress = given.pop("progress", None)
    backend = {"backend": "auto"} if "backend" in solver_named(case.solver).extra_options else {}
    course = Course(vibration.problem, case.solver, solver_options(case.tolerance, backend | given))
    begin, span = float(case.record_from or 0.0), case.end - float(case.record_from or 0.0)
    period = _period(vibration)
    pilot = course.copy()
    pilot.advance(np.array([begin]))
    length = _positive(stretch) if stretch is not None else stretch_length(pilot, span, period, largest)
    cycle = round(period / length)  # stretches in a period: where it is a whole number of them, only whole periods are averaged
    if cycle == 0 or abs(cycle * length - period) > 1e-9 * period:
        cycle = 1
        if stretch is None:
            length = span / ceil(span / length * (1 - 1e-12))
    count = int(span / (cycle * length) * (1 + 1e-12)) * cycle
    if count < FEWEST:
        what = f"holds {count} stretches of {length:.4g} s, of which at least {FEWEST} are needed"
        raise CaseError(
            "Lyapunov exponents", f"the span from {begin:.6g} to {case.end:.6g} s {what}", "give the case a later end"
        )
    before = min(ceil(TURNING * count), int((begin - vibration.problem.t0) / length * (1 + 1e-12)))
    turning = min(max(0, ceil((ceil(LEFT_OUT * count) - before) / cycle)) * cycle, count // 2)
    course.advance(np.array([begin - before * length]))
    frame = one_direction if largest else all_directions
    ends = np.asarray(begin + length * np.arange(1 - before, count + 1), dtype=float)
    runs = SolverOptions(case.tolerance, backend=str(given.get("backend", "auto")))
    found = frame(course, ends, length, runs, np.random.default_rng(case.seed), progress)
    skipped = before + turning
    record = Record(
        logs=found.logs[skipped:] / length,
        volumes=found.volumes[skipped:] / length,
        strobes=found.states[skipped + cycle - 1 :: cycle] / course.problem.scale,
        begin=begin + turning * length,
        length=length,
        cycle=cycle,
        period=period if cycle > 1 or abs(length - period) <= 1e-9 * period else 0.0,
    )
    part = settled_part(record, case, vibration, course)
    return _result(case, vibration, course, record, part, span - len(record.logs) * length)


def _asked(x: Any, revolutions: int, transient: int | None, tolerance: float | None) -> Case:
    """The case itself, or one over some revolutions of a model."""
    if isinstance(x, Case):
        return asked_case(x, "Lyapunov exponents", tolerance=tolerance)
    bound = bind(x, question="Lyapunov exponents")
    window = settled_window(bound)
    first = window.first if transient is None else transient * window.period
    last = first + revolutions * window.period
    return asked_case(bound, "Lyapunov exponents", tolerance=tolerance, end=last, record_from=first)


def _result(case: Case, vibration: Vibration, course: Course, record: Record, part: Part, left_out: float) -> ExponentsResult:
    """The means over the part of the record that counts, with all that is said of it."""
    logs, whole, length = record.logs[part.first :], record.logs, record.length
    order = np.argsort(-logs.mean(axis=0), kind="stable")
    exponents = logs.mean(axis=0)[order]
    autonomous, complete = vibration.autonomous, len(exponents) == len(vibration.kept)
    half = np.hypot(scatter(logs[:, order], record.cycle), case.tolerance / length)
    if part.ending.reached:
        exponents, half = joined(exponents, half, part.ending.exponents, case.tolerance / length)
    if part.beside is not None:
        half = widened(exponents, half, part.beside)
    if part.thirds is not None:
        half = drifted(exponents, half, part.thirds)
    taken = np.unique(np.linspace(1, len(whole), min(CURVE, len(whole))).astype(int))
    divergence = float(record.volumes[part.first :].mean())
    transient = part.transient
    return ExponentsResult(
        model=vibration.model.name,
        exponents=exponents,
        half_width=half,
        complete=complete,
        neutral=vibration.neutral_names,
        flow=int(np.abs(exponents).argmin()) if autonomous and complete and course.moves() else None,
        autonomous=autonomous,
        divergence=divergence,
        trace_gap=float(logs.mean(axis=0).sum()) - divergence if complete else float("nan"),
        begin=record.begin + part.first * length,
        times=taken * length,
        running=np.cumsum(whole[:, order], axis=0)[taken - 1] / taken[:, None],
        period=record.period,
        stretch=length,
        stretches=len(logs),
        tolerance=case.tolerance,
        left_out=max(0.0, left_out) if left_out > 1e-9 * len(whole) * length else 0.0,
        stationary=part.stationary,
        transient=len(whole) * length if part.after else part.first * length,
        transient_exponents=np.sort(transient.mean(axis=0))[::-1] if len(transient) else np.zeros(0),
        transient_half_width=scatter(transient, record.cycle)[:1] if len(transient) else np.zeros(0),
        ends_in=part.ending.words,
        beside=_told(part.beside),
        known=part.known,
        drift=part.drift,
    )


def _told(orbit: PeriodicOrbit | None) -> str:
    if orbit is None:
        return ""
    return f"a stable orbit, largest exponent {exponents_of(orbit)[0]:.4g} 1/s, {orbit.verdict}"


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
