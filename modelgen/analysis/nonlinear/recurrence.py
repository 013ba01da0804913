"""Does a sequence of states come back? The number of strobes after which it repeats, and from when on it stands still.

Below ``strobes``, ``surface``, ``verdict``; knows sequences only, of a driveline or of any map. A sequence has period n where
states n apart differ by no more than a tolerance, for at least four repetitions; the smallest such n counts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LONGEST = 16
REPEATS, FEWEST = 4, 16
SPLIT = 300.0  # of the tolerance: how far a shorter period must miss, or the sequence may still be on its way to it


class Recurrence(NamedTuple):
    """``period`` in strobes, 0 where none was found; ``first``: index from which on it holds; ``residual``: largest departure.

    Without a period, ``first`` is the length of the sequence and ``residual`` the least one that any period leaves.
    """

    period: int
    first: int
    residual: float


def recurrence(sequence: Array, tolerance: float, longest: int = LONGEST) -> Recurrence:
    """How the end of a sequence (strobes, coordinates), given in units of each coordinate's scale, repeats.

    The departure of a strobe is taken from the last one with the same phase, so a slow creep is no period. A motion that still
    swings to and fro about a single point while it settles is no period 2: shorter periods must miss clearly. A motion many
    scales large is held against its own size.

    >>> recurrence(np.tile([[1.0], [2.0]], (20, 1)), 1e-9)
    Recurrence(period=2, first=0, residual=0.0)
    """
    count, best, size = len(sequence), np.inf, size_of(sequence)
    for period in range(1, longest + 1):
        window = max(FEWEST, REPEATS * period)
        if count < window:
            break
        away = departures(sequence, period) / size
        residual = float(away[-window:].max())
        if residual <= tolerance and best < SPLIT * tolerance:
            break
        if residual <= tolerance:
            beyond = np.flatnonzero(away > tolerance)
            first = int(beyond[-1]) + 1 if len(beyond) else 0
            return Recurrence(period, first, float(away[first:].max()))
        best = min(best, residual)
    return Recurrence(0, count, best)


def departures(sequence: Array, period: int) -> Array:
    """Largest coordinate of the difference between each strobe and the last one of the same phase (strobes,)."""
    count = len(sequence)
    same_phase = count - 1 - (count - 1 - np.arange(count)) % period
    return np.asarray(np.abs(sequence - sequence[same_phase]).max(axis=1, initial=0.0))


def nearest_return(sequence: Array) -> float:
    """The least that any period leaves as departure over the whole sequence, of those that have four repetitions in it."""
    periods = range(1, max(1, min(LONGEST, len(sequence) // REPEATS)) + 1)
    return min(float(departures(sequence, period).max(initial=0.0)) for period in periods) / size_of(sequence)


def size_of(sequence: Array) -> float:
    """What departures refer to: the scale (1), or the largest coordinate of the last strobe where the motion has outgrown it."""
    return max(1.0, float(np.abs(sequence[-1]).max(initial=0.0))) if len(sequence) else 1.0
