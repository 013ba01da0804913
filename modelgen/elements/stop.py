"""Rotational stops: hard, with a coefficient of restitution, or elastic with a damper. Vocabulary of drivelines, below ``model``.

The hard stop is Newton's impact law: an impulse that turns the relative speed round, times the restitution, and keeps momentum
(Brogliato, Nonsmooth Mechanics, 3rd ed., ch. 4; Goldsmith, Impact, ch. 1). The elastic one is a spring with clearance.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import sympy

from modelgen.model import Element, Flange, Guard, Modes, Param, quantity
from modelgen.model.declarations import FlangeSymbols


class HardStop(Element):
    """Two stops that limit the angle between two nodes: u = angle a - angle b stays between -clearance and +clearance.

    At a stop du/dt becomes -restitution du/dt at once. Between stops it transmits nothing. A run must begin between them. It
    cannot carry a torque at rest: a steady push against it ends in ever faster bounces, which a run reports by that name.
    """

    a, b = Flange("driving end"), Flange("driven end")
    clearance = Param("rad", positive=True, doc="largest angle either way")
    restitution = Param(default=0.5, least=0.0, largest=1.0, doc="speed after an impact per speed before")

    @quantity("rad")
    def twist(self) -> Any:
        """Angle of a less angle of b."""
        return self.a.angle - self.b.angle

    @quantity("rad/s")
    def twist_rate(self) -> Any:
        """Speed of a less speed of b."""
        return self.a.speed - self.b.speed

    def guards(self) -> Iterable[Guard]:
        thrown_back = {self.a.speed - self.b.speed: -self.restitution * self.twist_rate}
        yield Guard("upper", self.twist - self.clearance, +1, reset=thrown_back, barrier=True)
        yield Guard("lower", self.twist + self.clearance, -1, reset=thrown_back, barrier=True)


class ElasticStop(Element):
    """Two elastic stops with clearance between two nodes: torque = k (u - clearance) + c du/dt beyond it, and likewise behind.

    u = angle a - angle b. Between the stops it transmits nothing. The damper acts while the stop is touched, and begins and ends
    with a jump where c is not zero; it does not keep the stops from pulling for the moment in which they part.
    """

    a, b = Flange("driving end"), Flange("driven end")
    clearance = Param("rad", nonnegative=True, doc="angle either way without contact")
    stiffness = Param("N*m/rad", positive=True, doc="stiffness k of a stop")
    damping_coefficient = Param("N*m*s/rad", default=0.0, nonnegative=True, doc="damping coefficient c of a stop")
    side = Modes("free", "upper", "lower", continuous=False, doc="which stop is touched")

    @quantity("rad")
    def twist(self) -> Any:
        """Angle of a less angle of b."""
        return self.a.angle - self.b.angle

    @quantity("rad/s")
    def twist_rate(self) -> Any:
        """Speed of a less speed of b."""
        return self.a.speed - self.b.speed

    @quantity("rad")
    def penetration(self) -> Any:
        """How far a stop is pressed in."""
        return self.side.upper * (self.twist - self.clearance) + self.side.lower * (self.twist + self.clearance)

    @quantity("N*m")
    def torque(self) -> Any:
        """Torque that the stops transmit from a to b."""
        touched = self.side.upper + self.side.lower
        return self.stiffness * self.penetration + touched * self.damping_coefficient * self.twist_rate

    def regions(self) -> Mapping[sympy.Symbol, Any]:
        return {self.side.upper: self.twist - self.clearance, self.side.lower: -self.twist - self.clearance}

    def torques(self) -> Mapping[FlangeSymbols, Any]:
        return {self.a: -self.torque, self.b: self.torque}

    def stored_energy(self) -> Any:
        return self.stiffness * self.penetration**2 / 2

    def dissipated_power(self) -> Any:
        return (self.torque - self.stiffness * self.penetration) * self.twist_rate
