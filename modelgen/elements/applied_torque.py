"""Applied torques: harmonic rows on a base frequency, and a step. Vocabulary of drivelines, below ``model``.

The rows are those of the paper's Eq. 22: a with sine, b with cosine, on a named base frequency.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy

from modelgen.model import Choice, Clock, Element, Flange, Orders, Param, harmonic_rows, quantity
from modelgen.model.declarations import TIME, FlangeSymbols


class HarmonicTorque(Element):
    """A periodic torque on a node: T = scale * (mean + sum_h a_h sin(h (w t + phase)) + b_h cos(h (w t + phase))).

    w is the base frequency; ``sine`` and ``cosine`` hold a_h and b_h for the ``orders`` h (by default 1, 2, ..., n). ``phase`` is
    an angle of the base. Without rows it is a constant torque and needs no base.
    """

    balanced_by = "scale"

    flange = Flange()
    base = Clock(doc="the driveline's base frequency that the rows run on")
    mean = Param("N*m", default=0.0, doc="mean torque")
    sine = Param("N*m", default=(), series=True, doc="a_h")
    cosine = Param("N*m", default=(), series=True, doc="b_h")
    orders = Orders(doc="harmonics h of the base")
    phase = Param("rad", default=0.0, doc="angle by which the rows lead, in radians of the base")
    scale = Param(default=1.0, doc="factor on the whole torque; balance() sets it")

    @quantity("N*m", mean=lambda self: self.scale * self.mean)
    def torque(self) -> Any:
        """Torque on the node."""
        angle, terms = self.base.angle, [self.mean]
        for order, b, a in harmonic_rows(self.where, self.orders, self.cosine, self.sine):
            # Turned by the phase here, so that sin(h w t) and cos(h w t) are shared by every torque on the same base.
            turn_cos, turn_sin = sympy.cos(order * self.phase), sympy.sin(order * self.phase)
            terms.append((a * turn_cos - b * turn_sin) * sympy.sin(order * angle))
            terms.append((a * turn_sin + b * turn_cos) * sympy.cos(order * angle))
        return self.scale * sympy.Add(*terms)  # at once: a sum that grows term by term takes quadratic time

    def torques(self) -> Mapping[FlangeSymbols, Any]:
        return {self.flange: self.torque}

    def supplied_power(self) -> Any:
        return self.torque * self.flange.speed


class SteppedTorque(Element):
    """A torque on a node that goes from ``before`` to ``after`` at a given time, at once or along a straight ramp.

    The static start sees the torque before the step.
    """

    flange = Flange()
    shape = Choice("step", "ramp", doc="at once, or in a straight line over duration")
    before = Param("N*m", default=0.0, doc="torque before the step")
    after = Param("N*m", doc="torque after it")
    at = Param("s", default=0.0, doc="time of the step, or of the ramp's beginning")
    duration = Param("s", positive=True, when={"shape": "ramp"}, doc="length of the ramp")

    @quantity("N*m", mean=lambda self: self.before)
    def torque(self) -> Any:
        """Torque on the node."""
        if self.shape == "step":
            return sympy.Piecewise((self.before, self.at > TIME), (self.after, True))
        share = sympy.Min(1, sympy.Max(0, (TIME - self.at) / self.duration))
        return self.before + (self.after - self.before) * share

    def torques(self) -> Mapping[FlangeSymbols, Any]:
        return {self.flange: self.torque}

    def supplied_power(self) -> Any:
        return self.torque * self.flange.speed
