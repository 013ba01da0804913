"""CasADi's adaptive integrators, driven in chunks of the output times.

Part of ``solvers``; shared by ``cvodes``, ``idas``, ``erk`` and ``rosenbrock``. A call into CasADi can neither be interrupted nor
does it return anything when it fails. So time is advanced in chunks short enough for budgets of seconds and for cancellation, and
long enough that starting anew costs little (BDF starts at order one: some 60 steps, where a chunk has thousands). A chunk that
fails is tried again with an eighth of its length, until it succeeds or the place of trouble is known closely enough to be named
by ``diagnosis``. States count from the start of each chunk and are weighed by the absolute tolerance alone.
"""

from __future__ import annotations

import contextlib
import io
import math
import re
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np

from modelgen.solvers.coordinates import ScaledProblem, symbols_for
from modelgen.solvers.diagnosis import chatter, explain
from modelgen.solvers.outcome import Ending, Outcome
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Statistics, Trajectory, Vector
from modelgen.solvers.smallest_step import time_of_start
from modelgen.solvers.time_breaks import time_breaks
from modelgen.solvers.watch import Watch

LONGEST = 0.3  # s of wall clock that a chunk may take at the very worst
SHARE = 0.25  # of that is what it is expected to take
FEWEST = 100  # steps per output interval that should be allowed: a start at order one needs most of them
UNKNOWN_SIZE = 10_000  # instructions of a function that does not tell
LEAST = 16  # that are allowed, however dear
CAUTIOUS = 1000  # steps allowed in the first chunk, and in one after a chunk that failed
SHRINK, GROWTH = 8, 4
MANY_BREAKS = 64  # of a law in time, beyond which each chunk holds one output or none
NEAR = 1e-3  # of the horizon: so close to the trouble, its reason is looked for


@dataclass(frozen=True)
class Plugin:
    """What is particular to one of CasADi's integrators.

    ``rates_per_step``: what a step costs, in evaluations of the right-hand side. ``settings`` are options of its own; ``counts``
    names steps, rejected steps and evaluations in its statistics (several names are added up). ``own_steps``: it takes
    ``min_step_size`` and ``step_size``. ``stiff``: its smallest step counts from the pace of the start. ``noisy``: it prints what
    cannot be switched off.
    """

    name: str
    rates_per_step: int
    counts: tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]
    settings: dict[str, Any] = field(default_factory=dict)
    own_steps: bool = False
    stiff: bool = False
    noisy: bool = False


SUNDIALS_COUNTS = (("nsteps",), ("netfails", "nncfails"), ("nfevals",))
RUNGE_KUTTA_COUNTS = (("n_steps",), ("n_reject",), ("n_rhs",))

REASONS = {
    "CONV_FAIL": Outcome.NEWTON_FAILED,
    "TOO_MUCH_WORK": Outcome.STEP_TOO_SMALL,
    "TOO_MUCH_ACC": Outcome.STEP_TOO_SMALL,
    "ERR_FAIL": Outcome.STEP_TOO_SMALL,
    "Evaluation failed": Outcome.STEP_TOO_SMALL,  # all that erk and rosenbrock ever say
}


class _Integrators:
    """CasADi integrators over the times of a chunk; built anew only when those, or the allowed steps, differ.

    Time is counted from the start of the chunk, in units of about its shortest interval: CasADi skips intervals that are shorter
    than 1e-9 without a word. The start and the unit are parameters.
    """

    def __init__(self, scaled: ScaledProblem, plugin: Plugin, options: SolverOptions, single: bool) -> None:
        self.plugin, self.options, self.scaled, self.single = plugin, options, scaled, single
        self.floor = 0.0
        n, symbols = scaled.size, symbols_for(scaled.rate)
        tau, y, p = symbols.sym("tau"), symbols.sym("y", n), symbols.sym("p", 2 + scaled.parameters.size)
        start, unit, q = p[0], p[1], p[2:]
        self.system = {"t": tau, "x": y, "p": p, "ode": unit * scaled.rate(start + unit * tau, y, q)}
        self.resolution = 2 * math.ulp(max(abs(scaled.problem.t0), abs(float(scaled.problem.times[-1]))))
        self.known: dict[tuple[Any, ...], tuple[Vector, ca.Function]] = {}

    def gain(self, t: float, y: Vector, times: Vector, allowed: int) -> tuple[Vector, dict[str, Any]]:
        """What y gains from t to each of the times (n, nx), and the statistics; raises RuntimeError as CasADi does."""
        offsets = times - t
        # Between breaks no two chunks are alike but in their one end: in units of their length they share an integrator.
        alone = self.single and offsets.size == 1
        unit = float(offsets[0]) if alone else 2.0 ** math.floor(math.log2(np.diff(offsets, prepend=0.0).min()))
        chunk = self.over(offsets / unit, unit, allowed)
        parameters = np.concatenate([[t, unit], self.scaled.parameters_from(y)])
        with _quiet() if self.plugin.noisy else contextlib.nullcontext():
            gained = chunk(x0=np.zeros(self.scaled.size), p=parameters)["xf"]
        return np.array(gained).T, chunk.stats()

    def over(self, offsets: Vector, unit: float, allowed: int) -> ca.Function:
        """An integrator to the given times after its start, allowed so many steps from one to the next."""
        settings = self.step_sizes(unit)
        key = (offsets.size, allowed, *settings.items())
        if key not in self.known or np.abs(self.known[key][0] - offsets).max() * unit > self.resolution:
            settings |= {"abstol": self.options.tolerance, "reltol": 0.0, "max_num_steps": allowed, "show_eval_warnings": False}
            settings |= self.plugin.settings
            self.known[key] = offsets, ca.integrator("chunk", self.plugin.name, self.system, 0.0, offsets.tolist(), settings)
        return self.known[key][1]

    def step_sizes(self, unit: float) -> dict[str, Any]:
        """The options that are times, in the unit of the chunk."""
        given = {"max_step_size": self.options.largest_step}
        if not self.known:
            given["step0"] = self.options.first_step
        if self.plugin.own_steps:
            given |= {"step_size": self.options.fixed_step, "min_step_size": self.floor}
        return {name: size / unit for name, size in given.items() if size is not None}


