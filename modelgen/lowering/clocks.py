"""Time in the laws: clock angles, the harmonics of the base frequencies, and what each law makes of them.

Part of ``lower``, on ``fixed``. A clock is a base frequency; its angle stays a symbol of its own, so that the mean model can
average over it, and becomes frequency times t only in the right-hand side. Multiples of an angle come from the addition theorems
of sine and cosine: one sine and one cosine per clock, whatever the number of orders.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from modelgen.equations.records import Instance
from modelgen.lowering.fixed import Fixed

Harmonics = dict[tuple[int, int, str], ca.SX]
"""By clock, order and wave ("sin" or "cos")."""


@dataclass(frozen=True, eq=False)
class Clocks:
    """Time and what follows it; ``values`` and ``timed`` have one column per instance.

    ``running_angles`` [rad] are what the clock angles are at t: frequency times t. ``values`` are what a block takes as clocks:
    t [s], angle [rad] and frequency [rad/s] of each of its clocks, its harmonics. ``timed`` are its quantities that depend on
    time but not on the state.
    """

    time: ca.SX
    angles: ca.SX
    running_angles: ca.SX
    values: list[ca.SX]
    timed: list[ca.SX]

    def running(self, expression: ca.SX) -> ca.SX:
        """The expression with the running angles in place of the clock angles."""
        return ca.substitute(expression, self.angles, self.running_angles) if self.angles.numel() else expression


def clocks_of(fixed: Fixed) -> Clocks:
    """The clocks of a driveline, as new symbols t and clock angles with everything built on them."""
    eq = fixed.equations
    time, angles = ca.SX.sym("t"), ca.SX.sym("clock", len(eq.clocks))
    harmonics = _harmonics(fixed, angles)
    values = [_values(fixed, instance, time, angles, harmonics) for instance in eq.instances]
    timed = [
        fixed.block(instance).timed(*given, column)
        for instance, given, column in zip(eq.instances, fixed.given, values, strict=True)
    ]
    running_angles = ca.vertcat(*(frequency * time for frequency in fixed.frequencies))
    return Clocks(time, angles, running_angles, values, timed)


def _values(fixed: Fixed, instance: Instance, time: ca.SX, angles: ca.SX, harmonics: Harmonics) -> ca.SX:
    template = fixed.equations.templates[instance.template]
    values = [time]
    for name in template.clocks:
        index = instance.clocks.get(name)
        values += [ca.SX(0), ca.SX(0)] if index is None else [angles[index], fixed.frequencies[index]]
    for h in template.harmonics:
        index = instance.clocks.get(h.clock)
        # A clock that stands still is at the angle zero; nothing varies with it (``equations.clocks``).
        values.append(ca.SX(h.wave == "cos") if index is None else harmonics[index, h.order, h.wave])
    return ca.vertcat(*values)


def _harmonics(fixed: Fixed, angles: ca.SX) -> Harmonics:
    """sin and cos of the multiples of each clock that any law asks for, by repeated products of one sine and cosine."""
    wanted: dict[int, set[int]] = {}
    for instance in fixed.equations.instances:
        for h in fixed.equations.templates[instance.template].harmonics:
            if h.clock in instance.clocks:
                wanted.setdefault(instance.clocks[h.clock], set()).add(h.order)
    found: Harmonics = {}
    for clock, orders in wanted.items():
        known = {1: (ca.sin(angles[clock]), ca.cos(angles[clock]))}
        for order in sorted(orders):
            found[clock, order, "sin"], found[clock, order, "cos"] = _multiple(order, known)
    return found


def _multiple(order: int, known: dict[int, tuple[ca.SX, ca.SX]]) -> tuple[ca.SX, ca.SX]:
    """sin and cos of a multiple of an angle from those of its halves: rounding grows with log2(order) products only."""
    if order not in known:
        (s1, c1), (s2, c2) = _multiple(order // 2, known), _multiple(order - order // 2, known)
        known[order] = (s1 * c2 + c1 * s2, c1 * c2 - s1 * s2)
    return known[order]
