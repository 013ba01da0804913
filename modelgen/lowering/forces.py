"""Forces: every law evaluated at a motion, summed over nodes, then over groups to M angle'' = torque.

Part of ``lower``, on ``fixed`` and ``motion``. Each instance calls the block of its template once. A node's torque acts on
the groups of its row with its coefficients, its mass terms with those of both nodes (virtual work). Modal damping, if asked for,
is one more torque on the groups: its matrix arrives in the parameter vector, because modes are numeric.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca

from modelgen.equations.records import Instance
from modelgen.lowering.arguments import Arguments, flags_by_variable
from modelgen.lowering.fixed import Fixed
from modelgen.lowering.mass import Terms, add, solve_symmetric
from modelgen.lowering.motion import Motion
from modelgen.lowering.parameters import MODAL


@dataclass(frozen=True, eq=False)
class Forces:
    """What the laws give at one motion.

    ``torque`` on each node [N*m], ``mass`` terms between nodes [kg*m^2], ``rates`` of the elements' own states, ``values`` of
    every named quantity, ``powers`` with the stored energies [J] and powers [W]; ``by_flange`` and ``by_mass_term`` hold the
    torques and mass terms of each instance, unsummed.
    """

    torque: list[ca.SX]
    mass: Terms
    rates: list[ca.SX]
    values: dict[str, ca.SX]
    powers: dict[str, ca.SX]
    by_flange: list[ca.SX]
    by_mass_term: list[ca.SX]


@dataclass(frozen=True, eq=False)
class Balance:
    """M angle'' = torque over the groups: torque [N*m], terms of M [kg*m^2], and angle'' [rad/s^2]."""

    torque: ca.SX
    mass: Terms
    acceleration: ca.SX


Stage = Callable[[Fixed, Instance, Arguments], Sequence[ca.SX]]


def at_an_instant(fixed: Fixed, instance: Instance, given: Arguments) -> Sequence[ca.SX]:
    """What the state stage of an instance gives for its arguments."""
    return list(fixed.block(instance).state(*given.all))


def forces_at(fixed: Fixed, arguments: list[Arguments], motion: Motion, stage: Stage = at_an_instant) -> Forces:
    """All laws at a motion; ``arguments`` are those of every instance (``arguments_at``)."""
    eq = fixed.equations
    forces = Forces([ca.SX(0)] * len(eq.nodes), {}, [ca.SX(0)] * fixed.own_count, {}, {}, [], [])
    for instance, given in zip(eq.instances, arguments, strict=True):
        block, template = fixed.block(instance), eq.templates[instance.template]
        named, torque, rates, powers, mass = stage(fixed, instance, given)
        for flange, each in zip(template.flanges, ca.vertsplit(torque) if template.flanges else [], strict=True):
            forces.torque[instance.nodes[flange]] += each
        for state, (_, symbol, *_) in zip(instance.states, template.states, strict=True):
            forces.rates[state - 2 * fixed.order] = rates[list(template.rates).index(symbol)]
        for (f, g), each in zip(template.mass, ca.vertsplit(mass) if template.mass else [], strict=True):
            add(forces.mass, (instance.nodes[f], instance.nodes[g]), each)
        forces.by_flange.append(torque)
        forces.by_mass_term.append(mass)
        prefix = f"{instance.name}." if instance.name else ""
        stages = ((block.fixed_names, given.seen[2]), (block.timed_names, given.seen[4]), (block.state_names, named))
        for names, column in stages:
            forces.values.update({f"{prefix}{name}": column[row] for row, name in enumerate(names)})
        for modes, flags in zip(template.modes, flags_by_variable(template, given.flags), strict=True):
            forces.values[f"{prefix}{modes.name}"] = sum((k * flag for k, flag in enumerate(flags)), start=ca.SX(0))
        for row, name in enumerate(("stored_energy", "dissipated_power", "supplied_power")):
            forces.powers[f"{instance.name}.{name}"] = powers[row]
    if eq.modal_ratio is not None:
        _add_modal_damping(fixed, motion, forces)
    return forces


def _add_modal_damping(fixed: Fixed, motion: Motion, forces: Forces) -> None:
    """Torques -C (speed less uniform rotation); C acts on groups and is zero for the rigid rotation."""
    eq, n = fixed.equations, len(fixed.equations.groups)
    matrix = ca.reshape(fixed.parameters.vector_symbol[fixed.parameters.slices[MODAL]], n, n)
    rates = ca.vertcat(*(speed - mean for speed, mean in zip(motion.speeds, fixed.mean_speeds, strict=True)))
    torque = -ca.mtimes(matrix, rates)
    first: dict[int, int] = {}
    for index, node in enumerate(eq.nodes):
        group = node.group
        if group is not None and node.row[group] == 1:
            first.setdefault(group, index)
    for group, index in first.items():
        forces.torque[index] += torque[group]
    forces.powers["modal_damping.dissipated_power"] = -ca.dot(torque, rates)


def balance_of(fixed: Fixed, forces: Forces) -> Balance:
    """The forces summed over the nodes of each group, and the accelerations that follow."""
    n = len(fixed.equations.groups)
    sums = [ca.SX(0)] * n
    for row, each in zip(fixed.node_rows, forces.torque, strict=True):
        for group, c in row.items():
            sums[group] += c * each
    mass: Terms = {}
    for (a, b), value in forces.mass.items():
        for i, c in fixed.node_rows[a].items():
            for j, d in fixed.node_rows[b].items():
                add(mass, (i, j), c * d * value)
    acceleration = solve_symmetric(mass, dict(enumerate(sums)))
    return Balance(ca.vertcat(*sums), mass, ca.vertcat(*(acceleration[group] for group in range(n))))
