"""The arrays that generated C reads and writes, for a number of runs of one model.

Part of ``solvers``, between ``native`` and ``lowering.native``: problems, options and what is to be gathered become one ``Task``.
"""

from __future__ import annotations

import ctypes
import functools
import math
from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.lowering.guard_kinds import SAMPLED, WAYS, guard_counting
from modelgen.lowering.native import NativeSolver, native_observer
from modelgen.lowering.native.stages import Stages
from modelgen.lowering.native.task import COUNTS, FACTS, REDUCTIONS, RULES, Log, Task
from modelgen.lowering.switching import Switching
from modelgen.solvers.gather import Gather, written_out
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Vector
from modelgen.solvers.time_breaks import time_breaks

UNTOUCHED = -1
LOG_ROOM = 1024  # events that a worker notes between two looks
FINDS, CHAINS = 32, 33 * 33  # events of each guard in a step that are kept, and what may follow from one at its time
ALL = 2**62


class NativeMemory:
    """Arrays of so many runs, and the ``task`` that points to them."""

    def __init__(
        self,
        solver: NativeSolver,
        problems: Sequence[InitialValueProblem],
        options: SolverOptions,
        gather: Gather,
        correction: float,
    ) -> None:
        self.solver, self.switching = solver, problems[0].switching
        jobs, samples, n = len(problems), problems[0].times.size, solver.states
        shared = all(np.array_equal(each.times, problems[0].times) for each in problems)
        self.p, self.x0, self.scale = (np.array([getattr(each, name) for each in problems]) for name in ("p", "x0", "scale"))
        self.times = np.array([each.times for each in problems[: 1 if shared else jobs]])
        self.states = np.zeros((jobs, samples, n)) if gather.states else None
        self.last = np.zeros((jobs, 2, n))
        self.counts, self.facts = np.zeros((jobs, len(COUNTS)), dtype=np.int64), np.zeros((jobs, len(FACTS)))
        self.counts[:, 0] = UNTOUCHED
        self.next = np.zeros(1, dtype=np.int64)
        budget, fixed = options.budget, options.fixed_step
        self.task = Task(
            jobs=jobs,
            samples=samples,
            times_stride=0 if shared else samples,
            begin=problems[0].t0,
            tolerance=options.tolerance,
            first_step=options.first_step or 0.0,
            largest_step=options.largest_step or math.inf,
            smallest_step=budget.smallest_step,
            bound=budget.bound,
            correction=correction,
            fixed_step=fixed or 0.0,
            rule=RULES.index("fixed" if fixed is not None else options.rule),
            max_steps=int(budget.max_steps),
            max_events=int(budget.max_events),
            log_limit=ALL if gather.events is None else gather.events,
        )
        self.kept: Vector | None = None
        self.reduced: Vector | None = None
        self.p_now: Vector | None = None
        self._observe(gather, jobs, samples)
        self._switch(problems, options)
        self.breaks = [time_breaks(problem) for problem in problems]
        most = max(map(len, self.breaks))
        self.task.break_count = most
        if most:
            self.stops = np.full((jobs, 2, most), np.inf)
            for row, each in zip(self.stops, self.breaks, strict=True):
                row[:, : len(each)] = each.before, each.after
            self.task.breaks = self.stops.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        for name in ("p", "x0", "scale", "times", "states", "last", "facts", "kept", "reduced", "p_now"):
            self._point(name)
        for name in ("next", "counts"):
            self._point(name, ctypes.c_int64)

    def _point(self, name: str, kind: Any = ctypes.c_double) -> None:
        array = getattr(self, name)
        if array is not None:
            setattr(self.task, name, array.ctypes.data_as(ctypes.POINTER(kind)))

    def _observe(self, gather: Gather, jobs: int, samples: int) -> None:
        """Channels at the output times, and room for what is left of them."""
        if gather.channels is None:
            return
        sizes, model = (gather.channels.numel_in(1), gather.channels.numel_in(2)), (self.solver.states, self.solver.parameters)
        if sizes != model:
            found = f"take {sizes[0]} states and {sizes[1]} parameters, the model has {model[0]} and {model[1]}"
            raise CaseError("gather, channels", found, "give a function of the same model")
        channels = native_observer(written_out(gather.channels), self.solver.lanes > 1)
        self.observers = [channels]
        self.task.channels = channels.entry()
        self.reduced = np.zeros((jobs, len(REDUCTIONS), channels.outputs))
        self.reduced[:, 0], self.reduced[:, 1] = np.inf, -np.inf
        self.kept = np.full((jobs, samples, channels.outputs), np.nan) if gather.keep else None

    def _switch(self, problems: Sequence[InitialValueProblem], options: SolverOptions) -> None:
        """Guards, resets, tables of crossings and modes."""
        self.happened: NDArray[np.int64] | None = None
        self.held: Vector | None = None
        if self.switching is None or not self.switching.crossings:
            return
        switching, task, many = self.switching, self.task, self.solver.lanes > 1
        surfaces, self.surface, self.read = distinct_guards(switching)
        self.guards = native_observer(surfaces, many)
        task.guards = self.guards.entry()
        if switching.resets is not None:
            self.resets = native_observer(written_out(switching.resets), many)
            task.resets = self.resets.entry()
        bounds, rests, self.way = surface_counting(switching)
        self.bounds, self.rests = native_observer(bounds, many), native_observer(rests, many)
        task.bounds, task.rests, task.sampled_guards = (
            self.bounds.entry(),
            self.rests.entry(),
            int(WAYS.index(SAMPLED) in self.way),
        )
        self.crossing, self.mode, values = tables(switching, self.surface)
        task.crossings, task.surfaces, task.reads = len(self.crossing), len(np.unique(self.surface)), len(self.read)
        task.variables, task.all_values = len(self.mode), values
        jobs = len(problems)
        self.happened, self.held = np.zeros((jobs, task.crossings), dtype=np.int64), np.zeros((jobs, values))
        sizes = [guard_sizes(problem, options.tolerance) for problem in problems]
        first = np.unique(self.surface, return_index=True)[1]
        self.guard_floor, self.guard_zero = np.array([floor[first] for floor, _ in sizes]), np.array([zero for _, zero in sizes])
        self.first_modes = np.array([[mode.of(problem.p) for mode in switching.modes] for problem in problems], dtype=np.int64)
        self.p_now = self.p.copy()
        for name in ("guard_floor", "guard_zero", "held"):
            self._point(name)
        self.undecided = np.zeros((jobs, task.crossings), dtype=np.int64)
        for name in ("first_modes", "happened", "crossing", "mode", "read", "way", "undecided"):
            self._point(name, ctypes.c_int64)

    def counting(self, job: int) -> tuple[str, ...]:
        """How the guard of each crossing was counted in a run."""
        ways = [WAYS[way] for way in self.way[self.surface].tolist()]
        return tuple(SAMPLED if left else way for way, left in zip(ways, self.undecided[job].tolist(), strict=True))

    def log(self) -> NativeLog:
        """Room for the events that one worker comes upon."""
        lanes = self.solver.lanes
        room = LOG_ROOM + 2 * lanes * ((FINDS + 1) * self.task.crossings + CHAINS) if self.task.crossings else 0
        return NativeLog(room, self.solver.states)


