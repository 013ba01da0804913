"""Natural modes of M q'' + C q' + K q = 0, all of them, for drivelines of up to some hundred degrees of freedom.

Below ``modal``. What turns or moves without any stiffness is split off first, in the chosen coordinates, so a rigid mode is exactly
zero and takes no accuracy from the others; each frequency is then improved by its Rayleigh quotient in relative angles, where a
tree of shafts has a diagonal stiffness and nothing cancels.
Sources: F. Tisseur, K. Meerbergen, SIAM Rev. 43 (2001) 235 (state-space form); B. N. Parlett, The Symmetric Eigenvalue Problem
(1998), ch. 1 (Rayleigh quotient).
"""

from __future__ import annotations

from dataclasses import dataclass

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
    squares = np.einsum("im,ij,jm->m", vectors, reduced_stiffness, vectors) / np.einsum("im,ij,jm->m", vectors, reduced_mass, vectors)
    order = np.argsort(squares, kind="stable")
    rigid = np.linalg.solve(np.linalg.cholesky(inertia), loose.T).T if loose.size else loose
    shapes = np.hstack([rigid, (elastic @ vectors)[:, order]])
    shapes = shapes / np.sqrt(np.einsum("im,ij,jm->m", shapes, mass, shapes))
    return Modes(np.concatenate([np.zeros(loose.shape[1]), squares[order]]), shapes, loose.shape[1])


@dataclass(frozen=True, eq=False)
class DampedModes:
    """Damped vibrating modes: ``values`` s [1/s] with positive imaginary part, by frequency, and ``shapes`` (groups, modes) of q e^(st)."""

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


def damped_modes(damping: Array, stiffness: Array, modes: Modes) -> DampedModes:
    """Damped vibrating modes, those that do not oscillate left out.

    In the coordinates of ``modes``, without the angles of the free ones, so that their zero eigenvalues do not come in.
    ``damping`` and ``stiffness`` may have more rows and columns than groups: those of own states z with z' + C_zq q' + K_zq q +
    K_zz z = 0. Only some lowest modes given: the damping is projected on them.
    """
    shapes, free = modes.shapes, modes.free
    n, count = shapes.shape
    elastic = shapes[:, free:]
    skew = (stiffness[:n, :n] - stiffness[:n, :n].T) / 2
    inner_stiffness = np.diag(modes.squares)[:, free:] + shapes.T @ skew @ elastic
    inner_damping = shapes.T @ damping[:n, :n] @ shapes
    # A rigid rate stays where drag acts on it.
    drag = np.abs(shapes[:, :free]).T @ np.abs(damping[:n, :n])
    kept = np.ones(count, dtype=bool)
    kept[:free] = np.any(np.abs(shapes[:, :free].T @ damping[:n, :n]) > ZERO * drag, axis=1) | (len(damping) > n)
    angles, rates = count - free, int(kept.sum())
    own = len(damping) - n
    matrix = np.zeros((angles + rates + own,) * 2)
    matrix[:angles, angles : angles + rates] = np.eye(count)[free:, kept]
    matrix[angles : angles + rates, :angles] = -inner_stiffness[kept]
    matrix[angles : angles + rates, angles : angles + rates] = -inner_damping[np.ix_(kept, kept)]
    matrix[angles : angles + rates, angles + rates :] = -shapes[:, kept].T @ stiffness[:n, n:]
    matrix[angles + rates :, :angles] = -stiffness[n:, :n] @ elastic
    matrix[angles + rates :, angles : angles + rates] = -damping[n:, :n] @ shapes[:, kept]
    matrix[angles + rates :, angles + rates :] = -stiffness[n:, n:]
    values, vectors = np.linalg.eig(matrix)
    upper = np.flatnonzero(values.imag > 1e-9 * np.abs(values))
    upper = upper[np.argsort(values[upper].imag, kind="stable")]
    found = shapes[:, kept] @ vectors[angles : angles + rates, upper] / values[upper]
    largest = np.abs(found).argmax(axis=0)
    return DampedModes(values[upper].astype(complex), (found / found[largest, np.arange(len(upper))]).astype(complex))
