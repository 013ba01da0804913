"""Every claim of the paper beside what the model gives: holds, does not hold, or cannot be decided, and the evidence.

Part of ``cli``. Claims about sizes are judged in ``paper``; here come those about the series and about kinds of motion. Every
verdict is computed; where a motion depends on its start, which the paper does not give, nothing is decided.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from modelgen.analysis import BifurcationResult
from modelgen.analysis.classification.motion_evidence import REACHED, MotionEvidence
from modelgen.cli.reproduce_work import Reproduction
from modelgen.drivelines.claims import MotionClaim
from modelgen.plots import gear_meshes
from modelgen.reports.paper import ClaimRow, judge

HOLDS, FAILS, OPEN = "holds", "does not hold", "cannot be decided"
DEGREES = math.degrees(1.0)


def claim_rows(work: Reproduction) -> list[ClaimRow]:
    """All claims in the paper's order."""
    rows = [_series(work), *judge(work.claims, work.runs)]
    rows += [_begin(work, name) for name in work.diagrams]
    rows += [_settles(work, name, diagram) for name, diagram in work.diagrams.items()]
    for claim in work.claims.motion.claims:
        found = {name: work.motions[name, claim.value] for name in work.diagrams}
        same = len({id(each) for each in found.values()}) == 1
        for name, evidence in list(found.items())[: 1 if same else None]:
            rows.append(motion_row(work, claim, evidence, "both readings" if same else f"reading {name}"))
    return rows


def _series(work: Reproduction) -> ClaimRow:
    """Whether the claimed order has the least error of all orders computed."""
    order = work.claims.series_order
    errors = {pair.name: pair.errors for pair in gear_meshes(work.response.model, work.response.point).pairs if pair.errors}
    best = {name: int(each.order[each.rms.argmin()]) for name, each in errors.items()}
    said = "; ".join(
        f"{name}: rms {100 * each.rms[order]:.3g} % at order {order}, {100 * each.rms[best[name]]:.3g} % at {best[name]}, "
        f"largest {100 * each.maximum[order]:.3g} % and {100 * each.maximum[best[name]]:.3g} %"
        for name, each in errors.items()
    )
    return ClaimRow(
        "order of the Fourier series with the smallest error",
        f"{order}",
        f"the highest computed, {max(best.values())}" if len(set(best.values())) == 1 else str(best),
        HOLDS if set(best.values()) == {order} else FAILS,
        f"{said}; a least-squares series only gets better in the mean with every order",
    )


def _begin(work: Reproduction, reading: str) -> ClaimRow:
    """The kind of motion at the low end of the range."""
    motion = work.claims.motion
    low = motion.range[0]
    evidence = work.motions[reading, low]
    return ClaimRow(
        f"motion at {motion.parameter} = {low:g} ({_mesh(work, reading, low)})",
        motion.begins_as,
        kinds(evidence),
        _verdict(evidence, motion.begins_as),
        evidence_text(evidence),
    )


def _settles(work: Reproduction, reading: str, diagram: BifurcationResult) -> ClaimRow:
    """From which value on every column of the diagram has the claimed period."""
    motion = work.claims.motion
    wanted = [column.settled and column.period == motion.settles_to for column in diagram.columns]
    other = [k for k, good in enumerate(wanted) if not good]
    first = other[-1] + 1 if other else 0
    claim = f"settles to period {motion.settles_to} as {motion.parameter} grows (reading {reading})"
    loose = [column for column in diagram.columns if not column.settled]
    rest = f"{len(loose)} of {len(wanted)} columns did not come to stand still within {_waited(diagram)} strobes"
    if loose:
        rest += f" (residual up to {max(column.residual for column in loose):.2g} of the states' scales)"
    if first == len(wanted):
        return ClaimRow(claim, "yes", "not up to the end of the range", FAILS, rest)
    share = len(wanted) - first
    periods = sorted({column.period for column in diagram.columns if column.settled})
    return ClaimRow(
        claim,
        "yes",
        f"period {motion.settles_to} in every column from {motion.parameter} = {diagram.columns[first].value:.4g} on",
        HOLDS,
        f"{share} columns; settled columns have period {', '.join(map(str, periods))}; {rest}. Where it begins also depends on "
        "how long one waits: slow decay looks like a cloud",
    )


def _waited(diagram: BifurcationResult) -> int:
    return max(column.transient + len(column.points) for column in diagram.columns)


