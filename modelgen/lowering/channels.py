"""Output channels: every named quantity at a motion, energies and powers, and the torques through rigid gears.

Part of ``lower``, on ``motion`` and ``forces``; the last before the record is made. The equations list the channels with their
units, this file finds their expressions.
"""

from __future__ import annotations

import casadi as ca

from modelgen.lowering.fixed import Fixed
from modelgen.lowering.forces import Balance, Forces, matrix_of
from modelgen.lowering.motion import Motion


def channels_of(fixed: Fixed, motion: Motion, forces: Forces, balance: Balance) -> dict[str, ca.SX]:
    """Expression of each output channel, in the order of the equations."""
    found = {
        **forces.values,
        **forces.powers,
        **_gear_torques(fixed, forces, balance),
        **_inertia_motions(fixed, motion, balance),
        **_totals(fixed, motion, forces, balance),
    }
    return {each.name: found[each.name] for each in fixed.equations.outputs}


def _inertia_motions(fixed: Fixed, motion: Motion, balance: Balance) -> dict[str, ca.SX]:
    """Angles, speed and acceleration of every inertia.

    The elastic angle is the deviation without the rigid rotation in it, which is the mean of all deviations weighted by inertia;
    a grounded group has none.
    """
    eq = fixed.equations
    diagonal = (balance.mass.get((g, g), ca.SX(0)) for g in range(len(eq.groups)))
    weights = [ratio * inertia for ratio, inertia in zip(fixed.ratios, diagonal, strict=True)]
    total = _sum_of_products(weights, fixed.ratios)
    rotation = _sum_of_products(weights, motion.deviations) / total
    found = {}
    for instance in eq.instances:
        template = eq.templates[instance.template]
        if not template.mass or len(template.flanges) != 1:
            continue
        node = instance.nodes[template.flanges[0]]
        g, node_ratio = eq.nodes[node].group, fixed.node_ratios[node]
        deviation = motion.deviations[g]
        parts = {
            "angle": motion.angles[g],
            "angle_deviation": deviation,
            "elastic_angle": deviation if eq.grounded[g] else deviation - fixed.ratios[g] * rotation,
            "speed": motion.speeds[g],
            "acceleration": balance.acceleration[g],
        }
        found.update({f"{instance.name}.{name}": node_ratio * value for name, value in parts.items()})
    return found


def _totals(fixed: Fixed, motion: Motion, forces: Forces, balance: Balance) -> dict[str, ca.SX]:
    """Kinetic energy angle'^T M angle' / 2 [J], and the sums of energies and powers over all elements."""
    speeds = ca.vertcat(*motion.speeds)
    matrix = matrix_of(balance.mass, len(fixed.equations.groups))
    found = {"total.kinetic_energy": ca.dot(speeds, ca.mtimes(matrix, speeds)) / 2}
    for name in ("stored_energy", "dissipated_power", "supplied_power"):
        parts = (value for key, value in forces.powers.items() if key.endswith(f".{name}"))
        found[f"total.{name}"] = sum(parts, start=ca.SX(0))
    return found


def _gear_torques(fixed: Fixed, forces: Forces, balance: Balance) -> dict[str, ca.SX]:
    """Torque through each rigid gear, from the balance of its nodes: G^T lambda = M angle'' - torques."""
    eq, rows, n = fixed.equations, fixed.constraints, len(fixed.equations.nodes)
    if not rows:
        return {}
    g = ca.SX(len(rows), n)
    for index, row in enumerate(rows):
        for node, c in row.items():
            g[index, node] = c
    second = (ratio * balance.acceleration[node.group] for node, ratio in zip(eq.nodes, fixed.node_ratios, strict=True))
    rest = ca.mtimes(matrix_of(forces.mass, n), ca.vertcat(*second)) - ca.vertcat(*forces.torque)
    multiplier = ca.solve(ca.mtimes(g, g.T), ca.mtimes(g, rest))
    found, row_of = {}, 0
    for instance in eq.instances:
        template = eq.templates[instance.template]
        if template.constraints:
            first = instance.nodes[template.flanges[0]]
            found[f"{instance.name}.torque"] = -multiplier[row_of] * rows[row_of][first]
            row_of += len(template.constraints)
    return found


def _sum_of_products(left: list[ca.SX], right: list[ca.SX]) -> ca.SX:
    return sum((a * b for a, b in zip(left, right, strict=True)), start=ca.SX(0))
