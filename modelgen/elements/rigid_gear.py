"""Rigid gear: two wheels without tooth compliance. Vocabulary of drivelines, below ``model``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from modelgen.model import Choice, Element, Flange, Param
from modelgen.model.declarations import FlangeSymbols


class RigidGear(Element):
    """An ideal gear pair: teeth_a * angle a = teeth_b * angle b, eliminated exactly.

    Both angles count forward, each in its own shaft's sense. An inertia J on b is seen on a as J (teeth_a / teeth_b)^2.
    ``mesh="internal"`` is for a ring gear, whose shafts turn in the same sense in space.
    """

    a, b = Flange("driving wheel"), Flange("driven wheel")
    mesh = Choice("external", "internal", doc="whether the shafts turn in opposite senses in space")
    teeth_a = Param(positive=True, integer=True, doc="teeth of the wheel on a")
    teeth_b = Param(positive=True, integer=True, doc="teeth of the wheel on b")

    @property
    def sense(self) -> int:  # type: ignore[override]  # the class default is a constant, here it follows the switch
        """-1 for an external pair."""
        return -1 if self.mesh == "external" else 1

    def constraints(self) -> Iterable[Any]:
        return [self.teeth_a * self.a.angle - self.teeth_b * self.b.angle]

    def torques(self) -> Mapping[FlangeSymbols, Any]:
        return {}
