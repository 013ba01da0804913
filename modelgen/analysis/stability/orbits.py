"""Question: is there a periodic motion, after how many periods of the excitation does it repeat, and does it attract?

From a settled start, ``shooting`` finds a motion that comes back to itself, ``multipliers`` says what becomes of
small deviations. "Period n proven" means: followed with a tenth of the tolerance, it misses its start by less than 1e-10 of each
state's scale, misses it at every earlier strobe by far more, and every multiplier lies inside the unit circle. The rigid rotation
is left out (its multipliers are exactly 1).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.nonlinear.common_period import strobe_of
from modelgen.analysis.stability.coordinates import Vibration, vibration_of
from modelgen.analysis.stability.course import Course
from modelgen.analysis.stability.multipliers import Complex, kind_of_loss, kinds_of_loss, multipliers_of, stability
from modelgen.analysis.stability.shooting import Shot, residual, shoot, speed_at
from modelgen.errors import CaseError
from modelgen.solvers.asked_case import asked_case
from modelgen.solvers.case import Case
from modelgen.solvers.problem import SolverOptions
from modelgen.solvers.registry import solve

Array = NDArray[np.float64]
PROVEN = 1e-10
"""Residual, in scales of the states, up to which a motion counts as coming back to itself."""
APART = 1e-6
"""Distance, in scales, above which an earlier strobe is another point."""
SETTLED = 1e-6
SLOW = 1000.0
"""Periods in which a deviation halves, above which no run of the usual length comes to an orbit."""
SEARCH, RETURN = 4000, 0.05


@dataclass(frozen=True, eq=False)
class PeriodicOrbit:
    """A motion that repeats, or the best that was found.

    ``period`` [s] = ``order`` times ``base_period`` (that of the excitation; for an autonomous system its own, order 1).
    ``begin`` [s] and ``state`` (of all states, the rigid rotation so that it does not drift): where it starts. ``residual``:
    largest distance of the end from the start, in scales of the states. ``multipliers``: largest first; ``flow``: the one along
    the motion of an autonomous system, 1 in theory. ``neutral``: states of the rigid rotation, whose multipliers are exactly 1.
    ``rounds`` of Newton's method.
    """

    model: str
    names: tuple[str, ...]
    begin: float
    state: Array
    period: float
    base_period: float
    order: int
    residual: float
    multipliers: Complex
    flow: complex | None
    neutral: tuple[str, ...]
    autonomous: bool
    rounds: int
    tolerance: float

    @property
    def found(self) -> bool:
        """Whether the motion comes back to itself."""
        return self.residual < PROVEN

    @property
    def proven(self) -> bool:
        """Whether it comes back to itself and attracts."""
        return self.found and self.stability == "stable"

    @property
    def stability(self) -> str:
        """ "stable", "unstable" or "undecided", by the multipliers."""
        return stability(self.multipliers)

    @property
    def losses(self) -> tuple[str, ...]:
        """How stability is lost: "fold", "flip", "Neimark-Sacker"; empty for an orbit that is not unstable."""
        return kinds_of_loss(self.multipliers)

    @property
    def verdict(self) -> str:
        """One sentence: what was found, and on what evidence."""
        what = "limit cycle" if self.autonomous else f"period {self.order}"
        if not self.found:
            return (
                f"not found: after {self.rounds} rounds of Newton's method the end still misses the start by "
                f"{self.residual:.2g} scales; start nearer to the orbit, settle longer, or try another order"
            )
        evidence = f"residual {self.residual:.1g} of the scales, largest |multiplier| {self.largest:.9g}"
        if self.stability == "stable":
            return f"{what} proven{self._patience()}: {evidence}"
        if self.stability == "unstable":
            return f"{what} exists and is unstable ({', '.join(self.losses)}): {evidence}"
        return f"{what} exists, its stability is undecided ({kind_of_loss(self.multipliers[0])} at hand): {evidence}"

    @property
    def half_life(self) -> float:
        """Periods after which the deviation that lasts longest is half of what it was; inf where none decays."""
        if not 0 < self.largest < 1:
            return 0.0 if self.largest == 0 else float("inf")
        return float(np.log(0.5) / np.log(self.largest))

    def _patience(self) -> str:
        """In words, that no run of the usual length comes to an orbit which attracts so slowly."""
        if self.half_life < SLOW:
            return ""
        halves = f"a deviation halves in {self.half_life:.2g} periods, {self.half_life * self.period:.2g} s"
        return f", though it hardly attracts ({halves}: runs show what they began with)"

    @property
    def largest(self) -> float:
        """The largest |multiplier|, 0 without any."""
        return float(np.abs(self.multipliers).max(initial=0.0))

    @property
    def start(self) -> Mapping[str, float]:
        """The state by name, as a ``Case`` takes it."""
        return dict(zip(self.names, self.state.tolist(), strict=True))

    def __str__(self) -> str:
        rows = [f"periodic orbit of {self.model!r}: {self.verdict}", f"  period {self.period:.12g} s"]
        for each in self.multipliers[:8]:
            rows.append(f"  multiplier {complex(each):.9g}, size {abs(each):.9g}")
        if self.flow is not None:
            rows.append(f"  along the motion {self.flow.real:.9g}, 1 in theory")
        if self.neutral:
            rows.append(f"  apart, exactly 1: {', '.join(self.neutral)}")
        return "\n".join(rows)

    __repr__ = __str__


def periodic_orbit(
    case: Any,
    *,
    order: int = 1,
    period: float | None = None,
    settle: int = 20,
    tolerance: float = 1e-12,
    report: Callable[[str], None] | None = None,
) -> PeriodicOrbit:
    """The periodic motion near where a case settles, that repeats after ``order`` periods of its excitation.

    The case gives the model, its parameters, where to start, and the tolerance for settling; ``settle``: at most so many periods
    (fewer where it stands still before; 0 takes the start as it is). ``period`` [s] of the excitation where the model does not
    know it (time stands in a plain system's rates); of an autonomous system, a first guess instead of a search up to the end of
    the case. ``tolerance``: of the shooting. Raises CaseError where there is no period, or the motion cannot be followed.

    >>> from modelgen import lower, system
    >>> model = lower(system({"x": 2.0, "v": 0.0}, {"x": "v", "v": "(1 - x**2)*v - x"}, name="van_der_pol"))
    >>> orbit = periodic_orbit(Case(model, end=30.0))
    >>> round(orbit.period, 8), orbit.proven, orbit.multipliers.real.round(6).tolist()
    (6.66328686, True, [0.00086])
    """
    if isinstance(order, bool) or not isinstance(order, int) or order < 1:
        raise CaseError("periodic orbit, order", f"is {order!r}", "give a whole number from 1 up")
    if period is not None and not 0 < period < np.inf:
        raise CaseError("periodic orbit, period", f"is {period!r}", "give a positive time")
    tell = report or (lambda _: None)
    case = asked_case(case, "periodic orbit")
    vibration = vibration_of(case)
    given = dict(case.options)
    backend = str(given.get("backend", "auto"))
    course = Course(vibration.problem, "rk4", SolverOptions(case.tolerance, backend=backend))
    free = vibration.autonomous
    if free and order != 1:
        raise CaseError("periodic orbit, order", f"is {order}, but nothing excites the system", "leave it out")
    tell("settle")
    base = _settled_period(vibration, course, case, order, period, settle)
    problem = replace(vibration.problem, x0=course.state, p=course.p)  # strobes are alike, so time goes back to the start
    options = SolverOptions(tolerance, backend=backend)
    shot = shoot(problem, base * order, free, options, lambda rounds: tell(f"shoot, round {rounds}"))
    shot, order = _shortest(problem, shot, order, free, options, tell)
    tell("check")
    left = residual(problem, shot.state, shot.period, replace(options, tolerance=tolerance / 10))
    along = speed_at(problem, shot.state) if free else None
    multipliers, flow = multipliers_of(shot.monodromy, along)
    return PeriodicOrbit(
        model=vibration.model.name,
        names=vibration.whole.names,
        begin=problem.t0,
        state=_at_rest(vibration, shot, backend),
        period=shot.period,
        base_period=shot.period if free else base,
        order=order,
        residual=max(left, shot.residual),
        multipliers=multipliers,
        flow=flow,
        neutral=vibration.neutral_names,
        autonomous=free,
        rounds=shot.rounds,
        tolerance=tolerance,
    )


def _settled_period(vibration: Vibration, course: Course, case: Case, order: int, period: float | None, settle: int) -> float:
    """The period of the excitation (of an autonomous system, a guess) with the course where the motion has settled."""
    if not vibration.autonomous:
        base = period if period is not None else strobe_of(vibration.model, vibration.point).period
        strobes = [course.state]
        for turn in range(1, settle + 1):
            course.advance(np.array([vibration.problem.t0 + turn * base]))
            strobes.append(course.state)
            if turn >= order and np.abs((strobes[-1] - strobes[-1 - order]) / course.problem.scale).max() < SETTLED:
                break
        return base
    if settle:
        course.advance(np.array([vibration.problem.t0 + (settle * period if period is not None else case.end - case.begin)]))
    return period if period is not None else _return_time(course.copy(), case.end - case.begin)


def _return_time(course: Course, longest: float) -> float:
    """After which time an autonomous motion first comes back near where it is [s]."""
    begin, here = course.time, course.state
    times = begin + longest * np.arange(1, SEARCH + 1) / SEARCH
    away = np.array([np.linalg.norm((each.x0 - here) / each.scale) for each in course.advance(times)][1:])
    far = away.max(initial=0.0)
    left = np.flatnonzero(away > 0.5 * far)
    if far > APART and len(left):
        for k in range(int(left[0]) + 1, len(away) - 1):
            if away[k] < RETURN * far and away[k - 1] >= away[k] <= away[k + 1]:
                return float(times[k] - begin)
    what = f"does not come back near its start within {longest:.6g} s"
    raise CaseError("periodic orbit", what, "give the case a later end, or a first guess of the period")


def _shortest(
    problem: Any, shot: Shot, order: int, free: bool, options: SolverOptions, tell: Callable[[str], None]
) -> tuple[Shot, int]:
    """The shot over the shortest period after which the motion has come back: a divisor of the one asked for."""
    pieces = 12 if free else order
    if shot.residual > APART or pieces == 1:
        return shot, order
    strobes = replace(problem, x0=shot.state, times=problem.t0 + shot.period * np.arange(1, pieces + 1) / pieces)
    run = solve(strobes, "rk4", options)
    for part in (each for each in range(1, pieces) if pieces % each == 0):
        if len(run.times) >= part and np.abs((run.states[part - 1] - shot.state) / problem.scale).max() < APART:
            tell("shoot over the shorter period")
            again = shoot(replace(problem, x0=shot.state), shot.period * part / pieces, free, options, lambda _: None)
            return again, part if not free else 1
    return shot, order


def _at_rest(vibration: Vibration, shot: Shot, backend: str) -> Array:
    """The whole state, with rigid speeds such that rigid angles return too."""
    state = vibration.state(shot.state)
    order = len(vibration.model.equations.steps)
    turning = [k for k in vibration.neutral if k < order and k + order in vibration.neutral]
    if turning:
        start = replace(vibration.whole, x0=state, times=np.array([vibration.whole.t0 + shot.period]))
        run = solve(start, "rk4", SolverOptions(1e-10, backend=backend))
        if len(run.times):
            for k in turning:
                state[k + order] = -run.states[-1, k] / shot.period
    return state
