"""A motion followed piece by piece, and how long a piece may be so that a frame of deviations keeps its directions apart.

Below ``exponents`` and ``orbits``. Between two orthonormalizations every deviation turns toward the one that grows fastest. Once
the fastest has outgrown the slowest by e^12, some five digits of the slowest are lost; no more are given away.
"""

from __future__ import annotations

import functools
from dataclasses import replace
from math import ceil, inf

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.registry import solve

Array = NDArray[np.float64]
SPREAD = 12.0
LEAST = 64
"""Stretches into which a span is divided at least."""
SAMPLES = 64
STANDING = 1e-3
"""Share of its largest speed below which a motion has come to rest."""


def modes_at(problem: InitialValueProblem, run: Trajectory, times: Array) -> list[Array]:
    """The parameters with the flags of the modes that hold at each of the increasing times of a run; at an event, before it."""
    if run.events is None or problem.switching is None or not problem.switching.modes:
        return [problem.p] * len(times)
    switching, events, found = problem.switching, run.events, []
    present = list(events.start or [mode.of(problem.p) for mode in switching.modes])
    place = 0
    for time in times:
        while place < len(events) and events.times[place] < time:
            crossing = switching.crossings[int(events.which[place])]
            if crossing.variable is not None and crossing.enter is not None:
                present[crossing.variable] = crossing.enter
            place += 1
        p = problem.p.copy()
        for mode, value in zip(switching.modes, present, strict=True):
            mode.put(p, value)
        found.append(p)
    return found


class Course:
    """Where a motion stands: ``time``, ``state``, ``p`` (parameters with the flags of its modes)."""

    def __init__(self, problem: InitialValueProblem, solver: str, options: SolverOptions) -> None:
        self.problem, self.solver, self.options = problem, solver, options
        self.time, self.state, self.p = problem.t0, problem.x0, problem.p
        self.fastest = self.last_speed = 0.0

    def copy(self) -> Course:
        """Another course from the same place."""
        other = Course(self.problem, self.solver, self.options)
        other.back_to(self)
        return other

    def back_to(self, other: Course) -> None:
        """Stand again where another course of the same motion stands."""
        self.time, self.state, self.p = other.time, other.state, other.p
        self.fastest, self.last_speed = other.fastest, other.last_speed

    def advance(self, times: Array) -> list[InitialValueProblem]:
        """Go on to the last of the times; a problem for each stretch that ends at one of them, from where it begins.

        Raises CaseError for a motion that does not get there.
        """
        if times[-1] <= self.time:
            return []
        start = replace(self.problem, t0=self.time, x0=self.state, p=self.p, times=times)
        run = solve(start, self.solver, self.options)
        if len(run.times) < len(times):
            raise CaseError("motion", run.message, "start elsewhere, or change the tolerance or the parameters")
        begins = np.concatenate([[self.time], times[:-1]])
        states = np.vstack([self.state, run.states])
        flags = modes_at(start, run, np.append(begins, times[-1]))
        stretches = [
            replace(start, t0=float(begins[k]), x0=states[k], p=flags[k], times=times[k : k + 1]) for k in range(len(times))
        ]
        self.time, self.state, self.p = float(times[-1]), states[-1], flags[-1]
        for each in stretches:
            speed = np.asarray(each.rhs(each.t0, each.x0, each.p)).ravel() / each.scale
            self.last_speed = float(np.linalg.norm(speed))
            self.fastest = max(self.fastest, self.last_speed)
        return stretches

    def moves(self) -> bool:
        """Whether the motion has not come to rest."""
        return self.last_speed > STANDING * self.fastest


def stretch_length(course: Course, span: float, period: float, largest: bool) -> float:
    """Time between two orthonormalizations [s]: a part of the period (one or more), or of the span without one.

    ``largest``: for a single deviation, which must only neither vanish nor overflow. Rates of growth are the real parts of the
    eigenvalues of df/dx, at 64 places along the first part of the motion.
    """
    pilot = course.copy()
    reach = min(span, 2 * period) if period else span / 8
    places = pilot.advance(course.time + reach * np.arange(1, SAMPLES + 1) / SAMPLES)
    fastest = 0.0
    for each in places:
        matrix = jacobian(each.rhs)(each.t0, each.x0, each.p).full() * each.scale / each.scale[:, None]
        real = np.linalg.eigvals(matrix).real
        fastest = max(fastest, abs(real.max()) if largest else real.max() - real.min())
    longest = min(SPREAD / fastest if fastest > 0 else inf, span / LEAST)
    return period / max(1, ceil(period / longest)) if 0 < 2 * period <= span else longest


@functools.lru_cache(maxsize=16)
def jacobian(rhs: ca.Function) -> ca.Function:
    """(t, x, p) -> df/dx of a right-hand side."""
    t, x, p = rhs.sx_in() if rhs.is_a("SXFunction") else rhs.mx_in()
    return ca.Function("jacobian", [t, x, p], [ca.jacobian(rhs(t, x, p), x)])
