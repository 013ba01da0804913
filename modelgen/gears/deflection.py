"""Deflection of one tooth along the line of action: Eq. 2-6 and 8 of the paper.

Follows ``tooth``, feeds ``mesh``. Everything here is per line load F_N/b of 1 N/m, so a deflection has the unit
m/(N/m) = m^2/N; 1e-12 of it are 1 pm per N/m.

Eq. 3-5 are the integrals of a cantilever of variable section (Timoshenko, shear factor 1), Eq. 6 the rotation of the half-plane
the tooth stands on, Eq. 8 a linearized Hertzian contact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import ModelError
from modelgen.gears.tooth import Tooth

_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class ToothDeflection:
    """The four parts of Eq. 2, each [m^2/N] with the shape of the load radius."""

    rectangle: NDArray[np.float64]
    trapezoid: NDArray[np.float64]
    shear: NDArray[np.float64]
    foundation: NDArray[np.float64]

    @property
    def total(self) -> NDArray[np.float64]:
        """delta = delta_Br + delta_Bt + delta_s + delta_G (Eq. 2) [m^2/N]."""
        return self.rectangle + self.trapezoid + self.shear + self.foundation


def tooth_deflection(
    tooth: Tooth, radius: NDArray[np.float64] | float, young_modulus: float, poisson_ratio: float, shear_factor: float = 1.0
) -> ToothDeflection:
    """Deflection of a tooth loaded at a radius [m] of its flank, per unit line load (Eq. 3-6).

    ``young_modulus`` [Pa], ``poisson_ratio`` [1]. ``shear_factor`` multiplies Eq. 5: 1 is the paper's, 1.2 Timoshenko's for a
    rectangle. Below the start of the involute the trapezoid bears nothing and Eq. 3 and 5 end at the load (h_r becomes h_x).
    Raises ModelError for a load beside the flank.

    >>> tooth = Tooth(26, 0.007, 0.0, math.radians(20), 1.0, 0.25)
    >>> parts = tooth_deflection(tooth, 0.091, 206e9, 0.3)
    >>> [round(float(part) * 1e12, 3) for part in (parts.rectangle, parts.trapezoid, parts.shear, parts.foundation)]
    [4.801, 1.216, 8.626, 16.09]
    """
    lowest, highest = max(tooth.base_radius, tooth.root_radius), tooth.tip_radius
    if not np.all((radius >= lowest * (1 - _ROUNDING)) & (radius <= highest * (1 + _ROUNDING))):
        raise ModelError(
            f"tooth with a tip radius of {highest:.6g} m",
            "the load is not on the flank",
            f"give radii from {lowest:.6g} to {highest:.6g} m",
        )
    load = tooth.load_height(radius)
    rectangle = np.minimum(tooth.rectangle_height, load)
    width, apex = tooth.root_thickness, tooth.apex_height
    compliance = np.cos(tooth.load_angle(radius)) ** 2 / young_modulus
    narrowing = (apex - load) / (apex - rectangle)
    logarithm = np.log(narrowing)
    return ToothDeflection(
        rectangle=12 * compliance / width**3 * (load * rectangle * (load - rectangle) + rectangle**3 / 3),
        trapezoid=6 * compliance / width**3 * (apex - rectangle) ** 3 * (narrowing * (4 - narrowing) - 2 * logarithm - 3),
        shear=shear_factor * 2 * (1 + poisson_ratio) * compliance / width * (rectangle - (apex - rectangle) * logarithm),
        foundation=24 * load**2 * compliance / (math.pi * width**2),
    )


def contact_deflection(young_modulus: float, poisson_ratio: float) -> float:
    """delta_pv = 4 (1 - nu^2) / (pi E) [m^2/N], approach of the two flanks per unit line load (Eq. 8).

    >>> round(contact_deflection(206e9, 0.3) * 1e12, 4)
    5.6245
    """
    return 4 * (1 - poisson_ratio**2) / (math.pi * young_modulus)
