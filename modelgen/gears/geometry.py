"""One cylindrical gear: spur, or helical with the data of its normal section.

Follows ``tooth`` (the section it is cut to) and feeds ``mesh``. Lengths [m], angles [rad].
Source: ISO 21771:2007.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from modelgen.gears.bounds import bounded, whole
from modelgen.gears.involute import involute
from modelgen.gears.tooth import Tooth

STANDARD_PRESSURE_ANGLE = math.radians(20)


@dataclass(frozen=True)
class Gear:
    """An external involute gear, cut by a rack.

    Arguments: ``teeth`` (whole), normal ``module`` [m], ``profile_shift`` [modules], normal ``pressure_angle`` [rad],
    ``addendum`` and ``clearance`` of the rack [modules], ``helix_angle`` [rad] at the reference circle (its hand does not
    matter), ``tip_shortening`` [modules] by which the tips are turned off (usual with large profile shifts). Raises
    ModelError for a number out of bounds, undercut that reaches the flank, pointed teeth.

    >>> gear = Gear(teeth=26, module=0.007)
    >>> print(f"{gear.base_radius:.6f} {gear.involute_start_radius:.6f} {gear.tip_radius:.6f}")
    0.085512 0.086174 0.098000
    >>> Gear(teeth=9, module=0.007)
    Traceback (most recent call last):
    ...
    modelgen.errors.ModelError: gear with 9 teeth: undercut reaches the flank (9 teeth in the normal section, 13.68 needed); use \
more teeth or a profile_shift of at least 0.342
    """

    teeth: int
    module: float
    profile_shift: float = 0.0
    pressure_angle: float = STANDARD_PRESSURE_ANGLE
    addendum: float = 1.0
    clearance: float = 0.25
    helix_angle: float = 0.0
    tip_shortening: float = 0.0

    def __post_init__(self) -> None:
        # 26.0 may come from a model's parameters; inside it is 26.
        object.__setattr__(self, "teeth", whole(self.teeth, "teeth", "gear", at_least=3, at_most=1_000_000))
        where = f"gear with {self.teeth} teeth"
        bounded(self.module, "module", where, "m", at_least=1e-6, below=1)
        bounded(self.profile_shift, "profile_shift", where, at_least=-2, at_most=2)
        bounded(self.pressure_angle, "pressure_angle", where, "rad", at_least=0.1, at_most=0.8)
        bounded(self.addendum, "addendum", where, above=0, at_most=2)
        bounded(self.clearance, "clearance", where, at_least=0, at_most=1)
        bounded(self.helix_angle, "helix_angle", where, "rad", at_least=0, at_most=0.8)
        bounded(self.tip_shortening, "tip_shortening", where, at_least=0, at_most=1)
        self.tooth.refuse_impossible(where)

    @cached_property
    def tooth(self) -> Tooth:
        """The tooth in the normal section: that of a spur gear with the virtual number of teeth."""
        return Tooth(
            self.virtual_teeth,
            self.module,
            self.profile_shift,
            self.pressure_angle,
            self.addendum,
            self.clearance,
            self.tip_shortening,
        )

    @property
    def transverse_module(self) -> float:
        """m_t = m_n / cos(beta) [m]."""
        return self.module / math.cos(self.helix_angle)

    @cached_property
    def transverse_pressure_angle(self) -> float:
        """alpha_t = arctan(tan(alpha_n) / cos(beta)) [rad]."""
        return math.atan2(math.tan(self.pressure_angle), math.cos(self.helix_angle))

    @cached_property
    def base_helix_angle(self) -> float:
        """beta_b = arcsin(sin(beta) cos(alpha_n)) [rad]."""
        return math.asin(math.sin(self.helix_angle) * math.cos(self.pressure_angle))

    @property
    def virtual_teeth(self) -> float:
        """z_n = z / (cos(beta_b)^2 cos(beta)), teeth of the spur gear with the same normal section."""
        return self.teeth / (math.cos(self.base_helix_angle) ** 2 * math.cos(self.helix_angle))

    @property
    def reference_radius(self) -> float:
        """r = z m_t / 2 [m]."""
        return self.teeth * self.transverse_module / 2

    @property
    def base_radius(self) -> float:
        """r_b = r cos(alpha_t) [m]."""
        return self.reference_radius * math.cos(self.transverse_pressure_angle)

    @property
    def tip_radius(self) -> float:
        """r_a = r + (h_a* + x - k) m_n [m], k the tip shortening."""
        return self.reference_radius + (self.tooth.tip_radius - self.tooth.reference_radius)

    @property
    def root_radius(self) -> float:
        """r_f = r - (h_a* + c* - x) m_n [m]."""
        return self.reference_radius + (self.tooth.root_radius - self.tooth.reference_radius)

    @property
    def base_pitch(self) -> float:
        """p_b = 2 pi r_b / z [m], transverse: the path of contact that belongs to one tooth."""
        return 2 * math.pi * self.base_radius / self.teeth

    @property
    def involute_start_roll(self) -> float:
        """Transverse roll length [m] where the involute begins, 0 in case of slight undercut. It is the radius of curvature
        there, which is 1/cos(beta_b) times as large in the normal section."""
        return self.tooth.involute_start_roll * math.cos(self.base_helix_angle)

    @property
    def involute_start_radius(self) -> float:
        """r_F [m], transverse."""
        return math.hypot(self.base_radius, self.involute_start_roll)

    @cached_property
    def tip_roll(self) -> float:
        """Transverse roll length [m] at the tip: sqrt(r_a^2 - r_b^2)."""
        return math.sqrt(self.tip_radius**2 - self.base_radius**2)

    def half_angle(self, radius: float) -> float:
        """Half the angle [rad] that a tooth fills on a circle [m] in the transverse plane."""
        filled = (math.pi + 4 * self.profile_shift * math.tan(self.pressure_angle)) / (2 * self.teeth)
        there = math.acos(min(self.base_radius / radius, 1.0))
        return filled + float(involute(self.transverse_pressure_angle) - involute(there))

    def section_radius(self, roll: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Radius [m] on the normal section's tooth for a load at a transverse roll length [m].

        Both flanks begin and end together and are run through in proportion; for spur gears it is sqrt(r_b^2 + roll^2).
        """
        tooth, start = self.tooth, self.involute_start_roll
        scale = (tooth.tip_roll - tooth.involute_start_roll) / (self.tip_roll - start)
        return np.hypot(tooth.base_radius, tooth.involute_start_roll + (np.asarray(roll) - start) * scale)