def motion_row(work: Reproduction, claim: MotionClaim, evidence: MotionEvidence, reading: str) -> ClaimRow:
    """One claim about the kind of motion at a place."""
    channel = work.channels[claim.at]
    counted = evidence.groups(channel)
    verdict = _verdict(evidence, claim.kind)
    if verdict == HOLDS and claim.groups and set(counted) != {claim.groups}:
        verdict = "holds in part"
    groups = f", {claim.groups} group{'s' * (claim.groups != 1)} of points" if claim.groups else ""
    seen = ", ".join(f"{count} from the {start} start" for count, start in zip(counted, evidence.starts, strict=True))
    parameter = work.claims.motion.parameter
    sizes = ", ".join(
        f"{DEGREES * swing:.3g}° ({start})" for swing, start in zip(evidence.swing(channel), evidence.starts, strict=True)
    )
    return ClaimRow(
        f"motion at the {claim.at.replace('_', ' ')}, {parameter} = {claim.value:g} ({reading})",
        claim.kind + groups,
        f"{kinds(evidence)}; groups of points: {seen}",
        verdict,
        f"{exponent_text(evidence)}; {orbit_text(evidence)}; elastic angle, half p-p, physical: {sizes}; the rest under Motions",
    )


def _verdict(evidence: MotionEvidence, claimed: str) -> str:
    """Holds if it is that kind from every start, fails if it is another one from every start."""
    names = [each.name for each in evidence.verdicts]
    if all(name == claimed for name in names):
        return HOLDS
    if any(name in (claimed, "undecided") for name in names):
        return OPEN
    return FAILS


def kinds(evidence: MotionEvidence) -> str:
    """The kind of motion by start."""
    names = [each.name for each in evidence.verdicts]
    if len(set(names)) == 1:
        return f"{names[0]} from {'every start' if len(names) > 1 else evidence.starts[0]}"
    return "; ".join(f"{name} from the {start} start" for name, start in zip(names, evidence.starts, strict=True))


def evidence_text(evidence: MotionEvidence) -> str:
    """What was found, one finding after the other."""
    return "; ".join(_findings(evidence))


def _findings(evidence: MotionEvidence) -> Iterator[str]:
    if evidence.undamped:
        yield "a mode has no damping or next to none: no attractor to speak of, a motion keeps what it began with"
    for start, section, verdict in zip(evidence.starts, evidence.sections, evidence.verdicts, strict=True):
        said = [each for each in verdict.evidence if each.source in ("section", "0-1 test", "spectrum")]
        found = ", ".join(f"{each.source}: {each.finding}" for each in said)
        yield f"{start} start, after {section.transient} strobes: {found}"
    yield exponent_text(evidence)
    yield orbit_text(evidence)
    if not all(section.settled for section in evidence.sections):
        halves = ", ".join(
            f"{first:.4g} to {second:.4g} J ({start})"
            for (first, second), start in zip(evidence.stored(), evidence.starts, strict=True)
        )
        yield f"mean stored energy at the strobes, first to second half: {halves}"
    lost = ", ".join(f"{watts / 1e3:.3g} kW" for watts in evidence.dissipated())
    yield f"mean dissipated power {lost}"


def exponent_text(evidence: MotionEvidence) -> str:
    """The largest Lyapunov exponent with its interval, or why there is none."""
    found = evidence.exponents
    if found is None:
        return f"Lyapunov exponents could not be found ({evidence.exponents_missing})"
    size = f"{found.exponents[0]:.4g} ± {found.half_width[0]:.2g} 1/s"
    said = f"largest Lyapunov exponent {size} at 95 % over {found.duration:.4g} s ({found.sign}, {evidence.starts[0]} start)"
    if found.complete:
        said += f", sum of all {found.exponents.sum():.6g} 1/s against a mean divergence of {found.divergence:.6g} 1/s"
    return said


def orbit_text(evidence: MotionEvidence) -> str:
    """The orbit with its largest multiplier, and whether the strobes have come to it."""
    orbit = evidence.orbit
    if orbit is None:
        return f"no periodic motion was found by shooting ({evidence.orbit_missing})"
    if not orbit.found:
        return f"shooting: {orbit.verdict}"
    near = [start for start, away in zip(evidence.starts, evidence.away, strict=True) if away < REACHED]
    if len(near) == len(evidence.starts):
        return f"shooting: {orbit.verdict}; the strobes have come to it from every start"
    far = ", ".join(f"{away:.2g} ({start})" for start, away in zip(evidence.starts, evidence.away, strict=True))
    return f"beside that, shooting: {orbit.verdict}; the strobes stay away from it by {far} of the states' scales"


def _mesh(work: Reproduction, reading: str, value: float) -> str:
    return f"reading {reading}, xi = {work.xi[reading, value]:g}"
