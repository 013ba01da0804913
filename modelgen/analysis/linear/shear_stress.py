"""Shear stress at the surface of a round shaft under torsion, by its nominal section.

Below ``forced``. tau = 16 T d_o / (pi (d_o^4 - d_i^4)); no stress concentration.
Source: Young, Budynas, Roark's Formulas for Stress and Strain (2002), ch. 10.
"""

from __future__ import annotations

from math import pi

from modelgen.errors import CaseError
from modelgen.units import read_quantity

Diameter = float | str | tuple[float | str, float | str]
"""Outer diameter, or outer and inner one, as numbers in m or texts such as "80 mm"."""


def shear_stress_factor(diameter: Diameter, where: str) -> float:
    """Shear stress [Pa] per torque [N*m]. Raises CaseError unless 0 <= inner < outer.

    >>> round(shear_stress_factor("80 mm", "shaft 's'"))
    9947
    """
    outer, inner = _both(diameter, where)
    return 16 * outer / (pi * (outer**4 - inner**4))


def outer_diameter(diameter: Diameter, where: str) -> float:
    """The outer diameter [m]. Raises CaseError unless 0 <= inner < outer.

    >>> outer_diameter(("80 mm", "40 mm"), "shaft 's'")
    0.08
    """
    return _both(diameter, where)[0]


def _both(diameter: Diameter, where: str) -> tuple[float, float]:
    pair = diameter if isinstance(diameter, (tuple, list)) else (diameter, 0.0)
    try:
        outer, inner = (read_quantity(each, "m", where) if isinstance(each, str) else float(each) for each in pair)
    except (TypeError, ValueError):
        raise CaseError(where, f"is {diameter!r:.60}", "give the outer diameter in m, or outer and inner one") from None
    if not 0 <= inner < outer < float("inf"):
        raise CaseError(where, f"is {diameter!r:.60}", "give a positive outer diameter and a smaller inner one")
    return outer, inner
