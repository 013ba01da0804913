"""Question: is the motion periodic, quasi-periodic or chaotic, and which evidence says so?

Evidence from a section: whether its points come back (``recurrence``), whether they still drift, how few lines their spectrum
needs, and the 0-1 test for chaos; beside it, where they are given, the largest exponent with its interval and the verdict on a
periodic orbit. Proof comes before inference; two inferences must agree; where they do not, the motion is undecided.
Source of the 0-1 test: G. A. Gottwald, I. Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129-145.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.classification.sequence_tests import drift, line_share, zero_one
from modelgen.analysis.nonlinear.recurrence import FEWEST, Recurrence, recurrence
from modelgen.errors import CaseError

Array = NDArray[np.float64]
HIGHEST = 64  # period that is looked for, where there are four repetitions of it
NEAR = 300.0  # of the tolerance: points that come back this near are no evidence of a curve or a cloud
ENOUGH = 100  # points that spectrum and 0-1 test need
REGULAR, CHAOTIC = 0.2, 0.8  # of the 0-1 test
LINES, BROAD = 0.95, 0.75  # share of the spectrum in its strongest lines
DRIFTS = 0.15  # relative change of mean or spread between the halves of the section, in units of the spread


class ExponentEvidence(Protocol):
    """Lyapunov exponents as ``lyapunov_exponents`` gives them; ``sign`` of the largest: "positive", "negative" or "undecided".

    Where they have ``stationary``, ``transient_chaos`` and ``beside``, these count as well: what is not stationary speaks for
    transient chaos or for nothing.
    """

    @property
    def exponents(self) -> Array: ...

    @property
    def half_width(self) -> Array: ...

    @property
    def flow(self) -> int | None: ...

    @property
    def sign(self) -> str: ...


class OrbitEvidence(Protocol):
    """A periodic orbit as shooting gives it: ``order`` in common periods, ``proven``: it closes and attracts."""

    @property
    def order(self) -> int: ...

    @property
    def proven(self) -> bool: ...

    @property
    def verdict(self) -> str: ...


@dataclass(frozen=True)
class Evidence:
    """One piece: what was looked at, what was found in words, what it speaks for ("" for nothing), and whether it decided."""

    source: str
    finding: str
    speaks_for: str
    decided: bool = False


@dataclass(frozen=True)
class Verdict:
    """``kind``: "periodic", "quasi-periodic", "chaotic", "transient chaos" or "undecided".

    ``period`` in strobes of a periodic motion, or of that in which transient chaos ends (0 where that is not known); else 0.
    """

    kind: str
    period: int
    evidence: tuple[Evidence, ...]
    conservative: bool = False

    @property
    def name(self) -> str:
        """The kind with the period: ``period 2``; ``transient chaos, then period 2``."""
        if self.kind == "transient chaos" and self.period:
            return f"{self.kind}, then period {self.period}"
        return f"period {self.period}" if self.kind == "periodic" else self.kind

    def __str__(self) -> str:
        decided = "; ".join(f"{each.source}: {each.finding}" for each in self.evidence if each.decided)
        others = "; ".join(f"{each.source}: {each.finding}" for each in self.evidence if not each.decided)
        words = f"{self.name}, decided by {decided}" if decided else f"{self.name}: {others}"
        if decided and others:
            words += f" (beside it: {others})"
        if self.conservative:
            words += "; without damping: the motion from this start, no attractor"
        return words

    __repr__ = __str__


def classify(
    sequence: Array,
    tolerance: float = 1e-6,
    *,
    exponents: ExponentEvidence | None = None,
    orbit: OrbitEvidence | None = None,
    complete: bool = True,
    conservative: bool = False,
) -> Verdict:
    """The verdict on a motion from its section points ``sequence`` (points,) or (points, coordinates), per scale.

    ``tolerance``: how near points come back. ``complete``: whether the section strobes everything, so that a periodic motion
    shows as points. ``conservative``: nothing is damped, and there is no attractor to speak of.
    Raises CaseError for fewer than 16 points or points that are not finite.

    >>> turn = (5 ** 0.5 - 1) * np.pi
    >>> classify(np.column_stack([np.cos(turn * np.arange(400)), np.sin(turn * np.arange(400))])).name
    'quasi-periodic'
    """
    try:
        points = np.asarray(sequence, dtype=float)
    except (TypeError, ValueError):
        problem = f"is given {type(sequence).__name__}"
        raise CaseError("classification", problem, "give section points as an array, such as poincare(case).sequence") from None
    points = points[:, None] if points.ndim == 1 else points
    if points.ndim != 2 or len(points) < FEWEST or not points.shape[1]:
        raise CaseError("classification", f"is given points of shape {points.shape}", f"give at least {FEWEST} section points")
    if not np.all(np.isfinite(points)):
        raise CaseError("classification", "is given points that are not finite", "give a run that reached its end")
    if not tolerance > 0:
        raise CaseError("classification, tolerance", f"is {tolerance!r}", "give a positive share of the scales")
    found = [_orbit(orbit)] if orbit is not None else []
    back = recurrence(points, tolerance, HIGHEST)
    found += _section(points, tolerance, back, complete)
    found += [_exponent(exponents)] if exponents is not None else []
    kind, deciding = _decide(found)
    period = 0
    if kind == "periodic":
        period = orbit.order if orbit is not None and deciding == {"orbit"} else back.period
        if back.period not in (0, period):
            kind, deciding, period = "undecided", set(), 0
    if kind == "transient chaos":
        period = orbit.order if orbit is not None and orbit.proven else back.period
    weighed = tuple(Evidence(each.source, each.finding, each.speaks_for, each.source in deciding) for each in found)
    return Verdict(kind, period, weighed, conservative)


def _orbit(orbit: OrbitEvidence) -> Evidence:
    return Evidence("orbit", orbit.verdict, "periodic" if orbit.proven else "")


def _exponent(found: ExponentEvidence) -> Evidence:
    """An interval around zero speaks for neighbors that neither part nor meet."""
    first = next((k for k in range(len(found.exponents)) if k != found.flow), None)
    if first is None:
        return Evidence("exponents", "none beside that along the motion", "")
    size = f"largest {found.exponents[first]:.3g} +- {found.half_width[first]:.1g} 1/s"
    if not getattr(found, "stationary", True):
        told = "; ".join([size, *getattr(found, "remarks", ())])
        return Evidence("exponents", told, "transient chaos" if getattr(found, "transient_chaos", False) else "")
    if getattr(found, "beside", ""):
        return Evidence("exponents", f"{size}; beside it {found.beside}", "undecided")  # type: ignore[attr-defined]
    kinds = {"positive": "chaotic", "negative": "periodic", "undecided": "quasi-periodic"}
    return Evidence("exponents", size, kinds[found.sign])


def _section(points: Array, tolerance: float, back: Recurrence, complete: bool) -> list[Evidence]:
    period, residual = back.period, back.residual
    if period and back.first >= ENOUGH:
        test = zero_one(points[: back.first])
        words = f"{back.first} points wander (K = {test:.2f}), the other {len(points) - back.first} come back after {period}"
        kind = "transient chaos" if test > CHAOTIC else "periodic"
        return [Evidence("section", words, kind if complete else "")]
    if period:
        words = f"{len(points)} points come back after {period} (within {residual:.1e} of the scales)"
        return [Evidence("section", words, "periodic" if complete else "")]
    if residual < NEAR * tolerance:
        words = f"points almost come back ({residual:.1e} of the scales): slow decay, or errors of the integration"
        return [Evidence("section", words, "undecided")]
    away = drift(points, tolerance)
    if away > DRIFTS:
        return [Evidence("section", f"still changes: its halves differ by {away:.2g} of their spread", "undecided")]
    if len(points) < ENOUGH:
        return [Evidence("section", f"{len(points)} points do not come back, too few for spectrum and 0-1 test", "")]
    test, share = zero_one(points), line_share(points)
    regular = "quasi-periodic" if complete else ""
    said = regular if test < REGULAR else "chaotic" if test > CHAOTIC else ""
    drawn = regular if share > LINES else "chaotic" if share < BROAD else ""
    return [
        Evidence("section", f"{len(points)} points do not come back (residual {residual:.1e} of the scales)", ""),
        Evidence("0-1 test", f"K = {test:.2f}", said),
        Evidence("spectrum", f"{100 * share:.0f} % in its strongest lines", drawn),
    ]


def _decide(found: list[Evidence]) -> tuple[str, set[str]]:
    """The kind, and the sources that decided it."""
    says = {each.source: each.speaks_for for each in found}
    transient = {source for source, said in says.items() if said == "transient chaos"}
    if transient and says["section"] != "quasi-periodic":
        return "transient chaos", transient
    if says.get("orbit") == "periodic" and set(says.values()) <= {"periodic", ""}:
        return "periodic", {"orbit"}
    if says["section"] == "undecided":
        return "undecided", set()
    if says["section"] == "periodic":
        against = says.get("exponents") == "chaotic"
        return ("undecided", set()) if against else ("periodic", {"section"})
    for kind in ("chaotic", "quasi-periodic"):
        agreeing = {source for source, said in says.items() if said == kind}
        others = {said for source, said in says.items() if source not in agreeing} - {""}
        if len(agreeing) >= 2 and not others:
            return kind, agreeing
    return "undecided", set()
