"""Shaft: a massless torsion spring with damping. Vocabulary of drivelines, below ``model``.

Damping switches as torsional-vibration practice has them: a ratio of the local two-disk mode, one ratio for all modes of the
line, a coefficient, or a loss factor turned into a coefficient at a stated frequency.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy

from modelgen.model import Choice, Element, Flange, Param, quantity
from modelgen.model.declarations import FlangeSymbols


class Shaft(Element):
    """A massless shaft between two nodes: torque = stiffness * twist + damping * twist rate, positive when a drives b.

    Equation: u = angle a - angle b, T = k u + c du/dt; the shaft exerts -T on a and +T on b.
    The switch ``damping`` says where c comes from:
    ``per_shaft``: c = 2 zeta sqrt(k J_a J_b / (J_a + J_b)), with the inertias rigidly on the two nodes;
    ``modal``: c = 0 here, and ``damping_ratio`` acts on every elastic mode of the mean-stiffness driveline;
    ``value``: c is given; ``loss_factor``: c = eta k / omega_ref, right at that frequency only.
    """

    a, b = Flange("driving end"), Flange("driven end")
    stiffness = Param("N*m/rad", positive=True, doc="torsional stiffness k")
    damping = Choice("per_shaft", "modal", "value", "loss_factor", doc="where the damping coefficient comes from")
    damping_ratio = Param(default=0.0, nonnegative=True, when={"damping": ("per_shaft", "modal")}, doc="zeta")
    damping_coefficient = Param("N*m*s/rad", nonnegative=True, when={"damping": "value"}, doc="c")
    loss_factor = Param(nonnegative=True, when={"damping": "loss_factor"}, doc="eta")
    reference_frequency = Param("rad/s", positive=True, when={"damping": "loss_factor"}, doc="omega_ref")

    @quantity("rad")
    def twist(self) -> Any:
        """Angle of a less angle of b."""
        return self.a.angle - self.b.angle

    @quantity("rad/s")
    def twist_rate(self) -> Any:
        """Speed of a less speed of b."""
        return self.a.speed - self.b.speed

    @quantity("N*m*s/rad")
    def viscous_coefficient(self) -> Any:
        """Damping coefficient c that the switch gives."""
        if self.damping == "per_shaft":
            reduced = self.a.inertia * self.b.inertia / (self.a.inertia + self.b.inertia)
            return 2 * self.damping_ratio * sympy.sqrt(self.stiffness * reduced)
        if self.damping == "value":
            return self.damping_coefficient
        if self.damping == "loss_factor":
            return self.loss_factor * self.stiffness / self.reference_frequency
        return sympy.Integer(0)

    @quantity("N*m")
    def torque(self) -> Any:
        """Torque that the shaft transmits from a to b."""
        return self.stiffness * self.twist + self.viscous_coefficient * self.twist_rate

    def torques(self) -> Mapping[FlangeSymbols, Any]:
        return {self.a: -self.torque, self.b: self.torque}

    def stored_energy(self) -> Any:
        return self.stiffness * self.twist**2 / 2

    def dissipated_power(self) -> Any:
        return self.viscous_coefficient * self.twist_rate**2

    def modal_damping(self) -> Any:
        return self.damping_ratio if self.damping == "modal" else None
