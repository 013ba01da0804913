"""Static equilibrium under mean torques: where a simulation starts unless told otherwise.

Below ``lowering``. Newton's method in the chosen coordinates with a pseudo time step: inside the backlash there is no stiffness,
and the pseudo step carries the flank across the gap to the side that the mean torque presses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import BalanceError, CaseError
from modelgen.lowering import Compiled

Array = NDArray[np.float64]
BALANCED = 1e-6  # mean power that may remain, relative to the sum of its parts
ITERATIONS = 400


@dataclass(frozen=True, eq=False)
class Coordinates:
    """The linear map between group angles and the chosen coordinates: angles = ``to_angles`` @ q, q = ``to_states`` @ angles.

    ``roots`` and ``forms`` are the columns of q that are rigid angles and relative angles; ``ratio`` is the speed of each group
    per speed of the reference shaft, ``speed`` its mean speed [rad/s].
    """

    to_angles: Array
    to_states: Array
    roots: list[int]
    forms: list[int]
    ratio: Array
    speed: Array

    @classmethod
    def of(cls, model: Compiled, p: Array) -> Coordinates:
        """The map for one set of parameters."""
        eq = model.equations
        n, own = len(eq.steps), len(own_start(model))
        columns = np.eye(len(eq.states))[:, :n]
        to_angles = np.asarray(model.mean_model["angles"].map(n)(columns, p)[0]) if n else np.zeros((0, 0))
        zeros = np.zeros((n, n))
        states = np.asarray(model.mean_model["coordinates"].map(n)(np.eye(n), zeros, np.zeros((own, n)), p))[:n] if n else zeros
        ratio, speed = (np.asarray(each).ravel() for each in model.mean_model["ratios"](p))
        roots = [step.state for step in eq.steps if step.form is None]
        return cls(to_angles, states, roots, [k for k in range(n) if k not in roots], ratio, speed)

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


def static_angles(model: Compiled, p: Array, mean: Array, coordinates: Coordinates) -> tuple[Array, float]:
    """Static group angles [rad] and the drift [rad/s^2] of the reference shaft. Own states are held at their start.

    Raises BalanceError for mean torques that do not balance, CaseError where no equilibrium is found.
    """
    own, n = own_start(model), len(coordinates.ratio)
    angle = np.zeros(n)
    if n == 0:
        return angle, 0.0
    torque = mean_torque(model, p, mean, angle, own)
    mass = linear_model(model, p, mean, angle, own)[0]
    drive, drift = _drift(model, torque, mass, coordinates)
    to_angles = coordinates.to_angles[:, coordinates.forms]

    def residual(u: Array) -> Array:
        return np.asarray(to_angles.T @ (mean_torque(model, p, mean, to_angles @ u, own) - drive))

    u = np.zeros(len(coordinates.forms))
    rest = residual(u)
    size = float(np.abs(rest).max(initial=0.0))
    inertia = np.diag(to_angles.T @ mass @ to_angles)
    weight, stall = 1.0, 0
    for _ in range(ITERATIONS):
        if np.abs(rest).max(initial=0.0) <= 1e-14 * size or stall > 3:
            break
        stiffness = to_angles.T @ linear_model(model, p, mean, to_angles @ u, own)[2] @ to_angles
        fastest = float(np.max(np.abs(np.diag(stiffness)) / inertia)) or 1.0
        trial = u + np.linalg.solve(stiffness + np.diag(weight * fastest * inertia), rest)
        new = residual(trial)
        if np.linalg.norm(new) <= np.linalg.norm(rest) * (1 + 1e-9):
            stall = stall + 1 if np.linalg.norm(new) > 0.5 * np.linalg.norm(rest) and np.abs(rest).max() < 1e-9 * size else 0
            u, rest, weight = trial, new, weight / 10
        else:
            weight *= 4
            stall += weight > 1e12
    if np.abs(rest).max(initial=0.0) > 1e-9 * size:
        remains = f"a generalized force of {np.abs(rest).max():.3g} remains"
        raise CaseError(
            f"driveline {model.name!r}", f"has no static equilibrium ({remains})", 'start from "zero" or from given states'
        )
    return to_angles @ u, drift


def _drift(model: Compiled, torque: Array, mass: Array, coordinates: Coordinates) -> tuple[Array, float]:
    """Torques that the rigid acceleration takes up, and that acceleration at the reference shaft."""
    rigid = coordinates.rigid
    if rigid.shape[1] == 0:
        return np.zeros_like(torque), 0.0
    acceleration = np.linalg.solve(rigid.T @ mass @ rigid, rigid.T @ torque)
    drive = mass @ rigid @ acceleration
    ratio, speed = coordinates.ratio, coordinates.speed
    net, parts = float(ratio @ torque), float(np.abs(ratio * torque).sum())
    drift = net / float(ratio @ mass @ ratio)
    if np.any(speed) and abs(net) > BALANCED * parts and not model.equations.drifts:
        power = net * float(np.max(np.abs(speed / ratio)))
        raise BalanceError(
            f"driveline {model.name!r}",
            f"mean torques leave {net:.6g} N*m ({power:.4g} W) at the reference shaft, "
            f"which would accelerate by {drift:.4g} rad/s^2",
            "use balance(load), change a torque, or declare that it drifts",
        )
    return drive, drift
