"""The operating point: parameters in balance, the static state under mean torques, and the linear model about it.

Between ``lowering`` and everything that asks a question: the static start, the scales of the states, modal damping and modal
analysis all rest on it. The mean model replaces what varies with time by its mean over a period; the static state loads the
meshes on the flank that the mean torque presses.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.lowering import Compiled
from modelgen.lowering.parameters import MODAL
from modelgen.solvers.equilibrium import Coordinates
from modelgen.solvers.static_state import StaticState, remaining_torques, static_state
from modelgen.solvers.undamped_modes import natural_modes

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """A driveline at rest relative to its uniform rotation.

    ``p`` (parameters, complete), ``mean`` (means of what varies with time), ``angle`` (static angle of each group [rad], from
    uniform rotation), ``start`` (the static state), ``mass``, ``damping``, ``stiffness`` (matrices over group angles), ``drift``
    [rad/s^2] (acceleration of the reference shaft that an unbalanced mean torque causes), ``coordinates`` (states and angles).
    ``holding`` [N*m]: torque of every element that sticks or has slipped on the way; ``remarks``: what the torques alone do not
    decide, and what was taken. ``no_rest``: why there is no static state, where none was needed; the angles are then zero.
    ``begin``: the state where a run starts at rest; that of ``start``, but with what has slipped a little inside its limit.
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
    holding: Mapping[str, float] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    no_rest: str = ""
    begin: Array | None = None

    def frequencies(self) -> Array:
        """Undamped natural frequencies [Hz], sorted; a rigid rotation is at zero."""
        return np.sort(natural_modes(self.mass, self.stiffness, self.coordinates, self.damping).frequencies)

    def remaining(self, model: Compiled) -> list[tuple[str, float, float]]:
        """Where several speeds are given: the shaft of each, the mean torque left along it, and the sum of the sizes."""
        if self.coordinates.by_speed.shape[1] < 2:
            return []
        torque = model.mean_model.torque_at(self.p, self.mean, np.zeros(len(self.angle)), model.mean_model.own_start)
        return remaining_torques(model, torque, self.coordinates)


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


def point_of(model: Compiled, must_rest: bool = True) -> OperatingPoint:
    """The operating point for the values that a model holds; see ``bound_model.operating_point``."""
    p = model.parameters.vector()
    coordinates = Coordinates.of(model, p)
    mean = model.mean_model.means_at(p)
    if len(coordinates.ratio):
        _check_finite(model, *model.mean_model.matrices_at(p, mean, np.zeros(len(coordinates.ratio)), model.mean_model.own_start))
    try:
        rest, no_rest = static_state(model, p, mean, coordinates), ""
    except CaseError as error:
        if must_rest:
            raise
        rest, no_rest = StaticState(np.zeros(len(coordinates.ratio)), 0.0, {}, ()), f"{error.where}: {error.problem}"
    own, angle = model.mean_model.own_start, rest.angle
    mass, damping, stiffness = model.mean_model.matrices_at(p, mean, angle, own)
    if model.equations.modal_ratio is not None:
        zeta = model.parameters.value(p, model.equations.modal_ratio)
        p[model.parameters.slices[MODAL]] = _modal_damping(mass, stiffness, zeta).ravel(order="F")
        mass, damping, stiffness = model.mean_model.matrices_at(p, mean, angle, own)
    start = np.asarray(model.mean_model.coordinates(angle, np.zeros_like(angle), own, p)).ravel()
    begin = start
    if rest.begin is not None:
        begin = np.asarray(model.mean_model.coordinates(rest.begin, np.zeros_like(angle), own, p)).ravel()
    return OperatingPoint(
        p, mean, angle, start, mass, damping, stiffness, rest.drift, coordinates, rest.holding, rest.remarks, no_rest, begin
    )


def _check_finite(model: Compiled, mass: Array, damping: Array, stiffness: Array) -> None:
    """Raises CaseError for matrices, or accelerations by them, that leave the range of numbers."""
    with np.errstate(all="ignore"):
        for name, matrix in (("mass", mass), ("damping", damping), ("stiffness", stiffness)):
            per_inertia = matrix / np.diag(mass)[:, None]
            if not np.all(np.isfinite(per_inertia)):
                group = model.equations.groups[int(np.argmin(np.isfinite(per_inertia).all(axis=1)))]
                what = f"the {name} at {group!r}, or what it is per inertia there, is beyond double precision"
                raise CaseError(f"driveline {model.name!r}", what, "check inertias, stiffnesses and damping there")


def _modal_damping(mass: Array, stiffness: Array, zeta: float) -> Array:
    """C = sum of 2 zeta omega_i (M v_i)(M v_i)^T over the elastic modes v_i with v^T M v = 1; zero for rigid rotation."""
    factor, symmetric = _symmetric_form(mass, stiffness)
    squares, shapes = np.linalg.eigh(symmetric)
    squares[np.abs(squares) < 1e-12 * np.abs(squares).max()] = 0.0
    left = factor @ shapes
    return np.asarray((left * (2 * zeta * np.sqrt(np.maximum(squares, 0.0)))) @ left.T)
