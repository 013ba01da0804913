"""Coordinates in numbers: the linear map between the angles of the groups and the states that were chosen for them.

Part of ``solvers``, on the mean model; ``static_state`` finds the equilibrium in these terms.
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
        n, own = len(eq.steps), len(model.mean_model.own_start)
        columns = np.eye(len(eq.states))[:, :n]
        to_angles = np.asarray(model.mean_model.angles.map(n)(columns, p)[0]) if n else np.zeros((0, 0))
        zeros = np.zeros((n, n))
        states = np.asarray(model.mean_model.coordinates.map(n)(np.eye(n), zeros, np.zeros((own, n)), p))[:n] if n else zeros
        ratio, speed, by_speed = model.mean_model.ratios_at(p)
        roots = [step.state for step in eq.steps if step.form is None]
        return cls(to_angles, states, roots, [k for k in range(n) if k not in roots], ratio, speed, by_speed)

    @property
    def rigid(self) -> Array:
        """Rigid rotations as columns over the groups."""
        return self.to_angles[:, self.roots]
