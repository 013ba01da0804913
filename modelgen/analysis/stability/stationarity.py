"""Is a sequence of local means the same all the way, does it change to another, where, and by how much; or does it still drift?

Below ``exponents``; knows sequences only. The sequence is cut into blocks. Of all places where it may change (the thirds of the
record among them) the one counts whose two sides differ most, in units of the scatter of the blocks about their own side's mean,
which is widened where neighboring blocks hang together. What is left behind it is looked at again. A drift has no such place:
its blocks stand in order nearly all the way (Kendall's rank correlation with time), and its thirds go on differing.
Sources: D. M. Hawkins, J. Am. Stat. Assoc. 72 (1977) 180 (largest two-sample statistic over all places of a change);
M. G. Kendall, Biometrika 30 (1938) 81, H. B. Mann, Econometrica 13 (1945) 245 (rank correlation as a test of trend).
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
STILL = 1e-14
"""Steps of a state, per its scale, that are rounding."""
IN_ORDER = 0.6
"""Rank correlation of blocks with time above which they drift: six times its scatter for 48 blocks that know nothing of time."""
DEPARTS = 10.0
"""Times by which steps of a state grow from the first third of a record to its last one, by more than its root each third."""


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


def drift(values: Array, floor: float = 0.0) -> Array | None:
    """Means of the thirds (3,) of a sequence (terms,) that still drifts at its end, else None; ``floor`` as in ``steady_from``.

    >>> drift(1 / np.arange(10.0, 200.0)).round(2).tolist(), drift(np.random.default_rng(1).standard_normal(960))
    ([0.03, 0.01, 0.01], None)
    """
    blocks = min(BLOCKS, len(values))
    if blocks < FEWEST:
        return None
    means = np.array([each.mean() for each in np.array_split(values, blocks)])
    later, earlier = np.tril_indices(blocks, -1)
    steps = means[later] - means[earlier]
    order = float(np.where(np.abs(steps) > floor, np.sign(steps), 0.0).mean())
    thirds = np.array([each.mean() for each in np.array_split(values, 3)])
    moved = np.diff(thirds)
    least = np.maximum(floor, SMALL * np.maximum(np.abs(thirds[1:]), np.abs(thirds[:-1])))
    goes_on = abs(order) > IN_ORDER and np.all(moved * np.sign(order) > least)
    return thirds if goes_on else None


def departure(states: Array) -> float:
    """How many times larger the steps of a sequence of states (terms, states) have become, where they grow all the way; else 0.

    Steps, and not the states, so that an angle that turns on and on departs from nothing.

    >>> departure(1e-8 * np.exp(0.05 * np.arange(200.0))[:, None]) > 100, departure(np.arange(200.0)[:, None])
    (True, 0.0)
    """
    if len(states) < FEWEST:
        return 0.0
    sizes = np.abs(np.diff(states, axis=0)).max(axis=1)
    first, middle, last = (float(np.median(each)) for each in np.array_split(sizes, 3))
    grown = last / max(first, np.finfo(float).tiny)
    each = np.sqrt(DEPARTS) * 0.9
    return grown if grown > DEPARTS and last > each * middle and middle > each * first and last > STILL else 0.0
