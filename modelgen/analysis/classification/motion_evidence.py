"""Question: what kind of motion is it, does it depend on the start, and what proves it?

All evidence on a motion side by side: its sections from several starts, a periodic motion by shooting with its multipliers,
Lyapunov exponents with their intervals, what becomes of the stored energy. A proof counts as evidence on a motion only if the
strobes have come to that orbit; otherwise it says that such an orbit exists as well.
Without damping there is no attractor to speak of: the section then shows one motion from one start.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.classification.damping import undamped
from modelgen.analysis.classification.groups import groups
from modelgen.analysis.classification.verdict import Verdict, classify
from modelgen.analysis.nonlinear.runs import setting
from modelgen.analysis.nonlinear.sections import SectionResult, section_channels, strobe_section
from modelgen.analysis.nonlinear.strobes import Patience, Strobed, strobed
from modelgen.analysis.stability.exponents import ExponentsResult, lyapunov_exponents
from modelgen.analysis.stability.orbits import PeriodicOrbit, periodic_orbit
from modelgen.errors import CaseError
from modelgen.solvers.asked_case import asked_case
from modelgen.solvers.case import Case

Array = NDArray[np.float64]
ENERGY, LOSS = "total.stored_energy", "total.dissipated_power"
REACHED = 1e-4
"""Of the states' scales: strobes this near an orbit have come to it."""
BRIEF = 16
"""Stretches of a common period, for the largest exponent of a motion that does not stand still."""
LAST = 16
"""Strobes at the end of a section that are looked at for that."""


@dataclass(frozen=True, eq=False)
class MotionEvidence:
    """Evidence on the motion of a ``case`` from several ``starts``; sections and verdicts in their order.

    ``channels`` are those asked for; the sections hold stored energy [J] and dissipated power [W] after them. ``period`` [s]: the
    common period. ``orbit``, ``exponents``: None where there are none, and ``orbit_missing``, ``exponents_missing`` say why.
    ``away``: least distance of the last strobes from the orbit by start, per scale of the states (nan without an orbit).
    ``undamped``: a mode has no damping, or next to none, so that a motion keeps what it began with.
    """

    case: Case
    starts: tuple[str, ...]
    channels: tuple[str, ...]
    period: float
    sections: tuple[SectionResult, ...]
    verdicts: tuple[Verdict, ...]
    orbit: PeriodicOrbit | None
    orbit_missing: str
    away: tuple[float, ...]
    exponents: ExponentsResult | None
    exponents_missing: str
    undamped: bool

    @property
    def verdict(self) -> Verdict:
        """That on the motion from the first start."""
        return self.verdicts[0]

    def groups(self, channel: str) -> tuple[int, ...]:
        """Groups of points in the phase plane of a channel, by start."""
        k = self.channels.index(channel)
        return tuple(_groups(section, k) for section in self.sections)

    def spread(self, channel: str) -> tuple[float, ...]:
        """Half the extent of the section's points in a channel, by start [unit of the channel]."""
        k = self.channels.index(channel)
        return tuple(float(np.ptp(section.values[:, k])) / 2 for section in self.sections)

    def swing(self, channel: str) -> tuple[float, ...]:
        """Half peak to peak of a channel over the motion drawn, by start [unit of the channel]."""
        k = self.channels.index(channel)
        return tuple(float(np.ptp(section.orbit_values[:, k])) / 2 for section in self.sections)

    def stored(self) -> tuple[tuple[float, float], ...]:
        """Mean stored energy [J] at the strobes of the first and of the second half, by start."""
        k = len(self.channels)
        halves = [np.array_split(section.values[:, k], 2) for section in self.sections]
        return tuple((float(first.mean()), float(second.mean())) for first, second in halves)

    def dissipated(self) -> tuple[float, ...]:
        """Mean dissipated power [W] over the motion drawn, by start."""
        return tuple(float(section.orbit_values[:, len(self.channels) + 1].mean()) for section in self.sections)


def _groups(section: SectionResult, k: int) -> int:
    """Points that came back are as many groups as the period has strobes, or fewer where they coincide in this plane."""
    plane = np.column_stack([section.values[:, k], section.rates[:, k]])
    whole = np.ptp(np.column_stack([section.orbit_values[:, k], section.orbit_rates[:, k]]), axis=0)
    closeness = np.asarray(whole * REACHED, dtype=float)
    return groups(plane[-section.period :], closeness, fewest=1) if section.period else groups(plane, closeness)


