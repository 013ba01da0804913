"""The operating point: parameters in balance, the static state under mean torques, and the linear model about it.

Between ``lowering`` and everything that asks a question: the static start, the scales of the states, modal damping and modal
analysis all rest on it. The mean model replaces what varies with time by its mean over a period; the static state loads the
meshes on the flank that the mean torque presses.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import BalanceError
from modelgen.lowering import Compiled
from modelgen.lowering.parameters import MODAL
from modelgen.solvers.asked_model import asked_model
from modelgen.solvers.equilibrium import Coordinates, linear_model, mean_torque, own_start, static_angles
from modelgen.solvers.sampled_turn import sampled_turn

Array = NDArray[np.float64]
SAMPLES = 2048  # of one turn of each clock: exact for Fourier rows below this order


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """A driveline at rest relative to its uniform rotation.

    ``p`` (parameters, complete), ``mean`` (means of what varies with time), ``angle`` (static angle of each group [rad], from
    uniform rotation), ``start`` (the static state), ``mass``, ``damping``, ``stiffness`` (matrices over group angles), ``drift``
    [rad/s^2] (acceleration of the reference shaft that an unbalanced mean torque causes), ``coordinates`` (states and angles).
    """

    p: Array
    mean: Array
    angle: Array
    start: Array
    mass: Array
    damping: Array
    stiffness: Array
    drift: float
    coordinates: Coordinates

    def frequencies(self) -> Array:
        """Undamped natural frequencies [Hz], sorted; a rigid rotation is at zero."""
        return natural_frequencies(self.mass, self.stiffness)


def natural_frequencies(mass: Array, stiffness: Array) -> Array:
    """Undamped natural frequencies [Hz] of M q'' + K q = 0, sorted, from the symmetric form L^-1 K L^-T with M = L L^T."""
    squares = np.linalg.eigvalsh(_symmetric_form(mass, stiffness)[1])
    # Rounding leaves a rigid mode at +-1e-10 of the largest square; what is that small is zero.
    squares[np.abs(squares) < 1e-13 * max(np.abs(squares).max(), 1e-300) * len(squares)] = 0.0
    return np.sort(np.sign(squares) * np.sqrt(np.abs(squares)) / (2 * np.pi))


def _symmetric_form(mass: Array, stiffness: Array) -> tuple[Array, Array]:
    """L and L^-1 K L^-T with M = L L^T: its eigenvalues are the squares of the natural frequencies [rad^2/s^2]."""
    factor = np.asarray(np.linalg.cholesky(mass), dtype=float)
    symmetric = np.linalg.solve(factor, np.linalg.solve(factor, stiffness).T)
    return factor, np.asarray((symmetric + symmetric.T) / 2)


def operating_point(model: Compiled, values: Mapping[str, Any] | None = None) -> OperatingPoint:
    """The operating point for the model's parameters with some changed by name.

    Raises BalanceError when the mean torques do not balance and the driveline is not declared to drift, CaseError when there is
    no equilibrium.

    >>> from modelgen import load, assemble, lower
    >>> point = operating_point(lower(assemble(load("fracturing-truck"))))
    >>> point.frequencies()[1:4].round(3).tolist()
    [45.236, 75.253, 124.143]
    """
    model = asked_model(model, "operating_point")
    p = model.parameters.vector(values)
    _balance(model, p, {*model.parameters.given, *(values or ())})
    mean = mean_values(model, p)
    coordinates = Coordinates.of(model, p)
    angle, drift = static_angles(model, p, mean, coordinates)
    own = own_start(model)
    mass, damping, stiffness = linear_model(model, p, mean, angle, own)
    if model.equations.modal_ratio is not None:
        zeta = model.parameters.value(p, model.equations.modal_ratio)
        p[model.parameters.slices[MODAL]] = _modal_damping(mass, stiffness, zeta).ravel(order="F")
        mass, damping, stiffness = linear_model(model, p, mean, angle, own)
    start = np.asarray(model.mean_model["coordinates"](angle, np.zeros_like(angle), own, p)).ravel()
    return OperatingPoint(p, mean, angle, start, mass, damping, stiffness, drift, coordinates)


def mean_values(model: Compiled, p: Array) -> Array:
    """Means over a period of every quantity that varies with time only: as stated by its element, else by sampling."""
    stated, explicit = (np.asarray(each).ravel() for each in model.mean_model["means"](p))
    if explicit.all():
        return stated
    rows = np.flatnonzero(explicit == 0)
    stated[rows] = sampled_turn(model, SAMPLES, tuple(rows.tolist()))(p).mean(axis=1)
    return stated


def _balance(model: Compiled, p: Array, fixed: set[str]) -> None:
    """Sets the scale of the balanced loads, in place, so that the mean power of the whole driveline is zero."""
    names = [name for name in model.equations.balanced if name not in fixed]
    if not names:
        return
    own, n = own_start(model), len(model.equations.groups)
    entries = [model.parameters.slices[name].start for name in names]
    given = p[entries].copy()

    def power(factor: float) -> float:
        p[entries] = factor * given
        speeds = np.asarray(model.mean_model["ratios"](p)[1]).ravel()
        return float(speeds @ mean_torque(model, p, mean_values(model, p), np.zeros(n), own))

    without, load = power(0.0), power(1.0)
    if load == without:
        raise BalanceError(
            f"driveline {model.name!r}", "the balanced loads have no mean torque", "give them a mean, or balance other loads"
        )
    scale = without / (without - load)
    if scale < 0 and load < without and not model.equations.balance_may_drive:  # what absorbed power would supply it
        loads = ", ".join(repr(name.rpartition(".")[0]) for name in names)
        raise BalanceError(
            f"driveline {model.name!r}",
            f"balance would scale {loads} by {scale:.4g}, which turns the load into a drive",
            "correct a torque or its sign, or allow it: balance(..., may_drive=True), in a model file balance_may_drive = true",
        )
    p[entries] = given * scale


def _modal_damping(mass: Array, stiffness: Array, zeta: float) -> Array:
    """C = sum of 2 zeta omega_i (M v_i)(M v_i)^T over the elastic modes v_i with v^T M v = 1; zero for rigid rotation."""
    factor, symmetric = _symmetric_form(mass, stiffness)
    squares, shapes = np.linalg.eigh(symmetric)
    squares[np.abs(squares) < 1e-12 * np.abs(squares).max()] = 0.0
    left = factor @ shapes
    return np.asarray((left * (2 * zeta * np.sqrt(np.maximum(squares, 0.0)))) @ left.T)
