"""How sure is a mean of a sequence whose terms hang together? Its 95 % interval from means of long blocks.

Below ``exponents``; knows sequences only. Where blocks are so long that they know nothing of each other, the spread of their
means tells that of the whole mean, whatever hangs together inside a block, with either sign. How long that is, is not known: the
largest of the estimates from 16, 32 and 64 blocks counts.
Sources: H. Flyvbjerg, H. G. Petersen, J. Chem. Phys. 91 (1989) 461; Student's t by its expansion, M. Abramowitz, I. A. Stegun,
Handbook of Mathematical Functions (1964), 26.7.5.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
BLOCKS = (64, 32, 16)
_NORMAL = 1.959963984540054


def half_width(values: Array) -> Array:
    """Half the 95 % interval of the mean of each column of (terms, columns); not a number below 16 terms.

    >>> half_width(np.tile([[1.0], [-1.0]], (32, 1))).round(3).tolist()
    [0.252]
    """
    widest = np.full(values.shape[1], np.nan)
    for blocks in BLOCKS:
        size = len(values) // blocks
        if size:
            means = values[len(values) - blocks * size :].reshape(blocks, size, -1).mean(axis=1)
            widest = np.fmax(widest, student(blocks - 1) * means.std(axis=0, ddof=1) / np.sqrt(blocks))
    return widest


def student(freedom: int) -> float:
    """The 97.5 % point of Student's t, from four degrees of freedom on to 0.5 %.

    >>> round(student(7), 2), round(student(30), 3)
    (2.36, 2.042)
    """
    z = _NORMAL
    return (
        z
        + (z**3 + z) / (4 * freedom)
        + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * freedom**2)
        + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * freedom**3)
    )
