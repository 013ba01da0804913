"""Cross-check: the same case by several solvers at several tolerances, channel by channel.

Between ``simulate`` and ``analysis``. Two solvers that share nothing but the right-hand side agree only if both are right about
time; their differences must fall with the tolerance. A difference is stated relative to half the peak-to-peak of the
channel's fluctuating part, so that neither a large mean nor a rolling angle hides it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.solvers.asked_case import asked_case
from modelgen.solvers.case import Case
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Statistics
from modelgen.solvers.simulate import simulate
from modelgen.solvers.solution import Solution

Array = NDArray[np.float64]
VIBRATING = (".angle_deviation", ".twist", ".deflection", ".force")
SEGMENTS = 24
SAMPLES = 20_001  # of the comparison, where no case says how many
MEANINGLESS = 1e-2  # beyond this difference two trajectories are no longer the same motion


@dataclass(frozen=True, eq=False)
class CrosscheckRun:
    """One solver at one tolerance: how it ended, what it cost, and its largest difference per channel."""

    solver: str
    tolerance: float
    outcome: Outcome
    message: str
    statistics: Statistics
    differences: Mapping[str, float]

    @property
    def worst(self) -> float:
        """Largest relative difference over the channels; infinite for a run that did not reach the end."""
        return max(self.differences.values(), default=math.inf)

    @property
    def worst_channel(self) -> str:
        """The channel it is in."""
        return max(self.differences, key=lambda name: self.differences[name], default="none")


@dataclass(frozen=True, eq=False)
class CrosscheckResult:
    """All runs against a reference run, over ``horizon`` [s] of simulated time.

    ``runs`` by solver and tolerance; ``reference`` names the run that the others are compared with; ``swing`` is half the
    peak-to-peak of each channel's fluctuating part [its unit]; ``growth_rate`` [1/s] of the difference between the two best
    runs where it grows exponentially (0 otherwise), ``meaningful_until`` [s]: when that difference passes 1 %, by what was
    seen or by its growth (infinite where it does not grow).
    """

    model: str
    horizon: float
    reference: tuple[str, float]
    reference_message: str
    swing: Mapping[str, float]
    runs: tuple[CrosscheckRun, ...]
    growth_rate: float
    meaningful_until: float

    @property
    def solvers(self) -> tuple[str, ...]:
        """The solvers compared, the reference's first."""
        return tuple(dict.fromkeys([self.reference[0], *(run.solver for run in self.runs)]))

    def best(self, solver: str) -> CrosscheckRun:
        """The run of a solver that came nearest to the reference."""
        return min((run for run in self.runs if run.solver == solver), key=lambda run: run.worst)

    @property
    def worst_relative_difference(self) -> float:
        """Largest difference of any channel, each solver at its best tolerance."""
        return max((self.best(name).worst for name in {run.solver for run in self.runs}), default=0.0)

    def sentence(self) -> str:
        """How far the comparison carries, in words."""
        if not self.growth_rate:
            worst = f"{self.worst_relative_difference:.2g}"
            return f"Over {self.horizon:g} s the solvers differ by at most {worst}; the difference does not grow exponentially."
        return (
            f"The difference grows exponentially, by a factor e every {1 / self.growth_rate:.3g} s; "
            f"a comparison of trajectories means something until about {self.meaningful_until:.3g} s."
        )

    def __str__(self) -> str:
        head = f"cross-check of {self.model!r} over {self.horizon:g} s against {self.reference[0]} at {self.reference[1]:g}"
        rows = [
            f"  {run.solver:12s} {run.tolerance:8.0e}  {run.worst:9.2e} in {run.worst_channel:32s} "
            f"{run.statistics.steps:8d} steps {run.statistics.evaluations:9d} evaluations {run.statistics.seconds:7.2f} s"
            for run in self.runs
        ]
        return "\n".join([head, *rows, self.sentence()])

    __repr__ = __str__


