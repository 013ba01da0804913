"""The tooth as Ishikawa sees it: a rectangle on the root line and a symmetric trapezoid above it.

Feeds ``deflection`` (Eq. 3-6 of the paper). The tooth is that of a spur gear; a helical gear lends its normal section,
whose number of teeth (the virtual one) need not be whole. Lengths [m], angles [rad].

The root line is the chord of the root circle at half-width S_F/2. The rectangle reaches from it to the start of the involute,
the trapezoid from there (S_F wide) to the tip (S_k wide). All heights count from the root line.
Source: Ishikawa's tooth model, which Eq. 3-6 of the paper presuppose; ISO 21771:2007 for the involute.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import ModelError
from modelgen.gears.involute import involute

# Down to four fifths of the theoretical limit of teeth (14 instead of 17.1 at 20 degrees: the usual practical limit) undercut is
# a few thousandths of a module high, ends about where the flank in use begins, and is neglected; below, it eats into that flank.
PRACTICAL_UNDERCUT = 0.8


@dataclass(frozen=True)
class Tooth:
    """Cross-section of one tooth, cut by a rack; addendum, clearance, shift and shortening in modules. ``Gear`` checks it.

    >>> tooth = Tooth(teeth=26, module=7.0, profile_shift=0.0, pressure_angle=math.radians(20), addendum=1.0, clearance=0.25)
    >>> [round(length, 3) for length in (tooth.root_thickness, tooth.tip_thickness, tooth.height, tooth.apex_height)]
    [12.859, 5.066, 15.969, 23.792]
    """

    teeth: float
    module: float
    profile_shift: float
    pressure_angle: float
    addendum: float
    clearance: float
    tip_shortening: float = 0.0

    def refuse_impossible(self, where: str) -> None:
        """Raise ModelError where undercut reaches the flank, the tip is pointed or the section is not a tooth."""
        sine = math.sin(self.pressure_angle)
        limit = PRACTICAL_UNDERCUT * 2 * (self.addendum - self.profile_shift) / sine**2
        if self.teeth < limit:
            shift = math.ceil(1e3 * (self.addendum - self.teeth * sine**2 / 2 / PRACTICAL_UNDERCUT)) / 1e3
            raise ModelError(
                where,
                f"undercut reaches the flank ({self.teeth:.4g} teeth in the normal section, {limit:.4g} needed)",
                f"use more teeth or a profile_shift of at least {shift:.3f}",
            )
        if not self.tip_radius > self.involute_start_radius:
            raise ModelError(
                where,
                "the tip circle lies below the start of the involute",
                "raise addendum or profile_shift, or shorten the tips less",
            )
        if not self.half_angle(self.tip_radius) > 0:
            raise ModelError(where, "the teeth are pointed below the tip circle", "reduce profile_shift or addendum")
        if not (0 < self.root_thickness < 2 * self.root_radius and self.tip_thickness < self.root_thickness):
            raise ModelError(
                where,
                f"the section is no tooth (root thickness {self.root_thickness:.4g} m, tip thickness {self.tip_thickness:.4g} m, "
                f"root radius {self.root_radius:.4g} m)",
                "check pressure_angle, addendum, clearance and profile_shift",
            )

    @property
    def reference_radius(self) -> float:
        """r = z m / 2 [m]."""
        return self.teeth * self.module / 2

    @property
    def base_radius(self) -> float:
        """r_b = r cos(alpha) [m]."""
        return self.reference_radius * math.cos(self.pressure_angle)

    @property
    def tip_radius(self) -> float:
        """r_a = r + (h_a* + x - k) m [m], k the tip shortening."""
        return self.reference_radius + (self.addendum + self.profile_shift - self.tip_shortening) * self.module

    @property
    def root_radius(self) -> float:
        """r_f = r - (h_a* + c* - x) m [m]."""
        return self.reference_radius - (self.addendum + self.clearance - self.profile_shift) * self.module

    @cached_property
    def involute_start_roll(self) -> float:
        """Roll length t = r sin(alpha) - (h_a* - x) m / sin(alpha) [m] where the straight flank of the rack ends; 0 if t < 0
        (slight undercut)."""
        sine = math.sin(self.pressure_angle)
        return max(self.reference_radius * sine - (self.addendum - self.profile_shift) * self.module / sine, 0.0)

    @property
    def tip_roll(self) -> float:
        """Roll length [m] at the tip: sqrt(r_a^2 - r_b^2)."""
        return math.sqrt(self.tip_radius**2 - self.base_radius**2)

    @cached_property
    def involute_start_radius(self) -> float:
        """r_F = sqrt(r_b^2 + t^2) [m]."""
        return math.hypot(self.base_radius, self.involute_start_roll)

    def pressure_angle_at(self, radius: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """alpha_r = arccos(r_b / r) [rad]."""
        return np.arccos(np.minimum(self.base_radius / np.asarray(radius), 1.0))

    def half_angle(self, radius: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """gamma(r) [rad], half the angle that the tooth fills on the circle of that radius:
        (pi + 4 x tan(alpha)) / (2 z) + inv(alpha) - inv(alpha_r)."""
        return self._half_angle_at_base - involute(self.pressure_angle_at(radius))

    @cached_property
    def _half_angle_at_base(self) -> float:
        tangent = math.tan(self.pressure_angle)
        return (math.pi + 4 * self.profile_shift * tangent) / (2 * self.teeth) + tangent - self.pressure_angle

    def _thickness(self, radius: float) -> float:
        return 2 * radius * math.sin(float(self.half_angle(radius)))

    @cached_property
    def root_thickness(self) -> float:
        """S_F = 2 r_F sin(gamma(r_F)) [m], the width of the rectangle."""
        return self._thickness(self.involute_start_radius)

    @cached_property
    def tip_thickness(self) -> float:
        """S_k = 2 r_a sin(gamma(r_a)) [m]."""
        return self._thickness(self.tip_radius)

    @cached_property
    def root_line(self) -> float:
        """y0 = sqrt(r_f^2 - (S_F/2)^2) [m], distance of the root line from the axis."""
        return math.sqrt(self.root_radius**2 - (self.root_thickness / 2) ** 2)

    @cached_property
    def height(self) -> float:
        """h [m], height of the tip above the root line."""
        return math.sqrt(self.tip_radius**2 - (self.tip_thickness / 2) ** 2) - self.root_line

    @cached_property
    def rectangle_height(self) -> float:
        """h_r [m], height of the rectangle."""
        return math.sqrt(self.involute_start_radius**2 - (self.root_thickness / 2) ** 2) - self.root_line

    @cached_property
    def apex_height(self) -> float:
        """h_i = (h S_F - h_r S_k) / (S_F - S_k) [m], where the sides of the trapezoid would meet."""
        wide, narrow = self.root_thickness, self.tip_thickness
        return (self.height * wide - self.rectangle_height * narrow) / (wide - narrow)

    def load_height(self, radius: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """h_x = r_x cos(gamma_x) - y0 [m], height of a load on the flank at that radius."""
        return radius * np.cos(self.half_angle(radius)) - self.root_line

    def load_angle(self, radius: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """omega_x = alpha_x - gamma_x [rad], between the load at that radius and the normal to the tooth's axis."""
        return self.pressure_angle_at(radius) - self.half_angle(radius)
