"""Points into results: prepares a batch of points, runs them side by side and measures them. The place where a sweep computes.

Part of ``sweeps``; used by this process, by worker processes and on a cluster alike. With generated C the points of a batch share
SIMD lanes, whose results do not depend on the neighbors; otherwise each point runs by itself on CasADi's virtual machine. So the
numbers depend on the point and on the engine, never on the batch. Whatever goes wrong with a point is its outcome.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.sweeps.collect import Collection, collection_of, gathered, measured
from modelgen.analysis.sweeps.shard import Batch
from modelgen.errors import LoweringError, ModelgenError
from modelgen.lowering.native import NoCompilerError, native_solver
from modelgen.solvers.bound_model import operating_point
from modelgen.solvers.case import Case
from modelgen.solvers.gather import Gather
from modelgen.solvers.lanes import solve_lanes
from modelgen.solvers.native_memory import watched_guards
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.registry import method_digest, solve, solver_named, solver_options
from modelgen.solvers.simulate import events_of, initial_value_problem

Array = NDArray[np.float64]
COMPILERS = 3  # that may be killed in a row


def settled(case: Case) -> tuple[Case, dict[str, Any]]:
    """The case with its back end decided, and the engine in words: numbers of different engines differ by rounding.

    C in lanes for a solver that has it, unless the case asks for the virtual machine or there is no compiler. Raises CaseError
    for a solver or an option that is not known, NoCompilerError where C is asked for and cannot be had.
    """
    options = {name: value for name, value in case.options.items() if name not in ("progress", "cancel")}
    asked = options.get("backend")
    engine = {"solver": case.solver}
    if digest := method_digest(case.solver):
        engine["method"] = digest
    rule = solver_options(case.tolerance, options).rule
    if "backend" not in solver_named(case.solver).extra_options:
        return case.change(options=options), {**engine, "backend": "vm"}
    if asked != "vm" and (rule == "smooth" or "extrapolate" in solver_named(case.solver).extra_options):
        switched = events_of(case)
        rhs = case.model.rhs_function if switched is None else switched.rhs_function
        guards = watched_guards(None if switched is None else switched.switching)
        try:
            width = _lanes(rhs, guards, case.solver)
        except LoweringError:
            if asked == "c":
                raise
        else:
            return case.change(options={**options, "backend": "c"}), {**engine, "backend": "c", "lanes": width}
    return case.change(options={**options, "backend": "vm"}), {**engine, "backend": "vm"}


def _lanes(rhs: ca.Function, guards: ca.Function | None, solver: str) -> int:
    """How many runs are side by side in generated C: of the very solver that will run, so that none is built for this alone.

    A compiler that somebody kills is asked again: it decides the engine.
    """
    for _ in range(COMPILERS - 1):
        with contextlib.suppress(NoCompilerError):
            return native_solver(rhs, lanes=True, method=solver, guards=guards).lanes
    return native_solver(rhs, lanes=True, method=solver, guards=guards).lanes


@dataclass(frozen=True, eq=False)
class _Prepared:
    """A point that can start: its problem, and what belongs to its states."""

    problem: InitialValueProblem
    offset: Array
    p: Array


class Runner:
    """Runs points of one sweep, for one thread at a time: CasADi's functions are not for several."""

    def __init__(
        self, case: Case, engine: Mapping[str, Any], names: tuple[str, ...], collect: tuple[str, ...], plan: str
    ) -> None:
        self.case, self.names, self.plan = case, names, plan
        self.lanes = engine["backend"] == "c"
        self.wanted: Collection = collection_of(case.model, collect, case.samples)
        self.options: SolverOptions = solver_options(case.tolerance, case.options)
        self.switched = events_of(case)
        self.gather = Gather(
            states=False,
            channels=_collected(case, self.wanted) if self.wanted.channels else None,
            keep=self.wanted.keeps and bool(self.wanted.channels),
            events=0,
        )

    def run(self, points: NDArray[np.int64], values: Array, threads: int = 1) -> Batch:
        """The batch of these points; ``values`` (m, names) are those of the swept parameters."""
        # Warnings of NumPy depend on the process; what is not finite shows in the outcome.
        with np.errstate(all="ignore"):
            return self._run(points, values, threads)

    def _run(self, points: NDArray[np.int64], values: Array, threads: int) -> Batch:
        cases = [self.at(row) for row in values.tolist()]
        numbers = np.full((len(cases), self.wanted.width), np.nan)
        outcomes, messages = [""] * len(cases), [""] * len(cases)
        ready: dict[int, _Prepared] = {}
        keys = tuple(map(key_of, cases))
        for k, case in enumerate(cases):
            try:
                ready[k] = _prepared(case)
            except Exception as error:
                outcomes[k], messages[k] = Outcome.BAD_INPUT.name, _reason(error)
        for k, (run, record) in self._solved(ready, threads).items():
            outcomes[k], messages[k] = run.outcome.name, run.message
            if run.outcome.is_good:
                try:
                    numbers[k], messages[k] = record(), ""
                except Exception as error:
                    outcomes[k], messages[k] = Outcome.SOLVER_ERROR.name, f"not measured: {error}"
        return Batch(self.plan, points, keys, tuple(outcomes), tuple(messages), numbers)

    def warm_up(self) -> None:
        """Build and load what the first batch needs, so that it takes no longer than others."""
        try:
            point = _prepared(self.case)
            if self.lanes:
                last = replace(point.problem, times=np.array([point.problem.t0 + 1e-9 * point.problem.horizon]))
                solve_lanes([last], self.options, 1, self.gather, self.case.solver)
        except Exception:  # a case that cannot run shows at its points
            return

    def at(self, row: list[float]) -> Case:
        """The case of a point."""
        return self.case.change(parameters={**self.case.parameters, **dict(zip(self.names, row, strict=True))})

    def _solved(self, ready: Mapping[int, _Prepared], threads: int) -> dict[int, tuple[Trajectory, Callable[[], Array]]]:
        """The runs of the points that could start, each with what measures it."""
        found: dict[int, tuple[Trajectory, Callable[[], Array]]] = {}
        # Channels in lanes do not know of angles that were taken out of the start.
        side_by_side = {k: each for k, each in ready.items() if self.lanes and not np.any(each.offset)}
        if side_by_side:
            # The budget of seconds is one of each run, lanes count it for all.
            budget = replace(self.options.budget, max_seconds=self.options.budget.max_seconds * len(side_by_side))
            problems, options = [each.problem for each in side_by_side.values()], replace(self.options, budget=budget)
            lanes = solve_lanes(problems, options, threads, self.gather, self.case.solver)
            for row, (k, run) in enumerate(zip(side_by_side, lanes.trajectories, strict=True)):
                found[k] = run, functools.partial(gathered, self.wanted, run, lanes, row)
        for k, each in ready.items():
            if k not in side_by_side:
                run = solve(each.problem, self.case.solver, self.options)
                found[k] = run, functools.partial(self._measured, run, each)
        return found

    def _measured(self, run: Trajectory, point: _Prepared) -> Array:
        model, states = self.case.model, run.states + point.offset
        outputs = tuple(name for name in self.wanted.channels if name in model.outputs)
        if self.switched is None or run.events is None:
            values = model.channels(run.times, states, point.p, outputs)
        else:
            values = self.switched.channels(run.times, states, run.events.modes(run.times), point.p, outputs)
        own = {name: states[:, model.state_index(name)] for name in self.wanted.channels if name not in values}
        return measured(self.wanted, run, {**values, **own})


