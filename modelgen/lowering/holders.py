"""What holds a speed, as statics sees it: which slip it keeps at zero, with which torques, and up to which limit.

Part of ``lower``, beside ``mean_model``. An element holds a speed by a multiplier (``Multiplier``, ``holds``). Its torques are
linear in it, and it lets go where a guard that leaves the holding mode passes zero: these give the limits.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from modelgen.equations.records import Equations, Template
from modelgen.lowering.arguments import Arguments
from modelgen.lowering.fixed import Fixed
from modelgen.lowering.forces import balance_of, forces_at
from modelgen.lowering.motion import Motion

UNLIMITED = 1e300


@dataclass(frozen=True, eq=False)
class Holders:
    """``slip`` [rad/s] of every holder and ``limits`` (lower, upper) of its multiplier; their derivatives.

    ``by_speed`` (holders, groups) is the slip per speed of a group, ``by_multiplier`` (groups, holders) the torque on a group per
    multiplier.
    """

    slip: ca.SX
    by_speed: ca.SX
    by_multiplier: ca.SX
    lower: ca.SX
    upper: ca.SX


def holder_names(equations: Equations) -> tuple[str, ...]:
    """The element of every held speed, in the order of ``Holders``."""
    return tuple(each.name for each in equations.instances for _ in equations.templates[each.template].holds)


def holders_of(fixed: Fixed, motion: Motion, arguments: list[Arguments], speeds: ca.SX) -> Holders:
    """The holders of a driveline in the modes in which each of them holds."""
    if not holder_names(fixed.equations):
        groups, none = speeds.numel(), ca.SX(0, 1)
        return Holders(none, ca.SX(0, groups), ca.SX(groups, 0), none, none)
    multipliers, holding = [], []
    for instance, given in zip(fixed.equations.instances, arguments, strict=True):
        template, slots = fixed.equations.templates[instance.template], fixed.block(instance).slots
        symbols = ca.SX.sym("multiplier", len(template.multipliers))
        held = {hold.flag for hold in template.holds}
        variables = {flag for modes in template.modes if held & set(modes.symbols) for flag in modes.symbols}
        flags = [
            ca.SX(float(flag in held)) if flag in variables else given.flags[row] for row, flag in enumerate(slots.flags)
        ]
        multipliers.append(symbols)
        holding.append(Arguments(given.seen, ca.vertcat(*flags), symbols))
    unknown = ca.vertcat(*multipliers)
    torque = balance_of(fixed, forces_at(fixed, holding, motion)).torque
    slips, chosen, lower, upper = [], [], [], []
    for instance, given, symbols in zip(fixed.equations.instances, holding, multipliers, strict=True):
        template = fixed.equations.templates[instance.template]
        if not template.holds:
            continue
        guards, _, _, held_speeds = fixed.block(instance).events(*given.all)
        for row, hold in enumerate(template.holds):
            multiplier = symbols[template.multipliers.index(hold.multiplier)]
            slips.append(held_speeds[row])
            chosen.append(multiplier)
            low, high = _limits(template, hold.flag.name, guards, multiplier, symbols)
            lower.append(low)
            upper.append(high)
    slip = ca.vertcat(*slips)
    nothing = ca.SX.zeros(unknown.numel())
    by_multiplier = ca.jacobian(torque, ca.vertcat(*chosen)) if chosen else ca.SX(torque.numel(), 0)
    return Holders(
        slip=ca.substitute(slip, unknown, nothing),
        by_speed=ca.substitute(ca.jacobian(slip, speeds), unknown, nothing),
        by_multiplier=ca.substitute(by_multiplier, unknown, nothing),
        lower=ca.substitute(ca.vertcat(*lower), unknown, nothing),
        upper=ca.substitute(ca.vertcat(*upper), unknown, nothing),
    )


def _limits(template: Template, flag: str, guards: ca.SX, multiplier: ca.SX, symbols: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Where the guards that leave the holding mode pass zero, as values of the multiplier."""
    lower, upper = ca.SX(-UNLIMITED), ca.SX(UNLIMITED)
    mode = next(
        (modes.name, value)
        for modes in template.modes
        for value, symbol in zip(modes.values, modes.symbols, strict=True)
        if symbol.name == flag
    )
    for row, guard in enumerate(template.guards):
        if (guard.variable, guard.leave) != mode:
            continue
        if not ca.depends_on(guards[row], multiplier):
            continue
        slope = ca.jacobian(guards[row], multiplier)
        at_rest = ca.substitute(guards[row], symbols, ca.SX.zeros(symbols.numel()))
        place = -at_rest / slope
        for direction in (+1, -1):
            if guard.direction in (direction, 0):  # it fires where its expression passes zero in this direction
                upper = ca.if_else(slope * direction > 0, ca.fmin(upper, place), upper)
                lower = ca.if_else(slope * direction < 0, ca.fmax(lower, place), lower)
    return lower, upper
