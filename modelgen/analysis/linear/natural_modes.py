"""Natural modes of M q'' + C q' + K q = 0, all of them, for drivelines of up to some hundred degrees of freedom.

Below ``modal``. What turns or moves without any stiffness is split off first, in the chosen coordinates, so a rigid mode is
exactly zero and takes no accuracy from the others; each frequency is then improved by its Rayleigh quotient in relative angles,
where a tree of shafts has a diagonal stiffness and nothing cancels.
Sources: F. Tisseur, K. Meerbergen, SIAM Rev. 43 (2001) 235 (state-space form); B. N. Parlett, The Symmetric Eigenvalue Problem
(1998), ch. 1 (Rayleigh quotient).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.solvers.equilibrium import Coordinates

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
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
    """All undamped modes. ``mass`` and the symmetric part of ``stiffness`` (groups, groups) count."""
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


@dataclass(frozen=True, eq=False)
class DampedModes:
    """Damped vibrating modes by frequency: ``values`` s [1/s], Im s > 0, and ``shapes`` q (groups, modes) of q e^(st)."""

    values: Complex
    shapes: Complex

    @property
    def frequencies(self) -> Array:
        """Damped frequencies [Hz]."""
        return np.asarray(self.values.imag / (2 * np.pi))

    @property
    def damping_ratios(self) -> Array:
        """-Re s / |s|."""
        return np.asarray(-self.values.real / np.abs(self.values))

    @property
    def decay_rates(self) -> Array:
        """-Re s [1/s]."""
        return np.asarray(-self.values.real)


def damped_modes(modes: Modes, damping: Any, stiffness: Array | None = None) -> DampedModes:
    """Damped vibrating modes, those that do not oscillate left out.

    In the coordinates of ``modes``, without the angles of the free ones, so that their zero eigenvalues do not come in; where
    only some lowest modes are given, the damping is projected on them. ``damping`` (groups, groups), an array or a sparse
    CasADi matrix. ``stiffness``, where given, adds its skew part; both may have more rows and columns than groups: those of own
    states z with z' + C_zq q' + K_zq q + K_zz z = 0.
    """
    shapes, free = modes.shapes, modes.free
    n, count = shapes.shape
    own = damping.shape[0] - n
    inner = shapes.T @ _times(damping[:n, :n], shapes)
    matrix_of_angles = np.diag(modes.squares)[:, free:]
    if stiffness is not None:
        matrix_of_angles = matrix_of_angles + shapes.T @ (stiffness[:n, :n] - stiffness[:n, :n].T) @ shapes[:, free:] / 2
    # A rigid rate stays where drag acts on it, and where own states might.
    size = np.abs(shapes[:, :free]).T @ _times(abs(damping[:n, :n]), np.abs(shapes))
    kept = np.ones(count, dtype=bool)
    kept[:free] = np.any(np.abs(inner[:free]) > ZERO * size, axis=1) | (own > 0)
    angles, rates = slice(0, count - free), slice(count - free, count - free + int(kept.sum()))
    matrix = np.zeros((rates.stop + own,) * 2)
    matrix[angles, rates] = np.eye(count)[free:, kept]
    matrix[rates, angles] = -matrix_of_angles[kept]
    matrix[rates, rates] = -inner[np.ix_(kept, kept)]
    if own and stiffness is not None:
        rest = slice(rates.stop, None)
        matrix[rates, rest] = -shapes[:, kept].T @ stiffness[:n, n:]
        matrix[rest, angles] = -stiffness[n:, :n] @ shapes[:, free:]
        matrix[rest, rates] = -damping[n:, :n] @ shapes[:, kept]
        matrix[rest, rest] = -stiffness[n:, n:]
    values, vectors = np.linalg.eig(matrix) if len(matrix) else (np.zeros(0, dtype=complex), matrix)
    upper = np.flatnonzero(values.imag > 1e-9 * np.abs(values))
    upper = upper[np.argsort(values[upper].imag, kind="stable")]
    found = shapes[:, kept] @ vectors[rates, upper] / values[upper]
    largest = np.abs(found).argmax(axis=0)
    return DampedModes(values[upper].astype(complex), (found / found[largest, np.arange(len(upper))]).astype(complex))


def _times(matrix: Any, columns: Array) -> Array:
    """Product of an array, or of a sparse CasADi matrix, with columns."""
    product = matrix @ columns
    return np.asarray(product.full() if isinstance(product, ca.DM) else product)
