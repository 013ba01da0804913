"""Question: how far do the natural frequencies stand off what excites them?

Gives values by name that ``check`` holds against separation rules. Source of the measure: API RP 684, train torsional analysis
(excitations over the speed range against undamped frequencies); critical speeds per order as in Ker Wilson, Practical Solution of
Torsional Vibration Problems, vol. 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Any

from modelgen.analysis.limits.known_value import KnownValue
from modelgen.analysis.linear.modal import ModalResult
from modelgen.errors import CaseError
from modelgen.model.values import plain_number
from modelgen.units import finite, read_quantity


def separation_margins(result: ModalResult, excitations: Mapping[str, Any]) -> dict[str, KnownValue]:
    """Distance of every vibrating mode from every excitation, per excitation frequency; 0 for a mode inside its range.

    ``excitations``: by name, a frequency ("95 Hz" or a number in Hz) or the pair of lowest and highest one over the speed range.
    Keys read ``mode 1 (45.24 Hz) / NAME.separation_margin``; vibrating modes count from 1.
    """
    values = {}
    for label, given in excitations.items():
        where = f"excitation {label!r}"
        pair = given if isinstance(given, (tuple, list)) else (given, given)
        if len(pair) != 2:
            raise CaseError(where, f"is {given!r:.60}", 'give a frequency, or a lowest and a highest one: ("80 Hz", "95 Hz")')
        low, high = (_positive(each, "Hz", where) for each in pair)
        if low > high:
            raise CaseError(where, f"runs from {low:g} to {high:g} Hz", "give the lowest frequency first")
        for name, frequency, nodes in _modes(result):
            margin = 1 - frequency / low if frequency < low else max(0.0, frequency / high - 1)
            values[f"{name} / {label}.separation_margin"] = KnownValue(margin, nodes=nodes)
    return values


def critical_speed_ratios(result: ModalResult, orders: Mapping[str, Any], speed: Any) -> dict[str, KnownValue]:
    """Critical speed of every vibrating mode and order, per operating speed: frequency / (order * turns per second).

    Each knows its order and the nodes of its mode, so that a rule judges those of which its text speaks.

    ``orders``: by name, excitations per turn of the shaft that turns at ``speed`` ("1900 rpm" or a number in rad/s).
    """
    turns = _positive(speed, "rad/s", "speed") / (2 * pi)
    counts = {label: _positive(order, "1", f"order {label!r}") for label, order in orders.items()}
    return {
        f"{name} / {label}.critical_speed_ratio": KnownValue(frequency / (order * turns), nodes=nodes, order=order)
        for label, order in counts.items()
        for name, frequency, nodes in _modes(result)
    }


def _modes(result: ModalResult) -> list[tuple[str, float, int]]:
    """Name, frequency [Hz] and nodes of every vibrating mode."""
    found = [(mode, float(result.frequencies[mode])) for mode in range(result.rigid, len(result.frequencies))]
    return [(f"{result.name(mode)} ({frequency:.4g} Hz)", frequency, int(result.nodes[mode])) for mode, frequency in found]


def _positive(value: Any, unit: str, where: str) -> float:
    number = read_quantity(value, unit, where) if isinstance(value, str) else finite(plain_number(value, where, unit), where)
    if number <= 0:
        raise CaseError(where, f"is {number:g} {unit}", "give a positive value")
    return number