def motion_evidence(
    case: Any,
    settings: Sequence[Mapping[str, float]],
    channels: Sequence[str] | None = None,
    *,
    starts: Sequence[str] = ("static", "zero"),
    count: int = 300,
    transient: int = 200,
    revolutions: int = 300,
    stage: Callable[[str], None] = lambda _: None,
    progress: Callable[[float], None] | None = None,
) -> list[MotionEvidence]:
    """Evidence on a case under several settings of its parameters, each from all ``starts``; all strobed together, in lanes.

    ``count``, ``transient``, ``channels`` as in ``poincare``. ``revolutions``: common periods that exponents are means over.
    Where a motion does not stand still, shooting begins at the orbit of the first setting whose motion does.
    Raises CaseError where there is no short common period.
    """
    case = asked_case(case, "motion")
    model = case.model
    if not starts or not settings:
        raise CaseError("motion", "has no starts or no settings", "give at least one of each")
    names, patience = section_channels(model, channels), Patience(count, transient)
    made = [setting(case.change(start=start), **values) for values in settings for start in starts]
    stage("strobe")
    found = strobed(made, patience, progress=progress)
    rows = [found[first : first + len(starts)] for first in range(0, len(found), len(starts))]
    sections = [[strobe_section(each, (*names, ENERGY, LOSS), patience.within(case.tolerance)) for each in row] for row in rows]
    orbits: dict[int, PeriodicOrbit | str] = {}
    for k in sorted(range(len(rows)), key=lambda k: not rows[k][0].settled):
        stage(f"shoot, {_said(settings[k])}")
        known = next((each for each in orbits.values() if isinstance(each, PeriodicOrbit) and each.found), None)
        orbits[k] = _orbit(rows[k][0], known)
    gathered = []
    for k, (row, cut) in enumerate(zip(rows, sections, strict=True)):
        stage(f"follow deviations, {_said(settings[k])}")
        exponents = _exponents(row[0], revolutions)
        gathered.append(_evidence(row, cut, names, tuple(starts), orbits[k], exponents))
    return gathered


def _said(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} = {value:.4g}" for name, value in values.items())


def _from(found: Strobed) -> Case:
    """The case from its last strobe on; time begins again, for everything repeats."""
    case = found.setting.case
    return case.change(start=dict(zip(case.model.states, found.final.tolist(), strict=True)), record_from=None)


def _orbit(found: Strobed, known: PeriodicOrbit | None) -> PeriodicOrbit | str:
    """The orbit that a motion has come to, or the one that a known orbit becomes; or why there is none."""
    if not found.settled and known is None:
        return "no periodic motion is near to start from"
    case, order = _from(found), max(1, found.period)
    if not found.settled and known is not None:
        case, order = case.change(start=dict(known.start)), known.order
    try:
        return periodic_orbit(case, order=order, settle=0)
    except CaseError as error:
        return str(error)


def _exponents(found: Strobed, revolutions: int) -> ExponentsResult | str:
    """All exponents of a motion that stands still, the largest of another, which tells chaos; or why there are none."""
    case = _from(found).change(end=found.strobe.period * revolutions)
    # Impacts make deviations grow faster than any rate of the equations tells: they are brought back to size often.
    stretch = None if found.settled else found.strobe.period / BRIEF
    try:
        return lyapunov_exponents(case, largest=not found.settled, stretch=stretch)
    except CaseError as error:
        return str(error)


def _evidence(
    row: Sequence[Strobed],
    sections: Sequence[SectionResult],
    names: tuple[str, ...],
    starts: tuple[str, ...],
    orbit: PeriodicOrbit | str,
    exponents: ExponentsResult | str,
) -> MotionEvidence:
    case = replace(row[0].setting.case)
    free = undamped(case)
    whole, spread = (orbit, exponents)
    proof = whole if isinstance(whole, PeriodicOrbit) else None
    lyapunov = spread if isinstance(spread, ExponentsResult) else None
    away = tuple(_away(each, proof) for each in row)
    verdicts = []
    for k, (section, far) in enumerate(zip(sections, away, strict=True)):
        reached = proof if far < REACHED else None
        own = lyapunov if k == 0 or reached else None  # the exponents are those of the first start's motion
        verdicts.append(
            classify(section.sequence, section.still, exponents=own, orbit=reached, complete=section.complete, conservative=free)
        )
    return MotionEvidence(
        case=case,
        starts=starts,
        channels=names,
        period=row[0].strobe.period,
        sections=tuple(sections),
        verdicts=tuple(verdicts),
        orbit=proof,
        orbit_missing=whole if isinstance(whole, str) else "",
        away=away,
        exponents=lyapunov,
        exponents_missing=spread if isinstance(spread, str) else "",
        undamped=free,
    )


def _away(found: Strobed, orbit: PeriodicOrbit | None) -> float:
    return float("nan") if orbit is None else distance_from(orbit, found.sequence, found.vibrating, found.scale)


def distance_from(orbit: PeriodicOrbit, sequence: Array, vibrating: Sequence[int], scale: Array) -> float:
    """Least distance of the last strobes (strobes, vibrating states), per scale, from an orbit; nan without orbit or strobes."""
    if not orbit.found or not len(sequence):
        return float("nan")
    kept = list(vibrating)
    return float(np.abs(sequence[-LAST:] - orbit.state[kept] / scale[kept]).max(axis=1).min())
