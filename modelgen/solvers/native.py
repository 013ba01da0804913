"""Runs in generated C: the memory of the loop, a watch on it, and an ending with a name.

Part of ``solvers``; the loop itself is ``lowering/native/solver.h``, with the step sizes of ``march`` (rule "smooth") and the
outputs of ``dense_output``. Here its memory is laid out, its workers are watched (wall clock, cancellation, chatter), and what
stopped a run is explained at the last good state, on CasADi's virtual machine. ``lanes`` runs many problems through the same
loop.
"""

from __future__ import annotations

import ctypes
import math
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from modelgen.errors import CaseError
from modelgen.lowering.native import NativeSolver, native_solver
from modelgen.lowering.native.library import COUNTS, FACTS, OUTCOMES, Task
from modelgen.solvers.coordinates import ScaledProblem
from modelgen.solvers.diagnosis import chatter, explain
from modelgen.solvers.outcome import Ending, Outcome
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Statistics, Trajectory
from modelgen.solvers.watch import PERIOD, Watch

FIRST_STRETCH = 64  # steps before the first look for chatter; doubled until a stretch takes half as long as the watch allows
UNTOUCHED = -1


def solve_native(problem: InitialValueProblem, options: SolverOptions) -> Trajectory:
    """Integrate one problem in generated C: the same steps as ``solve_rk4`` with the rule "smooth", but for rounding.

    Raises CaseError for an option that has no C, NoCompilerError without a compiler, LoweringError for an operation without C.
    """
    watch = Watch(options)  # building counts
    runs = NativeRuns(native_solver(problem.rhs), [problem], options, watch)
    runs.go(threads=1)
    return runs.trajectory(0)


