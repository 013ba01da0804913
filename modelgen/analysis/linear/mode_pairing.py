"""Which eigenvalues of the damped motion belong to which undamped mode: followed as the damping grows from nothing.

Below ``natural_modes``. Without damping every mode k has the pair +- i omega_k. The damping, and whatever else couples the modes,
then grows in steps from 0 to its full size; after each step an eigenvalue stays with the mode in whose plane its vector lies (the
participation factor of power-system modal analysis). Steps are halved until nobody is in doubt. A pair that meets the real axis
goes on as two real rates of its mode. So every mode has one pair or two real rates, whatever the order of frequencies, and no
mode loses its own because another one is overdamped.
Source: I. J. Perez-Arriaga, G. C. Verghese, F. C. Schweppe, IEEE Trans. PAS 101 (1982) 3117 (participation factors).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Numbers = NDArray[np.intp]
SURE = 0.6  # least participation of an eigenvalue in its mode for a step to be taken
FINEST = 1 / 256  # share of the damping below which a step is taken even so: two modes pass through each other there
REAL = 1e-9  # of an imaginary part per size that is rounding


def is_upper(values: Complex) -> NDArray[np.bool_]:
    """Which eigenvalues stand for an oscillation, one of each conjugate pair."""
    return np.asarray(values.imag > REAL * np.abs(values))


def followed(undamped: Array, damped: Array, block: Numbers) -> tuple[Complex, Complex, Numbers]:
    """Eigenvalues and vectors of ``damped``, and for each eigenvalue the block that it belongs to.

    ``block``: number of the block of each coordinate in ``undamped``, whose blocks do not see each other. Each block keeps as
    many eigenvalues as it has coordinates, and never half of a conjugate pair.
    """
    if not len(block):
        return np.zeros(0, dtype=complex), np.zeros((0, 0), dtype=complex), block
    share, step = 0.0, 1.0
    owner = block
    vectors = inverse = np.eye(len(block), dtype=complex)
    while True:
        step = min(step, 1.0 - share)
        whole = share + step >= 1.0
        values, found = np.linalg.eig(damped if whole else undamped + (share + step) * (damped - undamped))
        found = found.astype(complex)
        back = _inverse(found)
        part = _participation(inverse @ found, back @ vectors, owner, int(block.max()) + 1)
        named, least = _assigned(values, part, np.bincount(block, minlength=len(part)))
        if least < SURE and step > FINEST:
            step /= 2
            continue
        share, owner, vectors, inverse = share + step, named, found, back
        if whole:
            return values, found, owner
        step *= 2


def _inverse(vectors: Complex) -> Complex:
    try:
        return np.asarray(np.linalg.inv(vectors))
    except np.linalg.LinAlgError:  # exactly at the real axis two vectors are one
        return np.asarray(np.linalg.pinv(vectors))


def _participation(ahead: Complex, back: Complex, owner: Numbers, blocks: int) -> Array:
    """(blocks, eigenvalues): how much of each new eigenvalue lies in the plane of each block's old ones; 1 if all does."""
    shares = ahead * back.T
    total = np.zeros((blocks, shares.shape[1]), dtype=complex)
    np.add.at(total, owner, shares)
    return np.abs(total)


def _assigned(values: Complex, part: Array, room: Numbers) -> tuple[Numbers, float]:
    """The block of each eigenvalue, the largest participation first, pairs before real ones; and the least one that was taken."""
    room = room.copy()
    owner = np.full(len(values), -1, dtype=np.intp)
    partner = _partners(values)
    least = np.inf
    for size, mine in ((2, np.flatnonzero(is_upper(values))), (1, np.flatnonzero(partner < 0))):
        todo = set(mine.tolist())
        for place in np.argsort(-part[:, mine], axis=None, kind="stable"):
            number, column = divmod(int(place), len(mine))
            value = int(mine[column])
            if value in todo and room[number] >= size:
                todo.remove(value)
                room[number] -= size
                least = min(least, float(part[number, value]))
                owner[value] = number
                if size == 2:
                    owner[partner[value]] = number
    return owner, least


def _partners(values: Complex) -> Numbers:
    """The conjugate of each eigenvalue of a real matrix, which ``eig`` puts beside it; -1 for a real one."""
    partner = np.full(len(values), -1, dtype=np.intp)
    upper = np.flatnonzero(is_upper(values))
    partner[upper], partner[upper + 1] = upper + 1, upper
    return partner
