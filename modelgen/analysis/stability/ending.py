"""Where does a motion end? What shooting finds from its last state, and whether the motion comes to it.

Below ``exponents``. Strobes that come back at the end of a record have come to a periodic motion; of others the nearest return
tells after how many periods shooting may close. A stable orbit that is found is an attractor; whether this motion ends there is
seen by following it on.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.nonlinear.recurrence import LONGEST, Recurrence, recurrence
from modelgen.analysis.stability.coordinates import Vibration
from modelgen.analysis.stability.course import Course
from modelgen.analysis.stability.orbits import PeriodicOrbit, periodic_orbit
from modelgen.errors import CaseError
from modelgen.solvers.case import Case

Array = NDArray[np.float64]
STILL, NOISE = 1e-6, 10.0
"""Of the scales, or tolerances of the solver: how near strobes come back that stand still."""
REACHED = 1e-4
"""Of the scales: a motion this near an orbit has come to it."""
LONGEST_WAIT = 2000
"""Periods that a motion is followed on for at most."""


@dataclass(frozen=True, eq=False)
class Ending:
    """``orbit``: stable, found from the last state; ``reached``: whether the motion comes to it.

    ``period`` of the strobes that come back at the end of the record, from the one numbered ``first`` on; 0 where none do.
    ``at_rest``: the motion has come to rest.
    """

    orbit: PeriodicOrbit | None = None
    reached: bool = False
    period: int = 0
    first: int = 0
    at_rest: bool = False

    @property
    def words(self) -> str:
        """What the motion ends in, as far as is known."""
        if self.at_rest:
            return "rest"
        if self.orbit is not None and self.reached:
            return self.orbit.verdict
        return f"a motion whose strobes come back after {self.period}, which is not proven" if self.period else ""

    @property
    def exponents(self) -> Array:
        """Those of the orbit [1/s], largest first, from its multipliers; the one along an autonomous motion is left out."""
        return np.zeros(0) if self.orbit is None else exponents_of(self.orbit)


def exponents_of(orbit: PeriodicOrbit) -> Array:
    """Exponents of an orbit [1/s], largest first, from its multipliers."""
    sizes = np.maximum(np.abs(orbit.multipliers), 1e-300)
    return np.asarray(np.sort(np.log(sizes) / orbit.period)[::-1])


def returns(strobes: Array, tolerance: float) -> Recurrence:
    """Whether the strobes (strobes, states per scale) of a record come back at its end, and from when on."""
    return recurrence(strobes, max(STILL, NOISE * tolerance))


def ending(case: Case, vibration: Vibration, course: Course, strobes: Array, period: float) -> Ending:
    """What the motion comes to from where a ``course`` stands at the end of its record.

    ``strobes`` (strobes, states per scale) over the record, ``period`` [s] apart, that of the excitation; where that is not known
    (0) only whether an autonomous motion rests.
    """
    if not period:
        return Ending(at_rest=vibration.autonomous and not course.moves())
    back = returns(strobes, case.tolerance)
    order = back.period or _nearest(strobes)
    place = course.copy()
    turns = ceil((place.time - vibration.problem.t0) / period * (1 - 1e-12))
    place.advance(np.array([vibration.problem.t0 + turns * period]))
    state = vibration.state(place.state)
    start = dict(zip(vibration.whole.names, state.tolist(), strict=True))
    try:
        orbit: PeriodicOrbit | None = periodic_orbit(
            case.change(start=start, record_from=None, options=_quiet(case)), order=order, settle=0
        )
    except CaseError:
        orbit = None
    if orbit is None or not orbit.proven:
        return Ending(period=back.period, first=back.first)
    return Ending(orbit, bool(back.period) or _comes_to(vibration, place, orbit), back.period, back.first)


def _quiet(case: Case) -> dict[str, object]:
    return {key: value for key, value in case.options.items() if key != "progress"}


def _nearest(strobes: Array) -> int:
    """After how many periods the end comes nearest to where it was."""
    orders = range(1, min(LONGEST, len(strobes) - 1) + 1)
    return min(orders, key=lambda order: float(np.abs(strobes[-1] - strobes[-1 - order]).max()), default=1)


def _comes_to(vibration: Vibration, course: Course, orbit: PeriodicOrbit) -> bool:
    """Whether a motion, followed on for as long as deviations from the orbit last, is on it."""
    size = min(max(orbit.largest, 1e-12), 1 - 1e-12)
    turns = orbit.order * min(ceil(LONGEST_WAIT / orbit.order), ceil(log(REACHED / 10) / log(size)) + 8)
    begin, wanted = course.time, np.asarray(orbit.state)[list(vibration.kept)]
    try:
        course.advance(begin + orbit.base_period * np.arange(1.0, turns + 1.0))
        distances = []
        for _ in range(orbit.order):
            distances.append(float(np.abs((course.state - wanted) / course.problem.scale).max()))
            course.advance(np.array([course.time + orbit.base_period]))
    except CaseError:
        return False
    return min(distances) < REACHED
