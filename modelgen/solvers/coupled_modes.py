"""Modes of M q'' + G q' + K q = 0 where K is not symmetric, or where rates are coupled by a skew matrix G (gyroscopic terms).

Beside ``undamped_modes``, which finds those of symmetric matrices. Eigenvalues are lambda with (lambda^2 M + lambda G + K) r = 0,
of the first-order form in the chosen coordinates; positions that meet no stiffness are left out of it, so that a rigid mode
is exactly zero. A mode is a pair of conjugate eigenvalues, or two real ones. Forces that circulate (skew stiffness) can make
modes that grow without any damping.
Sources: L. Meirovitch, Computational Methods in Structural Dynamics (1980), ch. 3 and 4 (gyroscopic and circulatory systems);
F. Tisseur, K. Meerbergen, SIAM Rev. 43 (2001) 235 (linearization, left eigenvectors).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.solvers.equilibrium import Coordinates

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
ROUNDING = 1e-12  # difference of two entries that mirror each other, relative to the rows they stand in
ZERO = 1e-12  # stiffness against a motion, relative to the terms it is made of, that is rounding
REAL = 1e-7  # of an eigenvalue: a part below it may be what rounding makes of two equal eigenvalues


@dataclass(frozen=True, eq=False)
class CoupledModes:
    """The first-order form x' = A x without damping, and its modes; x: elastic coordinates, then the rates of all coordinates.

    ``values`` (modes,) complex lambda [1/s], 0 for the first ``free``; of a pair the upper one, of two real ones the larger.
    ``right``, ``left`` (groups, modes): eigenvectors with left^T (2 lambda M + G) right = 1; rigid shapes in both for those.
    ``to_angles`` (groups, coordinates): the first ``loose`` of them meet no stiffness. ``basis`` (x, x): real, a pair of columns
    for each vibrating mode, then what is left; ``block`` (x,): the mode of each column, -1 for what is left.
    ``matrix``: A. ``mass`` [kg*m^2] (groups, groups).
    """

    values: Complex
    right: Complex
    left: Complex
    free: int
    to_angles: Array
    loose: int
    basis: Array
    block: NDArray[np.intp]
    matrix: Array
    mass: Array


def is_skew(matrix: Array) -> bool:
    """Whether a square matrix differs from its mirror image by more than rounding.

    >>> is_skew(np.array([[15.0, -15.0], [-10.0, 10.0]])), is_skew(np.array([[1.0, -1.0], [-1.0 - 1e-15, 1.0]]))
    (True, False)
    """
    row = np.abs(matrix).max(axis=1, initial=0.0)
    row = np.maximum(row, np.abs(matrix).max(axis=0, initial=0.0))
    return bool(np.any(np.abs(matrix - matrix.T) > ROUNDING * np.sqrt(np.outer(row, row))))


def is_skew_sparse(matrix: Any) -> bool:
    """The same of a sparse CasADi matrix, without a dense one."""
    rows, columns = (np.array(each, dtype=np.intp) for each in matrix.sparsity().get_triplet())
    values = np.abs(np.array(matrix.nonzeros()))
    row = np.zeros(matrix.shape[0])
    np.maximum.at(row, rows, values)
    np.maximum.at(row, columns, values)
    skew = matrix - matrix.T
    rows, columns = (np.array(each, dtype=np.intp) for each in skew.sparsity().get_triplet())
    return bool(np.any(np.abs(np.array(skew.nonzeros())) > ROUNDING * np.sqrt(row[rows] * row[columns])))


def coupling_words(stiffness: Array, damping: Array) -> str:
    """What is to be said of modes of such matrices; nothing where both are symmetric."""
    causes = []
    if is_skew(stiffness):
        causes.append("the stiffness is not symmetric")
    if is_skew(damping):
        causes.append("rates are coupled gyroscopically (the damping matrix has a skew part)")
    if not causes:
        return ""
    return (
        f"{' and '.join(causes)}: frequencies are those of the full matrices; a shape shows amplitudes, with the sign of the part"
        " in phase, and energy shares are those of its motion"
    )


def coupled_modes(mass: Array, damping: Array, stiffness: Array, coordinates: Coordinates) -> CoupledModes:
    """All modes of the full ``stiffness`` and of the skew part of ``damping``. Raises LinAlgError where there are none."""
    gyroscopic = (damping - damping.T) / 2
    gyroscopic = gyroscopic if is_skew(damping) else np.zeros_like(gyroscopic)
    to_angles, loose = _loose_first(mass, stiffness, coordinates.to_angles)
    inertia = to_angles.T @ mass @ to_angles
    per_inertia = np.linalg.solve(inertia, to_angles.T @ np.hstack([stiffness @ to_angles[:, loose:], gyroscopic @ to_angles]))
    n = len(mass)
    elastic = n - loose
    matrix = np.zeros((elastic + n, elastic + n))
    matrix[:elastic, elastic + loose :] = np.eye(elastic)
    matrix[elastic:] = -per_inertia
    # Positions are counted in a unit of time that makes both halves alike.
    pace = np.sqrt(np.abs(per_inertia[loose:, :elastic]).max(initial=0.0)) or 1.0
    scale = np.concatenate([np.full(elastic, 1 / pace), np.ones(n)])
    values, vectors = _modes(matrix * scale / scale[:, None], elastic, loose, bool(np.any(gyroscopic)))
    vectors = vectors * scale[:, None]
    upper, basis, block, free = _grouped(values, vectors, n)
    left = np.linalg.inv(vectors).T[elastic:, upper]
    left = to_angles @ np.linalg.solve(inertia, left)
    right = to_angles @ vectors[elastic:, upper] / values[upper]
    rigid = _rigid(mass, to_angles[:, :loose], to_angles @ vectors[elastic:, values == 0].real, free)
    return CoupledModes(
        values=np.concatenate([np.zeros(free), values[upper]]),
        right=np.hstack([rigid, right]),
        left=np.hstack([rigid, left]),
        free=free,
        to_angles=to_angles,
        loose=loose,
        basis=basis,
        block=np.where(block >= 0, block + free, -1),
        matrix=matrix,
        mass=mass,
    )


def split_by_stiffness(stiffness: Array, motions: Array) -> tuple[Array, Array]:
    """Columns of motions over the groups: those that meet no stiffness but rounding, and the others."""
    force, size = np.abs(stiffness @ motions), np.abs(stiffness) @ np.abs(motions)
    is_free = np.all(force <= ZERO * size, axis=0)
    return motions[:, is_free], motions[:, ~is_free]


def _loose_first(mass: Array, stiffness: Array, to_angles: Array) -> tuple[Array, int]:
    """Coordinates as columns over the groups, those against which no stiffness acts first, and how many these are."""
    loose, stiff = split_by_stiffness(stiffness, to_angles)
    if stiff.size:
        # Other motions without stiffness lie across the coordinates.
        lengths = np.sqrt(np.einsum("im,ij,jm->m", stiff, mass, stiff))
        stiff = stiff / lengths
        factor = np.linalg.cholesky(mass)
        _, sizes, rows = np.linalg.svd(np.linalg.solve(factor, stiffness @ stiff))
        none = sizes <= ZERO * sizes.max(initial=0.0)
        loose, stiff = np.hstack([loose, stiff @ rows[none].T]), stiff @ rows[~none].T if none.any() else stiff
    return np.hstack([loose, stiff]), loose.shape[1]


def _modes(matrix: Array, elastic: int, loose: int, gyroscopic: bool) -> tuple[Complex, Complex]:
    """Eigenvalues and vectors of the first-order form; exactly 0 where it has no force at all."""
    size = len(matrix)
    if not gyroscopic:
        return _by_squares(matrix, elastic, loose)
    _, sizes, rows = np.linalg.svd(matrix)
    still = sizes <= ZERO * sizes.max(initial=0.0)
    across = np.vstack([rows[still], rows[~still]]).T
    none = int(still.sum())
    turned = across.T @ matrix @ across
    values, inner = np.linalg.eig(turned[none:, none:])
    values = np.where(np.abs(values.real) <= REAL * np.abs(values), 1j * values.imag, values).astype(complex)
    along = turned[:none, none:] @ inner / values
    vectors = np.zeros((size, size), dtype=complex)
    vectors[:, :none] = across[:, :none]
    vectors[:, none:] = across @ np.vstack([along, inner])
    return np.concatenate([np.zeros(none, dtype=complex), values]), vectors


def _by_squares(matrix: Array, elastic: int, loose: int) -> tuple[Complex, Complex]:
    """The same without gyroscopic terms: by lambda^2, which rounding leaves real where it is."""
    size = len(matrix)
    if not elastic:
        return np.zeros(loose, dtype=complex), np.eye(loose, dtype=complex)
    pace = matrix[0, elastic + loose]
    squares, shapes = np.linalg.eig(-matrix[elastic + loose :, :elastic] * pace)
    squares, shapes = squares.astype(complex), shapes.astype(complex)
    split = (squares.imag != 0) & (np.abs(squares.imag) <= REAL * np.abs(squares))  # one real square, twice
    shapes[:, split] = np.where(squares[split].imag > 0, shapes[:, split].real, shapes[:, split].imag)
    squares[split] = squares[split].real
    if np.any(np.abs(squares) <= ZERO * np.abs(matrix[elastic:]).max(initial=0.0) * pace):
        problem = "a motion that meets no stiffness is pushed by another one, so that it grows with time as a power does"
        raise CaseError("natural modes", f"the stiffness is not symmetric: {problem}", "give it a stiffness of its own")
    roots = np.sqrt(-squares)
    vectors = np.eye(size, dtype=complex)
    both = np.concatenate([roots, -roots])
    shapes = np.hstack([shapes, shapes])
    along = matrix[elastic : elastic + loose, :elastic] @ shapes / both
    vectors[:, : 2 * elastic] = np.vstack([shapes, along, shapes * both / pace])
    vectors[:, 2 * elastic :] = np.eye(size)[:, elastic : elastic + loose]
    return np.concatenate([both, np.zeros(loose)]), vectors


def _grouped(values: Complex, vectors: Complex, n: int) -> tuple[NDArray[np.intp], Array, NDArray[np.intp], int]:
    """The eigenvalue of each vibrating mode, by frequency; a real basis with the mode of each column; number of rigid modes."""
    upper = np.flatnonzero(values.imag > 0)
    real = np.flatnonzero((values.imag == 0) & (values != 0))
    real = real[np.argsort(-values[real].real, kind="stable")]
    pairs = [(int(real[k]), int(real[-1 - k])) for k in range(len(real) // 2)]
    # The largest first: it is as far below zero as a frequency, which does not exist, would be above.
    told = [(-abs(float(values[first].real)), (first, second)) for first, second in pairs]
    told += [(float(values[k].imag), (int(k), -1)) for k in upper]
    told.sort(key=lambda each: each[0])
    columns, block = [], []
    for number, (_, (first, second)) in enumerate(told):
        block += [number, number]
        columns += [vectors[:, first].real, vectors[:, first].imag if second < 0 else vectors[:, second].real]
    taken = {k for _, pair in told for k in pair}
    rest = [k for k in np.flatnonzero(values.imag == 0) if int(k) not in taken]
    columns += [vectors[:, k].real for k in rest]
    block += [-1] * len(rest)
    chosen = np.array([first for _, (first, _) in told], dtype=np.intp)
    return chosen, np.array(columns).reshape(-1, len(values)).T, np.array(block, dtype=np.intp), n - len(told)


def _rigid(mass: Array, loose: Array, rates: Array, free: int) -> Array:
    """Rigid shapes with shape^T M shape = 1: all motions without stiffness, or those that gyroscopic terms let go on."""
    found = loose if loose.shape[1] == free else np.linalg.svd(rates)[0][:, :free]
    if not found.size:
        return found[:, :free]
    return np.asarray(np.linalg.solve(np.linalg.cholesky(found.T @ mass @ found), found.T).T)
