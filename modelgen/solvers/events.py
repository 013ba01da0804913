"""Events of a run: what fires where, what it changes, and the log.

Part of ``solvers``; kept by ``march`` where a problem has switching. An event with an effect (a mode, a reset, a stop) cuts the
step at its place on the dense output; a section is only noted. After an event the modes that are lawful there are found by
following guards that are already beyond zero. Signs are kept over steps: a guard has crossed when it is on the other side of zero
than it was, and one that starts at zero has the sign that the motion takes next.

Policy: ``SolverOptions.events`` "auto" locates events where a law jumps or has memory, where a state is reset, and where sections
are asked for; a law that is only kinked (backlash) is left to the error control, which costs up to twice the evaluations where
there are many kinks, and nothing where there are none. Guards that never fire cost no evaluation of the right-hand side, but one
look at them per step (some 15 % of the time on the 16-degree truck on the virtual machine, ``tests/bench/guards.py``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.lowering.switching import Switching
from modelgen.solvers.coordinates import ScaledProblem
from modelgen.solvers.event_log import EventLog
from modelgen.solvers.guards import BoundGuards, guard_floors, guard_functions
from modelgen.solvers.location import crossings
from modelgen.solvers.method import BoundStep, Method, bind
from modelgen.solvers.outcome import Ending, Outcome
from modelgen.solvers.problem import SolverOptions, Vector

MANY = 32  # events at one time, or one after the other without time to speak of, that are no accident
MOMENT = 1e-10  # of the horizon: no time to speak of


@dataclass(frozen=True, eq=False)
class Restart:
    """Where a run goes on after an event: time, y, and the ending if it does not."""

    time: float
    y: Vector
    ending: Ending | None


class Events:
    """The events of one run; ``q`` of the scaled problem holds the flags of the present modes."""

    def __init__(self, switching: Switching, scaled: ScaledProblem, method: Method, options: SolverOptions) -> None:
        self.switching, self.scaled, self.options = switching, scaled, options
        self.p = scaled.parameters[2 * scaled.size :]
        self.functions = guard_functions(switching, method.interpolant, scaled.size)
        count = len(switching.crossings)
        self.start, self.signs = np.zeros(2 * count), np.zeros(count)
        self.floors, self.zeros = guard_floors(switching, scaled.problem, options.tolerance)
        self.directions = np.array([crossing.direction for crossing in switching.crossings])
        self.effect = np.array(
            [each.variable is not None or each.reset is not None or each.stops for each in switching.crossings], dtype=bool
        )
        self.moving = np.array(
            [each.variable is not None and each.enter != each.leave for each in switching.crossings], dtype=bool
        )
        self.leaps = np.array([each.variable is None and each.reset is not None for each in switching.crossings], dtype=bool)
        self.acts = np.array([each.variable is not None or each.reset is not None for each in switching.crossings], dtype=bool)
        self.flags = np.array([mode.first + k for mode in switching.modes for k in range(len(mode.values))], dtype=int)
        self._point = np.zeros(1), np.zeros(scaled.size), np.zeros(scaled.size), scaled.parameters
        self._rates, self._evaluate_rates = bind(self.functions.rates, self._point, (self.start,))
        self.times: list[float] = []
        self.which: list[int] = []
        self.states: list[Vector] = []
        self.initial: tuple[int, ...] = ()
        first, last = float(scaled.problem.times[0]), float(scaled.problem.times[-1])
        self.window, self.settled, self.held = (first, last), first, np.zeros(self.flags.size)
        self.fired: set[int] = set()
        self.jumped = self.unsettled = False
        self.last, self.intervals, self.size = -math.inf, list[float](), 0.0

    def bind(self, bound: BoundStep) -> BoundGuards:
        """The guards over the steps of a bound step."""
        return BoundGuards(self.functions, bound, self.scaled.parameters, self.start, self.floors)

    def begin(self, t: float, y: Vector) -> Restart:
        """The lawful modes at the start of a run, with the resets on the way there; nothing of it is logged."""
        self.jumped = True
        restart = Restart(t, *self._chain(t, y, 0, logged=False))
        self.initial = tuple(mode.of(self.p) for mode in self.switching.modes)
        return restart

    def restart(self, t: float, y: Vector, slope: Vector) -> None:
        """Values and signs of all guards at the start of the next step, after an event or at the start of a run."""
        self._evaluate(t, y, slope)
        g, rate = np.split(self.start, 2)
        near = np.abs(g) <= self.zeros
        ahead = np.where(near, np.sign(rate), np.sign(g))
        # A guard at zero that changes something starts on the side from which it fires: it does if the motion goes there. One
        # that just fired has the sign of the motion, unless it was brought to rest there. (A stop may be where a run starts.)
        resting = np.abs(rate) * self.size <= self.zeros
        waiting = self.acts & near & (self.directions != 0)
        fired = np.isin(np.arange(g.size), list(self.fired)) & self.effect & ~(waiting & resting & self.leaps)
        fresh = np.where(waiting, -self.directions, ahead)
        np.copyto(self.signs, np.where(fired, np.sign(rate), fresh), where=self.effect | self.jumped)
        self.fired.clear()
        self.jumped = False
        self._look_at_signs()

    def advance(self, guards: BoundGuards, t: float, h: float, t_new: float) -> Restart | None:
        """Go over an accepted step in which something may have crossed; where to go on, if an event with an effect cuts it."""
        width = max(4 * math.ulp(max(abs(t), abs(t_new))) / h, np.finfo(float).eps)
        self.size = h
        for theta, index, sign in sorted(self._found(guards, width)):
            time = min(t + theta * h, t_new)
            place, values = guards.at(theta)
            if self.effect[index]:
                return self._cut(time, index, place.copy(), values.copy())
            self.signs[index] = sign
            if self.directions[index] in (0, sign) and (ending := self._log(time, index, place)) is not None:
                return Restart(time, place.copy(), ending)
        self.start[:] = guards.end
        self._note_signs(guards.end[: self.signs.size])
        self._look_at_signs()
        return None

    def log(self, t: float) -> EventLog:
        """What happened until t."""
        self._settle(t)
        span = self.settled - self.window[0]
        which = np.array(self.which, dtype=np.int64)
        return EventLog(
            switching=self.switching,
            times=np.array(self.times, dtype=float),
            which=which,
            states=np.array(self.states, dtype=float).reshape(len(which), self.scaled.size),
            counts=np.bincount(which, minlength=self.signs.size).astype(np.int64),
            shares=self.held / span if span > 0 else self.p[self.flags].copy(),
            start=self.initial,
        )

    def _found(self, guards: BoundGuards, width: float) -> list[tuple[float, int, int]]:
        """All passings of sections in the step, and the first event of each guard with an effect: (theta, number, new sign)."""
        found = []
        for index in range(self.signs.size):
            if not self._active(index):
                continue
            for theta, sign in crossings(guards, index, float(self.signs[index]), width, float(self.zeros[index])):
                fires = self.directions[index] in (0, sign)
                if fires or not self.effect[index]:
                    found.append((theta, index, sign))
                if fires and self.effect[index]:
                    break
        return found

    def _cut(self, t: float, first: int, y: Vector, values: NDArray[np.float64]) -> Restart:
        """The event at t, all others at the same place, and the modes that follow from them."""
        g, rate = np.split(values, 2)
        sides = np.where(~self.acts & (np.abs(g) <= self.zeros), np.sign(rate), np.sign(g))
        watched = np.array([self._active(index) for index in range(g.size)], dtype=bool)
        together = watched & (self.signs * sides < 0) & ((self.directions == 0) | (self.directions == sides))
        np.copyto(self.signs, sides, where=sides != 0)
        together[first] = True
        count, ending = 0, self._crowded(t, first, abs(float(rate[first])))
        for index in np.flatnonzero(together).tolist():
            if ending is not None:
                break
            if not self.effect[index]:
                ending = self._log(t, index, y)
            elif not self.acts[index] or (self._active(index) and (count == 0 or self._value(t, y)[index] * sides[index] > 0)):
                y, ending = self._fire(t, y, index)
                count += 1
        if ending is None:
            y, ending = self._chain(t, y, count)
        return Restart(t, y, ending)

    def _chain(self, t: float, y: Vector, count: int, logged: bool = True) -> tuple[Vector, Ending | None]:
        """Fire guards that are beyond zero in the present modes, until none is."""
        while True:
            beyond = self.moving & (self.directions * self._value(t, y) > self.zeros)
            index = next((each for each in np.flatnonzero(beyond).tolist() if self._active(each)), None)
            if index is None:
                return y, None
            count += 1
            if count > MANY:
                return y, self._ending(Outcome.EVENT_CHATTER, t, index)
            y, ending = self._fire(t, y, index, logged)
            if ending is not None:
                return y, ending

    def _fire(self, t: float, y: Vector, index: int, logged: bool = True) -> tuple[Vector, Ending | None]:
        """One event: log, reset, change of mode."""
        crossing, problem = self.switching.crossings[index], self.scaled.problem
        ending = self._log(t, index, y) if logged else None
        if ending is not None:
            return y, ending
        self.fired.add(index)
        if crossing.reset is not None and self.switching.resets is not None:
            x = np.array(self.switching.resets(t, self.scaled.states(y), self.p))[:, crossing.reset]
            y = (x - problem.x0) / problem.scale
            self.jumped = True
        if crossing.variable is not None and crossing.enter is not None:
            self._settle(t)
            self.switching.modes[crossing.variable].put(self.p, crossing.enter)
        return y, self._ending(Outcome.EVENT, t, index) if crossing.stops else None

    def _log(self, t: float, index: int, y: Vector) -> Ending | None:
        budget = self.options.budget.max_events
        if len(self.times) >= budget:
            return self._ending(Outcome.MAX_EVENTS, t, index, budget=budget)
        self.times.append(t)
        self.which.append(index)
        self.states.append(self.scaled.states(y))
        return None

    def _crowded(self, t: float, index: int, rate: float) -> Ending | None:
        """Whether events follow each other without time to speak of, or motion: ever faster (Zeno), or not."""
        interval, self.last = t - self.last, t
        short = interval < max(MOMENT * self.scaled.problem.horizon, 64 * math.ulp(t))
        if not short and not rate * interval <= self.zeros[index]:
            self.intervals.clear()
            return None
        self.intervals.append(interval)
        if len(self.intervals) < MANY:
            return None
        early, late = sum(self.intervals[: MANY // 2]), sum(self.intervals[MANY // 2 :])
        shrinking = late < 0.9 * early and early > 64 * MANY / 2 * math.ulp(t)  # a few last digits of the time are rounding
        return self._ending(Outcome.ZENO if shrinking else Outcome.EVENT_CHATTER, t, index)

    def _ending(self, outcome: Outcome, t: float, index: int, **facts: float) -> Ending:
        return Ending(outcome, outcome.sentence(time=t, event=self.switching.crossings[index].name, **facts))

    def _active(self, index: int) -> bool:
        crossing = self.switching.crossings[index]
        if crossing.variable is None or crossing.leave is None:
            return True
        return bool(self.p[self.switching.modes[crossing.variable].first + crossing.leave] > 0.5)

    def _note_signs(self, g: NDArray[np.float64]) -> None:
        np.copyto(self.signs, np.sign(g), where=np.abs(g) > self.zeros)

    def _look_at_signs(self) -> None:
        """Note whether a guard starts the next step on another side than that of its value: then it must be looked at."""
        self.unsettled = bool(np.any(self.signs * self.start[: self.signs.size] <= 0))

    def _value(self, t: float, y: Vector) -> NDArray[np.float64]:
        """The guards at a point."""
        self._evaluate(t, y, np.zeros_like(y))
        return self.start[: self.signs.size]

    def _evaluate(self, t: float, y: Vector, slope: Vector) -> None:
        self._point[0][0], self._point[1][:], self._point[2][:] = t, y, slope
        self._evaluate_rates()

    def _settle(self, t: float) -> None:
        """Count the time until t for the present modes."""
        until = min(max(t, self.window[0]), self.window[1])
        self.held += self.p[self.flags] * (until - self.settled)
        self.settled = until
