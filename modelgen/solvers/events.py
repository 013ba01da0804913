"""Events of a run: what fires where, and how the run goes on after it.

Part of ``solvers``; kept by ``march`` where a problem has switching. An event with an effect (a mode, a reset, a stop) cuts the
step at its place on the dense output; a section is only noted. What follows from an event at its time is found by ``firing``.
Signs are kept over steps: a guard has crossed when it is on the other side of zero than it was, and one that starts at zero has
the sign that the motion takes next. A guard that its reset has taken away from zero has the sign of its value, so it may fire
again within the very next step. What comes within a few roundings of zero and turns back is noted as a touch.

Policy: ``SolverOptions.events`` "auto" locates events where a law jumps or has memory, where a state is reset, and where sections
are asked for; a law that is only kinked (backlash) is left to the error control, which costs up to twice the evaluations where
there are many kinks, and nothing where there are none. Guards that never fire cost no evaluation of the right-hand side, but one
look at them per step (some 15 % of the time on the 16-degree truck on the virtual machine, ``tests/bench/guards.py``).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from modelgen.lowering.guard_kinds import SAMPLED, guard_counting
from modelgen.lowering.step_control import MANY, MOMENT, ROUNDINGS, SHRINKING, TOUCH
from modelgen.lowering.switching import Switching
from modelgen.solvers.coordinates import ScaledProblem
from modelgen.solvers.event_log import EventLog
from modelgen.solvers.firing import Firing, Restart
from modelgen.solvers.guards import REST, BoundGuards, guard_functions
from modelgen.solvers.location import EXCUSED, NONE, Passing
from modelgen.solvers.method import BoundStep, Method
from modelgen.solvers.outcome import Ending, Outcome
from modelgen.solvers.problem import SolverOptions, Vector
from modelgen.solvers.root_counting import Enclosures, RootCounting


class Events(Firing):
    """The events of one run; ``q`` of the scaled problem holds the flags of the present modes."""

    def __init__(self, switching: Switching, scaled: ScaledProblem, method: Method, options: SolverOptions) -> None:
        super().__init__(switching, scaled, guard_functions(switching, method.interpolant, scaled.size), options)
        crossings, count = switching.crossings, len(switching.crossings)
        self.interpolant, self.counting = method.interpolant, guard_counting(switching)
        self.ways = list(self.counting.ways)
        self.signs, self.grazes = np.zeros(count), np.full(count, EXCUSED)
        self.limits = np.array([self.floors, TOUCH * self.zeros, np.zeros(count)])
        self.acts = np.array([each.variable is not None or each.reset is not None for each in crossings], dtype=bool)
        self.effect = self.acts | np.array([each.stops for each in crossings], dtype=bool)
        self.leaps = np.array([each.variable is None and each.reset is not None for each in crossings], dtype=bool)
        self.initial: tuple[int, ...] = ()
        self.touches: list[tuple[float, int]] = []
        self.unsettled = False
        self.last, self.intervals, self.size, self.returns = -math.inf, list[float](), 0.0, 0

    def bind(self, bound: BoundStep) -> BoundGuards:
        """The guards over the steps of a bound step."""
        return BoundGuards(self.functions, bound, self.scaled.parameters, self.start, self.limits)

    def begin(self, t: float, y: Vector) -> Restart:
        """The lawful modes at the start of a run, with the resets on the way there; nothing of it is logged."""
        self.jumped = True
        restart = Restart(t, *self.chain(t, y, 0, None, logged=False))
        self.entered.clear()
        self.initial = tuple(mode.of(self.p) for mode in self.switching.modes)
        return restart

    def jump(self, t: float, y: Vector, after: float, y_after: Vector) -> Restart:
        """Go on behind a place where laws jump in time: what jumps over zero there fires, and the modes follow."""
        before, signs = self.before(t, y), self.signs.copy()
        g = self.value(after, y_after).copy()
        sides = np.where(np.abs(g) > self.zeros, np.sign(g), 0.0)
        over = (signs * sides < 0) & ((self.directions == 0) | ((self.directions == sides) & ~self.moving))
        np.copyto(self.signs, sides, where=sides != 0)
        ending, count = None, 0
        for index in np.flatnonzero(over).tolist():
            if ending is None and self.active(index):
                count += int(self.effect[index])
                if self.effect[index]:
                    y_after, ending = self.fire(after, y_after, index)
                else:
                    ending = self.log_event(after, index, y_after)
        if ending is None:
            y_after, ending = self.chain(after, y_after, count, before)
        return Restart(after, y_after, ending)

    def returning(self, t: float, y: Vector, slope: Vector) -> Restart | None:
        """Where a mode that was entered by a jump is left again without time passing: on from the one that holds instead.

        (Of several held speeds one that was let go may be held again by what let go after it.)
        """
        if not self.entered:
            return None
        self.evaluate(t, y, slope)
        g, rate = (self.directions * each for each in np.split(self.start, 2))
        moment = MOMENT * self.scaled.problem.horizon
        leaving = self.moving & (rate > 0) & (-g <= rate * moment)
        crossings = self.switching.crossings
        found = [n for n in np.flatnonzero(leaving).tolist() if crossings[n].variable in self.entered and self.active(n)]
        if not found:
            return None
        self.returns += 1
        if self.returns > MANY:
            return Restart(t, y, self.ending(Outcome.EVENT_CHATTER, t, found[0]))
        before = self.before(t, y)
        y, ending = self.fire(t, y.copy(), found[0])
        if ending is None:
            y, ending = self.chain(t, y, 1, before)
        return Restart(t, y, ending)

    def restart(self, t: float, y: Vector, slope: Vector) -> None:
        """Values and signs of all guards at the start of the next step, after an event or at the start of a run."""
        self.evaluate(t, y, slope)
        g, rate = np.split(self.start, 2)
        near = np.abs(g) <= self.zeros
        ahead = np.where(near, np.sign(rate), np.sign(g))
        # A guard at zero that changes something starts on the side from which it fires: it does if the motion goes there. One
        # that just fired has the sign of the motion, unless it was brought to rest there, or taken away. (A stop may be where a
        # run starts.)
        resting = np.abs(rate) * self.size <= self.zeros
        waiting = self.acts & near & (self.directions != 0)
        there = np.array([self.fired.get(index, math.nan) for index in range(g.size)])
        fired = (np.abs(g - there) <= self.zeros) & self.effect & ~(waiting & resting & self.leaps)
        fresh = np.where(waiting, -self.directions, ahead)
        np.copyto(self.signs, np.where(fired, np.sign(rate), fresh), where=self.effect | self.jumped)
        self.grazes = np.where(np.abs(g) <= self.limits[1], EXCUSED, NONE)
        moment = float(self.scaled.problem.times[-1])
        self.limits[2] = REST * self.counting.rests(min(t, moment), moment, self.p)
        self.fired.clear()
        self.entered.clear()
        self.jumped, self.returns = False, 0
        self._look_at_signs()

    def advance(self, guards: BoundGuards, t: float, h: float, t_new: float) -> Restart | None:
        """Go over an accepted step in which something may have crossed; where to go on, if an event with an effect cuts it."""
        width = max(4 * math.ulp(max(abs(t), abs(t_new))) / h, np.finfo(float).eps)
        self.size = h
        grazes, signs = self.grazes.copy(), self.signs.copy()
        for theta, index, sign in sorted(self._found(guards, t, h, width, grazes, signs)):
            time = min(t + theta * h, t_new)
            if sign == 0:
                self.touches.append((time, index))
                continue
            place, values = guards.at(theta)
            if self.effect[index]:
                return self._cut(time, index, place.copy(), values.copy())
            self.signs[index] = sign
            if self.directions[index] in (0, sign) and (ending := self.log_event(time, index, place)) is not None:
                return Restart(time, place.copy(), ending)
        self.grazes, self.signs = grazes, signs
        self.start[:] = guards.end
        self._look_at_signs()
        return None

    def log(self, t: float) -> EventLog:
        """What happened until t."""
        self.settle(t)
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
            counting=tuple(self.ways),
            touch_times=np.array([time for time, _ in self.touches], dtype=float),
            touch_which=np.array([index for _, index in self.touches], dtype=np.int64),
            roundings=self.zeros,
        )

    def _found(
        self, guards: BoundGuards, t: float, h: float, width: float, grazes: Vector, signs: Vector
    ) -> list[tuple[float, int, int]]:
        """All passings of sections in the step, the first event of each guard with an effect, and touches before it.

        Each as (theta, number, new sign), with sign 0 for a touch. How guards stand at the end is left in ``grazes``, ``signs``.
        """
        found = []
        enclosures = Enclosures(self.counting.bounds, self.interpolant, guards, self.scaled.parameters)
        for index in range(self.signs.size):
            if not self.active(index):
                end = float(guards.end[index])
                signs[index] = math.copysign(1.0, end) if abs(end) > self.zeros[index] else signs[index]
                continue
            counting = RootCounting(guards, index, self.counting.ways[index], enclosures, float(self.zeros[index]), width)
            walk = Passing(counting, float(self.signs[index]), float(grazes[index]))
            for theta, sign in walk.walk(t, h):
                fires = sign == 0 or self.directions[index] in (0, sign)
                if fires or not self.effect[index]:
                    found.append((theta, index, sign))
                if sign and fires and self.effect[index]:
                    break
            grazes[index], signs[index] = walk.graze, walk.sign
            if not counting.decided:
                self.ways[index] = SAMPLED
        return found

    def _cut(self, t: float, first: int, y: Vector, values: NDArray[np.float64]) -> Restart:
        """The event at t, all others at the same place, and the modes that follow from them."""
        g, rate = np.split(values, 2)
        sides = np.where(~self.acts & (np.abs(g) <= self.zeros), np.sign(rate), np.sign(g))
        watched = np.array([self.active(index) for index in range(g.size)], dtype=bool)
        together = watched & (self.signs * sides < 0) & ((self.directions == 0) | (self.directions == sides))
        np.copyto(self.signs, sides, where=sides != 0)
        together[first] = True
        before = self.before(t, y)
        count, ending = 0, self._crowded(t, first, abs(float(rate[first])))
        for index in np.flatnonzero(together).tolist():
            if ending is not None:
                break
            if not self.effect[index]:
                ending = self.log_event(t, index, y)
            elif not self.acts[index] or (self.active(index) and (count == 0 or self.value(t, y)[index] * sides[index] > 0)):
                y, ending = self.fire(t, y, index)
                count += 1
        if ending is None:
            self.entered.clear()  # by the event itself
            y, ending = self.chain(t, y, count, before)
        return Restart(t, y, ending)

    def _crowded(self, t: float, index: int, rate: float) -> Ending | None:
        """Whether events follow each other without time to speak of, or motion: ever faster (Zeno), or not."""
        interval, self.last = t - self.last, t
        short = interval < max(MOMENT * self.scaled.problem.horizon, ROUNDINGS * math.ulp(t))
        if not short and not rate * interval <= self.zeros[index]:
            self.intervals.clear()
            return None
        self.intervals.append(interval)
        if len(self.intervals) < MANY:
            return None
        early, late = sum(self.intervals[: MANY // 2]), sum(self.intervals[MANY // 2 :])
        rounding = ROUNDINGS * MANY / 2 * math.ulp(t)  # a few last digits of the time
        shrinking = late < SHRINKING * early and early > rounding
        return self.ending(Outcome.ZENO if shrinking else Outcome.EVENT_CHATTER, t, index)

    def _look_at_signs(self) -> None:
        """Note whether a guard starts the next step near zero, or on another side than that of its value."""
        g = self.start[: self.signs.size]
        self.unsettled = bool(np.any((self.signs * g <= 0) | (np.abs(g) <= self.limits[1]) | (self.grazes < EXCUSED)))
