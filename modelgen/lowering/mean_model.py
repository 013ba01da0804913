"""The mean model: the driveline in physical angles, with every time-dependent quantity replaced by its mean.

Part of ``lower``; equilibrium, linearization and modal analysis are built on its functions. A law's quantities that depend on
time are inputs here (w), so that the caller decides whether they are means, values at an instant, or anything else. Laws that see
the angle of a shaft that turns are averaged over its turns (``mean_turn``). Modes are found by comparison, and what holds a speed
in some of them is zero: a brake that sticks holds nothing here, but its slip, its direction and its limits are given apart
(``holders``).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.lowering.arguments import arguments_at
from modelgen.lowering.channels import channels_of
from modelgen.lowering.clocks import Clocks
from modelgen.lowering.fixed import Fixed
from modelgen.lowering.forces import balance_of, forces_at
from modelgen.lowering.holders import holders_of
from modelgen.lowering.mass import matrix_of
from modelgen.lowering.mean_turn import mean_over_turns, sizes_of_torques
from modelgen.lowering.motion import coordinates_of, group_values, motion_of_angles
from modelgen.lowering.sampled_turn import sampled_turn

Array = NDArray[np.float64]
SAMPLES = 2048  # of one turn of each clock: exact for Fourier rows below this order


class SpeedRatios(NamedTuple):
    """Speeds of the groups: ``ratio`` per speed of the reference shaft, mean ``speed`` [rad/s], ``by_speed`` (groups, given)."""

    ratio: Array
    speed: Array
    by_speed: Array


class Matrices(NamedTuple):
    """Mass [kg*m^2], damping [N*m*s/rad] and stiffness [N*m/rad] over the angles of the groups."""

    mass: Array
    damping: Array
    stiffness: Array


@dataclass(frozen=True, eq=False)
class MeanModel:
    """The functions of CasADi that equilibrium and linearization use; those that end in ``_at`` give their numbers.

    Arguments: ``angle`` and ``speed``, deviations of the groups from uniform rotation; ``own`` states; ``p``; ``w``, the timed
    quantities of all instances. ``own_start``: the own states where they begin.

    ``torque``, ``linear``, ``elements`` and ``outputs`` of (angle, speed, own, p, w): torques on the groups [N*m] and rates of
    own states; mass, damping, stiffness; torque on every flange and mass terms; all channels. ``holders`` of the same: what
    sticks (``modelgen.lowering.holders``); ``timed`` (clock angles, t, p) -> w. ``means`` (p) -> w over a period, and flags of
    those that are stated. ``completed`` (p) -> p with its expressions. ``angles`` (x, p) -> angles and speeds; ``coordinates``
    (angle, speed, own, p) -> x. ``frequencies`` (p) of the base frequencies [rad/s]. ``nodes`` (p) -> angles of the nodes per
    angles of the groups. ``ratios`` (p) -> see ``SpeedRatios``. ``sizes`` of (angle, speed, own, p, w): torques on the
    groups [N*m] as sums of the sizes of their parts, before these cancel.
    """

    own_start: Array
    torque: ca.Function
    linear: ca.Function
    elements: ca.Function
    sizes: ca.Function
    outputs: ca.Function
    holders: ca.Function
    completed: ca.Function
    timed: ca.Function
    means: ca.Function
    angles: ca.Function
    coordinates: ca.Function
    frequencies: ca.Function
    nodes: ca.Function
    ratios: ca.Function

    def torque_at(self, p: Array, mean: Array, angle: Array, own: Array) -> Array:
        """Torque [N*m] on each group at rest."""
        return np.asarray(self.torque(angle, np.zeros(len(angle)), own, p, mean)[0]).ravel()

    def sizes_at(self, p: Array, mean: Array, angle: Array, own: Array) -> Array:
        """Torque [N*m] on each group at rest, as the sum of the sizes of its parts."""
        return np.asarray(self.sizes(angle, np.zeros(len(angle)), own, p, mean)).ravel()

    def matrices_at(self, p: Array, mean: Array, angle: Array, own: Array) -> Matrices:
        """The matrices at rest at these angles."""
        return Matrices(*(each.full() for each in self.linear(angle, np.zeros(len(angle)), own, p, mean)))

    def means_at(self, p: Array) -> Array:
        """Means over a period of every quantity that varies with time only: as stated by its element, else by sampling."""
        stated, explicit = (np.asarray(each).ravel() for each in self.means(p))
        if not explicit.all():
            rows = np.flatnonzero(explicit == 0)
            stated[rows] = sampled_turn(self.timed, SAMPLES, tuple(rows.tolist()))(p).mean(axis=1)
        return stated

    def frequencies_at(self, p: Array) -> Array:
        """Base frequencies [rad/s], in the order of the clocks."""
        return np.asarray(self.frequencies(p)).ravel()

    def nodes_at(self, p: Array) -> Array:
        """Angles of the nodes per angles of the groups (nodes, groups)."""
        return np.asarray(self.nodes(p).full())

    def ratios_at(self, p: Array) -> SpeedRatios:
        """Speeds of the groups."""
        ratio, speed, by_speed = self.ratios(p)
        return SpeedRatios(np.asarray(ratio).ravel(), np.asarray(speed).ravel(), by_speed.full())


def mean_model(fixed: Fixed, clocks: Clocks, x: ca.SX) -> MeanModel:
    """Functions for equilibrium and linearization.

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
    sizes = sizes_of_torques(fixed, arguments, forces.by_flange)
    torque, matrix, outputs, sizes, by_flange, by_mass_term = (
        ca.substitute(each, t, 0)
        for each in (
            *(balance.torque, matrix_of(balance.mass, n), outputs, sizes),
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
        "sizes": (given, [sizes]),
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
    start = np.array([state.start for state in eq.states if state.kind == "own"])
    return MeanModel(start, **{name: ca.Function(name, inputs, results) for name, (inputs, results) in functions.items()})


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