def _collected(case: Case, wanted: Collection) -> ca.Function:
    """The collected channels and states as a function (t, x, p) -> column, with the flags of modes in p where there are any."""
    model, switched = case.model, events_of(case)
    outputs = model.output_function if switched is None else switched.output_function
    t, x, p = (ca.SX.sym(name, outputs.size_in(k)) for k, name in enumerate(("t", "x", "p")))
    every = outputs(t, x, p)
    rows = [every[model.output_index(n)] if n in model.outputs else x[model.state_index(n)] for n in wanted.channels]
    return ca.Function("collected", [t, x, p], [ca.densify(ca.vertcat(*rows))], {"cse": True})


def key_of(case: Case) -> str:
    """The digest of a case; of one whose parameters are unlawful, that of its data."""
    try:
        return case.digest()
    except ModelgenError:
        return hashlib.sha256(json.dumps(case.data(), sort_keys=True).encode()).hexdigest()


def _prepared(case: Case) -> _Prepared:
    point = operating_point(case.model, case.parameters)
    problem, offset = initial_value_problem(case, point)
    return _Prepared(problem, offset, point.p)


def _reason(error: Exception) -> str:
    said = str(error) if isinstance(error, ModelgenError) else f"{type(error).__name__}: {error}"
    return Outcome.BAD_INPUT.sentence(reason=" ".join(said.split()))
