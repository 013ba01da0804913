"""``paper.md``: each quantitative claim of the paper beside what the model gives, for every reading of its damping.

Part of ``reports``. Verdicts are computed from the runs; nothing is tuned towards the paper, whose data are not published.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from modelgen.analysis import AnglesResult
from modelgen.analysis.time_domain.angles import InertiaAngles
from modelgen.drivelines.claims import Claims
from modelgen.reports.progress import Progress
from modelgen.reports.response import Request, Response, respond
from modelgen.reports.settings import common_switch, settle

SHAFT_FORMS, MESH_FORMS = ("per_shaft", "modal"), ("corrected", "literal")

DEFINITIONS: dict[str, Callable[[InertiaAngles], float]] = {
    "vibration angle, physical, 0-peak": lambda a: a.vibration.peak,
    "vibration angle, physical, half p-p": lambda a: a.vibration.half_pp,
    "vibration angle, referred, 0-peak": lambda a: a.vibration.peak / a.referred_ratio,
    "vibration angle, referred, half p-p": lambda a: a.vibration.half_pp / a.referred_ratio,
    "elastic angle, physical, 0-peak": lambda a: a.elastic.peak,
    "elastic angle, physical, half p-p": lambda a: a.elastic.half_pp,
    "elastic angle, referred, 0-peak": lambda a: a.elastic.peak / a.referred_ratio,
    "elastic angle, referred, half p-p": lambda a: a.elastic.half_pp / a.referred_ratio,
}
LIMITED = "vibration angle, physical, 0-peak"


@dataclass(frozen=True)
class Reading:
    """One reading of the paper's damping, and the angles it gives [deg], by definition and inertia."""

    shaft: str
    mesh: str
    degrees: dict[str, dict[str, float]]

    def order(self, definition: str) -> list[str]:
        """Inertias by falling angle."""
        angles = self.degrees[definition]
        return sorted(angles, key=lambda name: -angles[name])


@dataclass(frozen=True)
class ClaimRow:
    """A claim, what the model gives, and whether it holds."""

    claim: str
    paper: str
    model: str
    verdict: str
    evidence: str


def readings(response: Response, progress: Progress) -> list[Reading]:
    """The driveline of a response under every reading of shaft and mesh damping; its own reading is not run again."""
    request = replace(response.request, crosscheck=())
    own = [common_switch(response.line, kind) for kind in ("shaft", "gear_pair")]
    found = []
    for shaft in SHAFT_FORMS:
        for mesh in MESH_FORMS:
            angles = response.angles if own == [shaft, mesh] else _angles(response, shaft, mesh, request, progress)
            found.append(Reading(shaft, mesh, in_degrees(angles)))
    return found


def in_degrees(angles: AnglesResult) -> dict[str, dict[str, float]]:
    """Angles [deg] by definition and inertia."""
    return {
        name: {inertia: math.degrees(definition(each)) for inertia, each in angles.inertias.items()}
        for name, definition in DEFINITIONS.items()
    }


def _angles(response: Response, shaft: str, mesh: str, request: Request, progress: Progress) -> AnglesResult:
    return respond(settle(response.line, damping=shaft, mesh_damping=mesh), request, progress).angles


def judge(claims: Claims, runs: list[Reading]) -> list[ClaimRow]:
    """Each claim with its verdict: holds, does not hold, or cannot be decided, and why."""
    largest = [(run, run.order(LIMITED)[0]) for run in runs]
    values = [run.degrees[LIMITED][name] for run, name in largest]
    rows = [
        ClaimRow(
            "largest torsional angle",
            f"{claims.largest_angle_deg}°",
            f"{min(values):.3f}° to {max(values):.3f}° ({LIMITED}, over {_readings(runs)})",
            "cannot be decided",
            "the paper gives no inertia, stiffness, tooth number, speed or torque; "
            "with estimated data, closeness to its figure would prove nothing",
        )
    ]
    wanted = [claims.roles[role] for role in claims.largest_at]
    hits = [f"{run.shaft}/{run.mesh}: {name}" for run in runs for name in DEFINITIONS if run.order(name)[: len(wanted)] == wanted]
    tops = sorted({", ".join(run.order(name)[:2]) for run in runs for name in DEFINITIONS})
    rows.append(
        ClaimRow(
            "where it is largest",
            ", then ".join(role.replace("_", " ") for role in claims.largest_at),
            "; ".join(tops),
            f"holds under {len(hits)} of {len(runs) * len(DEFINITIONS)} definitions and readings" if hits else "does not hold",
            "; ".join(hits) if hits else f"under none of the {len(DEFINITIONS)} definitions in {_readings(runs)}",
        )
    )
    percent = claims.multibody_difference_percent
    low, high = (claims.largest_angle_deg / (1 + percent / 100), claims.largest_angle_deg / (1 - percent / 100))
    rows.append(
        ClaimRow(
            "difference to a multibody model",
            f"{percent} % (so {low:.4f}° or {high:.4f}°)",
            "no multibody model of the same data was published",
            "cannot be decided",
            "our own cross-check of solvers (`modelgen run`, `modelgen crosscheck`) checks time integration, not modelling",
        )
    )
    over = [run for run, value in zip(runs, values, strict=True) if value > claims.limit_deg]
    rows.append(
        ClaimRow(
            f"the limit of {claims.limit_deg}° is exceeded",
            "yes",
            f"in {len(over)} of {_readings(runs)} ({LIMITED})",
            "holds" if len(over) == len(runs) else "holds in part" if over else "does not hold",
            claims.standard,
        )
    )
    return rows


def _readings(runs: list[Reading]) -> str:
    return f"{len(runs)} reading{'s' * (len(runs) != 1)}"


def paper_text(response: Response, claims: Claims, runs: list[Reading], command: str) -> str:
    """The text of ``paper.md``."""
    from modelgen.reports.report import environment

    names = [claims.roles[role] for role in claims.roles]
    return (
        environment()
        .get_template("paper.md.jinja")
        .render(
            claims=claims,
            command=command,
            definitions=list(DEFINITIONS),
            limited=LIMITED,
            line=response.line,
            places=names,
            rows=judge(claims, runs),
            runs=runs,
            zeta=response.model.parameters.value(response.point.p, "zeta"),
            xi=response.model.parameters.value(response.point.p, "xi"),
        )
    )