def crosscheck(
    case: Any,
    solvers: Sequence[str] = ("rk4", "cvodes"),
    tolerances: Sequence[float] | Mapping[str, Sequence[float]] = (1e-8, 1e-10),
    *,
    reference: tuple[str, float] | None = None,
    channels: Sequence[str] | None = None,
    end: Any = None,
) -> CrosscheckResult:
    """Runs the case by every solver at every tolerance and compares each channel with the reference run.

    ``tolerances`` are the same for all solvers, or given per solver. The reference is by default the first solver at a tenth of
    its tightest tolerance. ``channels`` defaults to every angle, twist, mesh deflection and force.
    ``end``: length of the comparison, of a case its own, of any other model 1 s.
    Raises CaseError for names that are not known and for a reference that did not reach its end.

    >>> from modelgen import Case, Driveline, Inertia, Shaft
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])
    >>> result = crosscheck(Case(line, end=0.5, start={"shaft.twist": 0.01}), tolerances=[1e-9])
    >>> result.solvers, result.worst_relative_difference < 1e-6
    (('rk4', 'cvodes'), True)
    """
    case = asked_case(case, "crosscheck", {"samples": SAMPLES}, end=end)
    if not solvers:
        raise CaseError("cross-check", "has nothing to compare", "give a case with its model and at least one solver")
    of_each = tolerances if isinstance(tolerances, Mapping) else dict.fromkeys(solvers, tolerances)
    plan = [(name, tolerance) for name in solvers for tolerance in of_each[name]]
    if not plan:
        raise CaseError("cross-check", "has no tolerances", "give at least one")
    chosen = reference or (solvers[0], min(tolerance for name, tolerance in plan if name == solvers[0]) / 10)
    names = tuple(channels or (name for name in case.model.outputs if name.endswith(VIBRATING)))
    base = case.change(channels=names)
    exact = _run(base, *chosen)
    if not exact.succeeded:
        raise CaseError(
            "cross-check", f"the reference run failed: {exact.message}", "shorten the horizon or loosen the tolerance"
        )
    swing = {name: _swing(exact.times, exact[name]) for name in names}
    moving = [name for name in names if swing[name] > 0]
    runs, nearest_difference = [], None
    for name, tolerance in plan:
        solution = _run(base, name, tolerance)
        differences: dict[str, float] = {}
        if solution.succeeded:
            over_time = np.array([np.abs(solution[key] - exact[key]) / swing[key] for key in moving])
            differences = dict(zip(moving, over_time.max(axis=1).tolist(), strict=True)) if moving else {"none": 0.0}
            if moving and name != chosen[0]:
                worst = over_time.max(axis=0)
                nearest_difference = (
                    worst if nearest_difference is None or worst.max() < nearest_difference.max() else nearest_difference
                )
        runs.append(CrosscheckRun(name, tolerance, solution.outcome, solution.message, solution.statistics, differences))
    growth, until = (0.0, math.inf) if nearest_difference is None else exponential_growth(exact.times, nearest_difference)
    return CrosscheckResult(
        case.model.name, case.end - case.begin, chosen, exact.message, swing, tuple(runs), growth, until
    )  # fmt: skip


def _run(case: Case, solver: str, tolerance: float) -> Solution:
    keep = {key: value for key, value in case.options.items() if key in ("budget", "progress", "cancel")}
    options = dict(case.options) if solver == case.solver else keep
    return simulate(case.change(solver=solver, tolerance=tolerance, options=options))


def without_line(times: Array, values: Array) -> Array:
    """Values less their best straight line in time (least squares): what fluctuates of a channel."""
    centered = times - times.mean()
    slope = float(centered @ (values - values.mean())) / float(centered @ centered)
    return np.asarray(values - values.mean() - slope * centered)


def _swing(times: Array, values: Array) -> float:
    """Half peak-to-peak of what fluctuates of a channel; zero where that is rounding only."""
    rest = without_line(times, values)
    noise = 1e-13 * float(np.abs(values).max(initial=0.0))
    return 0.0 if np.ptp(rest) <= noise else float(np.ptp(rest)) / 2


def exponential_growth(times: Array, difference: Array) -> tuple[float, float]:
    """Growth rate [1/s] of a difference and the time [s] at which it passes 1 %; (0, inf) where it does not grow exponentially.

    The largest difference in each of 24 parts of the horizon is fitted by a straight line in its logarithm; growth counts as
    exponential from a hundredfold on over the last half, with the line explaining nine tenths of the spread.
    """
    parts = [part for part in np.array_split(np.arange(len(times)), SEGMENTS) if len(part)]
    middle = np.array([times[part].mean() for part in parts])
    size = np.array([difference[part].max() for part in parts])
    over = np.flatnonzero(difference > MEANINGLESS)
    crossed = float(times[over[0]]) if over.size else math.inf
    use = (size > 0) & (size < MEANINGLESS)
    use[: len(use) // 4] = False
    if use.sum() < 5:
        return 0.0, crossed
    x, y = middle[use], np.log(size[use])
    slope, level = np.polyfit(x, y, 1)
    spread = float(np.var(y))
    explained = 1 - float(np.var(y - (slope * x + level))) / spread if spread > 0 else 0.0
    if slope * (x[-1] - x[0]) < math.log(100) or explained < 0.9:
        return 0.0, crossed
    return float(slope), min(crossed, float((math.log(MEANINGLESS) - level) / slope))
