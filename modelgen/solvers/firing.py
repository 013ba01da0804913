"""What happens at an event: the log, the reset, the change of mode, and what follows from it at the same time.

Part of ``solvers``, under ``events``, which finds where guards fire. After an event the modes that are lawful there are found by
following guards that are already beyond zero. Where a torque or a stiffness jumps beside several held modes, the jump is taken as
the limit of a steep ramp: of all guards beyond zero the one fires first that comes first on a straight line from its value before
the jump to that after it, and what comes after is looked at with the mode that it led to. So what lets go first relieves the
others, as it does in a machine (the path of Lemke's method for the complementarity problem of dry friction; Pfeiffer, Glocker,
Multibody Dynamics with Unilateral Contacts, ch. 6).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.lowering.step_control import MANY
from modelgen.lowering.switching import Switching
from modelgen.solvers.coordinates import ScaledProblem
from modelgen.solvers.guards import GuardFunctions, guard_floors
from modelgen.solvers.method import bind
from modelgen.solvers.outcome import Ending, Outcome
from modelgen.solvers.problem import SolverOptions, Vector


@dataclass(frozen=True, eq=False)
class Restart:
    """Where a run goes on after an event: time, y, and the ending if it does not."""

    time: float
    y: Vector
    ending: Ending | None


@dataclass(frozen=True, eq=False)
class Before:
    """Where a run stood before a jump: time, y, and the parameters with the flags of the modes."""

    time: float
    y: Vector
    p: Vector


class Firing:
    """The modes of one run, and the events that change them; ``p`` of the scaled problem holds the flags of the present modes."""

    def __init__(self, switching: Switching, scaled: ScaledProblem, functions: GuardFunctions, options: SolverOptions) -> None:
        self.switching, self.scaled, self.functions, self.options = switching, scaled, functions, options
        self.p = scaled.parameters[2 * scaled.size :]
        count = len(switching.crossings)
        self.start = np.zeros(2 * count)
        self.floors, self.zeros = guard_floors(switching, scaled.problem, options.tolerance)
        crossings = switching.crossings
        self.directions = np.array([crossing.direction for crossing in crossings])
        self.moving = np.array([each.variable is not None and each.enter != each.leave for each in crossings], dtype=bool)
        self.flags = np.array([mode.first + k for mode in switching.modes for k in range(len(mode.values))], dtype=int)
        self._point = np.zeros(1), np.zeros(scaled.size), np.zeros(scaled.size), scaled.parameters
        self._rates, self._evaluate_rates = bind(functions.rates, self._point, (self.start,))
        self.times: list[float] = []
        self.which: list[int] = []
        self.states: list[Vector] = []
        first, last = float(scaled.problem.times[0]), float(scaled.problem.times[-1])
        self.window, self.settled, self.held = (first, last), first, np.zeros(self.flags.size)
        self.fired: dict[int, float] = {}  # what fired since the last step, with the values of the guards there
        self.entered: set[int] = set()  # mode variables that changed since the last step
        self.jumped = False

    def before(self, t: float, y: Vector) -> Before:
        """Where the run stands, in the modes that it is in."""
        return Before(t, y.copy(), self.p.copy())

    def chain(self, t: float, y: Vector, count: int, before: Before | None, logged: bool = True) -> tuple[Vector, Ending | None]:
        """Fire guards that are beyond zero in the present modes, until none is."""
        while True:
            index = self._next(t, y, before)
            if index is None:
                return y, None
            count += 1
            if count > MANY:
                return y, self.ending(Outcome.EVENT_CHATTER, t, index)
            y, ending = self.fire(t, y, index, logged)
            if before is not None:
                self._enter(before.p, index)
            if ending is not None:
                return y, ending

    def _next(self, t: float, y: Vector, before: Before | None) -> int | None:
        """The guard beyond zero that fires next: where there are several, the one that a ramp from before would meet first."""
        beyond = self.moving & (self.directions * self.value(t, y) > self.zeros)
        found = [index for index in np.flatnonzero(beyond).tolist() if self.active(index)]
        if len(found) < 2 or before is None:
            return found[0] if found else None
        now = (self.directions * self.value(t, y))[found]
        present = self.p.copy()
        self.p[:] = before.p
        start = np.minimum((self.directions * self.value(before.time, before.y))[found], 0.0)
        self.p[:] = present
        return int(found[int(np.argmin(np.nan_to_num(-start / (now - start))))])

    def fire(self, t: float, y: Vector, index: int, logged: bool = True) -> tuple[Vector, Ending | None]:
        """One event: log, reset, change of mode."""
        crossing, problem = self.switching.crossings[index], self.scaled.problem
        ending = self.log_event(t, index, y) if logged else None
        if ending is not None:
            return y, ending
        self.fired[index] = float(self.value(t, y)[index])
        if crossing.reset is not None and self.switching.resets is not None:
            x = np.array(self.switching.resets(t, self.scaled.states(y), self.p))[:, crossing.reset]
            y = (x - problem.x0) / problem.scale
            self.jumped = True
        if crossing.variable is not None:
            self.settle(t)
            self.entered.add(crossing.variable)
            self._enter(self.p, index)
        return y, self.ending(Outcome.EVENT, t, index) if crossing.stops else None

    def _enter(self, p: Vector, index: int) -> None:
        """Put the mode to which a crossing leads into parameters."""
        crossing = self.switching.crossings[index]
        if crossing.variable is not None and crossing.enter is not None:
            self.switching.modes[crossing.variable].put(p, crossing.enter)

    def log_event(self, t: float, index: int, y: Vector) -> Ending | None:
        budget = self.options.budget.max_events
        if len(self.times) >= budget:
            return self.ending(Outcome.MAX_EVENTS, t, index, budget=budget)
        self.times.append(t)
        self.which.append(index)
        self.states.append(self.scaled.states(y))
        return None

    def ending(self, outcome: Outcome, t: float, index: int, **facts: float) -> Ending:
        return Ending(outcome, outcome.sentence(time=t, event=self.switching.crossings[index].name, **facts))

    def active(self, index: int) -> bool:
        """Whether a crossing is watched in the present modes."""
        crossing = self.switching.crossings[index]
        if crossing.variable is None or crossing.leave is None:
            return True
        return bool(self.p[self.switching.modes[crossing.variable].first + crossing.leave] > 0.5)

    def value(self, t: float, y: Vector) -> NDArray[np.float64]:
        """The guards at a point; overwritten by the next call."""
        self.evaluate(t, y, np.zeros_like(y))
        return self.start[: self.start.size // 2]

    def evaluate(self, t: float, y: Vector, slope: Vector) -> None:
        """Put guards and rates at a point into ``start``."""
        self._point[0][0], self._point[1][:], self._point[2][:] = t, y, slope
        self._evaluate_rates()

    def settle(self, t: float) -> None:
        """Count the time until t for the present modes."""
        until = min(max(t, self.window[0]), self.window[1])
        self.held += self.p[self.flags] * (until - self.settled)
        self.settled = until
