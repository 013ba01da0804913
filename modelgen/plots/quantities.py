"""From channels in SI to axes that people read: units with a prefix, angles in degrees, and each quantity's definition.

Used by all files of ``plots``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DEGREES = math.degrees(1.0)
_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_PREFIXED = ("N", "W", "J", "Pa", "m", "Hz")

DEFINITIONS = {
    "angle": r"angle $\theta$",
    "angle_deviation": r"angle less uniform rotation $\theta-\Omega t$",
    "elastic_angle": r"elastic angle $\theta-r\,\Sigma(Jr\theta)/\Sigma(Jr^2)$",
    "speed": r"speed $\dot\theta$",
    "acceleration": r"acceleration $\ddot\theta$",
    "twist": r"twist $\theta_a-\theta_b$",
    "twist_rate": r"twist rate $\dot\theta_a-\dot\theta_b$",
    "viscous_coefficient": r"damping $c$",
    "torque": r"torque $T$",
    "mesh_stiffness": r"mesh stiffness $k_m$",
    "mesh_damping": r"mesh damping $c_m$",
    "error": r"mesh error $e$",
    "error_rate": r"error rate $\dot e$",
    "approach": r"approach $r_a\theta_a-r_b\theta_b$",
    "deflection": r"deflection $\delta$",
    "deflection_rate": r"deflection rate $\dot\delta$",
    "penetration": r"penetration $f(\delta)$",
    "force": r"mesh force $F$",
    "stored_energy": "stored energy",
    "kinetic_energy": "kinetic energy",
    "dissipated_power": "dissipated power",
    "supplied_power": "supplied power",
}
"""Last part of a channel's name, and what the quantity is."""


@dataclass(frozen=True)
class Display:
    """How values of an SI unit are shown: multiplied by ``factor``, in ``unit``."""

    factor: float
    unit: str

    def __call__(self, values: Array | float) -> Array:
        return np.asarray(values, dtype=float) * self.factor


def written(unit: str) -> str:
    """A unit as it is printed.

    >>> written("kg*m^2/s")
    'kg·m²/s'
    """
    return "–" if unit == "1" else unit.replace("*", "·").replace("^2", "²").replace("^3", "³")


def display(unit: str, largest: float) -> Display:
    """Degrees for radians, else a prefix for the size of the largest value.

    >>> display("N*m", 24000.0)
    Display(factor=0.001, unit='kN·m')
    """
    if unit == "rad":
        return Display(DEGREES, "°")
    first = unit.replace("*", "/").replace("^", "/").split("/")[0]
    if first not in _PREFIXED or unit.startswith("m^") or not (math.isfinite(largest) and largest):
        return Display(1.0, written(unit))
    size, prefix = next((each for each in _PREFIXES if abs(largest) >= 0.9995 * each[0]), _PREFIXES[-1])
    return Display(1 / size, prefix + written(unit))


def quantity_text(value: float, unit: str, digits: int = 3) -> str:
    """A value with its unit, short.

    >>> quantity_text(1.05e7, "N*m/rad")
    '10.5 MN·m/rad'
    """
    shown = display(unit, value)
    return f"{float(shown(value)):.{digits}g} {shown.unit}" if unit != "1" else f"{value:.{digits}g}"


def definition(channel: str) -> str:
    """What the quantity of a channel is; its own name where no definition is known."""
    last = channel.rpartition(".")[2]
    return DEFINITIONS.get(last, last.replace("_", " "))


def label(channel: str, unit: str) -> str:
    """Text of an axis that shows a channel."""
    return f"{definition(channel)} [{unit}]"


def words(name: str) -> str:
    """A name as words: ``pump_free_end`` is "pump free end"."""
    return name.replace("_", " ")
