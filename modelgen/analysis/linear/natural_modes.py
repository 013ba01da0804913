"""Natural modes of M q'' + C q' + K q = 0, all of them, for drivelines of up to some hundred degrees of freedom.

Below ``modal``, on the undamped modes of ``modelgen.solvers.undamped_modes``.
Source: F. Tisseur, K. Meerbergen, SIAM Rev. 43 (2001) 235 (state-space form).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.mode_pairing import followed, is_upper
from modelgen.solvers.coupled_modes import ZERO, CoupledModes
from modelgen.solvers.undamped_modes import Modes, natural_modes

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

__all__ = ["DampedModes", "Modes", "damped_modes", "natural_modes"]


@dataclass(frozen=True, eq=False)
class DampedModes:
    """Damped vibrating modes by frequency: ``values`` s [1/s], Im s > 0, and ``shapes`` q (groups, modes) of q e^(st).

    ``undamped``: number of the undamped mode that each belongs to, -1 for an oscillation of own states alone. ``rates``
    (undamped modes, 2) [1/s]: the two rates of decay of an overdamped mode, the slower first; nan for the others.
    """

    values: Complex
    shapes: Complex
    undamped: NDArray[np.intp]
    rates: Array

    @property
    def frequencies(self) -> Array:
        """Damped frequencies [Hz]."""
        return np.asarray(self.values.imag / (2 * np.pi))

    @property
    def damping_ratios(self) -> Array:
        """-Re s / |s|."""
        return np.asarray(-self.values.real / np.abs(self.values) + 0.0)

    @property
    def decay_rates(self) -> Array:
        """-Re s [1/s]."""
        return np.asarray(-self.values.real + 0.0)


def damped_modes(modes: Modes, damping: Any, stiffness: Array | None = None) -> DampedModes:
    """Damped vibrating modes, each with its undamped one; overdamped ones as two rates.

    In the coordinates of ``modes``, without the angles of the free ones, so that their zero eigenvalues do not come in; where
    only some lowest modes are given, the damping is projected on them. ``damping`` (groups, groups), an array or a sparse
    CasADi matrix. ``stiffness``, where given, adds its skew part; both may have more rows and columns than groups: those of own
    states z with z' + C_zq q' + K_zq q + K_zz z = 0. Which belongs to which: ``mode_pairing``.
    """
    if modes.coupled is not None and stiffness is not None:
        return damped_coupled_modes(modes.coupled, len(modes.squares), damping, stiffness)
    shapes, free, count = modes.shapes, modes.free, modes.shapes.shape[1]
    undamped, matrix, kept = _first_order(modes, damping, stiffness)
    elastic, moving = count - free, int(kept.sum())
    block = np.full(len(matrix), elastic, dtype=np.intp)  # the last one: rigid rates and own states
    block[:elastic] = np.arange(elastic)
    block[elastic : elastic + moving][np.flatnonzero(kept) >= free] = np.arange(elastic)
    values, vectors, owner = followed(undamped, matrix, block)
    upper = np.flatnonzero(is_upper(values))
    upper = upper[np.argsort(values[upper].imag, kind="stable")]
    found = shapes[:, kept] @ vectors[elastic : elastic + moving, upper] / values[upper]
    return _told(values, owner, upper, found, (free, count), elastic)


def _told(
    values: Any, owner: NDArray[np.intp], upper: NDArray[np.intp], shapes: Any, modes: tuple[int, int], nobody: int
) -> DampedModes:
    """Damped modes from eigenvalues, the vibrating mode that owns each (``nobody``: none), and which are the upper ones.

    ``shapes`` (groups, upper ones) are scaled to 1 at their largest; ``modes``: numbers of free ones, and of all.
    """
    free, count = modes
    largest = np.abs(shapes).argmax(axis=0)
    rates = np.full((count, 2), np.nan)
    for mode in range(count - free):
        own = values[owner == mode]
        if not np.any(is_upper(own)):
            rates[free + mode] = np.sort(-own.real)
    return DampedModes(
        _without_rounding(values[upper].astype(complex), values),
        (shapes / shapes[largest, np.arange(len(upper))]).astype(complex),
        np.where(owner[upper] == nobody, -1, owner[upper] + free),
        rates,
    )


def _without_rounding(chosen: Complex, every: Complex) -> Complex:
    """Eigenvalues whose real part is no more than rounding, of either sign, are those of a mode without damping."""
    rounding = 4 * np.finfo(float).eps * float(np.abs(every).max(initial=0.0))
    return np.where(np.abs(chosen.real) <= rounding, 1j * chosen.imag, chosen)


def _first_order(modes: Modes, damping: Any, stiffness: Array | None) -> tuple[Array, Array, NDArray[np.bool_]]:
    """x' = A x without and with what couples modes; x: angles of the vibrating modes, the rates that are ``kept``, own states."""
    shapes, free = modes.shapes, modes.free
    n, count = shapes.shape
    own = damping.shape[0] - n
    inner = shapes.T @ _times(damping[:n, :n], shapes)
    squares = np.diag(modes.squares)[:, free:]
    matrix_of_angles = squares
    if stiffness is not None:
        matrix_of_angles = squares + shapes.T @ (stiffness[:n, :n] - stiffness[:n, :n].T) @ shapes[:, free:] / 2
    # A rigid rate stays where drag acts on it, and where own states might.
    size = np.abs(shapes[:, :free]).T @ _times(abs(damping[:n, :n]), np.abs(shapes))
    kept = np.ones(count, dtype=bool)
    kept[:free] = np.any(np.abs(inner[:free]) > ZERO * size, axis=1) | (own > 0)
    angles, rates = slice(0, count - free), slice(count - free, count - free + int(kept.sum()))
    matrix = np.zeros((rates.stop + own,) * 2)
    matrix[angles, rates] = np.eye(count)[free:, kept]
    undamped = matrix.copy()
    undamped[rates, angles] = -squares[kept]
    matrix[rates, angles] = -matrix_of_angles[kept]
    matrix[rates, rates] = -inner[np.ix_(kept, kept)]
    if own and stiffness is not None:
        rest = slice(rates.stop, None)
        matrix[rates, rest] = -shapes[:, kept].T @ stiffness[:n, n:]
        matrix[rest, angles] = -stiffness[n:, :n] @ shapes[:, free:]
        matrix[rest, rates] = -damping[n:, :n] @ shapes[:, kept]
        matrix[rest, rest] = undamped[rest, rest] = -stiffness[n:, n:]
    return undamped, matrix, kept


