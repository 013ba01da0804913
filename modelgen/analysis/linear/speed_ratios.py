"""How fast each shaft of a driveline turns per turn of the reference shaft; angles are referred to it by that ratio.

Below ``forced`` and the ``angles`` of ``time_domain``.
"""

from __future__ import annotations

from modelgen.lowering import Compiled
from modelgen.solvers.operating_point import OperatingPoint


def referred_ratios(model: Compiled, point: OperatingPoint) -> dict[str, float]:
    """Speed of every single-flange inertia per speed of the reference shaft."""
    ratio = model.mean_model["nodes"](point.p).full() @ point.coordinates.ratio
    found = {}
    for instance in model.equations.instances:
        if f"{instance.name}.angle_deviation" in model.outputs:
            node = next(iter(instance.nodes.values()))
            found[instance.name] = float(ratio[node])
    return found
