"""Speeds at which an order meets a mode between two speeds of a grid, close enough together that the peak is read right.

Below ``forced``. Near a resonance with damping ratio zeta the response over speed is 1/sqrt(1 + (d/zeta)^2) of its peak, d the
relative distance from it; a grid as coarse as zeta misses a third. Source: D. J. Inman, Engineering Vibration (2014), sec. 2.2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.excitation import Excitation
from modelgen.analysis.linear.frequency_response import frequency_response
from modelgen.analysis.linear.natural_modes import Modes, natural_modes
from modelgen.solvers.linear_model import LinearModel

Array = NDArray[np.float64]
AROUND = np.array([0.0, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0, 1.5, 2.5])
"""Distances from a resonance, in damping ratios: half of the closest gap reads a peak to 0.1 %."""
FINE = 0.2  # damping ratios between speeds of a grid that needs nothing more
SEEN = 1e-3  # share of a channel by which a resonance must stand out
UNDAMPED = 1e-9  # damping ratio below which a peak has no height


def resonance_speeds(
    linear: LinearModel, shaking: Excitation, response: NDArray[np.complex128], low: float, high: float
) -> Array:
    """Speeds [rad/s] within (low, high) to be added, by the linear model and the excitation at the lower one.

    ``response`` (channels, orders): amplitudes at the lower speed.
    """
    point = linear.point
    modes = natural_modes(point.mass, point.stiffness, point.coordinates, point.damping)
    omega = np.sqrt(np.maximum(modes.squares[modes.free :], 0.0))
    ratio = _damping_ratios(linear, modes, omega)
    orders = np.array([float(order) for order in shaking.orders])
    speeds = omega[:, None] / orders[None, :] if len(orders) else np.zeros((len(omega), 0))
    coarse = (speeds > low) & (speeds < high) & (ratio[:, None] > UNDAMPED) & (high - low > FINE * ratio[:, None] * speeds)
    mode, order = np.nonzero(coarse)
    if not len(mode):
        return np.zeros(0)
    found = speeds[mode, order]
    at_peak, *ends = (_alone(linear, shaking, order, each) for each in (found, np.full(len(mode), low), np.full(len(mode), high)))
    level = np.abs(response).sum(axis=1, keepdims=True)
    stands = np.any(at_peak - np.maximum(*ends) > SEEN * np.maximum(level, 1e-300), axis=0)
    around = np.concatenate([-AROUND[:0:-1], AROUND])
    near = (found[stands, None] * (1 + ratio[mode[stands], None] * around)).ravel()
    return np.unique(near[(near > low * (1 + 1e-12)) & (near < high * (1 - 1e-12))])


def _damping_ratios(linear: LinearModel, modes: Modes, omega: Array) -> Array:
    """Damping ratio of each vibrating mode, as far as damping leaves its shape as it is."""
    n, free = len(modes.shapes), modes.free
    matrices = [each[:n, :n] for each in (linear.damping, linear.hysteresis)]
    with np.errstate(divide="ignore", invalid="ignore"):
        if modes.coupled is None:
            shapes = modes.shapes[:, free:]
            viscous, lossy = (np.einsum("im,ij,jm->m", shapes, each, shapes) for each in matrices)
            return np.asarray((viscous + lossy / omega) / (2 * omega))
        left, right, value = modes.coupled.left[:, free:], modes.coupled.right[:, free:], modes.coupled.values[free:]
        matrices[0] = (matrices[0] + matrices[0].T) / 2  # the skew part is in the modes
        viscous, lossy = (np.einsum("im,ij,jm->m", left, each, right) for each in matrices)
        return np.asarray((value * viscous + 1j * lossy - value).real / omega)


def _alone(linear: LinearModel, shaking: Excitation, order: NDArray[np.int64], speeds: Array) -> Array:
    """Size (channels, resonances) of what each order alone gives at its speed."""
    n = len(linear.mass)
    omega = np.array([float(each) for each in shaking.orders])[order] * speeds
    force = shaking.amplitudes[:n, order]
    motion = frequency_response(linear.mass, linear.damping, linear.stiffness, omega, force, linear.hysteresis)
    gain = linear.by_angle @ motion + 1j * (linear.by_speed @ (omega * motion) + linear.by_hysteresis @ motion)
    return np.asarray(np.abs(gain + shaking.amplitudes[n:, order]))