def _times(matrix: Any, columns: Array) -> Array:
    """Product of an array, or of a sparse CasADi matrix, with columns."""
    product = matrix @ columns
    return np.asarray(product.full() if isinstance(product, ca.DM) else product)


def damped_coupled_modes(coupled: CoupledModes, count: int, damping: Array, stiffness: Array) -> DampedModes:
    """The same of modes whose matrices are not symmetric, all of them, of which those of the ``count`` lowest are given."""
    n, free, to_angles = len(coupled.to_angles), coupled.free, coupled.to_angles
    elastic = n - coupled.loose
    undamped, matrix = _coupled_first_order(coupled, damping, stiffness)
    vibrating = len(coupled.values) - free
    block = np.full(len(matrix), vibrating, dtype=np.intp)
    block[: 2 * n - coupled.loose] = np.where(coupled.block >= 0, coupled.block - free, vibrating)
    whole = np.eye(len(matrix))
    whole[: len(coupled.basis), : len(coupled.basis)] = coupled.basis
    alone, all_of_it = (np.asarray(np.linalg.solve(whole, each @ whole)) for each in (undamped, matrix))
    values, vectors, owner = followed(alone, all_of_it, block)
    moves = np.abs(values) > ZERO * np.abs(values).max(initial=0.0)
    kept = (owner < count - free) | ((owner == vibrating) & moves)
    upper = np.flatnonzero(is_upper(values) & kept)
    upper = upper[np.argsort(values[upper].imag, kind="stable")]
    found = to_angles @ (whole @ vectors[:, upper])[elastic : elastic + n] / values[upper]
    return _told(values, owner, upper, found, (free, count), vibrating)


def _coupled_first_order(coupled: CoupledModes, damping: Array, stiffness: Array) -> tuple[Array, Array]:
    """x' = A x without and with damping and own states; x: elastic coordinates, rates of all of them, own states."""
    to_angles, inner = coupled.to_angles, len(coupled.matrix)
    n, own = len(to_angles), len(damping) - len(to_angles)
    elastic = n - coupled.loose
    undamped = np.zeros((inner + own, inner + own))
    undamped[:inner, :inner] = coupled.matrix
    matrix = undamped.copy()
    rates, rest = slice(elastic, inner), slice(inner, None)
    inertia = to_angles.T @ coupled.mass @ to_angles
    symmetric = (damping[:n, :n] + damping[:n, :n].T) / 2
    matrix[rates, rates] -= np.linalg.solve(inertia, to_angles.T @ symmetric @ to_angles)
    if own:
        matrix[rates, rest] = -np.linalg.solve(inertia, to_angles.T @ stiffness[:n, n:])
        matrix[rest, :elastic] = -stiffness[n:, :n] @ to_angles[:, coupled.loose :]
        matrix[rest, rates] = -damping[n:, :n] @ to_angles
        matrix[rest, rest] = undamped[rest, rest] = -stiffness[n:, n:]
    return undamped, matrix
