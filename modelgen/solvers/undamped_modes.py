"""Undamped natural modes of M q'' + K q = 0, all of them, for drivelines of up to some hundred degrees of freedom.

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
from modelgen.solvers.equilibrium import Coordinates

Array = NDArray[np.float64]
ZERO = 1e-12  # stiffness against a motion, relative to the terms it is made of, that is rounding


@dataclass(frozen=True, eq=False)
class Modes:
    """Undamped modes, those without stiffness first, the others by frequency.

    ``squares`` [rad^2/s^2], exactly zero for the first ``free`` modes, negative for an unstable one; ``shapes`` (groups, modes)
    with shape^T M shape = 1.
    """

    squares: Array
    shapes: Array
    free: int

    @property
    def frequencies(self) -> Array:
        """Natural frequencies [Hz]; an unstable mode has a negative one."""
        return np.asarray(np.sign(self.squares) * np.sqrt(np.abs(self.squares)) / (2 * np.pi))


def natural_modes(mass: Array, stiffness: Array, coordinates: Coordinates) -> Modes:
    """All undamped modes. ``mass`` and the symmetric part of ``stiffness`` (groups, groups) count.

    Raises CaseError for inertias and stiffnesses that lie so far apart that double precision holds no modes of them.
    """
    try:
        with np.errstate(all="ignore"):
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
    to_angles = coordinates.to_angles
    force, size = np.abs(stiffness @ to_angles), np.abs(stiffness) @ np.abs(to_angles)
    is_free = np.all(force <= ZERO * size, axis=0)
    loose, stiff = to_angles[:, is_free], to_angles[:, ~is_free]
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
