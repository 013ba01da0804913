"""The mean model in numbers: coordinates and angles, torques, and the linear matrices at given angles.

Below ``lowering``; ``static_state`` finds the equilibrium in these terms.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.lowering import Compiled

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Coordinates:
    """The linear map between group angles and the chosen coordinates: angles = ``to_angles`` @ q, q = ``to_states`` @ angles.

    ``roots`` and ``forms`` are the columns of q that are rigid angles and relative angles; ``ratio`` is the speed of each group
    per speed of the reference shaft, ``speed`` its mean speed [rad/s], ``by_speed`` what each given speed contributes to it.
    """

    to_angles: Array
    to_states: Array
    roots: list[int]
    forms: list[int]
    ratio: Array
    speed: Array
    by_speed: Array

    @classmethod
    def of(cls, model: Compiled, p: Array) -> Coordinates:
        """The map for one set of parameters."""
        eq = model.equations
        n, own = len(eq.steps), len(own_start(model))
        columns = np.eye(len(eq.states))[:, :n]
        to_angles = np.asarray(model.mean_model["angles"].map(n)(columns, p)[0]) if n else np.zeros((0, 0))
        zeros = np.zeros((n, n))
        states = np.asarray(model.mean_model["coordinates"].map(n)(np.eye(n), zeros, np.zeros((own, n)), p))[:n] if n else zeros
        found = model.mean_model["ratios"](p)
        ratio, speed = (np.asarray(each).ravel() for each in found[:2])
        by_speed = found[2].full() if n else zeros
        roots = [step.state for step in eq.steps if step.form is None]
        return cls(to_angles, states, roots, [k for k in range(n) if k not in roots], ratio, speed, by_speed)

    @property
    def rigid(self) -> Array:
        """Rigid rotations as columns over the groups."""
        return self.to_angles[:, self.roots]


def own_start(model: Compiled) -> Array:
    """Start values of the elements' own states."""
    return np.array([state.start for state in model.equations.states if state.kind == "own"])


def mean_torque(model: Compiled, p: Array, mean: Array, angle: Array, own: Array) -> Array:
    """Torque [N*m] on each group at rest in the mean model."""
    return np.asarray(model.mean_model["torque"](angle, np.zeros(len(angle)), own, p, mean)[0]).ravel()


def linear_model(model: Compiled, p: Array, mean: Array, angle: Array, own: Array) -> tuple[Array, Array, Array]:
    """M, C, K over group angles, of the mean model at rest at these angles."""
    mass, damping, stiffness = model.mean_model["linear"](angle, np.zeros(len(angle)), own, p, mean)
    return mass.full(), damping.full(), stiffness.full()
