"""Undamped natural modes of M q'' + K q = 0, all of them, for drivelines of up to some hundred degrees of freedom.

Where K is not symmetric, or rates are coupled gyroscopically, they are those of ``coupled_modes``.

Below ``operating_point``, and below the modes with damping in ``analysis``. What turns or moves without any stiffness is split
off first, in the chosen coordinates, so a rigid mode is exactly zero and takes no accuracy from the others; each frequency is
then improved by its Rayleigh quotient in relative angles, where a tree of shafts has a diagonal stiffness and nothing cancels.
Source: B. N. Parlett, The Symmetric Eigenvalue Problem (1998), ch. 1 (Rayleigh quotient).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.solvers.coupled_modes import CoupledModes, coupled_modes, is_skew, split_by_stiffness
from modelgen.solvers.equilibrium import Coordinates

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Modes:
    """Undamped modes, those without stiffness first, the others by frequency.

    ``squares`` [rad^2/s^2], exactly zero for the first ``free`` modes, negative for an unstable one; ``shapes`` (groups, modes)
    with shape^T M shape = 1. ``coupled``: the modes of full matrices that are not symmetric, from which these are read; a shape
    then shows the amplitudes of its motion, with the sign of the part that moves in phase with the largest.
    """

    squares: Array
    shapes: Array
    free: int
    coupled: CoupledModes | None = None

    @property
    def frequencies(self) -> Array:
        """Natural frequencies [Hz]; an unstable mode has a negative one."""
        return np.asarray(np.sign(self.squares) * np.sqrt(np.abs(self.squares)) / (2 * np.pi))

    @property
    def growth(self) -> Array:
        """Rates [1/s] with which modes grow without any damping; 0 for those that do not."""
        if self.coupled is None:
            return np.sqrt(np.maximum(-self.squares, 0.0))
        return np.asarray(np.maximum(self.coupled.values.real[: len(self.squares)], 0.0))

    @property
    def motions(self) -> Array | Complex:
        """Shapes (groups, modes), complex where parts of a mode move out of phase."""
        return self.shapes if self.coupled is None else self.coupled.right[:, : len(self.squares)]

    def lowest(self, count: int | None) -> Modes:
        """The first ``count`` of them, or all."""
        return Modes(self.squares[:count], self.shapes[:, :count], min(self.free, count or len(self.squares)), self.coupled)


def natural_modes(mass: Array, stiffness: Array, coordinates: Coordinates, damping: Array | None = None) -> Modes:
    """All undamped modes of ``mass`` and ``stiffness`` (groups, groups), and of the skew part of ``damping``, where given.

    Raises CaseError for inertias and stiffnesses that lie so far apart that double precision holds no modes of them.
    """
    try:
        with np.errstate(all="ignore"):
            if is_skew(stiffness) or (damping is not None and is_skew(damping)):
                found = _read(
                    coupled_modes(mass, np.zeros_like(mass) if damping is None else damping, stiffness, coordinates), mass
                )
            else:
                found = _natural_modes(mass, stiffness, coordinates)
        if np.isfinite(found.squares).all() and np.isfinite(found.shapes).all():
            return found
    except np.linalg.LinAlgError:
        pass
    inertias = np.diag(coordinates.to_angles.T @ mass @ coordinates.to_angles)
    what = f"its inertias, from {inertias.min():.3g} to {inertias.max():.3g} kg*m^2, and its stiffnesses lie too far apart"
    raise CaseError("natural modes", f"{what} for double precision", "check inertias and stiffnesses, and their units")


def _natural_modes(mass: Array, stiffness: Array, coordinates: Coordinates) -> Modes:
    """All undamped modes, or LinAlgError or numbers that are not finite."""
    stiffness = (stiffness + stiffness.T) / 2
    # Rigid rotations, and relative angles that meet no stiffness where the driveline rests, such as a flank inside its backlash.
    loose, stiff = split_by_stiffness(stiffness, coordinates.to_angles)
    inertia = loose.T @ mass @ loose
    elastic = stiff - loose @ np.linalg.solve(inertia, loose.T @ mass @ stiff) if loose.size else stiff
    reduced_mass, reduced_stiffness = elastic.T @ mass @ elastic, stiff.T @ stiffness @ stiff
    factor = np.linalg.cholesky(reduced_mass)
    symmetric = np.linalg.solve(factor, np.linalg.solve(factor, reduced_stiffness).T)
    _, vectors = np.linalg.eigh((symmetric + symmetric.T) / 2)
    vectors = np.linalg.solve(factor.T, vectors)
    squares = np.einsum("im,ij,jm->m", vectors, reduced_stiffness, vectors) / np.einsum(
        "im,ij,jm->m", vectors, reduced_mass, vectors
    )
    order = np.argsort(squares, kind="stable")
    rigid = np.linalg.solve(np.linalg.cholesky(inertia), loose.T).T if loose.size else loose
    shapes = np.hstack([rigid, (elastic @ vectors)[:, order]])
    shapes = shapes / np.sqrt(np.einsum("im,ij,jm->m", shapes, mass, shapes))
    return Modes(np.concatenate([np.zeros(loose.shape[1]), squares[order]]), shapes, loose.shape[1])


def _read(coupled: CoupledModes, mass: Array) -> Modes:
    """Frequencies and amplitudes of coupled modes."""
    values, right = coupled.values, coupled.right
    omega = np.where(values.imag > 0, values.imag, -np.abs(values.real))
    largest = right[np.abs(right).argmax(axis=0), np.arange(right.shape[1])]
    in_phase = (right * (np.abs(largest) / largest)).real
    shapes = np.abs(right) * np.where(in_phase < 0, -1.0, 1.0)
    shapes = shapes / np.sqrt(np.einsum("im,ij,jm->m", shapes, mass, shapes))
    return Modes(np.sign(omega) * omega**2, shapes, coupled.free, coupled)
