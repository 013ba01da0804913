"""Question: over two parameters, such as speed and load, where do angles grow, and where do gears rattle?

Every cell is a run of its own: over a window of whole revolutions of the slowest base frequency, after the slowest vibrating mode
has decayed, it gives the largest vibration angle (less its best straight line), the least mesh force, and the shares of time that
the flanks are apart or on their back. Cells run in lanes, each with its own times, because speed changes every period.
Rattle is one-sided where flanks part and come back to the driving side, two-sided where the back flank is hit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.nonlinear.common_period import Strobe, strobe_of
from modelgen.analysis.nonlinear.motion import vibrating_states
from modelgen.analysis.nonlinear.recurrence import departures
from modelgen.analysis.nonlinear.runs import (
    Also,
    Setting,
    options_of,
    parameter_values,
    restarted,
    run_channels,
    setting,
)
from modelgen.analysis.time_domain.window import Window, settled_window
from modelgen.errors import BalanceError, CaseError, Interrupted, ModelError, nearest
from modelgen.lowering import Compiled
from modelgen.solvers.asked_case import asked_case
from modelgen.solvers.crosscheck import without_line
from modelgen.solvers.outcome import Outcome

Array = NDArray[np.float64]
RATTLE = ("none", "one-sided", "two-sided")
SAMPLES = 512  # of a revolution of the slowest base frequency
BATCH = 64  # cells whose motion is held in memory at once
FEWEST = 4  # repetitions that show a period
STILL = 1e-3  # of the scales: how near a motion comes back that repeats


@dataclass(frozen=True, eq=False)
class MapResult:
    """Cells over two parameters, ``first`` (columns) and ``second`` (rows), each by name, unit and values.

    Arrays are (second, first). ``peak_angle`` [rad]: largest vibration angle of any of ``inertias``, 0-peak, at the inertia of
    that number in ``where``. For each of ``meshes``: ``least_force`` [N], ``apart`` and ``back``, shares of time without contact
    and on the back flank. ``repeats``: after so many common periods (1 or 2), 0 where it does not, or the common period is longer
    than the window. ``settled``: the slowest mode had time to decay. ``failures``: sentence by (row, column) of cells that could
    not be run, whose numbers are nan; ``missing`` of them because Ctrl-C came.
    """

    model: str
    first: str
    first_unit: str
    first_values: Array
    second: str
    second_unit: str
    second_values: Array
    inertias: tuple[str, ...]
    peak_angle: Array
    where: NDArray[np.int64]
    meshes: tuple[str, ...]
    least_force: dict[str, Array]
    apart: dict[str, Array]
    back: dict[str, Array]
    repeats: NDArray[np.int64]
    settled: NDArray[np.bool_]
    failures: dict[tuple[int, int], str]
    revolutions: int
    base: str
    missing: int = 0

    @property
    def largest_angle(self) -> float | None:
        """The largest vibration angle of any cell [rad]; None where every cell failed."""
        known = self.peak_angle[~np.isnan(self.peak_angle)]
        return float(known.max()) if known.size else None

    def rattle(self, mesh: str | None = None) -> NDArray[np.int64]:
        """0 none, 1 one-sided, 2 two-sided (``RATTLE``) of one mesh, or the worst of all; -1 for a cell that could not be run."""
        if mesh is not None and mesh not in self.meshes:
            raise CaseError(f"operating map of {self.model!r}", f"no gear pair {mesh!r}", nearest(mesh, self.meshes))
        chosen = self.meshes if mesh is None else (mesh,)
        worst = np.zeros(self.peak_angle.shape, dtype=np.int64)
        for name in chosen:
            worst = np.maximum(worst, np.where(self.back[name] > 0, 2, np.where(self.apart[name] > 0, 1, 0)))
        return np.where(np.isnan(self.peak_angle), -1, worst)

    def __str__(self) -> str:
        worst = self.rattle()
        counted = (
            ", ".join(f"{name} {int(np.sum(worst == k))}" for k, name in enumerate(RATTLE)) if self.meshes else "no gear pair"
        )
        failed = ""
        if self.failures:
            (row, column), why = next(iter(self.failures.items()))
            failed = f"; {len(self.failures)} cells failed, the first in row {row + 1}, column {column + 1}: {why}"
        largest = f"; largest vibration angle {np.degrees(self.largest_angle):.4g} deg" if self.largest_angle is not None else ""
        return (
            f"operating map of {self.model!r}: {self.first} x {self.second}, {worst.size} cells; rattle: {counted}"
            f"{largest}{failed}"
        )

    __repr__ = __str__


def operating_map(
    case: Any,
    first: tuple[str, Sequence[Any]],
    second: tuple[str, Sequence[Any]],
    *,
    also: Also | None = None,
    revolutions: int = 8,
    longest: float = 60.0,
    tolerance: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> MapResult:
    """The map over two parameters, each given as (name, values in its SI unit or texts with units).

    ``also(value of first)``: further parameters that change with it. ``revolutions`` of the slowest base frequency are measured,
    after the transient, but at most ``longest`` seconds are run. Raises CaseError, NamingError, ModelError for what cannot be;
    a cell that has no balance or equilibrium is one of the failures, unless all are. Raises Interrupted with the cells that
    are done where Ctrl-C comes after the first of them.
    ``tolerance`` of a step, per scale of each state: by default that of a case, 1e-5 for any other model.
    """
    question = "operating map"
    case = asked_case(case, question, {"tolerance": 1e-5}, tolerance=tolerance)
    model = case.model
    axes = []
    for each in (first, second):
        if not isinstance(each, tuple) or len(each) != 2:
            raise CaseError(question, f"has the axis {each!r:.40}", "give (parameter, values)")
        axes.append((each[0], sorted(set(parameter_values(model, *each, question)))))
    if axes[0][0] == axes[1][0]:
        raise CaseError(question, f"has {axes[0][0]!r} on both axes", "name two parameters")
    if isinstance(revolutions, bool) or not isinstance(revolutions, int) or revolutions < 1:
        raise CaseError(f"{question}, revolutions", f"is {revolutions!r}", "give a whole number from 1 up")
    (name_1, values_1), (name_2, values_2) = axes
    places = [(row, column) for row in range(len(values_2)) for column in range(len(values_1))]
    measure = _Measure(model, (len(values_2), len(values_1)))
    settings: dict[tuple[int, int], tuple[Setting, Window]] = {}
    for row, column in places:
        changes = {**(also(values_1[column]) if also else {}), name_1: values_1[column], name_2: values_2[row]}
        try:
            made = setting(case, **changes)
            settings[row, column] = made, settled_window(model, made.point, revolutions, longest)
        except (BalanceError, CaseError, ModelError) as error:
            measure.failures[row, column] = str(error)
            if len(measure.failures) == len(places):
                raise
    missing = measure.take_all(settings, progress)
    window = next(iter(settings.values()))[1]
    result = MapResult(
        model=model.name,
        first=name_1,
        first_unit=model.parameters.place(name_1)[0].unit,
        first_values=np.array(values_1),
        second=name_2,
        second_unit=model.parameters.place(name_2)[0].unit,
        second_values=np.array(values_2),
        inertias=tuple(name.removesuffix(".angle_deviation") for name in measure.angles),
        peak_angle=measure.peak,
        where=measure.where,
        meshes=tuple(measure.meshes),
        least_force=measure.least,
        apart=measure.apart,
        back=measure.back,
        repeats=measure.repeats,
        settled=measure.settled,
        failures=measure.failures,
        revolutions=revolutions,
        base=window.base,
        missing=missing,
    )
    if missing:
        raise Interrupted(result)
    return result


def _batches(places: list[tuple[int, int]], size: int) -> Iterator[list[tuple[int, int]]]:
    for first in range(0, len(places), size):
        yield places[first : first + size]


class _Measure:
    """What is kept of each cell."""

    def __init__(self, model: Compiled, shape: tuple[int, int]) -> None:
        self.model = model
        self.angles = [name for name in model.outputs if name.endswith(".angle_deviation")]
        self.meshes = [name.removesuffix(".penetration") for name in model.outputs if name.endswith(".penetration")]
        self.peak = np.full(shape, np.nan)
        self.where = np.zeros(shape, dtype=np.int64)
        self.least, self.apart, self.back = ({mesh: np.full(shape, np.nan) for mesh in self.meshes} for _ in range(3))
        self.repeats = np.zeros(shape, dtype=np.int64)
        self.settled = np.zeros(shape, dtype=np.bool_)
        self.failures: dict[tuple[int, int], str] = {}

    def take_all(
        self, cells: dict[tuple[int, int], tuple[Setting, Window]], progress: Callable[[float], None] | None
    ) -> int:
        """Runs and measures all cells, or as many as are done when Ctrl-C comes; how many were not run."""
        done = 0
        try:
            for batch in _batches(list(cells), BATCH):
                self.take({place: cells[place] for place in batch})
                done += len(batch)
                if progress is not None:
                    progress(done / len(cells))
        except KeyboardInterrupt:
            if not done:
                raise
            missing = list(cells)[done:]
            self.failures.update(dict.fromkeys(missing, "Ctrl-C came before it was run"))
            for place in missing:
                self.peak[place] = np.nan
            return len(missing)
        return 0

    def take(self, cells: dict[tuple[int, int], tuple[Setting, Window]]) -> None:
        """Runs some cells together and measures each."""
        problems, case = [], next(iter(cells.values()))[0].case
        for made, window in cells.values():
            count = SAMPLES * window.revolutions
            times = window.first + (window.last - window.first) * np.arange(1, count + 1) / count
            problems.append(restarted(made.problem, made.problem.x0, times))
        pressed = [f"{mesh}.{kind}" for mesh in self.meshes for kind in ("force", "penetration")]
        names = [*self.angles, *pressed]
        runs = run_channels(case, problems, options_of(case), names)
        for (place, (made, window)), (run, values) in zip(cells.items(), runs, strict=True):
            if run.outcome is Outcome.SUCCESS:
                named = dict(zip(names, values.T, strict=True))
                self._cell(place, made, window, run.times, run.states, named)
            else:
                self.failures[place] = run.message

    def _cell(
        self, place: tuple[int, int], made: Setting, window: Window, times: Array, states: Array, values: dict[str, Array]
    ) -> None:
        peaks = np.array([np.abs(without_line(times, values[name])).max() for name in self.angles])
        self.peak[place] = peaks.max(initial=0.0)
        self.where[place] = int(peaks.argmax()) if len(peaks) else 0
        for mesh in self.meshes:
            depth = values[f"{mesh}.penetration"]
            self.least[mesh][place] = values[f"{mesh}.force"].min()
            self.apart[mesh][place] = np.mean(depth == 0)
            self.back[mesh][place] = np.mean(depth < 0)
        self.settled[place] = window.settled
        self.repeats[place] = self._repeats(made, window, states)

    def _repeats(self, made: Setting, window: Window, states: Array) -> int:
        """Common periods (1 or 2) after which the motion comes back, four times at least."""
        if window.revolutions < FEWEST:
            return 0
        try:
            strobe: Strobe = strobe_of(self.model, made.point, longest=window.revolutions / FEWEST)
        except CaseError:
            return 0
        each = SAMPLES * int(min(strobe.cycles.values()))
        kept = vibrating_states(self.model, made.point)
        sequence = (states[each - 1 :: each] / made.problem.scale)[:, kept]
        for period in (1, 2):
            if len(sequence) >= FEWEST * period and departures(sequence, period).max() <= STILL:
                return period
        return 0
