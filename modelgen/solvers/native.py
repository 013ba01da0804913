"""Runs in generated C: a watch on them, and an ending with a name.

Part of ``solvers``; the loop itself is ``lowering/native/solver.h``, with the step sizes of ``march``, the outputs of
``dense_output`` and the events of ``events``; its memory is laid out in ``native_memory``. Here its workers are watched (wall
clock, cancellation, chatter), and what stopped a run is explained at the last good state, on CasADi's virtual machine. ``lanes``
runs many problems through the same loop.
"""

from __future__ import annotations

import dataclasses
import math
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.lowering.methods import read_tableau
from modelgen.lowering.native import NativeSolver, native_solver
from modelgen.lowering.native.task import COUNTS, OUTCOMES
from modelgen.lowering.switching import Switching
from modelgen.solvers.coordinates import ScaledProblem
from modelgen.solvers.diagnosis import chatter, explain
from modelgen.solvers.event_log import EventLog
from modelgen.solvers.gather import Gather
from modelgen.solvers.native_memory import UNTOUCHED, NativeLog, NativeMemory, watched_guards
from modelgen.solvers.outcome import Ending, Outcome
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Statistics, Trajectory, Vector
from modelgen.solvers.watch import PERIOD, Watch

FIRST_STRETCH = 1024  # steps before the first look for chatter, which takes as long as a thousand of them
GROWTH = 4  # of stretches, until the next one would take longer than half of what the watch allows
EVENT_OUTCOMES = (Outcome.EVENT, Outcome.MAX_EVENTS, Outcome.ZENO, Outcome.EVENT_CHATTER)


def solve_native(problem: InitialValueProblem, options: SolverOptions, method: str = "rk4") -> Trajectory:
    """Integrate one problem in generated C: the steps and events of the same method on the virtual machine, but for rounding.

    Raises CaseError for an option that has no C, NoCompilerError without a compiler, LoweringError for an operation without C.
    """
    watch = Watch(options)  # building counts
    solver = native_solver(problem.rhs, method=method, guards=watched_guards(problem.switching))
    runs = NativeRuns(solver, [problem], options, watch, method=method)
    runs.go(threads=1)
    return runs.trajectory(0)


