"""Mesh data that a report prints beside the forces: mean stiffness and contact ratio of each gear pair.

Part of ``reports``, between ``response`` and the files of a run.
"""

from __future__ import annotations

import math

import numpy as np

from modelgen.gears import Gear, GearMesh
from modelgen.model import Element, Shared
from modelgen.reports.response import Response

SAMPLES = 8192  # of one mesh period: exact for Fourier rows


def mean_stiffness(response: Response, pair: str) -> float | None:
    """Mean mesh stiffness [N/m] over one mesh period; None for a law without such a quantity."""
    model, channel = response.model, f"{pair}.mesh_stiffness"
    if channel not in model.outputs:
        return None
    frequencies = model.mean_model.frequencies_at(response.point.p)
    named = {clock.name: float(f) for clock, f in zip(model.equations.clocks, frequencies, strict=True)}
    frequency = named.get(f"{pair}.contact", 0.0)
    period = 2 * math.pi / frequency if frequency > 0 else 1.0
    # Between the samples' ends, so that a jump at the period's edge is not met.
    times = (np.arange(SAMPLES) + 0.5) * (period / SAMPLES)
    states = np.tile(response.point.start, (SAMPLES, 1))
    return float(model.channels(times, states, response.point.p, [channel])[channel].mean())


def contact_ratio(response: Response, pair: str) -> float | None:
    """Contact ratio: from the teeth where the mesh follows from them, as given for two levels; None otherwise."""
    element = response.line[pair]
    form = element.choices.get("mesh")
    if form == "rectangular":
        return _value(response, element, "contact_ratio")
    if form != "geometry":
        return None
    common = {key: _value(response, element, key) for key in ("module", "pressure_angle")}
    shared = {key: _value(response, element, key) for key in ("face_width", "young_modulus", "poisson_ratio", "shear_factor")}
    teeth, shift = ([_value(response, element, f"{key}_{end}") for end in "ab"] for key in ("teeth", "profile_shift"))
    one, two = (Gear(int(z), profile_shift=x, **common) for z, x in zip(teeth, shift, strict=True))
    return GearMesh(one, two, **shared).transverse_contact_ratio


def _value(response: Response, element: Element, key: str) -> float:
    given = element.values[key]
    name = given.name if isinstance(given, Shared) else f"{element.name}.{key}"
    return response.model.parameters.value(response.point.p, name)
