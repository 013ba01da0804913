"""Output channels: named quantities and modes of every element, motions of the inertias, energies and powers, and totals.

Part of the grammar; the lowering computes them by these names.
"""

from __future__ import annotations

from collections.abc import Sequence

from modelgen.equations.parts import Part
from modelgen.equations.records import Output, Template
from modelgen.errors import ModelError

MOTION = {"angle": "rad", "angle_deviation": "rad", "elastic_angle": "rad", "speed": "rad/s", "acceleration": "rad/s^2"}
TOTALS = {"kinetic_energy": "J", "stored_energy": "J", "dissipated_power": "W", "supplied_power": "W"}


def list_outputs(parts: Sequence[Part]) -> tuple[Output, ...]:
    """All channels with their units. Raises ModelError where an element's quantity takes a name that is added here."""
    channels = [Output(f"{part.name}.{key}", unit) for part in parts for key, unit in _channels(part)]
    return (*channels, *(Output(f"total.{name}", unit) for name, unit in TOTALS.items()))


def _channels(part: Part) -> list[tuple[str, str]]:
    template = part.template
    channels = [(each.name, each.unit) for each in template.definitions if not each.hidden]
    channels += [(modes.name, "1") for modes in template.modes]
    if template.constraints:
        channels += [(name, "N*m") for name in ("torque", *constraint_channels(template))]
    if template.mass and len(template.flanges) == 1:
        channels += MOTION.items()
    if template.stored_energy != 0:
        channels.append(("stored_energy", "J"))
    if template.dissipated_power != 0:
        channels.append(("dissipated_power", "W"))
    names = [name for name, _ in channels]
    for name in names:
        if names.count(name) > 1:
            what = f"names a quantity {name!r}, which modelgen adds itself"
            raise ModelError(part.where, what, "rename the quantity")
    return channels


def constraint_channels(template: Template) -> tuple[str, ...]:
    """Names of the torques that a constraint exerts on the nodes at its flanges."""
    return tuple(f"torque_{flange}" for flange in template.flanges)
