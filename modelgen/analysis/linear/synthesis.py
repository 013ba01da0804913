"""From harmonics back to time: orders summed with their phases over the cycle after which all of them repeat.

Below ``forced``. The sum is exact, not a root of a sum of squares: peaks depend on phases.
"""

from __future__ import annotations

from fractions import Fraction
from math import gcd, lcm

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
LONGEST = 2**21  # samples of a cycle
MOST = 2**26  # samples of all sums together, in seconds of work


def common_cycle(orders: tuple[Fraction, ...]) -> Fraction:
    """Turns of the reference shaft after which all orders repeat; 1 without orders.

    >>> common_cycle((Fraction(1, 2), Fraction(3), Fraction(26, 3)))
    Fraction(6, 1)
    """
    if not orders:
        return Fraction(1)
    return 1 / Fraction(gcd(*(each.numerator for each in orders)), lcm(*(each.denominator for each in orders)))


def samples_of_cycle(orders: tuple[Fraction, ...], points: int = 64) -> int:
    """Samples of one common cycle with so many in a period of the highest order."""
    return points * max((int(order * common_cycle(orders)) for order in orders), default=1)


def synthesize(orders: tuple[Fraction, ...], amplitudes: Complex, points: int = 64) -> tuple[Array, Array]:
    """Re sum_h amplitude_h e^(i 2 pi order_h turn) over one common cycle.

    ``amplitudes`` (..., orders). Returns turns of the reference shaft (samples,), at least ``points`` per period of the highest
    order, and values (..., samples). Raises CaseError where the cycle is too long to be sampled.

    >>> turns, values = synthesize((Fraction(1, 2), Fraction(1)), np.array([1.0, -1.0j]), points=4)
    >>> turns.tolist(), values.round(6).tolist()  # cos(x/2) + sin(x) over two turns
    ([0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75],
     [1.0, 1.707107, 0.0, -1.707107, -1.0, 0.292893, 0.0, -0.292893])
    """
    cycle, count = common_cycle(orders), samples_of_cycle(orders, points)
    places = [int(order * cycle) for order in orders]
    if count > LONGEST:
        problem = f"the orders repeat only after {cycle} turns, {count} samples"
        raise CaseError("synthesis over the cycle", problem, "take the orders of one base frequency at a time, or a lowest few")
    spectrum = np.zeros((*amplitudes.shape[:-1], count // 2 + 1), dtype=complex)
    spectrum[..., places] = amplitudes / 2
    values = np.fft.irfft(spectrum * count, count, axis=-1)
    return float(cycle) * np.arange(count) / count, values


def extremes(orders: tuple[Fraction, ...], groups: tuple[tuple[str, ...], ...], amplitudes: Complex) -> tuple[Array, Array, bool]:
    """Least and largest value (...,) of the synthesized sum, and whether they are reached within the common cycle.

    Where that cycle is too long for the number of sums asked for, the sums of the extremes of each group of orders (``groups``:
    names per order) bound them: orders that never repeat together come as close to that as one waits.
    """
    count = samples_of_cycle(orders)
    sums = int(np.prod(amplitudes.shape[:-1]))
    if count <= LONGEST and count * sums <= MOST:
        values = synthesize(orders, amplitudes)[1]
        return values.min(axis=-1), values.max(axis=-1), True
    low, high = np.zeros(amplitudes.shape[:-1]), np.zeros(amplitudes.shape[:-1])
    for name in dict.fromkeys(groups):
        mine = [k for k, group in enumerate(groups) if group == name]
        values = synthesize(tuple(orders[k] for k in mine), amplitudes[..., mine])[1]
        low, high = low + values.min(axis=-1), high + values.max(axis=-1)
    return low, high, False
