"""Question: how does the settled motion change as a parameter changes?

Each value of the parameter gets a column: the strobes at the common period after the transient. Columns are independent (each
from the case's own start, or from several starts, which finds motions that coexist), or follow each other, each from the last
state of its neighbor, upward or downward, which shows hysteresis. A column that did not come to stand still is kept with its
residual and says so.
Without damping there is nothing that a motion settles to: a column then shows one motion from one start, no attractor.
Source: S. H. Strogatz, Nonlinear Dynamics and Chaos (1994), ch. 10.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.nonlinear.motion import motion_of
from modelgen.analysis.nonlinear.runs import Also, Setting, parameter_values, setting
from modelgen.analysis.nonlinear.sections import section_channels
from modelgen.analysis.nonlinear.strobes import Patience, Strobed, strobed
from modelgen.errors import CaseError, Interrupted, nearest
from modelgen.lowering import Compiled
from modelgen.solvers.asked_case import asked_case
from modelgen.solvers.case import STARTS, Case
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.start import starting_state

Array = NDArray[np.float64]
Start = str | Mapping[str, float]
DIRECTIONS = ("independent", "forward", "backward", "both")
BATCH = 64  # independent columns that run together, and are kept together when Ctrl-C comes


@dataclass(frozen=True, eq=False)
class Column:
    """The settled motion at one value: ``points`` (strobes, channels), ``sequence`` (strobes, vibrating states) per scale.

    ``branch``: "independent", "forward", "backward", or the number of the start. ``period`` in strobes (1 to 16; 0: none, or not
    settled); ``residual``: how far strobes are from coming back; ``transient``: strobes before; ``final``: the last state.
    """

    value: float
    branch: str
    points: Array
    sequence: Array
    period: int
    residual: float
    settled: bool
    transient: int
    final: Array
    outcome: Outcome
    message: str

    @property
    def failure(self) -> str:
        """Why the run did not reach its end; empty where it did."""
        return "" if self.outcome.is_good else self.message


@dataclass(frozen=True, eq=False)
class BifurcationResult:
    """Columns over a ``parameter`` (with its ``unit``), rising in value within each branch; ``channels`` with ``units``.

    ``values`` (columns of a branch,); ``still``: how near strobes come back, per scale; ``strobe``: what strobes, in words;
    ``missing``: how many columns were not run, because Ctrl-C came.
    """

    model: str
    parameter: str
    unit: str
    values: Array
    channels: tuple[str, ...]
    units: tuple[str, ...]
    columns: tuple[Column, ...]
    strobe: str
    still: float
    missing: int = 0

    @property
    def branches(self) -> tuple[str, ...]:
        """Names of the branches, in the order in which they were run."""
        return tuple(dict.fromkeys(column.branch for column in self.columns))

    def branch(self, name: str) -> tuple[Column, ...]:
        """The columns of one branch. Raises CaseError with the nearest name."""
        if name not in self.branches:
            raise CaseError(f"bifurcation diagram of {self.model!r}", f"no branch {name!r}", nearest(name, self.branches))
        return tuple(column for column in self.columns if column.branch == name)

    def channel(self, name: str) -> int:
        """Position of a channel. Raises CaseError with the nearest name."""
        if name not in self.channels:
            raise CaseError(f"bifurcation diagram of {self.model!r}", f"no channel {name!r}", nearest(name, self.channels))
        return self.channels.index(name)

    @property
    def failed(self) -> tuple[Column, ...]:
        """The columns whose runs did not reach their end."""
        return tuple(column for column in self.columns if column.failure)

    def coexisting(self, tolerance: float = 1e-3) -> Array:
        """Values (rising) where branches have settled to different motions, of different period or farther apart per scale."""
        found = []
        for value in self.values.tolist():
            here = [column for column in self.columns if column.value == value and column.settled]
            if any(_apart(here[0], other) > tolerance for other in here[1:]):
                found.append(value)
        return np.array(found)

    def __str__(self) -> str:
        unsettled = sum(not column.settled for column in self.columns)
        periods = sorted({column.period for column in self.columns if column.settled})
        found = f"periods {', '.join(map(str, periods))}" if periods else "no period"
        rest = f"; {unsettled} of {len(self.columns)} columns did not come to stand still" if unsettled else ""
        if failed := self.failed:
            rest += f"; {len(failed)} runs failed, the first at {failed[0].value:.6g} {self.unit}: {failed[0].failure}"
        if self.missing:
            rest += f"; interrupted: {self.missing} columns were not run"
        return (
            f"bifurcation diagram of {self.model!r} over {self.parameter}: {len(self.values)} values from {self.values[0]:.6g} "
            f"to {self.values[-1]:.6g} {self.unit}, {len(self.branches)} branches, {found}{rest}"
        )

    __repr__ = __str__


def _apart(one: Column, other: Column) -> float:
    """Least distance of any strobe of one column from the last of the other; infinite for different periods."""
    if one.period != other.period:
        return float("inf")
    return float(np.abs(one.sequence[-one.period :] - other.sequence[-1]).max(axis=1).min())


def bifurcation(
    case: Any,
    parameter: str,
    values: Sequence[Any],
    channels: Sequence[str] | None = None,
    *,
    direction: str = "independent",
    starts: Sequence[Start] | None = None,
    also: Also | None = None,
    count: int = 150,
    transient: int = 200,
    still: float | None = None,
    base: str | None = None,
    tolerance: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> BifurcationResult:
    """A bifurcation diagram over ``values`` of a parameter (numbers in its SI unit, or texts with units).

    ``direction``: "independent" (all columns at once, in lanes on all cores), "forward", "backward", or "both" of these.
    ``starts``: several starts for independent columns ("static", "zero", or values of states by name). ``also(value)`` gives
    further parameters that change with it. ``count``, ``transient``, ``still``, ``base`` and ``channels`` as in ``poincare``.
    ``tolerance`` of a step, per scale of each state: by default that of a case, 1e-5 for any other model.
    Raises CaseError, NamingError, ModelError, BalanceError for what cannot be, and Interrupted with the columns that are done
    where Ctrl-C comes after the first of them.
    """
    question = "bifurcation"
    case = asked_case(case, question, {"tolerance": 1e-5}, tolerance=tolerance)
    model = case.model
    if direction not in DIRECTIONS:
        raise CaseError(f"{question}, direction", f"is {direction!r}", nearest(str(direction), DIRECTIONS))
    if starts is not None and direction != "independent":
        raise CaseError(f"{question}, starts", f"are given with direction {direction!r}", 'leave them out, or take "independent"')
    listed = sorted(set(parameter_values(model, parameter, values, question)))
    names, patience = section_channels(model, channels), Patience(count, transient, still)
    settings = [setting(case, **{parameter: value, **(also(value) if also else {})}) for value in listed]
    if direction == "independent":
        asked = len(listed) * (1 if starts is None else len(starts))
        parts = _independent(case, settings, listed, starts, patience, base, progress)
    else:
        asked = len(listed) * (2 if direction == "both" else 1)
        parts = _followed(settings, listed, direction, patience, base, progress)
    found: Found = []
    still_within = patience.within(case.tolerance)
    try:
        for part in parts:
            found += part
    except KeyboardInterrupt:
        if not found:
            raise
        raise Interrupted(_result(model, parameter, names, found, still_within, asked - len(found))) from None
    return _result(model, parameter, names, found, still_within)


Found = list[tuple[str, float, Strobed]]


def _result(
    model: Compiled, parameter: str, names: Sequence[str], found: Found, still: float, missing: int = 0
) -> BifurcationResult:
    branches = list(dict.fromkeys(branch for branch, _, _ in found))
    found = sorted(found, key=lambda each: (branches.index(each[0]), each[1]))
    return BifurcationResult(
        model=model.name,
        parameter=parameter,
        unit=model.parameters.place(parameter)[0].unit,
        values=np.array(sorted({value for _, value, _ in found})),
        channels=tuple(names),
        units=tuple(model.unit(name) for name in names),
        columns=tuple(_column(value, branch, each, names) for branch, value, each in found),
        strobe=_strobe_text([each for _, _, each in found]),
        still=still,
        missing=missing,
    )


def _independent(
    case: Case,
    settings: list[Setting],
    values: list[float],
    starts: Sequence[Start] | None,
    patience: Patience,
    base: str | None,
    progress: Callable[[float], None] | None,
) -> Iterator[Found]:
    """Columns by themselves, some side by side."""
    if starts is not None and not starts:
        raise CaseError("bifurcation, starts", "are none", "give at least one")
    branches = ["independent"] if starts is None else [f"start {number}" for number in range(1, len(starts) + 1)]
    states = None if starts is None else [_start(case.model, each, start) for start in starts for each in settings]
    every = [(branch, value, each) for branch in branches for value, each in zip(values, settings, strict=True)]
    for first in range(0, len(every), BATCH):
        batch = every[first : first + BATCH]
        begin = None if states is None else states[first : first + BATCH]

        def share(done: float, first: int = first, size: int = len(batch)) -> None:
            if progress is not None:
                progress((first + done * size) / len(every))

        here = strobed([each for _, _, each in batch], patience, starts=begin, base=base, progress=share)
        yield [(branch, value, each) for (branch, value, _), each in zip(batch, here, strict=True)]


def _start(model: Compiled, each: Setting, start: Start) -> Array:
    """A starting state without the neutral rigid angles. Raises CaseError for an unknown one."""
    if isinstance(start, str) and start not in STARTS:
        raise CaseError("bifurcation, starts", f"has {start!r}", nearest(start, STARTS))
    state = starting_state(model, each.point, start)
    state[list(model.equations.rigid)] = 0.0
    return state


def _followed(
    settings: list[Setting],
    values: list[float],
    direction: str,
    patience: Patience,
    base: str | None,
    progress: Callable[[float], None] | None,
) -> Iterator[Found]:
    """Columns one after the other, each from the last state of its neighbor; both directions side by side."""
    last = len(settings) - 1
    orders = {"forward": list(range(last + 1)), "backward": list(range(last, -1, -1))}
    ways = list(orders) if direction == "both" else [direction]
    states: list[Array] | None = None
    for step in range(last + 1):
        here = [orders[way][step] for way in ways]
        done = strobed([settings[k] for k in here], patience, starts=states, base=base)
        states = [each.final for each in done]
        if progress is not None:
            progress((step + 1) / (last + 1))
        yield [(way, values[k], each) for way, k, each in zip(ways, here, done, strict=True)]


def _strobe_text(found: list[Strobed]) -> str:
    """The strobe in words; without its period where that changes with the parameter."""
    said = {str(each.strobe) for each in found}
    return (
        said.pop() if len(said) == 1 else f"{'common period' if found[0].strobe.complete else found[0].strobe.base} of each value"
    )


def _column(value: float, branch: str, found: Strobed, names: Sequence[str]) -> Column:
    points = motion_of(found.setting.case.model, found.times, found.states, found.setting.point.p, names)[0]
    return Column(
        value=value,
        branch=branch,
        points=points,
        sequence=found.sequence,
        period=found.period,
        residual=found.residual,
        settled=found.settled,
        transient=found.transient,
        final=found.final,
        outcome=found.outcome,
        message=found.message,
    )
