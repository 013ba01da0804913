"""Is a sequence of local means the same all the way, or does it change to another? Where, and by how much.

Below ``exponents``; knows sequences only. The sequence is cut into blocks. Of all places where it may change (the thirds of the
record among them) the one counts whose two sides differ most, in units of the scatter of the blocks about their own side's mean,
which is widened where neighboring blocks hang together. What is left behind it is looked at again.
Source: D. M. Hawkins, J. Am. Stat. Assoc. 72 (1977) 180 (largest two-sample statistic over all places of a change).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
BLOCKS, FEWEST = 48, 24
LEAST = 2
"""Blocks on either side of a change."""
CLEAR = 5.0
"""The statistic above which a change is one: of sequences without any, less than one in a thousand reaches it."""
SMALL = 0.05
"""Of the larger mean: a smaller change is none."""
CHANGES = 3


def steady_from(values: Array, floor: float = 0.0) -> int:
    """The place from which on a sequence (terms,) is one and the same; 0 where it is so from the beginning.

    ``floor``: changes of the mean below it are none.

    >>> noise = np.random.default_rng(1).standard_normal(960)
    >>> steady_from(noise), steady_from(np.where(np.arange(960) < 400, 3.0, 0.0) + noise)
    (0, 400)
    """
    place = 0
    for _ in range(CHANGES):
        step = _change(values[place:], floor)
        if not step:
            break
        place += step
    return place


def _change(values: Array, floor: float) -> int:
    """The first term after the clearest change, 0 for none."""
    blocks = min(BLOCKS, len(values))
    if blocks < FEWEST:
        return 0
    size = len(values) // blocks
    offset = len(values) - size * blocks
    means = values[offset:].reshape(blocks, size).mean(axis=1)
    best, place = 0.0, 0
    for split in range(LEAST, blocks - LEAST + 1):
        before, after = means[:split], means[split:]
        step = abs(float(before.mean() - after.mean()))
        if step <= max(floor, SMALL * max(abs(before.mean()), abs(after.mean()))):
            continue
        rest = np.concatenate([before - before.mean(), after - after.mean()])
        error = np.sqrt(_variance(rest) * (1 / split + 1 / (blocks - split)))
        if step > best * error:
            best, place = step / error if error > 0 else np.inf, split
    return offset + place * size if best > CLEAR else 0


def _variance(rest: Array) -> float:
    """Variance of what is left of the blocks, widened where each knows of the one before."""
    variance = float(rest @ rest) / (len(rest) - 2)
    if variance == 0:
        return 0.0
    together = min(0.9, max(0.0, float(rest[1:] @ rest[:-1]) / float(rest @ rest)))
    return variance * (1 + together) / (1 - together)