_LOCK = threading.Lock()


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Nothing that CasADi says goes to the screen; one thread at a time, because the stream belongs to all."""
    with _LOCK, contextlib.redirect_stderr(io.StringIO()):
        yield


def seconds_per_rate(rhs: ca.Function) -> float:
    """About how long an evaluation takes, by the size of the function.

    Not measured: the chunks, and with them the last digits of a result, must not depend on how busy the machine is.
    """
    return 1e-6 + 3e-9 * (rhs.n_instructions() if rhs.is_a("SXFunction") else UNKNOWN_SIZE)


class _Run:
    """One run: where it stands, how far the next chunk reaches, and how many steps it took."""

    def __init__(self, problem: InitialValueProblem, options: SolverOptions, plugin: Plugin) -> None:
        self.watch = Watch(options)
        self.problem, self.options, self.plugin = problem, options, plugin
        self.scaled = ScaledProblem(problem)
        self.t, self.y = problem.t0, np.zeros(self.scaled.size)
        self.start = time_of_start(self.scaled) if plugin.stiff else problem.horizon
        self.values = np.zeros((problem.times.size, self.scaled.size))
        self.done = int(problem.times[0] == problem.t0)  # outputs reached; the start itself is zero
        self.reach = problem.horizon / 64
        self.breaks = time_breaks(problem)
        self.t, self.passed = self.breaks.start(problem.t0)
        self.integrators = _Integrators(self.scaled, plugin, options, single=len(self.breaks) > MANY_BREAKS)
        self.affordable = LONGEST / (5e-6 + plugin.rates_per_step * seconds_per_rate(problem.rhs))  # steps in a chunk
        self.ceiling = CAUTIOUS  # the same, by experience
        self.pace = problem.horizon / CAUTIOUS  # mean step of the last chunk [s]
        self.counts = np.zeros(3, dtype=int)

    @property
    def floor(self) -> float:
        """The smallest step [s]: a share of the time since the start, in steps of 16, so that few integrators are built."""
        since = max(self.t - self.problem.t0, self.start)
        share = 16.0 ** math.floor(math.log(since / self.problem.horizon, 16))
        return max(self.options.budget.smallest_step * share * self.problem.horizon, 64 * math.ulp(max(abs(self.t), 1e-300)))

    def run(self) -> Trajectory:
        """Chunk by chunk to the end, or to whatever stops the run before."""
        ending = None
        end = float(self.problem.times[-1])
        if self.t < end and not np.isfinite(self.scaled.rates(self.t, self.y)).all():
            ending = self.explain(self.floor, Outcome.NON_FINITE_RATE)
        while ending is None and self.t < end:
            ending = self.advance()
        if ending is None:
            self.watch.finish()
            ending = Ending(Outcome.SUCCESS, Outcome.SUCCESS.sentence(time=end))
        steps, rejected, evaluations = self.counts.tolist()
        cost = Statistics(steps, rejected, evaluations, self.watch.seconds)
        return self.scaled.trajectory(self.values[: self.done], ending, cost)

    def advance(self) -> Ending | None:
        """One chunk; an ending if the run cannot or must not go on."""
        if (ending := self.look()) is not None:
            return ending
        times = self.next_times()
        length = float(times[-1]) - self.t
        allowed = max(LEAST, int(self.affordable_steps() / times.size))
        try:
            # Powers of two, so that few integrators are built.
            self.integrators.floor = self.floor
            gained, statistics = self.integrators.gain(self.t, self.y, times, 1 << (allowed.bit_length() - 1))
            reason = "" if np.isfinite(gained).all() else "a result that is not finite"
        except RuntimeError as error:
            reason = str(error)
        if reason:
            return self.shorten(length, reason)
        counts = np.array([sum(statistics[name] for name in names) for names in self.plugin.counts])
        self.accept(times, gained, counts)
        if np.abs(self.y).max() > self.options.budget.bound:
            return self.explain(length, Outcome.DIVERGED, beyond=self.y)
        return chatter(self.scaled, self.t, self.y, self.pace / 4)

    def look(self) -> Ending | None:
        """Ask the watch and count the steps."""
        reason = self.watch.look((self.t - self.problem.t0) / self.problem.horizon)
        if reason is Outcome.CANCELLED:
            return Ending(reason, reason.sentence(time=self.t))
        if reason is None and self.counts[0] >= self.options.budget.max_steps:
            reason = Outcome.MAX_STEPS
        return reason and self.explain(self.pace / 4, reason)

    def affordable_steps(self) -> float:
        """Steps that a chunk may take at the very worst."""
        return min(self.affordable, self.ceiling)

    def next_times(self) -> Vector:
        """The output times within reach, as many as the budget of a chunk allows; without any, just the reach.

        A chunk ends just before the next break of a law in time.
        """
        times, stop = self.problem.times, self.t + self.reach
        if self.passed < len(self.breaks):
            stop = min(stop, float(self.breaks.before[self.passed]))
        if self.integrators.single:
            return np.array([min(stop, float(times[self.done]))])
        most = max(1, int(self.affordable_steps() / FEWEST))
        last = int(np.searchsorted(times, stop, side="right"))
        if last == self.done:
            return np.array([stop])
        found = times[self.done : min(last, self.done + most)]
        return found if stop == self.t + self.reach or last > self.done + most or found[-1] == stop else np.append(found, stop)

    def accept(self, times: Vector, gained: Vector, counts: Vector) -> None:
        """Take a chunk over, and let the next one reach as far as the steps of this one suggest."""
        length = float(times[-1]) - self.t
        if self.problem.times[self.done] <= times[-1]:
            values = self.y + gained
            inside = np.abs(values).max(axis=1) <= self.options.budget.bound
            kept = int(np.count_nonzero(np.isin(times, self.problem.times))) if inside.all() else int(np.argmin(inside))
            self.values[self.done : self.done + kept] = values[:kept]
            self.done += kept
        self.t, self.y = float(times[-1]), self.y + gained[-1]
        self.cross()
        self.counts += counts
        self.pace = length / max(1, counts[0])
        self.ceiling *= 2
        possible = SHARE * self.affordable_steps() * self.pace
        while self.reach * 2 <= min(possible, GROWTH * length):
            self.reach *= 2  # powers of two: the same integrators serve again
        if possible < self.reach / 2:
            self.reach /= 2

    def cross(self) -> None:
        """Go over a break before which the run stands: outputs on it take the state there, which goes on with its slope."""
        if self.passed == len(self.breaks) or self.t < self.breaks.before[self.passed]:
            return
        after, times = float(self.breaks.after[self.passed]), self.problem.times
        self.passed += 1
        while self.done < times.size and times[self.done] <= after:
            self.values[self.done] = self.y
            self.done += 1
        self.y = self.y + (after - self.t) * self.scaled.rates(self.t, self.y)
        self.t = after

    def shorten(self, length: float, reason: str) -> Ending | None:
        """After a chunk that failed: name the trouble, or try a shorter one."""
        near = length < NEAR * self.problem.horizon
        if near and (found := chatter(self.scaled, self.t, self.y, length / SHRINK)) is not None:
            return found
        self.reach, self.ceiling = length / SHRINK, CAUTIOUS
        shortest = self.options.fixed_step or self.floor
        if self.reach >= shortest:
            return None
        word = next((word for word in REASONS if word in reason), None)
        if word is not None:
            outcome = REASONS[word]
            if self.options.fixed_step is not None:  # there is no smaller step to blame
                outcome = Outcome.DIVERGED
            return self.explain(length, outcome)
        flag = re.search(r'returned "(\w+)"', reason)
        return self.explain(length, Outcome.SOLVER_ERROR, reason=flag[1] if flag else reason.strip().splitlines()[-1])

    def explain(self, step: float, fallback: Outcome, **facts: Any) -> Ending:
        budget = self.options.budget
        budgets: dict[Outcome, float] = {Outcome.MAX_STEPS: budget.max_steps, Outcome.MAX_TIME: budget.max_seconds}
        known = {"tolerance": self.options.tolerance, "budget": budgets.get(fallback, math.nan)}
        return explain(self.scaled, self.t, self.y, step, fallback, **{**known, **facts})


def integrate_in_chunks(problem: InitialValueProblem, options: SolverOptions, plugin: Plugin) -> Trajectory:
    """Integrate a problem with one of CasADi's adaptive integrators."""
    return _Run(problem, options, plugin).run()
