"""Floquet multipliers: by what a small deviation is multiplied over one period, and how stability would be lost.

Below ``orbits``; knows numbers only. An orbit attracts if every multiplier lies inside the unit circle (those that are 1 in
theory apart: along the motion of an autonomous system, and of a rigid rotation). It loses that through +1 (fold), through -1
(flip, the period doubles) or as a pair (Neimark-Sacker, a second frequency appears).
Source: Y. A. Kuznetsov, Elements of Applied Bifurcation Theory (2004), ch. 4-5.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
MARGIN = 1e-6
"""From the unit circle, within which 1 is not told from another size: where two multipliers meet, their error is a root."""
_REAL = 1e-5


def multipliers_of(monodromy: NDArray[np.float64], along: NDArray[np.float64] | None) -> tuple[Complex, complex | None]:
    """Multipliers, largest first, and the one along the motion, whose direction is given; None without one.

    >>> found, flow = multipliers_of(np.array([[1.0, 5.0], [0.0, -0.5]]), np.array([1.0, 0.0]))
    >>> [complex(each) for each in found], flow
    ([(-0.5+0j)], (1+0j))
    """
    if along is None:
        return _sorted(np.asarray(np.linalg.eigvals(monodromy), dtype=complex)), None
    # In a basis that begins with the motion, the monodromy matrix is block triangular up to the error of integration.
    basis = np.linalg.qr(np.column_stack([along, np.eye(len(along))]))[0]
    turned = basis.T @ monodromy @ basis
    return _sorted(np.asarray(np.linalg.eigvals(turned[1:, 1:]), dtype=complex)), complex(turned[0, 0])


def _sorted(values: Complex) -> Complex:
    return values[np.lexsort((-values.imag, -values.real, -np.abs(values)))]


def stability(multipliers: Complex) -> str:
    """ "stable", "unstable", or "undecided" where the largest multiplier is as good as on the unit circle."""
    largest = float(np.abs(multipliers).max(initial=0.0))
    return "stable" if largest < 1 - MARGIN else "unstable" if largest > 1 + MARGIN else "undecided"


def kind_of_loss(multiplier: complex) -> str:
    """Through which bifurcation a multiplier leaves the unit circle there.

    >>> kind_of_loss(1.2), kind_of_loss(-1.01), kind_of_loss(0.8 + 0.7j)
    ('fold', 'flip', 'Neimark-Sacker')
    """
    if abs(complex(multiplier).imag) > _REAL * abs(multiplier):
        return "Neimark-Sacker"
    return "fold" if complex(multiplier).real > 0 else "flip"


def kinds_of_loss(multipliers: Complex) -> tuple[str, ...]:
    """Every kind by which stability is lost already, in the order of the multipliers."""
    return tuple(dict.fromkeys(kind_of_loss(each) for each in multipliers if abs(each) > 1 + MARGIN))
