"""``reproduction.md`` and ``reproduction.json``: claims with verdicts, the evidence on every motion, the figures.

Part of ``cli``. This file only gathers; the words and the layout stand in ``templates/reproduction.md.jinja``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from modelgen import __version__
from modelgen.analysis.classification.motion_evidence import MotionEvidence
from modelgen.cli.reproduce_claims import exponent_text, kinds, orbit_text
from modelgen.cli.reproduce_figures import PaperFigure
from modelgen.cli.reproduce_work import Reproduction
from modelgen.reports.paper import ClaimRow
from modelgen.reports.summary import summary

Data = dict[str, Any]
SHOWN = 6
"""Multipliers and exponents that the text lists; the data hold all."""


def reproduction_text(
    work: Reproduction, rows: Sequence[ClaimRow], figures: Sequence[PaperFigure], command: str, wall: float
) -> str:
    """The text of ``reproduction.md``; ``wall``: what everything took [s]."""
    from modelgen.reports.report import environment

    motion = work.claims.motion
    return (
        environment()
        .get_template("reproduction.md.jinja")
        .render(
            version=__version__,
            command=command,
            claims=work.claims,
            motion=motion,
            extent=work.extent,
            line=work.response.line,
            rows=rows,
            figures=figures,
            window=work.response.window,
            motions=_motions(work),
            diagrams={reading: _diagram(work, reading) for reading in work.diagrams},
            diagram_seconds=work.diagram_seconds,
            wall=wall,
            zip=zip,
        )
    )


def reproduction_data(work: Reproduction, rows: Sequence[ClaimRow], figures: Sequence[PaperFigure], wall: float) -> Data:
    """The same as plain data."""
    return {
        "model": work.response.line.name,
        "model_of_the_motions": work.stand_in.name,
        "extent": asdict(work.extent),
        "claims": [asdict(row) for row in rows],
        "response": summary(work.response),
        "angles_deg_by_reading": [{"shaft": run.shaft, "mesh": run.mesh, "degrees": run.degrees} for run in work.runs],
        "motions": [_motion_data(work, reading, value, each) for (reading, value), each in work.motions.items()],
        "diagrams": {reading: _diagram(work, reading) for reading in work.diagrams},
        "figures": [{"number": each.number, "file": each.file, "title": each.title} for each in figures],
        "seconds": {"figure_9": round(work.diagram_seconds, 3), "all": round(wall, 3)},
    }


def _motions(work: Reproduction) -> list[Data]:
    """What the text says of each motion; once where readings are the same."""
    readings: dict[int, list[str]] = {}
    for (reading, _), each in work.motions.items():
        readings.setdefault(id(each), []).append(reading)
    found = {id(each): (value, each) for (_, value), each in sorted(work.motions.items(), key=lambda item: item[0][1])}
    return [_motion(work, readings[key], value, each) for key, (value, each) in found.items()]


def _motion(work: Reproduction, readings: Sequence[str], value: float, each: MotionEvidence) -> Data:
    """What the text says of one motion."""
    orbit, exponents = each.orbit, each.exponents
    return {
        "readings": " and ".join(readings),
        "value": value,
        "xi": work.xi[readings[0], value],
        "kinds": kinds(each),
        "verdicts": [str(verdict) for verdict in each.verdicts],
        "starts": each.starts,
        "exponents": exponent_text(each),
        "orbit": orbit_text(each),
        "multipliers": [] if orbit is None else [abs(complex(mu)) for mu in orbit.multipliers[:SHOWN]],
        "spectrum": [] if exponents is None else list(zip(exponents.exponents, exponents.half_width, strict=True))[:SHOWN],
        "neutral": () if orbit is None else orbit.neutral,
        "rows": [
            {
                "place": role.replace("_", " "),
                "start": start,
                "swing": math.degrees(each.swing(channel)[k]),
                "spread": math.degrees(each.spread(channel)[k]),
                "groups": each.groups(channel)[k],
            }
            for role, channel in work.channels.items()
            for k, start in enumerate(each.starts)
        ],
        "stored": list(zip(each.starts, each.stored(), strict=True)),
        "dissipated": list(zip(each.starts, each.dissipated(), strict=True)),
        "undamped": each.undamped,
    }


def _motion_data(work: Reproduction, reading: str, value: float, each: MotionEvidence) -> Data:
    orbit, exponents = each.orbit, each.exponents
    return {
        "mesh_reading": reading,
        work.claims.motion.parameter: value,
        "xi": work.xi[reading, value],
        "undamped": each.undamped,
        "common_period_s": each.period,
        "starts": [
            {
                "start": start,
                "verdict": verdict.name,
                "evidence": [asdict(piece) for piece in verdict.evidence],
                "transient_strobes": section.transient,
                "strobes": len(section.times),
                "residual_scales": section.residual,
                "settled": section.settled,
                "distance_to_orbit_scales": away,
                "mean_stored_energy_j": list(stored),
                "mean_dissipated_power_w": lost,
            }
            for start, verdict, section, away, stored, lost in zip(
                each.starts, each.verdicts, each.sections, each.away, each.stored(), each.dissipated(), strict=True
            )
        ],
        "places": {
            role: {
                "channel": channel,
                "half_pp_deg": [math.degrees(swing) for swing in each.swing(channel)],
                "section_half_extent_deg": [math.degrees(spread) for spread in each.spread(channel)],
                "groups_of_points": list(each.groups(channel)),
            }
            for role, channel in work.channels.items()
        },
        "orbit": {"missing": each.orbit_missing}
        if orbit is None
        else {
            "verdict": orbit.verdict,
            "proven": orbit.proven,
            "order": orbit.order,
            "period_s": orbit.period,
            "residual_scales": orbit.residual,
            "multipliers": [{"real": complex(mu).real, "imaginary": complex(mu).imag} for mu in orbit.multipliers],
            "rigid_rotation_exactly_1": list(orbit.neutral),
        },
        "exponents": {"missing": each.exponents_missing}
        if exponents is None
        else {
            "per_s": exponents.exponents.tolist(),
            "half_95_percent_interval_per_s": exponents.half_width.tolist(),
            "sign_of_the_largest": exponents.sign,
            "duration_s": exponents.duration,
            "rigid_rotation_exactly_0": list(exponents.neutral),
        },
    }


def _diagram(work: Reproduction, reading: str) -> Data:
    result = work.diagrams[reading]
    return {
        "values": len(result.values),
        "strobes": min(len(column.points) for column in result.columns),
        "unsettled": sum(not column.settled for column in result.columns),
        "strobe": result.strobe,
        "columns": [
            {
                "value": column.value,
                "period": column.period,
                "settled": column.settled,
                "residual_scales": column.residual,
                "transient_strobes": column.transient,
                "strobes": len(column.points),
                "ending": "" if column.outcome.is_good else column.message,
            }
            for column in result.columns
        ],
    }
