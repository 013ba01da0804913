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
MINUS = "\N{MINUS SIGN}"
_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "\N{MICRO SIGN}"), (1e-9, "n"))
_PREFIXED = ("N", "W", "J", "Pa", "m", "Hz")

DEFINITIONS = {
    "angle": (r"\theta", "angle, rotation included"),
    "angle_deviation": (r"\theta-\Omega t", "angle less uniform rotation"),
    "elastic_angle": (r"\theta_{el}", f"elastic angle θ {MINUS} rΣ(Jrθ)/Σ(Jr²)"),
    "speed": (r"\dot\theta", "speed"),
    "acceleration": (r"\ddot\theta", "angular acceleration"),
    "twist": (r"\theta_a-\theta_b", "twist"),
    "twist_rate": (r"\dot\theta_a-\dot\theta_b", "rate of twist"),
    "viscous_coefficient": ("c", "damping coefficient"),
    "torque": ("T", "torque"),
    "mesh_stiffness": ("k_m", "mesh stiffness along the line of action"),
    "mesh_damping": ("c_m", "mesh damping along the line of action"),
    "error": ("e", "mesh error"),
    "error_rate": (r"\dot e", "rate of the mesh error"),
    "approach": (r"r_a\theta_a-r_b\theta_b", "approach along the line of action, without error"),
    "deflection": (r"\delta", "mesh deflection"),
    "deflection_rate": (r"\dot\delta", "rate of the mesh deflection"),
    "penetration": (r"f(\delta)", "penetration of the flanks"),
    "force": ("F", "mesh force along the line of action"),
    "stored_energy": ("E", "stored energy"),
    "kinetic_energy": ("E", "kinetic energy"),
    "dissipated_power": ("P", "dissipated power"),
    "supplied_power": ("P", "supplied power"),
}
"""Last part of a channel's name: the symbol of the quantity, and what it is."""


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
    return "-" if unit == "1" else unit.replace("*", "·").replace("^2", "²").replace("^3", "³")


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
    return DEFINITIONS[last][1] if last in DEFINITIONS else words(last)


def axis_label(channel: str, unit: str) -> str:
    """Text of an axis that shows a channel: its symbol and unit."""
    last = channel.rpartition(".")[2]
    return f"${DEFINITIONS[last][0]}$ [{unit}]" if last in DEFINITIONS else f"{words(last)} [{unit}]"


def number(value: float, digits: int = 4) -> str:
    """A number as it is printed.

    >>> number(1e6), number(152.23), number(-2.5) == f"{MINUS}2.5"
    ('1e6', '152.2', True)
    """
    return f"{value:.{digits}g}".replace("e-0", "e-").replace("e+0", "e").replace("-", MINUS)


def words(name: str) -> str:
    """A name as words: ``pump_free_end`` is "pump free end"."""
    return name.replace("_", " ")
