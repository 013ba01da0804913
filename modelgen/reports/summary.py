"""``summary.json``: the figures of a run for other programs, in fixed keys and named units.

Part of ``reports``. A figure that a driveline does not have (no gears, shafts with different damping, no cross-check asked for)
is null, or its table is empty; no number in it is ever infinite or missing without a word.
"""

from __future__ import annotations

import json
import math
from typing import Any

from modelgen.reports import limit
from modelgen.reports.meshes import contact_ratio, mean_stiffness
from modelgen.reports.response import Response
from modelgen.reports.settings import common_ratio, common_switch


def summary_text(response: Response, wall: float) -> str:
    """The text of ``summary.json``; ``wall`` is the time that the run took [s]."""
    return json.dumps({**summary(response), "wall_s": round(wall, 3)}, indent=2, allow_nan=False) + "\n"


def summary(response: Response) -> dict[str, Any]:
    """The figures of a run as plain data, without its time: angles in degrees, physical (referred: over ``referred_ratio``)."""
    found = response.angles
    return {
        "model": response.line.name,
        "natural_frequencies_hz": response.modes.frequencies.tolist(),
        "angles_deg": {
            name: {
                "vibration_peak": math.degrees(each.vibration.peak),
                "vibration_half_pp": math.degrees(each.vibration.half_pp),
                "elastic_peak": math.degrees(each.elastic.peak),
                "elastic_half_pp": math.degrees(each.elastic.half_pp),
                "referred_ratio": each.referred_ratio,
            }
            for name, each in found.inertias.items()
        },
        "twist_half_pp_deg": {name: math.degrees(each.half_pp) for name, each in found.twists.items()},
        "mesh": {
            name: {
                "force_min_n": each.least,
                "force_max_n": each.largest,
                "mean_stiffness_n_per_m": mean_stiffness(response, name),
                "contact_ratio": contact_ratio(response, name),
            }
            for name, each in found.meshes.items()
        },
        "window_s": [response.window.first, response.window.last],
        "damping": damping(response),
        "limit": limit_data(response),
        "limits": limits_data(response),
        "crosscheck": crosscheck_data(response),
    }


def damping(response: Response) -> dict[str, Any]:
    """How the driveline is damped; null where its shafts or gear pairs differ, or where it has none."""
    line = response.line
    xi = common_ratio(line, "gear_pair")
    scaled = isinstance(xi, str) and line.parameters[xi].expression is not None
    return {
        "shaft": common_switch(line, "shaft"),
        "zeta": _ratio(response, "shaft"),
        "mesh_form": common_switch(line, "gear_pair"),
        "xi": _ratio(response, "gear_pair"),
        "mesh_reading": None if xi is None else "scaled" if scaled else "fixed",
    }


def _ratio(response: Response, kind: str) -> float | None:
    ratio = common_ratio(response.line, kind)
    return response.model.parameters.value(response.point.p, ratio) if isinstance(ratio, str) else ratio


def limit_data(response: Response) -> dict[str, Any] | None:
    """The verdict on the largest angle by the rule that the model chooses for angles; None where it chooses none."""
    found = limit.verdict(limit.judged(response))
    if found is None:
        return None
    worst = found.worst
    return {
        "name": worst.citation,
        "quantity": limit.QUANTITY,
        "element": worst.element,
        "deg": found.limit,
        "value_deg": worst.value,
        "ok": found.ok,
    }


def limits_data(response: Response) -> list[dict[str, Any]]:
    """Every value that a rule chosen by the model judges, in the unit of the rule."""
    found = limit.judged(response)
    keys = ("rule", "element", "quantity", "value", "unit", "comparison", "limits", "margin", "verdict", "verified")
    return [{key: getattr(row, key) for key in keys} for row in found.rows] if found else []


def crosscheck_data(response: Response) -> dict[str, Any] | None:
    """The cross-check; its worst difference is null where a solver did not reach the end."""
    result = response.crosscheck
    if result is None:
        return None
    worst = result.worst_relative_difference
    return {
        "solvers": list(result.solvers),
        "worst_relative_difference": worst if math.isfinite(worst) else None,
        "horizon_s": result.horizon,
    }
