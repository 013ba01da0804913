"""Is there a stable periodic motion beside one that looks like chaos, to which it may come yet?

Below ``exponents``. Newton's method for the map over one, two, ... periods of the excitation begins at many strobes of the record
at once, side by side in lanes: chaos comes near everything that is near. It may cost about as much as the record itself. What it
closes on, and what attracts, is proven by shooting.
Source: P. Cvitanovic et al., Chaos: Classical and Quantum, ch. 16 (cycles are found from returns of a long run).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.stability.coordinates import Vibration
from modelgen.analysis.stability.course import Course
from modelgen.analysis.stability.orbits import SLOW, PeriodicOrbit, periodic_orbit
from modelgen.analysis.stability.propagators import crossed
from modelgen.errors import CaseError
from modelgen.solvers.case import Case
from modelgen.solvers.problem import SolverOptions

Array = NDArray[np.float64]
ORDERS = (1, 2, 3, 4)
ROUNDS = 10
TOGETHER = 16
"""Starts of Newton's method side by side."""
GOLDEN = 0.6180339887498949
"""Shares of the record at multiples of it are spread evenly, however many are taken."""
DECAYS = 0.5 ** (1 / SLOW)
"""Largest multiplier of an orbit to which a motion comes in a run of the usual length."""
SAME = 1e-3
"""Of the scales: states nearer to each other belong to one orbit."""
CLOSED = 1e-5
"""Of the scales: what shooting is asked to prove."""
BOLDEST = 0.5
"""Of the extent of the motion: longest step of Newton's method."""


def stable_orbit(
    case: Case, vibration: Vibration, strobes: Array, time: float, period: float, budget: float
) -> PeriodicOrbit | None:
    """A stable orbit that attracts within a usual run, found from ``strobes`` (strobes, states per scale) of the times ``time`` +
    whole periods [s]; None where the search finds none. ``budget``: periods that may be followed with all their tangents.
    """
    search, taken = _Search(case, vibration, strobes, time, period), 0
    while search.spent < budget:
        places = (np.arange(taken, taken + TOGETHER) * GOLDEN) % 1.0 * len(strobes)
        taken += TOGETHER
        for order in ORDERS:
            for state in search.closed(strobes[places.astype(int)], order):
                found = search.proven(state, order)
                if found is not None:
                    return found
    return None


class _Search:
    """Newton's method from strobes; ``spent``: periods that were followed so far."""

    def __init__(self, case: Case, vibration: Vibration, strobes: Array, time: float, period: float) -> None:
        self.case, self.vibration, self.time, self.period = case, vibration, time, period
        self.low, self.high = strobes.min(axis=0), strobes.max(axis=0)
        self.extent = float((self.high - self.low).max())
        backend = str(dict(case.options).get("backend", "auto"))
        self.options = SolverOptions(max(case.tolerance, 1e-9), backend=backend)
        self.spent = 0
        self.found: list[Array] = []

    def closed(self, states: Array, order: int) -> Iterator[Array]:
        """States (per scale) on which Newton's method closes, and from which deviations decay."""
        for _ in range(ROUNDS):
            if not len(states):
                return
            self.spent += order * len(states)
            states, ends, matrices = self.returned(states, order)
            missed = ends - states
            done = np.abs(missed).max(axis=1, initial=0.0) < CLOSED
            for k in np.flatnonzero(done):
                if np.abs(np.linalg.eigvals(matrices[k])).max() < DECAYS and self.is_new(states[k]):
                    yield states[k]
            states, missed, matrices = states[~done], missed[~done], matrices[~done]
            steps = np.array(
                [np.linalg.lstsq(m - np.eye(len(m)), -r, rcond=None)[0] for m, r in zip(matrices, missed, strict=True)]
            )
            steps = steps.reshape(states.shape)
            sizes = np.abs(steps).max(axis=1, keepdims=True, initial=0.0)
            states = states + steps * np.minimum(1.0, BOLDEST * self.extent / np.maximum(sizes, 1e-300))
            states = states[np.all((states > self.low - self.extent) & (states < self.high + self.extent), axis=1)]

    def is_new(self, state: Array) -> bool:
        """Whether no state so near was found before; shooting need not be asked twice."""
        known = any(np.abs(state - other).max() < SAME for other in self.found)
        self.found.append(state)
        return not known

    def returned(self, states: Array, order: int) -> tuple[Array, Array, Array]:
        """Starts with their ends and propagators over ``order`` periods; those left out that cannot be followed."""
        try:
            return states, *self.followed(states, order)
        except CaseError:
            n = states.shape[1]
            found: list[tuple[Array, Array, Array]] = [(np.zeros((0, n)), np.zeros((0, n)), np.zeros((0, n, n)))]
            for state in states[:, None]:
                try:
                    found.append((state, *self.followed(state, order)))
                except CaseError:
                    continue
            starts, ends, matrices = (np.concatenate(each) for each in zip(*found, strict=True))
            return starts, ends, matrices

    def followed(self, states: Array, order: int) -> tuple[Array, Array]:
        """Ends and propagators of all starts. Raises CaseError where one cannot be followed."""
        problem = self.vibration.problem
        at, flags = states * problem.scale, [problem.p] * len(states)
        total = np.array([np.eye(states.shape[1])] * len(states))
        times = np.array([self.time + self.period])
        for _ in range(order):
            stretches = [replace(problem, t0=self.time, x0=x, p=p, times=times) for x, p in zip(at, flags, strict=True)]
            found = crossed(stretches, self.period, self.options)
            at, flags, total = found.ends, found.modes, np.asarray(found.matrices) @ total
        return at / problem.scale, total

    def proven(self, state: Array, order: int) -> PeriodicOrbit | None:
        """The orbit through a state, if shooting proves it and a motion comes to it in a run of the usual length."""
        begin, problem = self.vibration.problem.t0, self.vibration.problem
        there = replace(problem, x0=state * problem.scale, t0=self.time, times=np.array([self.time + self.period]))
        course = Course(there, "rk4", self.options)
        turns = np.ceil((self.time - begin) / self.period * (1 - 1e-12))
        quiet = {key: value for key, value in self.case.options.items() if key != "progress"}
        try:
            course.advance(np.array([begin + turns * self.period]))
            names, whole = self.vibration.whole.names, self.vibration.state(course.state)
            start = dict(zip(names, whole.tolist(), strict=True))
            found = periodic_orbit(self.case.change(start=start, record_from=None, options=quiet), order=order, settle=0)
        except CaseError:
            return None
        return found if found.proven and found.half_life < SLOW else None
