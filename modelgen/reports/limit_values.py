"""The values that limits judge, by name and with units: angles, torques, stresses, distances from what excites.

Part of ``reports``, below the command ``limits``. Angles and torques come from the settled response (``response``) or from the
linear forced one at the operating speed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from modelgen.analysis import forced, modal
from modelgen.analysis.limits.check import angle_values
from modelgen.analysis.limits.known_value import KnownValue
from modelgen.analysis.limits.separation import critical_speed_ratios, separation_margins
from modelgen.analysis.linear.campbell import OrderLine, order_lines
from modelgen.analysis.linear.orders import order_number
from modelgen.analysis.linear.shear_stress import Diameter, outer_diameter, shear_stress_factor
from modelgen.errors import CaseError
from modelgen.lowering import Compiled
from modelgen.model import Driveline
from modelgen.reports.progress import Progress
from modelgen.reports.response import Request, Response, respond

Values = dict[str, Any]
SWINGING = {".angle_deviation": "vibration_angle", ".elastic_angle": "elastic_angle", ".twist": "twist"}
SEPARATION = ("separation_margin", "critical_speed_ratio")
HALF_PP = "_half_pp"
STILL = 1e-12  # rad
FORCED = "values are those of the linear forced response at the operating speed: no gaps, no start-up"
UNSETTLED = "the window is not settled: start-up vibration is still in these values"


def settled_values(
    line: Driveline, diameters: Mapping[str, Diameter], progress: Progress, rated: float | None = None
) -> tuple[Values, tuple[str, ...]]:
    """Values of a run over its settled window, and what is to be said of them. Raises what a run raises.

    ``rated`` [rad/s]: the maximum continuous speed, by default the operating speed.
    """
    response = respond(line, Request(rated=rated), progress)
    values = response_values(response, diameters)
    _refuse_stillness(values, line.name)
    return values, () if response.window.settled else (UNSETTLED,)


def response_values(response: Response, diameters: Mapping[str, Diameter]) -> Values:
    """Angles, mesh forces, torques and stresses of a run over its window."""
    values: Values = dict(angle_values(response.angles))
    ratio = speed_ratio(response.model, response.request.rated)
    for name, torque in response.solution.channels.items():
        if name.endswith(".torque"):
            low, high = float(torque.min()), float(torque.max())
            values |= _loads(name.removesuffix(".torque"), (high - low) / 2, max(abs(low), abs(high)), diameters, ratio)
    return values


def speed_ratio(model: Compiled, rated: float | None) -> float | None:
    """Operating speed per maximum continuous speed ``rated`` [rad/s], by default the operating speed; None without a speed."""
    if model.equations.speed is None:
        return None
    own = model.parameters.value(model.parameters.unbalanced(), "speed")
    return own / (rated or own)


def forced_values(
    model: Compiled, diameters: Mapping[str, Diameter], rated: float | None = None
) -> tuple[Values, tuple[str, ...]]:
    """Values of the linear response over the cycle at the operating speed, and what is to be said of them."""
    result, ratio = forced(model), speed_ratio(model, rated)
    values: Values = {}
    remarks = [FORCED]
    exact = True
    for channel in result.channels:
        element, _, kind = channel.rpartition(".")
        swing = result.swing(channel)
        exact = exact and swing.exact
        low, high, half_pp = float(swing.least[0]), float(swing.largest[0]), float(swing.half_pp[0])
        if f".{kind}" in SWINGING:
            name = f"{element}.{SWINGING[f'.{kind}']}"
            # A twist has a mean that counts, the others are deviations.
            peak = max(abs(low), abs(high)) if kind == "twist" else float(swing.peak[0])
            values |= {name: (peak, "rad"), name + HALF_PP: (half_pp, "rad")}
        elif kind == "torque":
            values |= _loads(element, half_pp, max(abs(low), abs(high)), diameters, ratio)
        elif kind == "force":
            values[f"{element}.mesh_force"] = (max(abs(low), abs(high)), "N")
    _refuse_stillness(values, model.name)
    if not exact:
        remarks.append("the orders repeat only after very long: sums over the cycle are upper bounds")
    return values, tuple(remarks)


def _refuse_stillness(values: Values, model: str) -> None:
    """Raises CaseError where nothing moves: zeros would pass every limit."""
    swings = [values[name][0] for name in values if name.endswith(HALF_PP)]
    if swings and max(swings) <= STILL:
        remedy = "give it harmonic torques, or ask for separation rules only"
        raise CaseError(f"driveline {model!r}", "does not vibrate, nothing excites it", remedy)


def _loads(element: str, half_pp: float, largest: float, diameters: Mapping[str, Diameter], ratio: float | None) -> Values:
    """Torques of an element, and its stress where its diameter is known, with that diameter and the speed ratio."""
    values: Values = {f"{element}.vibratory_torque": (half_pp, "N*m"), f"{element}.largest_torque": (largest, "N*m")}
    if element in diameters:
        where = f"shaft {element!r}, diameter"
        stress = half_pp * shear_stress_factor(diameters[element], where)
        facts = {"diameter": (outer_diameter(diameters[element], where), "m"), "speed_ratio": ratio}
        known = {key: fact for key, fact in facts.items() if fact is not None}
        values[f"{element}.vibratory_stress"] = KnownValue(stress, "Pa", **known)
    return values


def separation_values(
    model: Compiled,
    operating: tuple[float, float] | None,
    share: float,
    rated: float | None = None,
    orders: Sequence[float] = (),
) -> Values:
    """For every mode its distance from the nearest order over the operating speeds; every critical speed per speed ``rated``.

    Orders with less than ``share`` of the largest harmonic torque are left out, but those in ``orders`` have their critical
    speeds. ``rated`` [rad/s]: the maximum continuous speed, by default the highest operating speed. Nothing for a driveline
    without a speed.
    """
    if model.equations.speed is None:
        return {}
    own = model.parameters.value(model.parameters.unbalanced(), "speed")
    low, high = operating or (own, own)
    lines = order_lines(model, (low + high) / 2, None)
    largest = max((line.torque for line in lines), default=0.0)
    kept = {line.name: float(line.order) for line in lines if line.torque > 0 and line.torque >= share * largest}
    meant = {name: order for order in orders for name in [_name_of(order, lines)] if name not in kept}
    if not kept and not meant:
        return {}
    try:
        modes = modal(model)
    except CaseError:  # a driveline without inertias
        return {}
    turns = 1 / (2 * math.pi)
    margins = separation_margins(modes, {name: (order * low * turns, order * high * turns) for name, order in kept.items()})
    nearest: dict[str, str] = {}
    for name, margin in margins.items():
        mode = name.partition(" / ")[0]
        if mode not in nearest or margin < margins[nearest[mode]]:
            nearest[mode] = name
    return {name: margins[name] for name in nearest.values()} | critical_speed_ratios(modes, kept | meant, rated or high)


def _name_of(order: float, lines: Sequence[OrderLine]) -> str:
    """The name of an order that a rule speaks of, whether it excites or not."""
    found = [line.name for line in lines if abs(float(line.order) - order) <= 1e-9 * order]
    return found[0] if found else f"order {order_number(order)} (not excited)"
