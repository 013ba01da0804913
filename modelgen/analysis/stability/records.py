"""Which part of a record of local exponents counts, and how sure its means are.

Below ``exponents``. A record whose local means change is not stationary: what comes after the last change counts, from where the
strobes stand still if they do. Where the record looks like chaos all the way, shooting from its end tells whether a stable orbit
is at hand, to which it may come yet.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.stability.coordinates import Vibration
from modelgen.analysis.stability.course import Course, jacobian
from modelgen.analysis.stability.ending import Ending, ending, exponents_of, returns
from modelgen.analysis.stability.interval import half_width
from modelgen.analysis.stability.orbits import PeriodicOrbit
from modelgen.analysis.stability.orbits_beside import stable_orbit
from modelgen.analysis.stability.stationarity import SMALL, departure, drift, steady_from
from modelgen.solvers.case import Case

Array = NDArray[np.float64]
FEWEST = 16
"""Stretches below which there is no interval to speak of."""
PRICE = 1.5
"""Of the record: what the search for a stable orbit beside it may cost."""
THIRD = 1 / 3
"""Of the record: a part that came to no known attractor tells a sign only if it is longer."""


@dataclass(frozen=True, eq=False)
class Record:
    """Local exponents ``logs`` (stretches, exponents) and mean traces ``volumes`` (stretches,) [1/s] from ``begin`` [s] on.

    Each is over ``length`` [s]; ``strobes`` (cycles, states per scale) after every ``cycle`` stretches, ``period`` [s] apart (0:
    not known).
    """

    logs: Array
    volumes: Array
    strobes: Array
    begin: float
    length: float
    cycle: int
    period: float

    def leading(self, vibration: Vibration) -> Array:
        """The largest local exponent (cycles,), but for the one along an autonomous motion."""
        means = self.logs.mean(axis=0)
        order = np.argsort(-means, kind="stable")
        if vibration.autonomous and len(order) > 1 and np.argmin(np.abs(means)) == order[0]:
            order = order[1:]
        cycle = min(self.cycle, len(self.logs))  # a record shorter than one cycle counts as one
        whole = len(self.logs) // cycle
        return np.asarray(self.logs[: whole * cycle, order[0]].reshape(whole, cycle).mean(axis=1))


@dataclass(frozen=True, eq=False)
class Part:
    """The stretches from ``first`` on count, after the local exponents ``transient`` (stretches, exponents). ``after``: the whole
    record is transient. ``known``: whether a sign may be told; ``beside``: a stable orbit to which the motion may come yet.
    ``drift``: what has not settled at the end of the record, in words; ``thirds`` (3,): the largest local exponent in its thirds,
    where that drifts.
    """

    first: int
    stationary: bool
    ending: Ending
    transient: Array
    after: bool = False
    known: bool = True
    beside: PeriodicOrbit | None = None
    drift: str = ""
    thirds: Array | None = None


def settled_part(record: Record, case: Case, vibration: Vibration, course: Course) -> Part:
    """The part of a record that counts, and whether it goes on as it is. The ``course`` stands at its end."""
    part = _after_changes(record, case, vibration, course)
    if part.after or part.ending.reached or part.ending.period:
        return part
    cycles = part.first // record.cycle
    thirds = drift(record.leading(vibration)[cycles:], 2 * case.tolerance / record.length)
    if thirds is not None:
        words = f"the largest local exponent still drifts, {thirds[0]:.3g}, {thirds[1]:.3g} and {thirds[2]:.3g} 1/s in its thirds"
        return replace(part, stationary=False, known=False, drift=words, thirds=thirds)
    grown = departure(record.strobes[cycles:])
    if grown and not _is_linear(course):
        words = f"the motion still departs from where it was, in steps that have grown {grown:.3g} times"
        return replace(part, stationary=False, known=False, drift=words)
    return part


def _is_linear(course: Course) -> bool:
    """Whether rates are linear in the states, so that exponents are the same wherever the motion is."""
    rhs, switching = course.problem.rhs, course.problem.switching
    return switching is None and bool(jacobian(rhs).jac_sparsity(0, 1).nnz() == 0)


def _after_changes(record: Record, case: Case, vibration: Vibration, course: Course) -> Part:
    """The part of a record behind its last change."""
    series, floor = record.leading(vibration), 2 * case.tolerance / record.length
    cycles = steady_from(series, floor)
    back = returns(record.strobes, case.tolerance) if record.period else None
    if back is not None and back.period and 0 < back.first < len(series):
        early, late = float(series[: back.first].mean()), float(series[back.first :].mean())
        if abs(early - late) > max(floor, SMALL * max(abs(early), abs(late))) and back.first >= FEWEST:
            cycles = max(cycles, back.first)
    none = np.zeros((0, record.logs.shape[1]))
    hopeful = _is_positive(series[cycles:])
    if not cycles and not hopeful:
        return Part(0, True, Ending(), none)
    found = ending(case, vibration, course, record.strobes, record.period)
    if found.reached and not found.period:  # it settles only after the record
        return Part(0, False, found, record.logs, after=True)
    if found.period and (cycles or found.first >= FEWEST):
        cycles = min(max(cycles, found.first), len(series) - 1)
    first = cycles * record.cycle
    beside = None
    if hopeful and record.period and not found.period:
        beside = found.orbit if found.orbit is not None else _beside(record, case, vibration)
    if not first:
        return Part(0, True, found, none, beside=beside)
    told = bool(found.period) or found.at_rest or len(series) - cycles >= THIRD * len(series)
    return Part(first, False, found, record.logs[:first], known=told, beside=beside)


def _beside(record: Record, case: Case, vibration: Vibration) -> PeriodicOrbit | None:
    """A stable orbit beside the motion, looked for at about the price of the record."""
    price = PRICE * (1 + record.logs.shape[1]) / (1 + len(vibration.kept))
    return stable_orbit(case, vibration, record.strobes, record.begin, record.period, price * len(record.strobes))


def _is_positive(series: Array) -> bool:
    """Whether the mean of a sequence may well be above zero."""
    half = float(half_width(series[:, None])[0])
    return bool(series.mean() + (0.0 if np.isnan(half) else half) > 0)


def scatter(logs: Array, cycle: int) -> Array:
    """Half widths from the means over whole periods where there are enough of them, else over stretches."""
    whole = len(logs) // cycle
    if whole >= FEWEST and whole * cycle == len(logs):
        logs = logs.reshape(whole, cycle, -1).mean(axis=1)
    return half_width(logs)


def drifted(exponents: Array, half: Array, thirds: Array) -> Array:
    """Half widths that hold what a drift has passed through and where it may go, as far again as it has come."""
    return np.asarray(half + float(np.abs(exponents[0] - thirds).max()) + abs(float(thirds[0] - thirds[2])))


def widened(exponents: Array, half: Array, orbit: PeriodicOrbit) -> Array:
    """Half widths that hold the exponents of an orbit as well, to which the motion may come in the long run."""
    known = exponents_of(orbit)[: len(exponents)]
    wide = half.copy()
    wide[: len(known)] += np.abs(exponents[: len(known)] - known)
    return wide


def joined(exponents: Array, half: Array, orbit: Array, floor: float) -> tuple[Array, Array]:
    """Exponents of an orbit in place of the means over the end of a record that came to it.

    Intervals as wide as the scatter of the means, or as their distance from the orbit's, whichever is less.
    """
    count = min(len(orbit), len(exponents))
    best = exponents.copy()
    best[:count] = orbit[:count]
    return best, np.asarray(np.fmin(half, np.fmax(np.abs(exponents - best), floor)))
