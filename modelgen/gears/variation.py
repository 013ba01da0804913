"""How much the mesh stiffness varies over a base pitch.

Follows ``fourier``; the short answer to "how rough is this mesh", spur or helical.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from modelgen.gears.mesh import GearMesh
from modelgen.gears.piecewise import gauss_nodes, sample_phases


@dataclass(frozen=True)
class StiffnessVariation:
    """Mean, smallest and largest mesh stiffness and its standard deviation over a base pitch, all [N/m]."""

    mean: float
    minimum: float
    maximum: float
    deviation: float

    @property
    def peak_to_peak(self) -> float:
        """(maximum - minimum) / mean [1]."""
        return (self.maximum - self.minimum) / self.mean


def stiffness_variation(mesh: GearMesh) -> StiffnessVariation:
    """The variation of k_m; mean and deviation by integration, extremes from 1024 phases and both sides of every jump.

    >>> from modelgen.gears.geometry import Gear
    >>> spur = stiffness_variation(GearMesh(Gear(26, 0.007), Gear(46, 0.007), face_width=0.110))
    >>> print(f"{spur.minimum / 1e9:.3f} ... {spur.maximum / 1e9:.3f}, mean {spur.mean / 1e9:.3f}")
    1.714 ... 2.834, mean 2.465
    """
    phases, weights = gauss_nodes(mesh.breaks)
    stiffness = mesh.stiffness(phases)
    mean = float(weights @ stiffness)
    extremes = np.concatenate([stiffness, mesh.stiffness(sample_phases(mesh.breaks, per_period=1024))])
    deviation = math.sqrt(weights @ (stiffness - mean) ** 2)
    return StiffnessVariation(mean, float(np.min(extremes)), float(np.max(extremes)), deviation)
