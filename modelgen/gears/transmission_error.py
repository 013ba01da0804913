"""Static transmission error under load: how far the driven gear lags, along the line of action.

Follows ``mesh``. With slow rotation and the flanks loaded one way, k_m (delta - b) = F along the line of action. The half
backlash b only shifts the reading by a constant and is left out, so

    TE(tau) = r_b1 theta_1 - r_b2 theta_2 = F / k_m(tau) + e(tau),  F = T_1 / r_b1,

with the composite error e of Eq. 11 on the same clock: phase 0 where a tooth pair enters contact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.gears.bounds import bounded
from modelgen.gears.mesh import GearMesh
from modelgen.gears.piecewise import gauss_nodes, sample_phases


@dataclass(frozen=True)
class MeshError:
    """Composite error of the teeth over a base pitch (Eq. 11): ``mean`` e_0 and ``amplitude`` e_r [m], ``angle`` phi [rad].

    >>> float(MeshError(amplitude=10e-6)(0.25))
    1e-05
    """

    amplitude: float = 0.0
    mean: float = 0.0
    angle: float = 0.0

    def __post_init__(self) -> None:
        bounded(self.amplitude, "amplitude", "mesh error", "m", at_least=0)
        bounded(self.mean, "mean", "mesh error", "m")
        bounded(self.angle, "angle", "mesh error", "rad")

    def __call__(self, phase: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """e(tau) = e_0 + e_r sin(2 pi tau + phi) [m]."""
        return self.mean + self.amplitude * np.sin(2 * math.pi * np.asarray(phase, dtype=float) + self.angle)


@dataclass(frozen=True, eq=False)
class TransmissionError:
    """``value`` [m] at each ``phase`` [base pitches] of one period, both sides of every jump included; ``mean`` [m]."""

    phase: NDArray[np.float64]
    value: NDArray[np.float64]
    mean: float

    @property
    def peak_to_peak(self) -> float:
        """Largest minus smallest value [m]: what excites the gears."""
        return float(np.ptp(self.value))


_NO_ERROR = MeshError()


def static_transmission_error(
    mesh: GearMesh, torque_1: float, error: MeshError = _NO_ERROR, per_period: int = 256
) -> TransmissionError:
    """Transmission error over a base pitch under the torque [N m] that drives gear 1. Raises ModelError unless torque_1 > 0.

    >>> from modelgen.gears.geometry import Gear
    >>> mesh = GearMesh(Gear(26, 0.007), Gear(46, 0.007), face_width=0.110)
    >>> loaded = static_transmission_error(mesh, torque_1=6442.0)
    >>> print(f"mean {loaded.mean * 1e6:.1f} um, peak to peak {loaded.peak_to_peak * 1e6:.1f} um")
    mean 32.0 um, peak to peak 17.4 um
    """
    where = "static transmission error"
    force = bounded(torque_1, "torque_1", where, "N*m", above=0) / mesh.gear_1.base_radius
    per_period = int(bounded(per_period, "per_period", where, at_least=3, at_most=1e6))
    phase = sample_phases(mesh.breaks, per_period)
    nodes, weights = gauss_nodes(mesh.breaks)
    mean = float(weights @ (force / mesh.stiffness(nodes) + error(nodes)))
    return TransmissionError(phase, force / mesh.stiffness(phase) + error(phase), mean)
