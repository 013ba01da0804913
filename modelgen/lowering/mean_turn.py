"""Laws that depend on the angle of a shaft, averaged over its turns, for the questions that see the driveline at rest.

Part of ``lower``, for ``mean_model``. At an operating speed the shafts turn on and on; what is linear about the mean motion sees
the mean of a law over its own angle, as that of a stiffness k (1 + e cos 2 phi), and not its value at the angle zero. Where an
element sees two shafts of different speed, both are turned by their speeds, over twelve turns of the first.
"""

from __future__ import annotations

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


def mean_over_turns(fixed: Fixed, instance: Instance, given: Arguments) -> list[ca.SX]:
    """What the state stage of an instance gives, averaged over the turns of the shafts whose angles its laws see."""
    block, template = fixed.block(instance), fixed.equations.templates[instance.template]
    flanges = _turning(fixed.equations, instance)
    if not flanges:
        return list(block.state(*given.all))
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
        found = block.state(*before, moved, given.flags, given.multipliers)
        total = [a + b for a, b in zip(total, found, strict=True)] if total else list(found)
    return [each / count for each in total]


def _turning(equations: Equations, instance: Instance) -> tuple[str, ...]:
    """Flanges of an instance whose angle a law sees, and which turn in the mean."""
    if equations.speed is None:
        return ()
    seen = equations.templates[instance.template].absolute_angles
    return tuple(flange for flange in seen if equations.nodes[instance.nodes[flange]].over(equations.mean_speeds) != 0)
