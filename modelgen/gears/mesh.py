"""A pair of gears in mesh: path of contact, contact ratios, and stiffness over the base pitch (Eq. 1, 7 and 8).

Follows ``geometry`` and ``deflection``, feeds ``fourier``. Lengths [m], angles [rad], stiffness [N/m] along the transverse line
of action. Phase counts in base pitches; phase 0 is where a tooth pair enters contact (at the first slice if helical).

Gear 1 drives: a pair enters at gear 2's tip circle and leaves at gear 1's. The load point moves along the line of action; its
position s is measured from gear 1's tangent point, so r_x1 = sqrt(r_b1^2 + s^2) and r_x2 = sqrt(r_b2^2 + (a sin(alpha_w) - s)^2).
Source: ISO 21771:2007 for the geometry.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import ModelError
from modelgen.gears.bounds import bounded
from modelgen.gears.deflection import contact_deflection, tooth_deflection
from modelgen.gears.geometry import Gear
from modelgen.gears.helical import IN_STEP, overlap_average, overlap_breaks
from modelgen.gears.involute import angle_of_involute, involute


@dataclass(frozen=True)
class GearMesh:
    """Two external gears at their backlash-free center distance.

    Arguments: ``gear_1`` (driver) and ``gear_2`` of equal module, pressure angle and helix angle, common ``face_width`` [m],
    ``young_modulus`` [Pa] and ``poisson_ratio`` of both, ``shear_factor`` of Eq. 5 (1 as printed, 1.2 Timoshenko).
    Raises ModelError if the gears do not fit, do not reach a contact ratio of 1, or touch beside the involute.

    >>> mesh = GearMesh(Gear(26, 0.007), Gear(46, 0.007), face_width=0.110)
    >>> print(f"{mesh.center_distance:.4f} m, contact ratio {mesh.transverse_contact_ratio:.4f}")
    0.2520 m, contact ratio 1.6804
    """

    gear_1: Gear
    gear_2: Gear
    face_width: float
    young_modulus: float = 206e9
    poisson_ratio: float = 0.3
    shear_factor: float = 1.0

    def __post_init__(self) -> None:
        where = self._where
        for name in ("module", "pressure_angle", "helix_angle"):
            one, two = getattr(self.gear_1, name), getattr(self.gear_2, name)
            if one != two:
                raise ModelError(where, f"the gears differ in {name} ({one} and {two})", "give both the same")
        bounded(self.face_width, "face_width", where, "m", at_least=1e-6, below=10)
        bounded(self.young_modulus, "young_modulus", where, "Pa", at_least=1e6, at_most=1e13)
        bounded(self.poisson_ratio, "poisson_ratio", where, at_least=0, at_most=0.5)
        bounded(self.shear_factor, "shear_factor", where, at_least=0, at_most=10)
        if self._involute_of_working_angle <= 0:
            raise ModelError(
                where,
                f"no backlash-free center distance with profile shifts {self.gear_1.profile_shift:g} and "
                f"{self.gear_2.profile_shift:g}",
                "raise their sum",
            )
        self._refuse_bad_contact(where)

    def _refuse_bad_contact(self, where: str) -> None:
        if self.transverse_contact_ratio < 1:
            raise ModelError(
                where,
                f"contact ratio is {self.transverse_contact_ratio:.4f}, below 1: the teeth lose contact",
                "use more teeth, a larger addendum or smaller profile shifts",
            )
        for own, other in ((self.gear_1, self.gear_2), (self.gear_2, self.gear_1)):
            deepest = self.line_of_action - other.tip_roll
            if deepest < own.involute_start_roll - 1e-9 * own.module:  # beyond rounding
                reach = math.hypot(other.base_radius, self.line_of_action - own.involute_start_roll)
                shortening = math.ceil(1e3 * (other.tip_shortening + (other.tip_radius - reach) / other.module)) / 1e3
                raise ModelError(
                    where,
                    f"the tips of {other.teeth} teeth touch {own.teeth} teeth below the start of the involute (at roll length "
                    f"{deepest:.4g} m, involute from {own.involute_start_roll:.4g} m)",
                    f"give the {other.teeth} teeth a tip_shortening of at least {shortening:.3f}, or use more teeth",
                )
            gap = self.center_distance - own.root_radius - other.tip_radius
            if gap <= 0:
                raise ModelError(
                    where,
                    f"the tips of {other.teeth} teeth strike the root circle of {own.teeth} (clearance {gap:.3g} m)",
                    "raise clearance or tip_shortening",
                )

    @property
    def _where(self) -> str:
        return f"gear mesh {self.gear_1.teeth}/{self.gear_2.teeth}"

    # -- transverse geometry ------------------------------------------------------------------------------------------------

    @property
    def _involute_of_working_angle(self) -> float:
        one, two = self.gear_1, self.gear_2
        shift = 2 * (one.profile_shift + two.profile_shift) * math.tan(one.pressure_angle) / (one.teeth + two.teeth)
        return float(involute(one.transverse_pressure_angle)) + shift

    @cached_property
    def working_pressure_angle(self) -> float:
        """alpha_wt [rad], transverse: inv(alpha_wt) = inv(alpha_t) + 2 (x1 + x2) tan(alpha_n) / (z1 + z2)."""
        return angle_of_involute(self._involute_of_working_angle)

    @property
    def center_distance(self) -> float:
        """a = (r_b1 + r_b2) / cos(alpha_wt) [m]."""
        return (self.gear_1.base_radius + self.gear_2.base_radius) / math.cos(self.working_pressure_angle)

    @property
    def ratio(self) -> float:
        """z2 / z1: speed of gear 1 per speed of gear 2."""
        return self.gear_2.teeth / self.gear_1.teeth

    @property
    def base_pitch(self) -> float:
        """Transverse p_b [m], the period of the mesh along the line of action."""
        return self.gear_1.base_pitch

    @cached_property
    def line_of_action(self) -> float:
        """a sin(alpha_wt) [m], distance of the tangent points of the base circles."""
        return (self.gear_1.base_radius + self.gear_2.base_radius) * math.tan(self.working_pressure_angle)

    @cached_property
    def contact_start(self) -> float:
        """Position [m] where a pair enters: a sin(alpha_wt) - sqrt(r_a2^2 - r_b2^2)."""
        return self.line_of_action - self.gear_2.tip_roll

    @cached_property
    def contact_end(self) -> float:
        """Position [m] where a pair leaves: sqrt(r_a1^2 - r_b1^2)."""
        return self.gear_1.tip_roll

    @cached_property
    def transverse_contact_ratio(self) -> float:
        """eps_alpha, the path of contact in base pitches: on average as many pairs are in contact (in one slice)."""
        return (self.contact_end - self.contact_start) / self.base_pitch

    @property
    def overlap_ratio(self) -> float:
        """eps_beta = b sin(beta) / (pi m_n), the lag of the last slice in base pitches; 0 if spur."""
        return self.face_width * math.sin(self.gear_1.helix_angle) / (math.pi * self.gear_1.module)

    @property
    def total_contact_ratio(self) -> float:
        """eps_gamma = eps_alpha + eps_beta."""
        return self.transverse_contact_ratio + self.overlap_ratio

    @property
    def pitch_phase(self) -> float:
        """Phase at which a pair that entered at phase 0 touches at the pitch point."""
        return (self.gear_1.base_radius * math.tan(self.working_pressure_angle) - self.contact_start) / self.base_pitch

    # -- stiffness ----------------------------------------------------------------------------------------------------------

    @property
    def effective_width(self) -> float:
        """b cos(beta_b) [m]: contact line b/cos(beta_b), times cos(beta_b)^2 from tooth normal to transverse plane."""
        return self.face_width * math.cos(self.gear_1.base_helix_angle)

    def pair_stiffness(self, position: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """F/delta_sum [N/m] of one tooth pair loaded at a position [m] of the path of contact; 0 beside it.

        delta_sum = delta_1 + delta_2 + delta_pv (Eq. 7). Divided by the face width it is K of Eq. 1. For helical gears:
        all slices at the same position.
        """
        position = np.asarray(position, dtype=float)
        inside = (position >= self.contact_start) & (position <= self.contact_end)
        return np.where(inside, self._stiffness_at(np.clip(position, self.contact_start, self.contact_end)), 0.0)

    def _stiffness_at(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        deflection = np.full(position.shape, contact_deflection(self.young_modulus, self.poisson_ratio))
        for gear, roll in ((self.gear_1, position), (self.gear_2, self.line_of_action - position)):
            parts = tooth_deflection(
                gear.tooth, gear.section_radius(roll), self.young_modulus, self.poisson_ratio, self.shear_factor
            )
            deflection = deflection + parts.total
        return self.effective_width / deflection

    def slice_stiffness(self, phase: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Sum over the pairs in contact [N/m] as if all slices were in step: the mesh stiffness of spur gears."""
        ratio = self.transverse_contact_ratio
        travelled = (np.asarray(phase, dtype=float) % 1.0)[..., None] + np.arange(math.floor(ratio) + 1)
        stiffness = self._stiffness_at(self.contact_start + self.base_pitch * np.minimum(travelled, ratio))
        return np.sum(np.where(travelled < ratio, stiffness, 0.0), axis=-1)

    def stiffness(self, phase: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """k_m [N/m] at a phase (in base pitches, any real number; period 1).

        >>> mesh = GearMesh(Gear(26, 0.007), Gear(46, 0.007), face_width=0.110)
        >>> [round(float(mesh.stiffness(phase)) / 1e9, 3) for phase in (0.0, 0.5, 0.7, 1.0)]
        [2.752, 2.799, 1.747, 2.752]
        """
        return overlap_average(self.slice_stiffness, self.slice_breaks, self.overlap_ratio, phase)

    @property
    def slice_breaks(self) -> tuple[float, ...]:
        """Phases where a pair enters (0) and where one leaves (fractional part of eps_alpha)."""
        return 0.0, self.transverse_contact_ratio % 1.0

    @property
    def breaks(self) -> tuple[float, ...]:
        """Phases in [0, 1) between which k_m is smooth."""
        if self.overlap_ratio < IN_STEP:
            return self.slice_breaks
        return overlap_breaks(self.slice_breaks, self.overlap_ratio)
