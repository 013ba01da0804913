"""The loop of the step-doubling solvers: step sizes, budgets, outputs, and an ending with a name.

Part of ``solvers``; shared by ``doubled_step`` and ``collocation``, which bring the step as one CasADi function. Source: the
paper, Eq. 32 and the two cases below it, read so that the accepted step is always one that passed ("paper"); or a
proportional-integral controller on the same difference ("smooth"; Gustafsson 1991, Hairer, Norsett and Wanner, Solving Ordinary
Differential Equations I, II.4).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from modelgen.lowering.step_control import FIRST_ERROR, LARGEST_GROWTH, LEAST_ERROR, PAST, PRESENT, SAFETY, SMALLEST_SHRINK
from modelgen.solvers.coordinates import ScaledProblem
from modelgen.solvers.dense_output import DenseOutput
from modelgen.solvers.diagnosis import chatter, explain
from modelgen.solvers.events import Events
from modelgen.solvers.firing import Restart
from modelgen.solvers.first_size import first_size
from modelgen.solvers.guards import BoundGuards
from modelgen.solvers.method import BoundStep, Method
from modelgen.solvers.outcome import Ending, Outcome, StopRunError
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Statistics, Trajectory
from modelgen.solvers.smallest_step import smallest_step, time_of_start
from modelgen.solvers.time_breaks import time_breaks
from modelgen.solvers.watch import Watch

SOON, RARELY = 64, 512  # steps before the first look for chatter, and between later ones (1 % of the time)


Trial = tuple[BoundStep, BoundGuards | None]


class _March:
    """One run: the state, the bound step, and the rules of step sizes."""

    def __init__(self, problem: InitialValueProblem, options: SolverOptions, method: Method, watch: Watch) -> None:
        self.watch = watch
        self.options, self.method = options, method
        self.scaled = ScaledProblem(problem)
        self.breaks, self.end = time_breaks(problem), float(problem.times[-1])
        self.t, self.passed = self.breaks.start(problem.t0)
        self.asked = 0.0  # size that was wanted before it was cut short at the end or at a break
        self.state = np.zeros((2, self.scaled.size))
        self.events = Events(problem.switching, self.scaled, method, options) if problem.switching is not None else None
        self.trial = self.bound_step()
        self.output = DenseOutput(problem.times, problem.t0, self.scaled.size, method.interpolant)
        budget = options.budget
        self.ceiling = options.largest_step or math.inf
        self.limit = budget.bound**2
        self.start = time_of_start(self.scaled) if method.floor_outcome is Outcome.NEWTON_FAILED else None
        self.steps = self.tried = self.rejected = self.evaluations = 0
        self.smallest, self.largest = math.inf, 0.0
        self.next_check = SOON

    @property
    def floor(self) -> float:
        """The smallest step [s] where the run stands."""
        return smallest_step(self.scaled, self.options.budget.smallest_step, self.t, self.start)

    def bound_step(self) -> tuple[BoundStep, BoundGuards | None]:
        """A step bound to the state of the run, with the guards over it."""
        bound = BoundStep(self.method, self.state, self.scaled.parameters)
        return bound, self.events.bind(bound) if self.events is not None else None

    def run(self) -> Trajectory:
        """Go to the end, or to whatever stops the run before."""
        ending = Ending(Outcome.SUCCESS, Outcome.SUCCESS.sentence(time=self.end))
        try:
            if self.t < self.end:
                self.go()
            self.watch.finish()
        except StopRunError as stop:
            ending = stop.ending
        cost = Statistics(
            steps=self.steps,
            rejected=self.rejected,
            evaluations=self.evaluations + self.method.evaluations * self.tried,
            seconds=self.watch.seconds,
            smallest_step=self.smallest if self.steps else None,
            largest_step=self.largest if self.steps else None,
        )
        trajectory = self.scaled.trajectory(self.output.reached(), ending, cost)
        if self.events is None:
            return trajectory
        breaks = self.breaks.until(self.t, self.scaled.problem.t0)
        return replace(trajectory, events=replace(self.events.log(self.t), breaks=breaks))

    def go(self) -> None:
        """Start, and step to the end by the rule of the options."""
        if self.events is not None:
            self.restart(self.events.begin(self.t, self.state[0].copy()))
        else:
            self.new_slope()
        if self.options.fixed_step is not None:
            self.fixed(self.options.fixed_step)
        else:
            {"smooth": self.smooth, "paper": self.paper}[self.options.rule]()

    def new_slope(self) -> None:
        """The slope where the run stands."""
        self.evaluations += 1
        self.state[1] = self.scaled.rates(self.t, self.state[0])
        if not np.isfinite(self.state[1]).all():
            raise StopRunError(self.explain(self.floor, Outcome.NON_FINITE_RATE))

    def restart(self, found: Restart) -> None:
        """Go on from an event, or end there."""
        assert self.events is not None
        again: Restart | None = found
        while again is not None:
            self.t, self.state[0] = again.time, again.y
            if again.ending is not None:
                raise StopRunError(again.ending)
            self.new_slope()
            again = self.events.returning(self.t, *self.state)
        self.events.restart(self.t, *self.state)

    @property
    def stop(self) -> float:
        """The time that no step may cross: just before the next break, or the end."""
        return float(self.breaks.before[self.passed]) if self.passed < len(self.breaks) else self.end

    def cross(self) -> None:
        """Go over the break before which the run stands, on to its other side."""
        after = float(self.breaks.after[self.passed])
        self.passed += 1
        before, place = self.t, self.state[0].copy()
        self.t, self.state[0] = after, place + (after - before) * self.state[1]
        if self.events is None:
            self.new_slope()
        else:
            self.restart(self.events.jump(before, place, after, self.state[0].copy()))

    def explain(self, step: float, fallback: Outcome, **facts: Any) -> Ending:
        budgets: dict[Outcome, float] = {
            Outcome.MAX_STEPS: self.options.budget.max_steps,
            Outcome.MAX_TIME: self.options.budget.max_seconds,
        }
        return explain(
            *(self.scaled, self.t, self.state[0].copy(), step, fallback),
            **{"tolerance": self.options.tolerance, "budget": budgets.get(fallback, math.nan), **facts},
        )

    def attempt(self, step: Trial, h: float) -> float:
        """Try one step; its error in units of the tolerance, infinite if it left the numbers or the bound."""
        bound, guards = step
        self.tried += 1
        if self.tried > self.options.budget.max_steps:
            self.tried -= 1
            raise StopRunError(self.explain(h, Outcome.MAX_STEPS))
        if self.watch.clock() >= self.watch.next_look:
            self.look(h)
        bound.time[0], bound.size[0] = self.t, h
        bound.measures[1] = math.nan  # an evaluation that fails leaves it
        bound.evaluate()
        difference, total = bound.measures.tolist()
        error = difference / self.options.tolerance
        if not total <= self.limit:
            if not math.isfinite(total):
                return math.inf
            believed = error <= 1 or self.options.fixed_step is not None
            if believed and np.abs(bound.nodes[-2]).max() > self.options.budget.bound:
                raise StopRunError(self.explain(h, Outcome.DIVERGED, beyond=bound.nodes[-2].copy()))
        if guards is None or (error > 1 and self.options.fixed_step is None):
            return error
        if bound.method.extra is not None:
            self.evaluations += bound.complete()
        unresolved = guards.watch()
        return max(error, unresolved)

    def look(self, h: float) -> None:
        horizon = self.scaled.problem.horizon
        reason = self.watch.look((self.t - self.scaled.problem.t0) / horizon)
        if reason is Outcome.CANCELLED:
            raise StopRunError(Ending(reason, reason.sentence(time=self.t)))
        if reason is not None:
            raise StopRunError(self.explain(h, reason))

    def reject(self, h: float) -> float:
        """Count a rejected step; the size to try next, unless it would be too small."""
        self.rejected += 1
        if h < self.floor:
            failed = self.method.floor_outcome if math.isnan(self.trial[0].measures[1]) else Outcome.STEP_TOO_SMALL
            raise StopRunError(self.explain(self.floor, failed))
        return h

    def accept(self, step: Trial, t_new: float, h: float) -> bool:
        """Take the step over: outputs, statistics, and the state of the next one; whether an event or a break ends it."""
        bound, guards = step
        cut = None
        if self.events is not None and guards is not None:
            if guards.suspicious or self.events.unsettled:
                cut = self.events.advance(guards, self.t, h, t_new)
            else:
                np.copyto(self.events.start, guards.end)
        at_break = cut is None and t_new < self.end and t_new == self.stop
        until = cut.time if cut is not None else float(self.breaks.after[self.passed]) if at_break else t_new
        if self.output.next_time <= until:
            self.evaluations += bound.complete()
            self.output.record(self.t, h, until, self.state, bound.nodes)
        self.steps += 1
        self.largest = max(self.largest, h)
        self.smallest = min(self.smallest, h)
        if cut is not None:
            self.asked = 0.0
            self.restart(cut)
            return True
        self.state[:] = bound.nodes[-2:]
        self.t = t_new
        if at_break:
            self.cross()
            return True
        if self.steps >= self.next_check:
            self.next_check += min(self.steps, RARELY)
            if (found := chatter(self.scaled, t_new, self.state[0].copy(), h)) is not None:
                raise StopRunError(found)
        return False

    def clip(self, h: float) -> tuple[float, float]:
        """A size at most as large as wanted, and the time that it leads to: no sliver is left before a break or the end."""
        h = self.asked = min(h, self.ceiling)
        stop = self.stop
        remaining = stop - self.t
        if h >= remaining:
            return remaining, stop
        t_new = self.t + (remaining / 2 if 2 * h > remaining else h)
        return t_new - self.t, t_new  # exactly the distance between two floating-point times

    def first_size(self) -> float:
        """The size of the first step: given, or estimated."""
        if self.options.first_step is not None:
            return self.options.first_step
        self.evaluations += 1
        wanted, power = FIRST_ERROR * self.options.tolerance, self.method.control
        return max(first_size(self.scaled, self.t, self.state, wanted, power, self.ceiling), self.floor)

    def smooth(self) -> None:
        """Step sizes in proportion to the error to the power -1/(p+1), damped by the error of the step before."""
        exponent = 1 / self.method.control
        h, before = max(self.first_size(), self.floor), 1.0
        while self.t < self.end:
            h, t_new = self.clip(h)
            growth = LARGEST_GROWTH
            while (error := self.attempt(self.trial, h)) > 1:
                factor = SAFETY * error**-exponent if error < math.inf else 0.0
                h, t_new = self.clip(self.reject(h * max(SMALLEST_SHRINK, factor)))
                growth = 1.0  # not at once after a rejection
            if self.accept(self.trial, t_new, h):
                h, before = max(h, self.asked), 1.0
                continue
            error = max(error, LEAST_ERROR)
            factor = SAFETY * error ** (-PRESENT * exponent) * before ** (PAST * exponent)
            h = max(self.floor, h * min(growth, max(SMALLEST_SHRINK, factor)))
            before = error

    def paper(self) -> None:
        """Halve until the error is below the tolerance; else double until it is above, and take the last step that passed."""
        other = self.bound_step()
        h = max(self.first_size(), self.floor)
        while self.t < self.end:
            h, t_new = self.clip(h)
            passed = self.attempt(self.trial, h) <= 1
            if passed:
                while (longer := self.clip(2 * h))[0] >= 1.5 * h and self.attempt(other, longer[0]) <= 1:
                    self.trial, other = other, self.trial
                    h, t_new = longer
                self.rejected += longer[0] >= 1.5 * h
            while not passed:
                h, t_new = self.clip(self.reject(h / 2))
                passed = self.attempt(self.trial, h) <= 1
            self.accept(self.trial, t_new, h)

    def fixed(self, largest: float) -> None:
        """Equal steps of at most a given size, without error control."""
        start, span = self.t, self.end - self.t
        count = max(1, math.ceil(span / largest * (1 - 1e-12)))
        no_numbers = self.method.floor_outcome
        if no_numbers is Outcome.STEP_TOO_SMALL:  # there is no smaller step to blame
            no_numbers = Outcome.DIVERGED
        for index in range(1, count + 1):
            t_new = start + span * (index / count) if index < count else self.end
            while self.t < t_new:  # again after an event, with a short step
                until = min(t_new, self.stop)
                h = until - self.t
                if self.attempt(self.trial, h) == math.inf:
                    raise StopRunError(self.explain(h, no_numbers))
                self.accept(self.trial, until, h)


def march(problem: InitialValueProblem, options: SolverOptions, method: Method, watch: Watch) -> Trajectory:
    """Integrate a problem with a step that measures its error, by the rule of step sizes that the options name."""
    return _March(problem, options, method, watch).run()
