"""Tests on a sequence of section points: does it still change, does it need few lines, does it wander like noise?

Below ``verdict``; knows sequences only.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FREQUENCIES = 100  # of the 0-1 test; the median over them is taken
STRONGEST = 12  # lines
TREND = 0.1  # of the spread: a steady change that is let pass


def drift(points: Array, tolerance: float) -> float:
    """How far the halves of a section (points, coordinates) differ: change of mean and of spread, per the larger spread.

    The coordinate that changes most counts, of those that move by more than the tolerance. A spread that falls or grows through
    all four quarters by a third or more is a change too, however few the points are.
    """
    half = len(points) // 2
    first, second = points[:half], points[half : 2 * half]
    spreads = np.array([part.std(axis=0) for part in (first, second)])
    size = spreads.max(axis=0)
    moving = size > tolerance
    if not np.any(moving):
        return 0.0
    noise = 3.0 / np.sqrt(half)  # what the mean of independent points wanders by
    mean = np.abs(first.mean(axis=0) - second.mean(axis=0))[moving] / size[moving] - noise
    spread = np.abs(spreads[0] - spreads[1])[moving] / size[moving] - noise / np.sqrt(2)
    quarters = np.array([part.std(axis=0)[moving] for part in np.array_split(points, 4)])
    steps = np.diff(quarters, axis=0)
    one_way = np.all(steps > 0, axis=0) | np.all(steps < 0, axis=0)
    trend = np.where(one_way, 1 - quarters.min(axis=0) / quarters.max(axis=0), 0.0) - TREND
    return float(max(mean.max(), spread.max(), trend.max(), 0.0))


def main_coordinates(points: Array, count: int = 2) -> Array:
    """The directions of largest spread (points, up to ``count``), each of unit spread."""
    centered = points - points.mean(axis=0)
    left, size, _ = np.linalg.svd(centered, full_matrices=False)
    kept = size[:count] > 1e-12 * max(float(size[0]), 1e-300)
    return np.asarray(left[:, :count][:, kept] * np.sqrt(len(points)))


def line_share(points: Array) -> float:
    """Part of the power of the section's spectrum in its strongest lines; near 1 for periodic and quasi-periodic motion.

    Each line is a peak with its neighbors under a Hann window; a broad spectrum spreads over all frequencies.
    """
    signal = main_coordinates(points, 1)
    count = len(points)
    if not signal.size:
        return 1.0
    wave = signal[:, 0] - signal[:, 0].mean()
    power = np.abs(np.fft.rfft(wave * np.hanning(count))) ** 2
    total, found = float(power.sum()), 0.0
    lines = max(1, min(STRONGEST, len(power) // 16))
    for _ in range(lines):
        peak = int(power.argmax())
        part = slice(max(0, peak - 2), peak + 3)
        found += float(power[part].sum())
        power[part] = 0.0
    return found / total if total > 0 else 1.0


def zero_one(points: Array) -> float:
    """The 0-1 test for chaos on a section: K near 0 for regular motion, near 1 for chaotic motion.

    Translation variables p, q driven by the points at a frequency c; K is the correlation of their mean square displacement,
    damped by its oscillating term, with the number of steps. The median over many c in (pi/5, 4 pi/5) is taken.
    """
    signal = main_coordinates(points, 1)
    if not signal.size:
        return 0.0
    wave = signal[:, 0]
    count = len(wave)
    steps = count // 10
    n = np.arange(1, steps + 1)
    angles = np.pi / 5 + 3 * np.pi / 5 * (np.arange(FREQUENCIES) + 0.5) / FREQUENCIES
    found = []
    for c in angles:
        turned = np.cumsum(wave * np.exp(1j * c * np.arange(1, count + 1)))
        kept = count - steps
        displaced = np.array([np.mean(np.abs(turned[k : k + kept] - turned[:kept]) ** 2) for k in n])
        damped = displaced - wave.mean() ** 2 * (1 - np.cos(n * c)) / (1 - np.cos(c))
        found.append(float(np.corrcoef(n, damped)[0, 1]) if np.ptp(damped) > 0 else 0.0)
    return float(np.median(found))
