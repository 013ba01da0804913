"""The dimensionless gear pair x'' + 2 zeta x' + f(x) = F_m + F_ah w^2 cos(w t) as a driveline; f has a dead zone of +-1.

Two inertias of 2 on base radii of 1 have the equivalent mass 1; the error -F_ah sin(w t + pi/2) shakes with F_ah w^2 cos w t.
Source of the form: A. Kahraman, R. Singh, J. Sound Vib. 142 (1990) 49-75.
"""

from __future__ import annotations

from math import pi

from modelgen.elements import GearPair, HarmonicTorque, Inertia
from modelgen.model import Driveline

ZETA, MEAN, SHAKING = 0.05, 0.1, 0.05
# Where F_ah w^2 / |1 - w^2 + 2 i zeta w| = F_m: the linear branch touches the end of contact.
PARTS, JOINS = 0.8206310877, 1.407088466


def oscillator(zeta: float = ZETA, mean: float = MEAN, shaking: float = SHAKING, speed: float = 1.0) -> Driveline:
    """One tooth on each wheel, so that the mesh frequency is the speed."""
    return Driveline(
        "oscillator",
        speed=speed,
        reference="pinion",
        elements=[
            Inertia("pinion", inertia=2.0),
            Inertia("wheel", inertia=2.0),
            GearPair(
                "mesh", "pinion", "wheel", teeth_a=1, teeth_b=1, radii="given", base_radius_a=1.0, mean_stiffness=1.0,
                damping="value", damping_coefficient=2 * zeta, error_amplitude=shaking, error_phase=pi / 2, half_backlash=1.0,
            ),
            HarmonicTorque("drive", "pinion", mean=mean),
            HarmonicTorque("load", "wheel", mean=-mean),
        ],
    )  # fmt: skip
