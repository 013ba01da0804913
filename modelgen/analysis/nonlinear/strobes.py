"""Question: where does the motion stand at every common period, once the transient is over?

Below ``sections`` and ``bifurcation``. Runs go on in rounds until their strobes stand still relative to the scale of each
vibrating state, or a budget of strobes ends; then enough more for a record. Because everything repeats with the common period, a
round begins at time zero again: thousands of periods do not wear out the clock, and the rolling of a free driveline is put back.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.nonlinear.common_period import Strobe, strobe_of
from modelgen.analysis.nonlinear.motion import vibrating_states
from modelgen.analysis.nonlinear.recurrence import FEWEST, nearest_return, recurrence
from modelgen.analysis.nonlinear.runs import Setting, options_of, restarted, run_all
from modelgen.errors import CaseError
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Trajectory

Array = NDArray[np.float64]
ROUND = 20  # strobes between two looks
STILL, NOISE = 1e-6, 10.0
"""Of each state's scale: strobes that come back this near stand still, or within so many tolerances of the solver."""


@dataclass(frozen=True)
class Patience:
    """``count`` strobes are recorded after at most ``transient`` strobes; ``still``: how near they come back, per scale.

    By default 1e-6 or ten times the solver's tolerance, whichever is more.
    """

    count: int = 150
    transient: int = 200
    still: float | None = None

    def __post_init__(self) -> None:
        for name, least in (("count", FEWEST), ("transient", 0)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise CaseError(f"strobes, {name}", f"is {value!r}", f"give a whole number from {least} up")
        if self.still is not None and not 0 < self.still < 1:
            raise CaseError("strobes, still", f"is {self.still!r}", "give a share of the states' scales, such as 1e-6")

    def within(self, tolerance: float) -> float:
        """How near strobes must come back for runs at a tolerance."""
        return self.still if self.still is not None else max(STILL, NOISE * tolerance)


@dataclass(frozen=True, eq=False)
class Strobed:
    """The strobes of one run after its transient.

    ``states`` (strobes, nx) at whole common periods; ``scale`` (nx); ``vibrating``: positions of the states that count.
    ``transient`` strobes came before. ``period`` in strobes (0: none up to 16), ``residual``: how far strobes are from coming
    back, per scale; ``settled``: whether they stand still. ``outcome`` and ``message`` say how the run ended.
    """

    setting: Setting
    strobe: Strobe
    states: Array
    scale: Array
    vibrating: tuple[int, ...]
    transient: int
    period: int
    residual: float
    settled: bool
    outcome: Outcome
    message: str

    @property
    def sequence(self) -> Array:
        """The vibrating states per scale (strobes, vibrating states)."""
        kept = list(self.vibrating)
        return np.asarray(self.states[:, kept] / self.scale[kept], dtype=float)

    @property
    def times(self) -> Array:
        """Times of the strobes [s]; where everything repeats, all are the start of a common period."""
        t0 = self.setting.problem.t0
        if self.strobe.complete:
            return np.full(len(self.states), t0)
        return np.asarray(t0 + self.strobe.period * (self.transient + 1.0 + np.arange(len(self.states))), dtype=float)

    @property
    def final(self) -> Array:
        """The last state (nx,), to continue from."""
        return np.asarray(self.states[-1] if len(self.states) else self.setting.problem.x0)


def strobed(
    settings: Sequence[Setting],
    patience: Patience | None = None,
    *,
    starts: Sequence[Array] | None = None,
    base: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Strobed]:
    """Strobes of many settings of one case, all together in lanes.

    ``starts``: states to start from instead of each case's own. ``base``: strobe at the period of this base frequency; where that
    is not the common one the motion is no point, and the whole ``transient`` is waited for.
    Raises CaseError where there is no short common period.
    """
    patience = patience or Patience()
    if not settings:
        raise CaseError("strobes", "there are no settings", "give at least one")
    case, options = settings[0].case, options_of(settings[0].case)
    still = patience.within(options.tolerance)
    runs = [_Run(each, strobe_of(each.case.model, each.point, base), patience, still) for each in settings]
    if starts is not None and len(starts) != len(runs):
        raise CaseError("strobes, starts", f"are {len(starts)} for {len(runs)} settings", "give one for each")
    for run, start in zip(runs, starts or [], strict=False):
        run.state = np.array(start, dtype=float)
    while active := [run for run in runs if run.needs]:
        longest = max(run.needs for run in active)
        # Only whole common periods can be put together from rounds.
        size = min(ROUND, longest) if all(run.strobe.complete for run in active) else longest
        counted = np.arange(1.0, size + 1.0)
        problems = [
            restarted(
                *(run.setting.problem, run.state, np.array(run.setting.problem.t0 + run.strobe.period * counted)),
                before=run.before,
            )
            for run in active
        ]
        for run, trajectory in zip(active, run_all(case, problems, options), strict=True):
            run.take(trajectory)
        if progress is not None:
            progress(1 - sum(run.needs for run in runs) / (len(runs) * (patience.count + patience.transient)))
    return [run.result() for run in runs]


class _Run:
    """One run on its way: what it has shown so far, and how many strobes it still needs."""

    def __init__(self, setting: Setting, strobe: Strobe, patience: Patience, still: float) -> None:
        self.setting, self.strobe, self.patience, self.still = setting, strobe, patience, still
        model, self.scale = setting.case.model, setting.problem.scale
        self.neutral = list(model.equations.rigid)
        self.vibrating = vibrating_states(model, setting.point)
        self.state = np.array(setting.problem.x0)
        self.before: Trajectory | None = None
        self.seen = np.zeros((0, len(self.state)))
        self.transient = patience.transient
        self.outcome, self.message, self.ended = Outcome.SUCCESS, "", False

    @property
    def needs(self) -> int:
        """Strobes that are still to come, as far as is known."""
        return 0 if self.ended else max(0, self.transient + self.patience.count - len(self.seen))

    def take(self, trajectory: Trajectory) -> None:
        """Adds a round and looks whether the strobes stand still."""
        self.before, states = trajectory, trajectory.states
        self.outcome, self.message = trajectory.outcome, trajectory.message
        self.ended = trajectory.outcome is not Outcome.SUCCESS
        self.seen = np.concatenate([self.seen, states])
        if len(states):
            self.state = states[-1].copy()
            self.state[self.neutral] = 0.0
        found = recurrence(self.sequence(self.seen), self.still)
        # A departure after strobes that stood still already (a start near an unstable orbit) ends the transient later again.
        self.transient = min(found.first, self.patience.transient) if found.period else self.patience.transient

    def sequence(self, states: Array) -> Array:
        return np.asarray(states[:, self.vibrating] / self.scale[self.vibrating])

    def result(self) -> Strobed:
        states = self.seen[self.transient :][: self.patience.count]
        sequence = self.sequence(states)
        found = recurrence(self.sequence(self.seen), self.still)
        settled = found.period > 0 and found.first <= self.transient and not self.ended
        return Strobed(
            setting=self.setting,
            strobe=self.strobe,
            states=states,
            scale=self.scale,
            vibrating=tuple(self.vibrating),
            transient=min(self.transient, len(self.seen)),
            period=found.period if settled else 0,
            residual=found.residual if settled else nearest_return(sequence),
            settled=settled,
            outcome=self.outcome,
            message=self.message,
        )
