"""The watch on a run: wall clock, progress and cancellation, looked at often and cheaply.

Part of ``solvers``. A loop compares one clock reading per step with ``next_look`` and calls ``look`` when it is due.
"""

from __future__ import annotations

import time

from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import SolverOptions

PERIOD = 0.05  # s between two reports of progress; also the longest wait for a cancellation


class Watch:
    """Counts from its making; says when the budget of seconds is used up or somebody cancels."""

    clock = staticmethod(time.perf_counter)

    def __init__(self, options: SolverOptions) -> None:
        self.progress, self.cancel = options.progress, options.cancel
        self.start = self.clock()
        self.deadline = self.start + options.budget.max_seconds
        self.next_look = self.start

    @property
    def seconds(self) -> float:
        """Wall clock used so far [s]."""
        return self.clock() - self.start

    def look(self, fraction: float) -> Outcome | None:
        """Report the fraction done; why the run must stop now, if it must."""
        now = self.clock()
        self.next_look = min(self.deadline, now + PERIOD)
        if self.progress is not None:
            self.progress(fraction)
        if self.cancel is not None and self.cancel():
            return Outcome.CANCELLED
        return Outcome.MAX_TIME if now >= self.deadline else None

    def finish(self) -> None:
        """Report that all is done."""
        if self.progress is not None:
            self.progress(1.0)