class NativeRuns:
    """Some runs of one model, by any number of workers, and their endings."""

    def __init__(
        self,
        solver: NativeSolver,
        problems: Sequence[InitialValueProblem],
        options: SolverOptions,
        watch: Watch,
        gather: Gather | None = None,
        method: str = "rk4",
    ) -> None:
        _check(problems, options, method)
        self.solver, self.problems, self.options, self.watch = solver, problems, options, watch
        self.gather = gather or Gather()
        tableau = read_tableau(method)
        self.memory = NativeMemory(solver, problems, options, self.gather, tableau.correction(options.extrapolate))
        self.endings: dict[int, Ending] = {}
        self.events: dict[int, list[tuple[Vector, NDArray[np.int64], Vector]]] = {}
        self.stopped: Outcome | None = None
        self.guard = threading.Lock()

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
        task, log = self.memory.task, self.memory.log()
        work, stretch, looks = self.solver.workspace(task), FIRST_STRETCH, 0
        while True:
            start = self.watch.clock()
            going = self.solver.run(task, work, log.record, stretch)
            if self.watch.clock() - start < PERIOD / 2 / GROWTH:
                stretch *= GROWTH
            with self.guard:
                self.read(log)
                if not going or self.stopped is not None:
                    return
                if self.watch.clock() >= self.watch.next_look:
                    self.stopped = self.watch.look(self.fraction())
                if self.stopped is not None:
                    return
                jobs, looks = self.solver.jobs(work), looks + 1
                self.look_for_chatter(jobs[looks % len(jobs)])

    def read(self, log: NativeLog) -> None:
        """Take over the events that a worker has noted."""
        if log.record.used:
            log.empty(self.events)

    def scaled(self, job: int) -> ScaledProblem:
        """The problem of a run in scaled coordinates, in the modes in which it stands."""
        problem = self.problems[job]
        if self.memory.p_now is not None:
            problem = dataclasses.replace(problem, p=self.memory.p_now[job])
        return ScaledProblem(problem)

    def look_for_chatter(self, job: int) -> None:
        """End a run that chatters where it stands."""
        if job < 0:
            return
        memory = self.memory
        place = memory.last[job, 0] / self.problems[job].scale
        found = chatter(self.scaled(job), float(memory.facts[job, 0]), place, float(memory.facts[job, 1]))
        if found is not None:
            self.endings[job] = found
            memory.counts[job, COUNTS.index("stop")] = 1

    def fraction(self) -> float:
        """The part of all simulated time that is done."""
        done = 0.0
        for job, problem in enumerate(self.problems):
            if self.memory.counts[job, 0] != UNTOUCHED:
                done += (self.memory.facts[job, 0] - problem.t0) / problem.horizon if problem.horizon > 0 else 1.0
        return done / len(self.problems)

    def trajectory(self, job: int) -> Trajectory:
        """What a run has reached, with its ending."""
        problem, memory = self.problems[job], self.memory
        scaled = self.scaled(job)
        _, steps, rejected, evaluations, reached, _, _, _ = (int(each) for each in memory.counts[job])
        ending = self.endings.get(job) or self.ending(job, scaled)
        cost = Statistics(
            steps=steps,
            rejected=rejected,
            evaluations=evaluations,
            seconds=self.watch.seconds,
            smallest_step=float(memory.facts[job, 2]) if steps else None,
            largest_step=float(memory.facts[job, 3]) if steps else None,
            backend="c",
        )
        events = self.event_log(job)
        if memory.states is None:
            time = problem.t0 if memory.counts[job, 0] == UNTOUCHED else float(memory.facts[job, 0])
            place = (problem.x0 + memory.last[job, 0])[None]
            return Trajectory(np.array([time]), place, *ending, cost, events)
        run = scaled.trajectory(memory.states[job, :reached] / problem.scale, ending, cost)
        return dataclasses.replace(run, events=events) if events is not None else run

    def event_log(self, job: int) -> EventLog | None:
        """The events of a run, in order."""
        memory, problem = self.memory, self.problems[job]
        if memory.switching is None:
            return None
        parts = self.events.get(job, [])
        times = np.concatenate([np.zeros(0), *(part[0] for part in parts)])
        which = np.concatenate([np.zeros(0, dtype=np.int64), *(part[1] for part in parts)])
        states = np.concatenate([np.zeros((0, problem.x0.size)), *(part[2] for part in parts)])
        if memory.happened is None or memory.held is None or memory.p_now is None:
            return EventLog(memory.switching, times, which, states, np.zeros(0, dtype=np.int64), np.zeros(0))
        now = float(memory.facts[job, 0])
        total = now - float(problem.times[0])
        shares = memory.held[job] / total if total > 0 else flags(memory.switching, memory.p_now[job])
        count = memory.task.crossings
        events, touches = which < count, which >= count
        return EventLog(
            *(memory.switching, times[events], which[events], states[events], memory.happened[job], shares),
            start=tuple(memory.first_modes[job].tolist()),
            counting=memory.counting(job),
            touch_times=times[touches],
            touch_which=which[touches] - count,
            breaks=memory.breaks[job].until(now, problem.t0),
            roundings=memory.guard_zero[job],
        )

    def ending(self, job: int, scaled: ScaledProblem) -> Ending:
        """How a run ended: in C, or because all were stopped."""
        problem, memory = self.problems[job], self.memory
        code = int(memory.counts[job, 0])
        if code != UNTOUCHED and OUTCOMES[code] == "SUCCESS":
            return Ending(Outcome.SUCCESS, Outcome.SUCCESS.sentence(time=float(problem.times[-1])))
        t = problem.t0 if code == UNTOUCHED else float(memory.facts[job, 0])
        outcome = self.stopped if code == UNTOUCHED or OUTCOMES[code] == "RUNNING" else Outcome[OUTCOMES[code]]
        assert outcome is not None
        budget = self.options.budget
        if outcome is Outcome.CANCELLED:
            return Ending(outcome, outcome.sentence(time=t))
        if outcome in EVENT_OUTCOMES:
            assert problem.switching is not None
            name = problem.switching.crossings[int(memory.counts[job, COUNTS.index("last_event")])].name
            return Ending(outcome, outcome.sentence(time=t, event=name, budget=budget.max_events))
        y, beyond = memory.last[job] / problem.scale
        budgets = {Outcome.MAX_STEPS: budget.max_steps, Outcome.MAX_TIME: budget.max_seconds}
        return explain(
            *(scaled, t, y, float(memory.facts[job, 1]), outcome),
            beyond=beyond if outcome is Outcome.DIVERGED else None,
            tolerance=self.options.tolerance,
            budget=budgets.get(outcome, math.nan),
        )


def flags(switching: Switching, p: Vector) -> Vector:
    """The flags of all modes in a vector of parameters, in the order of ``value_names``."""
    return np.concatenate([np.zeros(0), *(p[mode.first : mode.first + len(mode.values)] for mode in switching.modes)])


def _check(problems: Sequence[InitialValueProblem], options: SolverOptions, method: str) -> None:
    first = problems[0]
    for index, each in enumerate(problems):
        if each.rhs is not first.rhs:
            raise CaseError(
                f"lanes, problem {index}", "has another right-hand side than the first", "run other models by themselves"
            )
        if each.switching is not first.switching:
            raise CaseError(
                f"lanes, problem {index}", "has other guards than the first", "share one switching, or run it by itself"
            )
        if each.t0 != first.t0 or each.times.size != first.times.size:
            found = f"starts at {each.t0:g} s with {each.times.size} output times"
            raise CaseError(f"lanes, problem {index}", found, f"the first starts at {first.t0:g} s with {first.times.size}")
    if options.rule == "paper" and not read_tableau(method).is_doubled:
        raise CaseError("native solver", f"has no rule 'paper' for {method!r}", "it belongs to step doubling: take rk4")
