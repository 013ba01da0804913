"""The mean model: the driveline in physical angles, with every time-dependent quantity replaced by its mean.

Part of ``lower``; equilibrium, linearization and modal analysis are built on its functions. A law's quantities that depend on
time are inputs here (w), so that the caller decides whether they are means, values at an instant, or anything else. Laws that see
the angle of a shaft that turns are averaged over its turns (``mean_turn``). Modes are found by comparison, and what holds a speed
in some of them is zero: a brake that sticks holds nothing here, but its slip, its direction and its limits are given apart
(``holders``).
"""

from __future__ import annotations

import itertools

import casadi as ca

from modelgen.lowering.arguments import arguments_at
from modelgen.lowering.channels import channels_of
from modelgen.lowering.clocks import Clocks
from modelgen.lowering.fixed import Fixed
from modelgen.lowering.forces import balance_of, forces_at
from modelgen.lowering.holders import holders_of
from modelgen.lowering.mass import matrix_of
from modelgen.lowering.mean_turn import mean_over_turns
from modelgen.lowering.motion import coordinates_of, group_values, motion_of_angles


def mean_model(fixed: Fixed, clocks: Clocks, x: ca.SX) -> dict[str, ca.Function]:
    """Functions for equilibrium and linearization; see ``Compiled.mean_model``.

    ``x`` is the vector of states, [angle, speed] are deviations of the groups from uniform rotation, and w stands for the timed
    quantities of all instances, one after the other.
    """
    eq, n, order = fixed.equations, len(fixed.equations.groups), fixed.order
    p, t = fixed.parameters.vector_symbol, clocks.time
    angles, speeds, own = ca.SX.sym("angle", n), ca.SX.sym("speed", n), ca.SX.sym("own", fixed.own_count)
    blocks = [fixed.block(instance) for instance in eq.instances]
    borders = [0, *itertools.accumulate(len(block.timed_names) for block in blocks)]
    w = ca.SX.sym("w", borders[-1])
    still = [ca.vertcat(*(ca.SX(0) for _ in block.slots.clocks)) for block in blocks]
    motion = motion_of_angles(fixed, t, angles, speeds, own)
    arguments = arguments_at(fixed, motion, still, ca.vertsplit(w, borders) if blocks else [])
    forces = forces_at(fixed, arguments, motion, mean_over_turns)
    balance = balance_of(fixed, forces)
    outputs = ca.vertcat(*channels_of(fixed, motion, forces, balance).values())
    torque, matrix, outputs, by_flange, by_mass_term = (
        ca.substitute(each, t, 0)
        for each in (
            *(balance.torque, matrix_of(balance.mass, n), outputs),
            *(ca.vertcat(*forces.by_flange), ca.vertcat(*forces.by_mass_term)),
        )
    )
    held = holders_of(fixed, motion, arguments, speeds)
    explicit = [ca.SX(flag) for block in blocks for flag in block.explicit_mean]
    means = [block.mean(*given) for block, given in zip(blocks, fixed.given, strict=True)]
    placed, placed_rates = (ca.vertcat(*group_values(fixed, part)) for part in (x[:order], x[order : 2 * order]))
    coordinates = coordinates_of(fixed, angles) + coordinates_of(fixed, speeds)
    given = [angles, speeds, own, p, w]
    functions: dict[str, tuple[list[ca.SX], list[ca.SX]]] = {
        "torque": (given, [torque, ca.vertcat(*forces.rates)]),
        "linear": (given, [matrix, -ca.jacobian(torque, speeds), -ca.jacobian(torque, angles)]),
        "elements": (given, [by_flange, by_mass_term]),
        "outputs": (given, [outputs]),
        "holders": (given, [ca.substitute(each, t, 0) for each in vars(held).values()]),
        "completed": ([p], [_completed(fixed)]),
        "timed": ([clocks.angles, t, p], [ca.vertcat(*clocks.timed)]),
        "means": ([p], [ca.vertcat(*means), ca.vertcat(*explicit)]),
        "angles": ([x, p], [placed, placed_rates]),
        "coordinates": ([angles, speeds, own, p], [ca.vertcat(*coordinates, own)]),
        "frequencies": ([p], [ca.vertcat(*fixed.frequencies)]),
        "nodes": ([p], [_rows(fixed.node_rows, n)]),
        "ratios": ([p], [ca.vertcat(*fixed.ratios), ca.vertcat(*fixed.mean_speeds), _by_speed(fixed)]),
    }
    return {name: ca.Function(name, inputs, results) for name, (inputs, results) in functions.items()}


def _rows(rows: list[dict[int, ca.SX]], groups: int) -> ca.SX:
    """Rows over groups as a matrix, sparse."""
    matrix = ca.SX(len(rows), groups)
    for index, row in enumerate(rows):
        for group, c in row.items():
            matrix[index, group] = c
    return matrix


def _by_speed(fixed: Fixed) -> ca.SX:
    """Mean speeds of the groups per each of the given speeds, (groups, given speeds)."""
    return ca.vertcat(*(ca.horzcat(*row) for row in fixed.by_speed))


def _completed(fixed: Fixed) -> ca.SX:
    """The parameter vector with the parameters given by expressions filled in from the others."""
    p = fixed.parameters.vector_symbol
    completed = ca.SX(p)
    for name, expression in fixed.parameters._expressions.items():
        completed[fixed.parameters.slices[name]] = expression(p)
    return completed
