"""Frequency response: steady motion of a linear driveline under harmonic forces, at many frequencies at once.

Below ``forced``, which asks it for every order at every speed; open to loops of one's own. D(w) = K + i H + i w C - w^2 M is
solved by elimination along the driveline (``elimination``), every solution is checked by its residual, and the frequencies that
elimination without pivoting does not solve well are solved again with pivoting.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.elimination import Elimination
from modelgen.errors import CaseError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
GOOD = 1e-13  # residual, relative to the terms it is made of, that needs no improvement
SINGULAR = 1e14  # response per force, relative to the size of D, beyond which there is none
NUMBERS = 400_000  # entries of all matrices of a batch: they stay in the cache


def frequency_response(
    mass: Array, damping: Array, stiffness: Array, frequencies: Array, force: Any, hysteresis: Array | None = None
) -> Complex:
    """Complex amplitudes q (n, f) of M q'' + C q' + (K + i H) q = force e^(i w t), at ``frequencies`` w (f,) [rad/s].

    ``mass`` [kg*m^2], ``damping`` [N*m*s/rad], ``stiffness`` and ``hysteresis`` [N*m/rad] (n, n), not necessarily symmetric;
    ``force`` (n, f), or (n,) for the same at every frequency [N*m]. The motion is the real part of q e^(i w t) [rad].
    Raises CaseError where a frequency is that of an undamped mode, and for shapes that do not fit.

    A disk of 2 kg*m^2 on a spring of 800 N*m/rad to ground (20 rad/s), at a quarter and at four times its natural frequency:

    >>> frequency_response(np.eye(1) * 2, np.zeros((1, 1)), np.eye(1) * 800, np.array([5.0, 80.0]), np.array([75.0])).real
    array([[ 0.1   , -0.00625]])
    """
    omega = np.asarray(frequencies, dtype=float)
    n, count = len(mass), omega.size
    right = np.asarray(force, dtype=complex)
    right = np.repeat(right[:, None], count, axis=1) if right.shape == (n,) else right
    hysteresis = np.zeros((n, n)) if hysteresis is None else hysteresis
    matrices = [np.asarray(each, dtype=float) for each in (mass, damping, hysteresis, stiffness)]
    if omega.ndim != 1 or right.shape != (n, count) or any(each.shape != (n, n) for each in matrices):
        shapes = f"matrices {', '.join(str(each.shape) for each in matrices)}, frequencies {omega.shape}, forces {right.shape}"
        raise CaseError("frequency response", f"does not fit: {shapes}", "give (n, n) matrices, f frequencies and (n, f) forces")
    pattern = sum(each != 0 for each in matrices) + np.eye(n)
    rows, columns = np.nonzero(pattern)
    entries = np.array([each[rows, columns] for each in matrices])
    elimination = Elimination(n, rows, columns) if len(rows) < n * n / 3 else None
    found = np.empty((n, count), dtype=complex)
    chunk = max(1, NUMBERS // (elimination.slots if elimination else n * n))
    for first in range(0, count, chunk):
        part = slice(first, first + chunk)
        found[:, part] = _solved(elimination, rows, columns, entries, omega[part], right[:, part])
    return found


def _solved(elimination: Elimination | None, rows: Any, columns: Any, entries: Array, omega: Array, right: Complex) -> Complex:
    """Solutions for a batch of frequencies, checked."""
    mass, damping, hysteresis, stiffness = entries[:, :, None]
    values = stiffness - omega**2 * mass + 1j * (hysteresis + omega * damping)
    n = len(right)
    starts = np.flatnonzero(np.diff(rows, prepend=-1))

    def product(entry: Any, x: Any) -> Any:
        return np.add.reduceat(entry * x[columns], starts, axis=0)

    def wrong(x: Complex) -> tuple[Complex, Array]:
        with np.errstate(all="ignore"):
            rest = right - product(values, x)
            size = product(np.abs(values), np.abs(x)) + np.abs(right)
            share = np.where(size > 0, np.abs(rest) / np.where(size > 0, size, 1.0), 0.0).max(axis=0, initial=0.0)
        return rest, np.where(np.isfinite(share), share, np.inf)

    poor = np.ones(len(omega), dtype=bool)
    x = np.zeros_like(right)
    if elimination is not None:
        placed = np.zeros((elimination.slots, len(omega)), dtype=complex)
        placed[elimination.slots_of(rows, columns)] = values
        factors = elimination.factor(placed)
        x = factors.solve(right)
        rest, share = wrong(x)
        if share.max(initial=0.0) > GOOD:
            x = x + factors.solve(rest)  # one step of iterative refinement
            share = wrong(x)[1]
        poor = share > 10 * GOOD
    if poor.any():
        for k in np.flatnonzero(poor):
            dense = np.zeros((n, n), dtype=complex)
            dense[rows, columns] = values[:, k]
            try:
                x[:, k] = np.linalg.solve(dense, right[:, k])
            except np.linalg.LinAlgError:
                x[:, k] = np.inf
    with np.errstate(all="ignore"):
        gain = np.abs(x).max(axis=0) * np.abs(values).max(axis=0)
        bad = ~(gain <= SINGULAR * np.abs(right).max(axis=0)) & (np.abs(right).max(axis=0) > 0)
    if bad.any():
        at = omega[bad][0]
        raise CaseError(
            "frequency response", f"{at:.9g} rad/s is the frequency of an undamped mode", "add damping or go around it"
        )
    return x
