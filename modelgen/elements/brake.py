"""Coulomb brake: dry friction against ground, or against something that moves at a given speed. Vocabulary, below ``model``.

Sticking is a mode of its own, with the speed held exactly and the torque that this takes as the unknown; nothing is smoothed.
Armstrong-Helouvry, Dupont, Canudas de Wit, A survey of models ... for the control of machines with friction, Automatica 30
(1994), the classical model; Brogliato, Nonsmooth Mechanics, 3rd ed., ch. 5.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import sympy

from modelgen.errors import ModelError
from modelgen.model import Derived, Element, Flange, Guard, Modes, Multiplier, Param, quantity
from modelgen.model.declarations import FlangeSymbols


def checked_torques(sliding_torque: float, holding_torque: float) -> tuple[float, ...]:
    """Nothing, for torques that allow a brake to stick where it has come to rest. Raises ModelError for others."""
    if holding_torque < sliding_torque:
        found = f"holding_torque {holding_torque:g} N*m is below sliding_torque {sliding_torque:g} N*m"
        raise ModelError("brake", found, "what breaks away must be able to slip: hold at least what slides")
    return ()


class Brake(Element):
    """Dry friction between a node and a side that turns at ``other_speed``, which is ground unless it is given.

    With the slip v = speed - other_speed the torque on the node is -T: T = sliding_torque where the node slips forward (v > 0),
    -sliding_torque backward, and while it sticks whatever keeps v at zero, up to holding_torque either way. Beyond that it
    breaks away. ``smallest_slip`` tells slip from rounding: a node sticks when v has passed zero by as much, and v is then set
    to zero; it moves the instants of sticking by smallest_slip per acceleration.
    """

    flange = Flange()
    sliding_torque = Param("N*m", nonnegative=True, doc="torque while it slips")
    holding_torque = Param("N*m", nonnegative=True, doc="largest torque while it sticks, not below the sliding torque")
    other_speed = Param("rad/s", default=0.0, doc="speed of the other side")
    smallest_slip = Param("rad/s", default=1e-11, positive=True, doc="slip that is taken for rest")
    check = Derived("N*m", checked_torques, of=("sliding_torque", "holding_torque"), count=lambda self: 0)
    contact = Modes("stick", "forward", "backward", continuous=False, doc="whether and which way it slips")
    friction = Multiplier("N*m", doc="torque that keeps it from slipping")

    @quantity("rad/s")
    def slip(self) -> Any:
        """Speed of the node over that of the other side."""
        return self.flange.speed - self.other_speed

    @quantity("N*m")
    def torque(self) -> Any:
        """Torque that the node passes to the other side."""
        contact = self.contact
        return self.sliding_torque * (contact.forward - contact.backward) + contact.stick * self.friction

    def torques(self) -> Mapping[FlangeSymbols, Any]:
        return {self.flange: -self.torque}

    def regions(self) -> Mapping[sympy.Symbol, Any]:
        return {self.contact.forward: self.slip - self.smallest_slip, self.contact.backward: -self.slip - self.smallest_slip}

    def holds(self) -> Mapping[sympy.Symbol, tuple[Any, sympy.Symbol]]:
        return {self.contact.stick: (self.slip, self.friction)}

    def guards(self) -> Iterable[Guard]:
        stick, forward, backward = self.contact
        at_rest = {self.flange.speed: self.other_speed}
        # A run may start slipping, and a blow elsewhere can tear the node away: what sticks must not be moving.
        yield Guard("moved_forward", self.slip - 2 * self.smallest_slip, +1, stick, forward)
        yield Guard("moved_backward", self.slip + 2 * self.smallest_slip, -1, stick, backward)
        yield Guard("break_forward", self.friction - self.holding_torque, +1, stick, forward, reset=at_rest)
        yield Guard("break_backward", self.friction + self.holding_torque, -1, stick, backward, reset=at_rest)
        yield Guard("stick_forward", self.slip + self.smallest_slip, -1, forward, stick, reset=at_rest)
        yield Guard("stick_backward", self.slip - self.smallest_slip, +1, backward, stick, reset=at_rest)

    def dissipated_power(self) -> Any:
        return self.torque * self.slip

    def supplied_power(self) -> Any:
        return -self.torque * self.other_speed
