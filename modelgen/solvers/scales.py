"""Scales of the states: the size that a tolerance refers to.

Below ``lowering``. A relative angle is measured by the largest torque about, divided by its own stiffness: a tolerance then means
the same share of the transmitted torque in a soft coupling and in a stiff mesh. Its rate is measured by that angle times
the local natural frequency. Nothing is measured by |angle|, which grows with every turn.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from modelgen.lowering import Compiled
from modelgen.lowering.sampled_turn import sampled_turn
from modelgen.solvers.equilibrium import Array
from modelgen.solvers.operating_point import OperatingPoint

SAMPLES = 256


def state_scales(model: Compiled, point: OperatingPoint, start: Array) -> Array:
    """The scale of each state [its own unit], positive, for a run from ``start``."""
    eq, c = model.equations, point.coordinates
    n = len(eq.steps)
    scale = np.ones(len(eq.states))
    if n:
        stiffness = _own_stiffness(model, point)
        mobility = np.diag(c.to_states @ np.linalg.solve(point.mass, c.to_states.T))
        # Lever of each coordinate: a torque T at the reference shaft is a generalized force T / lever in it.
        # Where its shafts stand still in the mean, the coordinate's own lever takes its place.
        lever = np.abs(c.to_states * c.ratio).max(axis=1)
        lever = np.where(lever > 0, lever, np.abs(c.to_states).max(axis=1))
        force = _reference_torque(model, point, start) / lever
        energy = _vibration_energy(point, start[n : 2 * n])
        with np.errstate(all="ignore"):
            size = np.where(force > 0, force / stiffness, np.sqrt(2 * energy / stiffness))
            size = np.where(np.isfinite(size) & (size > 0), size, 1.0)
            rate = size * np.sqrt(np.where(stiffness > 0, stiffness, 1.0) * mobility)
        rate = np.where(rate == 0, 1.0, rate)  # lost below the smallest number
        scale[:n], scale[n : 2 * n] = size, rate
        if c.roots:
            # A rigid angle is measured like the largest twist, referred to the reference shaft.
            scale[c.roots] = (size / lever)[c.forms].max(initial=0.0) or 1.0
            scale[[n + k for k in c.roots]] = (rate / lever)[c.forms].max(initial=0.0) or 1.0
    for index, state in enumerate(eq.states):
        if state.kind == "own" or state.scale is not None:
            scale[index] = state.scale if state.scale is not None else max(abs(state.start), abs(start[index])) or 1.0
    return scale


def _own_stiffness(model: Compiled, point: OperatingPoint) -> Array:
    """Stiffness of each coordinate by itself; where it has none at rest (inside a gap), that of a larger displacement."""
    c = point.coordinates
    stiffness = np.abs(np.diag(c.to_angles.T @ point.stiffness @ c.to_angles)).copy()
    own = model.mean_model.own_start
    zeros = np.zeros(len(point.angle))
    for k in c.forms:
        if stiffness[k] > 0:
            continue
        column = c.to_angles[:, k]
        for reach in 10.0 ** np.arange(-7, 1):
            places = (point.angle - reach * column, point.angle + reach * column)
            ends = [model.mean_model.torque(place, zeros, own, point.p, point.mean)[0] for place in places]
            stiffness[k] = max(stiffness[k], abs(float(column @ np.asarray(ends[1] - ends[0]).ravel())) / (2 * reach))
    return stiffness


def _reference_torque(model: Compiled, point: OperatingPoint, start: Array) -> float:
    """Largest torque on any group [N*m at the reference shaft] over a turn of the clocks, of the sources and at the start."""
    c, n = point.coordinates, len(model.equations.steps)
    own = np.tile(start[2 * n :, None], SAMPLES)
    timed, torque = sampled_turn(model.mean_model.timed, SAMPLES)(point.p), _torques_over_a_turn(model)
    largest = 0.0
    for angle in (np.zeros(n), c.to_angles @ start[:n]):
        found = torque(np.tile(angle[:, None], SAMPLES), np.zeros((n, SAMPLES)), own, point.p, timed)[0]
        largest = max(largest, float(np.abs(np.asarray(found) * c.ratio[:, None]).max(initial=0.0)))
    return largest


@functools.lru_cache(maxsize=8)
def _torques_over_a_turn(model: Compiled) -> Any:
    """The torques on the groups as one call over all samples of a turn; made once per model."""
    return model.mean_model.torque.map(SAMPLES)


def _vibration_energy(point: OperatingPoint, rates: Array) -> float:
    """Kinetic energy [J] of the speeds relative to uniform rotation, without the rigid part."""
    c = point.coordinates
    relative = rates.copy()
    relative[c.roots] = 0.0
    with np.errstate(over="ignore"):
        speed = c.to_angles @ relative
        return float(speed @ point.mass @ speed) / 2
