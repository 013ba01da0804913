"""Inertia: a rigid disk. Vocabulary of drivelines, below ``model``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from modelgen.model import Element, Flange, Param
from modelgen.model.declarations import FlangeSymbols


class Inertia(Element):
    """A rigid disk that turns with its node.

    Equation: J d(omega)/dt = sum of the torques on the node. Several inertias on one node add up.
    """

    flange = Flange()
    inertia = Param("kg*m^2", positive=True, doc="moment of inertia")

    def inertias(self) -> Mapping[FlangeSymbols, Any]:
        return {self.flange: self.inertia}
