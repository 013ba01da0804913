"""Output channels: every named quantity at a motion, energies and powers, and the torques that constraints take.

Part of ``lower``, on ``motion`` and ``forces``; the last before the record is made. The equations list the channels with their
units, this file finds their expressions.
"""

from __future__ import annotations

import casadi as ca

from modelgen.equations.outputs import constraint_channels
from modelgen.lowering.fixed import Fixed
from modelgen.lowering.forces import Balance, Forces
from modelgen.lowering.mass import Terms, matrix_of, solve_symmetric
from modelgen.lowering.motion import Motion

SMALL = 1e-300  # a row of a constraint that is zero at the values at hand


def channels_of(fixed: Fixed, motion: Motion, forces: Forces, balance: Balance) -> dict[str, ca.SX]:
    """Expression of each output channel, in the order of the equations."""
    found = {
        **forces.values,
        **forces.powers,
        **_constraint_torques(fixed, forces, balance),
        **_inertia_motions(fixed, motion, balance),
        **_totals(fixed, motion, forces, balance),
    }
    return {each.name: found[each.name] for each in fixed.equations.outputs}


def _inertia_motions(fixed: Fixed, motion: Motion, balance: Balance) -> dict[str, ca.SX]:
    """Angles, speed and acceleration of every inertia.

    The elastic angle is the deviation without the rigid rotations in it: theta - R (R^T M R)^-1 R^T M theta, with a column of R
    for each rotation that no law resists. What ground holds has none.
    """
    eq = fixed.equations
    elastic = _without_rotation(fixed, balance.mass, motion.deviations)
    acceleration = ca.vertsplit(balance.acceleration)
    found = {}
    for instance in eq.instances:
        template = eq.templates[instance.template]
        if not template.mass or len(template.flanges) != 1:
            continue
        node = instance.nodes[template.flanges[0]]
        parts = {
            "angle": motion.angles,
            "angle_deviation": motion.deviations,
            "elastic_angle": elastic,
            "speed": motion.speeds,
            "acceleration": acceleration,
        }
        found.update({f"{instance.name}.{name}": fixed.at_node(node, values) for name, values in parts.items()})
    return found


def _without_rotation(fixed: Fixed, mass: Terms, deviations: list[ca.SX]) -> list[ca.SX]:
    """The deviations of the groups without the free rotations in them, weighted by inertia."""
    rotations, roots = fixed.rotations, [step.group for step in fixed.equations.steps if step.form is None]
    if not roots:
        return deviations
    weights: dict[int, dict[int, ca.SX]] = {root: {} for root in roots}  # R^T M
    for (i, j), value in sorted(mass.items()):
        for root, ratio in rotations[i].items():
            weights[root][j] = weights[root].get(j, ca.SX(0)) + ratio * value
    inertia: Terms = {}
    for root, row in weights.items():
        for other in roots:
            terms = [value * rotations[group][other] for group, value in row.items() if other in rotations[group]]
            if terms:
                inertia[root, other] = sum(terms, start=ca.SX(0))
    momentum = {
        root: sum((value * deviations[group] for group, value in row.items()), start=ca.SX(0)) for root, row in weights.items()
    }
    amount = solve_symmetric(inertia, momentum)
    return [
        deviation - sum((ratio * amount[root] for root, ratio in rotations[group].items()), start=ca.SX(0))
        for group, deviation in enumerate(deviations)
    ]


def _totals(fixed: Fixed, motion: Motion, forces: Forces, balance: Balance) -> dict[str, ca.SX]:
    """Kinetic energy angle'^T M angle' / 2 [J], and the sums of energies and powers over all elements."""
    speeds = ca.vertcat(*motion.speeds)
    matrix = matrix_of(balance.mass, len(fixed.equations.groups))
    found = {"total.kinetic_energy": ca.dot(speeds, ca.mtimes(matrix, speeds)) / 2}
    for name in ("stored_energy", "dissipated_power", "supplied_power"):
        parts = (value for key, value in forces.powers.items() if key.endswith(f".{name}"))
        found[f"total.{name}"] = sum(parts, start=ca.SX(0))
    return found


def _constraint_torques(fixed: Fixed, forces: Forces, balance: Balance) -> dict[str, ca.SX]:
    """Torque of each constraint on the node at each flange, from the balance of the nodes: G^T lambda = M angle'' - torques.

    ``torque`` is what it takes from its first flange, so positive where that one drives. Of constraints that say the same, as in
    a closed loop of rigid gears, the torques are those with the least sum of squares: nothing elastic tells them apart.
    """
    rows, n = fixed.constraints, len(fixed.equations.nodes)
    if not rows:
        return {}
    g = ca.SX(len(rows), n)
    for index, row in enumerate(rows):
        for node, c in row.items():
            g[index, node] = c
    acceleration = ca.vertsplit(balance.acceleration)
    second = ca.vertcat(*(fixed.at_node(node, acceleration) for node in range(n)))
    rest = ca.mtimes(matrix_of(forces.mass, n), second) - ca.vertcat(*forces.torque)
    multiplier = _multipliers(g, rest, fixed.equations.redundant)
    found, row_of = {}, 0
    for instance in fixed.equations.instances:
        template = fixed.equations.templates[instance.template]
        if not template.constraints:
            continue
        mine = range(row_of, row_of + len(template.constraints))
        row_of = mine.stop
        for flange, name in zip(template.flanges, constraint_channels(template), strict=True):
            terms = (multiplier[row] * fixed.arms[row][flange] for row in mine if flange in fixed.arms[row])
            found[f"{instance.name}.{name}"] = sum(terms, start=ca.SX(0))
        found[f"{instance.name}.torque"] = -found[f"{instance.name}.{constraint_channels(template)[0]}"]
    return found


def _multipliers(g: ca.SX, rest: ca.SX, redundant: tuple[int, ...]) -> ca.SX:
    """lambda of G^T lambda = rest; where rows of G depend on others, the one whose torques have the least sum of squares."""
    if not redundant:
        return ca.solve(ca.mtimes(g, g.T), ca.mtimes(g, rest))
    size = ca.fmax(ca.vertcat(*(ca.sqrt(ca.sumsqr(g[row, :])) for row in range(g.size1()))), SMALL)
    unit = ca.diag(1 / size) @ g
    kept = [row for row in range(g.size1()) if row not in redundant]
    independent = unit[kept, :]
    square = ca.mtimes(independent, independent.T)
    sums = ca.solve(square, ca.mtimes(independent, rest))
    shares = ca.solve(square, ca.mtimes(independent, unit.T)).T
    return ca.mtimes(shares, ca.solve(ca.mtimes(shares.T, shares), sums)) / size