class NativeRuns:
    """The arrays that C reads and writes, and the endings of the runs."""

    def __init__(
        self, solver: NativeSolver, problems: Sequence[InitialValueProblem], options: SolverOptions, watch: Watch
    ) -> None:
        _check(problems, options)
        self.solver, self.problems, self.options, self.watch = solver, problems, options, watch
        jobs, samples, n = len(problems), problems[0].times.size, solver.states
        shared = all(np.array_equal(each.times, problems[0].times) for each in problems)
        self.p, self.x0, self.scale = (np.array([getattr(each, name) for each in problems]) for name in ("p", "x0", "scale"))
        self.times = np.array([each.times for each in problems[: 1 if shared else jobs]])
        self.states, self.last, self.extrema = np.zeros((jobs, samples, n)), np.zeros((jobs, 2, n)), np.full((jobs, 2, n), np.nan)
        self.counts, self.facts = np.zeros((jobs, len(COUNTS)), dtype=np.int64), np.zeros((jobs, len(FACTS)))
        self.counts[:, 0] = UNTOUCHED
        self.next = np.zeros(1, dtype=np.int64)
        self.endings: dict[int, Ending] = {}
        self.stopped: Outcome | None = None
        self.guard = threading.Lock()
        budget = options.budget
        self.task = Task(
            jobs=jobs,
            samples=samples,
            times_stride=0 if shared else samples,
            next=self.next.ctypes.data_as(ctypes.POINTER(ctypes.c_int64)),
            counts=self.counts.ctypes.data_as(ctypes.POINTER(ctypes.c_int64)),
            begin=problems[0].t0,
            tolerance=options.tolerance,
            first_step=options.first_step or 0.0,
            largest_step=options.largest_step or math.inf,
            smallest_step=budget.smallest_step,
            bound=budget.bound,
            correction=1 / 15 if options.extrapolate else 0.0,
            max_steps=int(budget.max_steps),
        )
        for name in ("p", "x0", "scale", "times", "states", "last", "extrema", "facts"):
            setattr(self.task, name, getattr(self, name).ctypes.data_as(ctypes.POINTER(ctypes.c_double)))

    def go(self, threads: int) -> None:
        """Run everything, by so many workers."""
        if threads == 1:
            self.work()
        else:
            with ThreadPoolExecutor(threads) as pool:
                try:
                    for each in [pool.submit(self.work) for _ in range(threads)]:
                        each.result()
                except BaseException:  # an interruption, or a progress report that fails: nobody goes on alone
                    self.stopped = Outcome.CANCELLED
                    raise
        if self.stopped is None:
            self.watch.finish()

    def work(self) -> None:
        """One worker: stretches of steps, with a look at the watch and for chatter in between."""
        work, stretch, looks = self.solver.workspace(), FIRST_STRETCH, 0
        while True:
            start = self.watch.clock()
            if not self.solver.run(self.task, work, stretch) or self.stopped is not None:
                return
            growing = self.watch.clock() - start < PERIOD / 2
            if growing:
                stretch *= 2
            with self.guard:
                if self.stopped is None and self.watch.clock() >= self.watch.next_look:
                    self.stopped = self.watch.look(self.fraction())
                if self.stopped is not None:
                    return
                jobs, looks = self.solver.jobs(work), looks + 1
                for job in jobs if growing else [jobs[looks % len(jobs)]]:
                    self.look_for_chatter(job)

    def look_for_chatter(self, job: int) -> None:
        """End a run that chatters where it stands."""
        if job < 0:
            return
        scaled = ScaledProblem(self.problems[job])
        found = chatter(
            scaled, float(self.facts[job, 0]), self.last[job, 0] / self.problems[job].scale, float(self.facts[job, 1])
        )
        if found is not None:
            self.endings[job] = found
            self.counts[job, COUNTS.index("stop")] = 1

    def fraction(self) -> float:
        """The part of all simulated time that is done."""
        done = 0.0
        for job, problem in enumerate(self.problems):
            if self.counts[job, 0] != UNTOUCHED:
                done += (self.facts[job, 0] - problem.t0) / problem.horizon if problem.horizon > 0 else 1.0
        return done / len(self.problems)

    def trajectory(self, job: int) -> Trajectory:
        """What a run has reached, with its ending."""
        problem = self.problems[job]
        scaled = ScaledProblem(problem)
        _, steps, rejected, evaluations, reached, _ = (int(each) for each in self.counts[job])
        ending = self.endings.get(job) or self.ending(job, scaled)
        cost = Statistics(
            steps=steps,
            rejected=rejected,
            evaluations=evaluations,
            seconds=self.watch.seconds,
            smallest_step=float(self.facts[job, 2]) if steps else None,
            largest_step=float(self.facts[job, 3]) if steps else None,
        )
        return scaled.trajectory(self.states[job, :reached] / problem.scale, ending, cost)

    def ending(self, job: int, scaled: ScaledProblem) -> Ending:
        """How a run ended: in C, or because all were stopped."""
        problem, code = self.problems[job], int(self.counts[job, 0])
        if code != UNTOUCHED and OUTCOMES[code] == "SUCCESS":
            return Ending(Outcome.SUCCESS, Outcome.SUCCESS.sentence(time=float(problem.times[-1])))
        t = problem.t0 if code == UNTOUCHED else float(self.facts[job, 0])
        outcome = self.stopped if code == UNTOUCHED or OUTCOMES[code] == "RUNNING" else Outcome[OUTCOMES[code]]
        assert outcome is not None
        if outcome is Outcome.CANCELLED:
            return Ending(outcome, outcome.sentence(time=t))
        y, beyond = self.last[job] / problem.scale
        budgets = {Outcome.MAX_STEPS: self.options.budget.max_steps, Outcome.MAX_TIME: self.options.budget.max_seconds}
        return explain(
            *(scaled, t, y, float(self.facts[job, 1]), outcome),
            beyond=beyond if outcome is Outcome.DIVERGED else None,
            tolerance=self.options.tolerance,
            budget=budgets.get(outcome, math.nan),
        )


def _check(problems: Sequence[InitialValueProblem], options: SolverOptions) -> None:
    first = problems[0]
    for index, each in enumerate(problems):
        if each.rhs is not first.rhs:
            raise CaseError(
                f"lanes, problem {index}", "has another right-hand side than the first", "run other models by themselves"
            )
        if each.t0 != first.t0 or each.times.size != first.times.size:
            found = f"starts at {each.t0:g} s with {each.times.size} output times"
            raise CaseError(f"lanes, problem {index}", found, f"the first starts at {first.t0:g} s with {first.times.size}")
    if options.fixed_step is not None or options.rule != "smooth":
        given = f"fixed_step = {options.fixed_step!r}" if options.fixed_step is not None else f"rule = {options.rule!r}"
        raise CaseError("native solver", f"has no use for {given}", 'leave it out, or take backend "vm"')
