"""Tooth and mesh stiffness of steel gears by ISO 6336-1, method B: the yardstick beside Eq. 1-8.

Follows ``mesh``. Results are per face width in N/m^2 [N/(m m)]; the standard's N/(mm um) is 1e9 of them. They hold in the
transverse plane, for spur and helical gears.
Source: ISO 6336-1:2006, clause 9, formulas (80) to (92); the 2019 edition has the same formulas as (82) to (94).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from modelgen.errors import CaseError
from modelgen.gears.bounds import bounded
from modelgen.gears.geometry import Gear
from modelgen.gears.mesh import GearMesh

_STEEL = 206e9  # Pa
_UNIT = 1e9  # N/(mm um) in N/m^2
_SOLID_DISC_MEASURED = 0.8  # C_M (83): measured teeth against the theory for solid discs


@dataclass(frozen=True)
class Iso6336Stiffness:
    """All per face width [N/m^2].

    ``theoretical``: c'_th of one pair (81). ``single``: c' of one pair, the largest value over the path of contact (80).
    ``mesh``: c_gamma_alpha, the mean over the base pitch (91). ``mesh_across``: c_gamma_beta for misalignment (92).
    """

    theoretical: float
    single: float
    mesh: float
    mesh_across: float


def iso6336_stiffness(mesh: GearMesh, blank_factor: float = 1.0, line_load: float | None = None) -> Iso6336Stiffness:
    """Method B. ``blank_factor`` is C_R (1 for solid discs), ``line_load`` F_t K_A / b [N/m] where it is below 100 N/mm.

    Good for eps_alpha >= 1.2 (below, spur gears may have up to 10 % less). Raises CaseError outside the standard's range of
    profile shifts: x_pinion >= x_wheel and -0.5 <= x_1 + x_2 <= 2.

    >>> stiffness = iso6336_stiffness(GearMesh(Gear(26, 0.007), Gear(46, 0.007), face_width=0.110))
    >>> print(f"c'_th {stiffness.theoretical / 1e9:.2f}, c_gamma {stiffness.mesh / 1e9:.2f} N/(mm um)")
    c'_th 17.00, c_gamma 20.03 N/(mm um)
    """
    pinion, wheel = sorted((mesh.gear_1, mesh.gear_2), key=lambda gear: (gear.teeth, -gear.profile_shift))
    where = f"ISO 6336-1 method B of {pinion.teeth}/{wheel.teeth} teeth"
    x1, x2 = pinion.profile_shift, wheel.profile_shift
    if not (x1 >= x2 and -0.5 <= x1 + x2 <= 2):
        raise CaseError(
            where,
            f"profile shifts {x1:g} (pinion) and {x2:g} (wheel) are outside the standard's range",
            "it asks for pinion >= wheel and a sum between -0.5 and 2",
        )
    bounded(blank_factor, "blank_factor", where, above=0, at_most=1.2)
    flexibility = (  # q' (82), mm um/N
        0.04723
        + 0.15551 / pinion.virtual_teeth
        + 0.25791 / wheel.virtual_teeth
        - 0.00635 * x1
        - 0.11654 * x1 / pinion.virtual_teeth
        - 0.00193 * x2
        - 0.24188 * x2 / wheel.virtual_teeth
        + 0.00529 * x1**2
        + 0.00182 * x2**2
    )
    theoretical = _UNIT / flexibility
    rack_factor = (_basic_rack_factor(pinion) + _basic_rack_factor(wheel)) / 2  # (87)
    single = theoretical * _SOLID_DISC_MEASURED * blank_factor * rack_factor * math.cos(pinion.helix_angle)  # (80)
    single *= mesh.young_modulus / _STEEL  # (88)
    if line_load is not None:
        single *= min(bounded(line_load, "line_load", where, "N/m", above=0) / 100e3, 1.0) ** 0.25  # (90)
    mean = single * (0.75 * mesh.transverse_contact_ratio + 0.25)  # (91)
    return Iso6336Stiffness(theoretical, single, mean, 0.85 * mean)  # (92)


def gear_blank_factor(web_thickness: float, face_width: float, rim_thickness: float, module: float) -> float:
    """C_R = 1 + ln(b_s/b) / (5 exp(s_R/(5 m_n))) for a wheel with web and rim (85); lengths in one unit.

    b_s/b counts within 0.2 ... 1.2 and s_R/m_n from 1 up, as the standard says.

    >>> gear_blank_factor(web_thickness=0.1, face_width=0.1, rim_thickness=0.02, module=0.005)
    1.0
    """
    where = "gear blank"
    web = bounded(web_thickness, "web_thickness", where, above=0) / bounded(face_width, "face_width", where, above=0)
    rim = bounded(rim_thickness, "rim_thickness", where, above=0) / bounded(module, "module", where, above=0)
    return 1 + math.log(min(max(web, 0.2), 1.2)) / (5 * math.exp(max(rim, 1.0) / 5))


def _basic_rack_factor(gear: Gear) -> float:
    """C_B (86), from the dedendum h_fP/m_n and the pressure angle of the rack."""
    dedendum = gear.addendum + gear.clearance
    return (1 + 0.5 * (1.2 - dedendum)) * (1 - 0.02 * (20 - math.degrees(gear.pressure_angle)))