class NativeLog:
    """The events that one worker came upon, emptied while it rests."""

    def __init__(self, room: int, states: int) -> None:
        self.job, self.which = np.zeros(room, dtype=np.int64), np.zeros(room, dtype=np.int64)
        self.time, self.state = np.zeros(room), np.zeros((room, states))
        self.record = Log(room=room, used=0)
        for name in ("job", "which", "time", "state"):
            kind = ctypes.c_int64 if name in ("job", "which") else ctypes.c_double
            setattr(self.record, name, getattr(self, name).ctypes.data_as(ctypes.POINTER(kind)))

    def empty(self, into: dict[int, list[tuple[Vector, NDArray[np.int64], Vector]]]) -> None:
        """Hand the events on, by runs: (times, numbers, states)."""
        used = int(self.record.used)
        for job in np.unique(self.job[:used]):
            mine = self.job[:used] == job
            into.setdefault(int(job), []).append((self.time[:used][mine], self.which[:used][mine], self.state[:used][mine]))
        self.record.used = 0


@functools.lru_cache(maxsize=64)
def distinct_guards(switching: Switching) -> tuple[ca.Function, NDArray[np.int64], NDArray[np.int64]]:
    """The distinct guards with their rates as one function, the one of each crossing, and the states that they depend on."""
    rates = written_out(switching.guard_rates)
    outputs, count = Stages.of(rates).outputs, len(switching.crossings)
    distinct = sorted(set(outputs[:count]), key=outputs.index)
    inputs = [ca.SX.sym(rates.name_in(index), rates.sparsity_in(index)) for index in range(4)]
    rows = [outputs.index(each) for each in distinct]
    values = rates(*inputs)[[*rows, *(count + row for row in rows)]]
    used = [index for index in range(inputs[1].numel()) if ca.depends_on(values, ca.vertcat(inputs[1][index], inputs[2][index]))]
    surface = np.array([distinct.index(each) for each in outputs[:count]], dtype=np.int64)
    return ca.Function("guards", inputs, [ca.densify(values)]), surface, np.array(used, dtype=np.int64)


