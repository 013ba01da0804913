"""Spring and damper to ground. Vocabulary of drivelines, below ``model``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from modelgen.model import Element, Flange, Param, quantity
from modelgen.model.declarations import FlangeSymbols


class GroundSpring(Element):
    """A torsion spring from a node to ground: torque on the node = -stiffness * angle - damping * speed.

    It sees an absolute angle, so a driveline that has one does not rotate: it has no rigid mode.
    """

    flange = Flange()
    stiffness = Param("N*m/rad", positive=True, doc="torsional stiffness k")
    damping = Param("N*m*s/rad", default=0.0, nonnegative=True, doc="damping coefficient c")

    @quantity("rad")
    def twist(self) -> Any:
        """Angle of the node against ground."""
        return self.flange.angle

    @quantity("N*m")
    def torque(self) -> Any:
        """Torque that the spring passes to ground."""
        return self.stiffness * self.twist + self.damping * self.flange.speed

    def torques(self) -> Mapping[FlangeSymbols, Any]:
        return {self.flange: -self.torque}

    def stored_energy(self) -> Any:
        return self.stiffness * self.twist**2 / 2

    def dissipated_power(self) -> Any:
        return self.damping * self.flange.speed**2


class GroundDamper(Element):
    """A viscous damper from a node to ground: torque on the node = -damping * speed.

    It sees the absolute speed: at an operating speed its drag is a mean torque that the drive must supply.
    """

    flange = Flange()
    damping = Param("N*m*s/rad", nonnegative=True, doc="damping coefficient c")

    @quantity("N*m")
    def torque(self) -> Any:
        """Torque that the damper passes to ground."""
        return self.damping * self.flange.speed

    def torques(self) -> Mapping[FlangeSymbols, Any]:
        return {self.flange: -self.torque}

    def dissipated_power(self) -> Any:
        return self.damping * self.flange.speed**2
