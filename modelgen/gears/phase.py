"""Mesh phase: where in its base pitch a mesh stands, and how two meshes on one gear stand to each other.

Follows ``geometry``. Phases count in base pitches and grow with forward rotation.
Source: R. G. Parker, J. Lin, Mesh phasing relationships in planetary and epicyclic gears, J. Mech. Design 126 (2004) 365-370.
"""

from __future__ import annotations

import math

from modelgen.gears.bounds import bounded, whole
from modelgen.gears.geometry import Gear


def mesh_phase(teeth: int, rotation: float, phase_at_zero: float = 0.0) -> float:
    """Phase in [0, 1) of a mesh after a gear of so many teeth has turned by ``rotation`` [rad].

    >>> mesh_phase(26, 2 * math.pi / 104)
    0.25
    """
    where = "mesh phase"
    turns = bounded(rotation, "rotation", where, "rad") / (2 * math.pi)
    return _wrapped(bounded(phase_at_zero, "phase_at_zero", where) + whole(teeth, "teeth", where, 1, 1_000_000) * turns)


def phase_between(
    gear: Gear, angle: float, pitch_radius_1: float | None = None, pitch_radius_2: float | None = None, *, idler: bool = False
) -> float:
    """Phase in [0, 1) of a second mesh on the gear, when its first mesh touches at the pitch point (both phases 0 there).

    ``angle`` [rad] leads from the first pitch point to the second in the gear's sense of rotation. The pitch radii are the
    working ones [m], by default the reference radius. Without ``idler`` the gear drives at both (a sun with its planets):
    its flanks pass the second pitch point z angle/(2 pi) base pitches later, the radii shifting it by the involute between
    them. As ``idler`` it is driven at the first and drives at the second, with the other flank of the tooth.

    >>> round(phase_between(Gear(24, 0.003), 2 * math.pi / 3), 12)  # 24 teeth, three planets: all in phase
    0.0
    >>> round(phase_between(Gear(25, 0.003), 2 * math.pi / 3), 12)
    0.666666666667
    """
    where = f"mesh phase of {gear.teeth} teeth"
    bounded(angle, "angle", where, "rad")
    first, second = (
        gear.half_angle(
            gear.reference_radius
            if radius is None
            else bounded(radius, "pitch radius", where, "m", at_least=gear.base_radius, at_most=gear.tip_radius)
        )
        for radius in (pitch_radius_1, pitch_radius_2)
    )
    # Angles of the two flanks, from the middle of the tooth, forward: the driving flank leads, the driven one trails.
    rotation_to_second = angle + (-first if idler else first) - second
    return _wrapped(-gear.teeth * rotation_to_second / (2 * math.pi))


def _wrapped(phase: float) -> float:
    """The phase in [0, 1), also where the remainder of a tiny negative number rounds to 1."""
    phase %= 1.0
    return phase if phase < 1.0 else 0.0