@functools.lru_cache(maxsize=64)
def surface_counting(switching: Switching) -> tuple[ca.Function, ca.Function, NDArray[np.int64]]:
    """Of the distinct guards: enclosures of them and their rates, those of ``GuardCounting.rest``, and how each is counted."""
    counting, surface = guard_counting(switching), distinct_guards(switching)[1]
    count = len(switching.crossings)
    first = np.unique(surface, return_index=True)[1]
    ways = np.array([WAYS.index(counting.ways[index]) for index in first], dtype=np.int64)

    def chosen(function: ca.Function, parts: int) -> ca.Function:
        inputs = [ca.SX.sym(function.name_in(index), function.sparsity_in(index)) for index in range(4)]
        rows = [part * count + index for part in range(parts) for index in first.tolist()]
        return ca.Function(function.name(), inputs, [ca.densify(function(*inputs)[rows])])

    return chosen(counting.bounds, 4), chosen(counting.rest, 2), ways


def watched_guards(switching: Switching | None) -> ca.Function | None:
    """What the native solver of a problem watches: the distinct guards with their rates, where there are any."""
    return distinct_guards(switching)[0] if switching is not None and switching.crossings else None


def tables(switching: Switching, surface: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """Crossings and mode variables as rows of numbers (see ``task.h``), and the number of all flags."""

    def number(value: int | None) -> int:
        return -1 if value is None else value

    crossing = [
        (each.direction, *map(number, (each.variable, each.leave, each.enter, each.reset)), int(each.stops), at)
        for each, at in zip(switching.crossings, surface, strict=True)
    ]
    mode, first = [], 0
    for variable in switching.modes:
        mode.append((variable.first, len(variable.values), first))
        first += len(variable.values)
    return np.array(crossing, dtype=np.int64), np.array(mode, dtype=np.int64).reshape(-1, 3), first


def guard_sizes(problem: InitialValueProblem, tolerance: float) -> tuple[Vector, Vector]:
    """Of every guard: the size below which it need not be resolved, and that below which it counts as zero at a start."""
    assert problem.switching is not None
    slopes = np.abs(_guard_slopes(problem.switching.guards)(problem.t0, problem.x0, problem.p).full())
    floor = tolerance * np.nan_to_num(slopes) @ problem.scale + 1e-300
    zero = 64 * np.finfo(float).eps * np.nan_to_num(slopes) @ (np.abs(problem.x0) + problem.scale)
    return floor, zero


@functools.lru_cache(maxsize=64)
def _guard_slopes(guards: ca.Function) -> ca.Function:
    t, x, p = (ca.SX.sym(name, guards.sparsity_in(index)) for index, name in enumerate(("t", "x", "p")))
    return ca.Function("guard_slopes", [t, x, p], [ca.densify(ca.jacobian(ca.vec(guards(t, x, p)), x))])
