"""How fast each shaft of a driveline turns per turn of the reference shaft; angles are referred to it by that ratio.

Below ``forced`` and the ``angles`` of ``time_domain``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modelgen.lowering import Compiled
from modelgen.solvers.operating_point import OperatingPoint


def referred_ratios(model: Compiled, point: OperatingPoint) -> dict[str, float]:
    """Speed of every single-flange inertia per speed of the reference shaft."""
    ratio = model.mean_model.nodes_at(point.p) @ point.coordinates.ratio
    found = {}
    for instance in model.equations.instances:
        if f"{instance.name}.angle_deviation" in model.outputs:
            node = next(iter(instance.nodes.values()))
            found[instance.name] = float(ratio[node])
    return found


def gears_between_speeds(model: Compiled, p: NDArray[np.float64]) -> list[str]:
    """Elements that join shafts of different speed or sense."""
    eq = model.equations
    ratio = model.mean_model.nodes_at(p) @ model.mean_model.ratios_at(p).ratio
    found = []
    for instance in eq.instances:
        template = eq.templates[instance.template]
        turning = {round(float(ratio[node]), 12) for node in instance.nodes.values()}
        if len(instance.nodes) > 1 and (template.sense < 0 or len(turning) > 1):
            found.append(instance.name)
    return found
