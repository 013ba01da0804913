"""Laws that depend on the angle of a shaft, averaged over its turns, for the questions that see the driveline at rest.

Part of ``lower``, for ``mean_model``. At an operating speed the shafts turn on and on; what is linear about the mean motion sees
the mean of a law over its own angle, as that of a stiffness k (1 + e cos 2 phi), and not its value at the angle zero. Where an
element sees two shafts of different speed, both are turned by their speeds, over twelve turns of the first.
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from modelgen.equations.records import Equations, Instance
from modelgen.lowering.arguments import Arguments
from modelgen.lowering.fixed import Fixed

SAMPLES = 48  # of a turn: exact for laws with fewer harmonics
TURNS = 12  # where an element sees shafts of different speeds


def turned_elements(equations: Equations) -> tuple[str, ...]:
    """Elements whose laws see an angle that runs on in the mean."""
    return tuple(instance.name for instance in equations.instances if _turning(equations, instance))


def averaged_words(names: tuple[str, ...]) -> str:
    """What a linear answer says of elements whose laws it has averaged; nothing without any."""
    return f"{', '.join(names)}: the law depends on the angle of a shaft, and is averaged over its turns here" if names else ""


def mean_over_turns(
    fixed: Fixed, instance: Instance, given: Arguments, part: Callable[[ca.SX], ca.SX] = lambda each: each
) -> list[ca.SX]:
    """What the state stage of an instance gives, or a ``part`` of it, averaged over the turns of the shafts that its laws see."""
    block, template = fixed.block(instance), fixed.equations.templates[instance.template]
    flanges = _turning(fixed.equations, instance)
    if not flanges:
        return [part(each) for each in block.state(*given.all)]
    speeds = {flange: fixed.at_node(instance.nodes[flange], fixed.ratios) for flange in flanges}
    turns = 1 if len({instance.nodes[flange] for flange in flanges}) == 1 else TURNS
    first = 2 * len(template.relatives)
    *before, motion = given.seen
    total: list[ca.SX] = []
    count = SAMPLES * turns
    for sample in range(count):
        angle = 2 * ca.pi * turns * sample / count
        moved = ca.SX(motion)
        for place, flange in enumerate(template.flanges):
            if flange in speeds:
                moved[first + 2 * place] += angle * speeds[flange] / speeds[flanges[0]]
        found = [part(each) for each in block.state(*before, moved, given.flags, given.multipliers)]
        total = [a + b for a, b in zip(total, found, strict=True)] if total else found
    return [each / count for each in total]


def sizes_of_torques(fixed: Fixed, arguments: list[Arguments], by_flange: list[ca.SX]) -> ca.SX:
    """Torques on the groups [N*m] that act before any of them cancels, over a turn or among elements: what rounding compares to.

    ``by_flange`` are the torques of every instance, averaged over turns.
    """
    sums = [ca.SX(0)] * len(fixed.equations.groups)
    for instance, given, torque in zip(fixed.equations.instances, arguments, by_flange, strict=True):
        turned = _turning(fixed.equations, instance)
        size = mean_over_turns(fixed, instance, given, ca.fabs)[1] if turned else ca.fabs(torque)
        flanges = fixed.equations.templates[instance.template].flanges
        for flange, each in zip(flanges, ca.vertsplit(size) if flanges else [], strict=True):
            for group, c in fixed.node_rows[instance.nodes[flange]].items():
                sums[group] += ca.fabs(c) * each
    return ca.vertcat(*sums)


def angles_seen_at_rest(equations: Equations) -> bool:
    """Whether a law sees the angle of a shaft that does not turn in the mean, which it then holds."""
    for instance in equations.instances:
        if set(equations.templates[instance.template].absolute_angles) - set(_turning(equations, instance)):
            return True
    return False


def _turning(equations: Equations, instance: Instance) -> tuple[str, ...]:
    """Flanges of an instance whose angle a law sees, and which turn in the mean."""
    if equations.speed is None:
        return ()
    seen = equations.templates[instance.template].absolute_angles
    return tuple(flange for flange in seen if equations.nodes[instance.nodes[flange]].over(equations.mean_speeds) != 0)
