"""Signals over unequal samples: values in between, amplitudes of orders, and the shift that lays one over another.

Below ``compare``. Harmonic amplitudes by least squares need no resampling and no window function (J. S. Bendat, A. G.
Piersol, Random Data, ch. 11, for the estimate; de Boor, A Practical Guide to Splines, ch. IV, for cubic Hermite interpolation).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
GOLDEN = (np.sqrt(5.0) - 1) / 2
MOST_CANDIDATES = 4000


def interpolant(times: Array, values: Array) -> Callable[[Array], Array]:
    """The signal as a function of time: cubic Hermite interpolation with central slopes; the ends hold beyond the ends.

    >>> t = np.linspace(0, 1, 101)
    >>> round(float(interpolant(t, np.sin(6 * t))(np.array([0.333]))[0] - np.sin(6 * 0.333)), 6)
    0.0
    """
    slopes = np.gradient(values, times)

    def at(when: Array) -> Array:
        left = np.clip(np.searchsorted(times, when, side="right") - 1, 0, len(times) - 2)
        step = times[left + 1] - times[left]
        s = np.clip((when - times[left]) / step, 0.0, 1.0)
        rest = 1 - s
        ends = values[left] * (1 + 2 * s) * rest**2 + values[left + 1] * (3 - 2 * s) * s**2
        return np.asarray(ends + step * s * rest * (slopes[left] * rest - slopes[left + 1] * s))

    return at


def order_amplitudes(times: Array, values: Array, frequency: float, count: int, line: bool) -> NDArray[np.complex128]:
    """Complex amplitudes X_h of the orders h = 1 ... count: values = mean (+ line) + sum Re X_h exp(i 2 pi h frequency t).

    ``frequency`` [Hz]; least squares over the samples, which should cover whole periods.
    """
    phase = 2 * np.pi * frequency * np.outer(times, np.arange(1, count + 1))
    middle, half = (times[0] + times[-1]) / 2, (times[-1] - times[0]) / 2
    columns = [np.ones((len(times), 1)), *([((times - middle) / half)[:, None]] if line else []), np.cos(phase), np.sin(phase)]
    found = np.linalg.lstsq(np.hstack(columns), values, rcond=None)[0]
    return np.asarray(found[-2 * count : -count] - 1j * found[-count:])


def correlation(first: Array, second: Array) -> float:
    """Correlation coefficient of two signals over the same samples; 0 where one of them is constant."""
    a, b = first - first.mean(), second - second.mean()
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 0 else 0.0


def best_shift(score: Callable[[float], float], low: float, high: float, step: float) -> float:
    """The shift between ``low`` and ``high`` of the largest score: every ``step`` first, then by golden section."""
    count = min(MOST_CANDIDATES, int(np.ceil((high - low) / step)) + 1)
    candidates = np.linspace(low, high, max(count, 3))
    best = int(np.argmax([score(float(each)) for each in candidates]))
    a, b = float(candidates[max(best - 1, 0)]), float(candidates[min(best + 1, len(candidates) - 1)])
    for _ in range(40):
        inner, outer = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
        if score(inner) >= score(outer):
            b = outer
        else:
            a = inner
    return (a + b) / 2
