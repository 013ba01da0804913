"""Helical teeth as thin spur slices: what the overlap does to the mesh stiffness.

Follows ``piecewise``, used by ``mesh`` and ``fourier``. Cut across the axis, a helical pair is a stack of thin spur pairs that do
not share load sideways. A slice at the fraction u of the face width runs u * eps_beta base pitches behind the first one, so
the mesh stiffness is the slice stiffness averaged over the last eps_beta periods:

    k_m(tau) = (1/eps_beta) * integral of k_slice(tau - w) dw, w from 0 to eps_beta.

The mean does not change. A harmonic n shrinks by |sinc(n eps_beta)| and lags by half the overlap; at a whole overlap ratio
nothing varies any more, and likewise at a whole transverse contact ratio as far as the pairs are equally stiff.

The stiffness of the slices is that of the normal section (virtual spur gear), whose flank is run through in proportion to the
transverse one, along a contact line of length b/cos(beta_b). Force and deflection normal to the tooth turn into those in the
transverse plane with cos(beta_b) each, which leaves the width b cos(beta_b), nearly the b cos(beta) of ISO 6336-1. Neglected:
coupling between slices, support by unloaded parts of the tooth, the ends of the face width.
Source: the slicing principle, e.g. J. D. Smith, Gear Noise and Vibration, 2nd ed. (2003); ISO 6336-1.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modelgen.gears.piecewise import PeriodicFunction, window_average

# Slices out of step by less than this are in step: the average over so short a window would be all rounding.
IN_STEP = 1e-9


def overlap_average(
    slice_stiffness: PeriodicFunction, breaks: Sequence[float], overlap_ratio: float, phase: NDArray[np.float64] | float
) -> NDArray[np.float64]:
    """Mesh stiffness of the stack at a phase, from that of a slice, in the slice's unit.

    >>> saw = lambda phase: phase % 1.0
    >>> float(overlap_average(saw, [0.0], 0.5, 0.5))  # mean of 0 ... 0.5
    0.25
    """
    if overlap_ratio < IN_STEP:
        return slice_stiffness(np.asarray(phase, dtype=float))
    return window_average(slice_stiffness, breaks, overlap_ratio, phase)


def overlap_rows(
    cosine: NDArray[np.float64], sine: NDArray[np.float64], overlap_ratio: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fourier rows a_n, b_n (n = 1, 2, ...) of the stack, from those of a slice: exact.

    c_n = a_n - i b_n turns into c_n exp(-i pi n eps_beta) sinc(n eps_beta).

    >>> cosine, sine = overlap_rows(np.array([1.0]), np.array([0.0]), 1.0)
    >>> abs(float(cosine[0])) < 1e-15
    True
    """
    shift = np.arange(1, len(cosine) + 1) * overlap_ratio
    rows = (cosine - 1j * sine) * np.exp(-1j * np.pi * shift) * np.sinc(shift)
    return rows.real, -rows.imag


def overlap_breaks(breaks: Sequence[float], overlap_ratio: float) -> tuple[float, ...]:
    """Phases where the stack's stiffness is not smooth: first and last slice cross the slice's own breaks."""
    return (*breaks, *((phase + overlap_ratio) % 1.0 for phase in breaks))
