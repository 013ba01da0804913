"""Question: which points does the motion leave in a Poincaré section, and which loop does it draw in the phase plane?

Two sections: a strobe at the common period of all that shakes (``poincare``), and a surface that a channel crosses
(``surface_section``). Both in vibrating coordinates: the rolling of a free driveline is no part of the motion. The phase plane of
a channel is its value and its exact rate.
Source: F. C. Moon, Chaotic Vibrations (1987), ch. 2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.nonlinear.common_period import Strobe
from modelgen.analysis.nonlinear.motion import motion_of
from modelgen.analysis.nonlinear.runs import options_of, restarted, run_one, setting
from modelgen.analysis.nonlinear.strobes import Patience, Strobed, strobed
from modelgen.errors import CaseError
from modelgen.lowering import Compiled
from modelgen.solvers.asked_case import asked_case
from modelgen.solvers.outcome import Outcome

Array = NDArray[np.float64]
FEWEST, MOST = 512, 8192  # samples of a common period
PER_CYCLE = 16  # samples of the fastest base frequency
LOOSE = 8  # common periods that are drawn of a motion that does not close


@dataclass(frozen=True, eq=False)
class SectionResult:
    """Points of a section, and the motion between them, in the phase planes of channels.

    ``channels`` with ``units``; ``times`` (points,) [s] of the points, counted in a strobe from the last restart; ``values``
    and ``rates`` (points, channels) in the unit of each and per s; ``orbit_values``, ``orbit_rates`` (samples, channels): the
    motion over ``orbit_periods`` common periods (0 where a surface cuts). ``sequence`` (points, vibrating states): the points per
    scale of each state. ``section`` says what cuts. ``period`` in points, 0 where they do not come back within ``still``;
    ``residual``, ``settled``, ``transient`` as in ``strobes``. ``complete``: whether a periodic motion shows as single points.
    """

    model: str
    parameters: dict[str, float]
    section: str
    channels: tuple[str, ...]
    units: tuple[str, ...]
    times: Array
    values: Array
    rates: Array
    orbit_values: Array
    orbit_rates: Array
    orbit_periods: int
    sequence: Array
    complete: bool
    transient: int
    period: int
    residual: float
    still: float
    settled: bool
    outcome: Outcome
    message: str

    @property
    def failure(self) -> str:
        """Why the run did not reach its end; empty where it did."""
        return "" if self.outcome.is_good else self.message

    def __str__(self) -> str:
        found = f"period {self.period}" if self.period else "no period up to 16"
        head = f"section of {self.model!r} at the {self.section}: {len(self.times)} points after {self.transient}"
        if self.failure:
            return f"{head}; the run failed, {self.failure}"
        return f"{head}, {found} (residual {self.residual:.2g} of the scales)"

    __repr__ = __str__


def poincare(
    case: Any,
    channels: Sequence[str] | None = None,
    *,
    count: int = 150,
    transient: int = 200,
    still: float | None = None,
    base: str | None = None,
    tolerance: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> SectionResult:
    """Strobe at the exact common period: one point for a periodic motion, n for period n.

    ``channels``: output channels, by default the elastic angles of the reference shaft and of the last inertia. ``count`` points
    are kept after at most ``transient`` strobes. ``base``: strobe at the period of this base frequency instead, where there is no
    short common period; a periodic motion then shows as a curve. Times, samples and ``end`` of the case are not used.
    Raises CaseError where there is no short common period, with the nearest choice.
    ``tolerance`` of a step, per scale of each state: by default that of a case, 1e-6 for any other model.
    """
    case = asked_case(case, "poincare", {"tolerance": 1e-6}, tolerance=tolerance)
    model = case.model
    names = section_channels(model, channels)
    patience = Patience(count, transient, still)
    found = strobed([setting(case)], patience, base=base, progress=progress)[0]
    return strobe_section(found, names, patience.within(case.tolerance))


def strobe_section(found: Strobed, names: Sequence[str], still: float) -> SectionResult:
    """The section that strobes show, with the motion between them drawn once."""
    model, p, strobe = found.setting.case.model, found.setting.point.p, found.strobe
    times = found.times
    values, rates = motion_of(model, times, found.states, p, names)
    periods = found.period or LOOSE
    orbit = _orbit(found, strobe, periods, float(times[-1]) if len(times) else 0.0)
    orbit_values, orbit_rates = motion_of(model, *orbit, p, names)
    return SectionResult(
        model=model.name,
        parameters={name: float(model.parameters.value(p, name)) for name in found.setting.case.parameters},
        section=str(strobe),
        channels=tuple(names),
        units=tuple(model.unit(name) for name in names),
        times=times,
        values=values,
        rates=rates,
        orbit_values=orbit_values,
        orbit_rates=orbit_rates,
        orbit_periods=periods,
        sequence=found.sequence,
        complete=strobe.complete,
        transient=found.transient,
        period=found.period,
        residual=found.residual,
        still=still,
        settled=found.settled,
        outcome=found.outcome,
        message=found.message,
    )


def _orbit(found: Strobed, strobe: Strobe, periods: int, begin: float) -> tuple[Array, Array]:
    """Times and states of the motion from the last strobe on, over so many periods."""
    problem, case = found.setting.problem, found.setting.case
    fastest = max((float(each) for each in strobe.cycles.values()), default=1.0)
    samples = int(np.clip(PER_CYCLE * fastest, FEWEST, MOST)) * periods
    times = begin + strobe.period * periods * np.arange(samples + 1) / samples
    state = found.final.copy()
    state[list(case.model.equations.rigid)] = 0.0
    again = restarted(problem, state, times, begin)
    trajectory = run_one(case, again, options_of(case))
    return trajectory.times, trajectory.states


def section_channels(model: Compiled, channels: Sequence[str] | None) -> tuple[str, ...]:
    """The channels that are asked for, or the elastic angles of the reference shaft and of the last inertia.

    Raises CaseError for unknown channels, and for those that hold the rolling of a free driveline.
    """
    if channels is None:
        elastic = [name for name in model.outputs if name.endswith(".elastic_angle")]
        first = f"{model.equations.reference}.elastic_angle"
        wanted = [first if first in elastic else elastic[0], elastic[-1]] if elastic else []
        return tuple(dict.fromkeys(wanted))
    names = tuple(dict.fromkeys([channels] if isinstance(channels, str) else channels))
    if not names:
        raise CaseError(f"driveline {model.name!r}, channels", "there are none", "name at least one")
    for name in names:
        model.output_index(name)
        stem, _, last = name.rpartition(".")
        if model.equations.rigid and last in ("angle", "angle_deviation"):
            problem = "holds the rolling of the whole driveline, which is no vibration"
            raise CaseError(f"section, channel {name!r}", problem, f"take {stem}.elastic_angle, or a twist")
    return names
