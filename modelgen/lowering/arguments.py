"""Arguments of the laws: what every instance sees of a motion, and which of its modes hold there.

Part of ``lower``, between ``motion`` and ``forces``. Which mode holds is either given from outside, as flags that a solver with
events keeps, or found by comparison: a mode holds where the expression of its region is zero or positive.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import casadi as ca

from modelgen.equations.mode_records import DiscreteModes
from modelgen.equations.records import Instance, Template
from modelgen.lowering.fixed import Fixed
from modelgen.lowering.motion import Motion


@dataclass(frozen=True, eq=False)
class Arguments:
    """What a block's state stage takes: ``seen`` without the modes, their ``flags``, and the ``multipliers`` of held speeds."""

    seen: tuple[ca.SX, ...]
    flags: ca.SX
    multipliers: ca.SX

    @property
    def all(self) -> tuple[ca.SX, ...]:
        """Everything in the order of the block."""
        return (*self.seen, self.flags, self.multipliers)


def arguments_at(
    fixed: Fixed,
    motion: Motion,
    clocks: list[ca.SX],
    timed: list[ca.SX],
    flags: list[ca.SX] | None = None,
    multipliers: list[ca.SX] | None = None,
) -> list[Arguments]:
    """The arguments of every instance; ``clocks`` and ``timed`` have one column per instance, as in ``Clocks``.

    Without ``flags`` they are found by comparison; without ``multipliers`` these are zero: nothing holds.
    """
    found = []
    for index, (instance, given) in enumerate(zip(fixed.equations.instances, fixed.given, strict=True)):
        template = fixed.equations.templates[instance.template]
        seen = (*given, clocks[index], timed[index], _seen(fixed, instance, motion))
        held = ca.SX.zeros(len(template.multipliers)) if multipliers is None else multipliers[index]
        found.append(Arguments(seen, _compared(fixed, instance, seen) if flags is None else flags[index], held))
    return found


def flags_by_variable(template: Template, flags: ca.SX) -> list[list[ca.SX]]:
    """The flags of an instance, a row for each of its variables."""
    borders = [0, *itertools.accumulate(len(modes.values) for modes in template.modes)]
    return [[flags[row] for row in range(first, last)] for first, last in itertools.pairwise(borders)]


def _seen(fixed: Fixed, instance: Instance, motion: Motion) -> ca.SX:
    """What an instance sees of a motion: its forms and rates, the angles and speeds of its flanges, its own states."""
    values = [value for form in instance.forms for value in (motion.forms[form], motion.form_rates[form])]
    for flange in fixed.equations.templates[instance.template].flanges:
        node = instance.nodes[flange]
        values += [fixed.at_node(node, motion.angles), fixed.at_node(node, motion.speeds)]
    values += [motion.own[state - 2 * fixed.order] for state in instance.states]
    return ca.vertcat(*values)


def _compared(fixed: Fixed, instance: Instance, seen: tuple[ca.SX, ...]) -> ca.SX:
    """Flags by comparison; modes that have no regions stay in the mode of the start."""
    template = fixed.equations.templates[instance.template]
    if not template.modes:
        return ca.SX(0, 1)
    regions = iter(ca.vertsplit(fixed.block(instance).regions(*seen)))
    return ca.vertcat(*(flag for modes in template.modes for flag in _one_hot(modes, [next(regions) for _ in modes.regions])))


def _one_hot(modes: DiscreteModes, regions: list[ca.SX]) -> list[ca.SX]:
    if not regions:
        return [ca.SX(int(value == modes.start)) for value in range(len(modes.values))]
    flags, left = dict.fromkeys(modes.values, ca.SX(0)), ca.SX(1)
    for value, region in zip(modes.regions, regions, strict=True):
        inside = region >= 0
        flags[value] = left * inside
        left = left * (1 - inside)
    flags[modes.values[0]] = left
    return list(flags.values())
