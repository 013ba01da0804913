"""Fourier series of the mesh stiffness (Eq. 9) and what it leaves out.

Follows ``mesh``; ``mesh_stiffness_rows`` is the entry from which parameters of a model are derived.

    k_m(tau) = k_0 + sum over n of [a_n cos(2 pi n tau) + b_n sin(2 pi n tau)], tau = omega_m t / (2 pi).

The rows are the least-squares ones. Their rms error can only fall with the order, while the largest error of a function with
jumps stays at half the jump (Gibbs): no order is "the one with the smallest error", so both errors are given for every order.
Source: any text on Fourier series; the paper, Eq. 9 and its Fig. 1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.gears.bounds import whole
from modelgen.gears.geometry import Gear
from modelgen.gears.helical import overlap_rows
from modelgen.gears.mesh import GearMesh
from modelgen.gears.piecewise import PeriodicFunction, gauss_nodes, sample_phases


@dataclass(frozen=True, eq=False)
class FourierSeries:
    """mean, and cosine a_n and sine b_n rows for n = 1 ... order, in the unit of the function."""

    mean: float
    cosine: NDArray[np.float64]
    sine: NDArray[np.float64]

    @property
    def order(self) -> int:
        return len(self.cosine)

    def __call__(self, phase: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """The series at a phase (in periods), in its shape."""
        angle = 2 * math.pi * np.asarray(phase, dtype=float)[..., None] * np.arange(1, self.order + 1)
        return self.mean + np.cos(angle) @ self.cosine + np.sin(angle) @ self.sine


@dataclass(frozen=True, eq=False)
class SeriesErrors:
    """Errors of the series cut after order 0, 1, 2, ..., each as a fraction of the mean."""

    order: NDArray[np.int_]
    rms: NDArray[np.float64]
    maximum: NDArray[np.float64]


def fit_series(function: PeriodicFunction, breaks: Sequence[float], order: int) -> FourierSeries:
    """Fourier series of a function of period 1 that is smooth between the breaks, to rounding.

    >>> series = fit_series(lambda phase: 3 + np.sin(2 * np.pi * phase), [0.0], order=2)
    >>> round(series.mean, 12), series.sine.round(12).tolist()
    (3.0, [1.0, 0.0])
    """
    phases, weights = gauss_nodes(breaks, waves=order)
    values = weights * function(phases)
    angles = 2 * math.pi * np.arange(1, order + 1)[:, None] * phases
    return FourierSeries(float(np.sum(values)), 2 * np.cos(angles) @ values, 2 * np.sin(angles) @ values)


def mesh_stiffness_series(mesh: GearMesh, order: int) -> FourierSeries:
    """Mean [N/m] and rows [N/m] of the mesh stiffness. Raises CaseError unless the order is whole and 0 to 500.

    >>> mesh = GearMesh(Gear(26, 0.007), Gear(46, 0.007), face_width=0.110)
    >>> series = mesh_stiffness_series(mesh, order=10)
    >>> print(f"{series.mean:.5e} {series.cosine[0]:.4e} {series.sine[0]:.4e}")
    2.46466e+09 -3.0074e+08 4.9647e+08
    """
    order = _checked_order(order)
    one_slice = fit_series(mesh.slice_stiffness, mesh.slice_breaks, order)
    # Exact for the stack of slices, and without effect on spur gears.
    return FourierSeries(one_slice.mean, *overlap_rows(one_slice.cosine, one_slice.sine, mesh.overlap_ratio))


def series_errors(mesh: GearMesh, highest_order: int) -> SeriesErrors:
    """Rms and largest error of the truncated series for every order up to the highest, relative to the mean.

    >>> errors = series_errors(GearMesh(Gear(26, 0.007), Gear(46, 0.007), face_width=0.110), 10)
    >>> print(f"order 10: rms {errors.rms[10]:.2%}, largest {errors.maximum[10]:.0%}")
    order 10: rms 4.07%, largest 21%
    """
    highest_order = _checked_order(highest_order)
    series = mesh_stiffness_series(mesh, highest_order)
    nodes, weights = gauss_nodes(mesh.breaks, waves=2 * highest_order)
    looked_at = sample_phases(mesh.breaks, per_period=32 * max(highest_order, 8))
    phases = np.concatenate([nodes, looked_at])
    residual = mesh.stiffness(phases) - series.mean
    rms, maximum = [], []
    for order in range(highest_order + 1):
        if order:
            angle = 2 * math.pi * order * phases
            residual = residual - series.cosine[order - 1] * np.cos(angle) - series.sine[order - 1] * np.sin(angle)
        rms.append(math.sqrt(weights @ residual[: len(nodes)] ** 2))
        maximum.append(float(np.max(np.abs(residual))))
    return SeriesErrors(np.arange(highest_order + 1), np.array(rms) / series.mean, np.array(maximum) / series.mean)


def mesh_stiffness_rows(
    teeth_1: int,
    teeth_2: int,
    module: float,
    face_width: float,
    pressure_angle: float,
    young_modulus: float,
    poisson_ratio: float,
    shear_factor: float,
    profile_shift_1: float,
    profile_shift_2: float,
    order: int,
) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    """k_0 [N/m] and the rows a_n, b_n [N/m], n = 1 ... order, of a spur gear pair, from plain SI numbers and radians.

    The same numbers give the same bits. Raises ModelError for gears that cannot run, CaseError for a bad order.

    >>> mean, cosine, sine = mesh_stiffness_rows(17, 108, 0.009, 0.220, math.radians(20), 206e9, 0.3, 1.0, 0.0, 0.0, 10)
    >>> print(f"{mean:.5e}", cosine.shape, sine.shape)
    4.91019e+09 (10,) (10,)
    """
    gear_1 = Gear(teeth_1, module, profile_shift_1, pressure_angle)
    gear_2 = Gear(teeth_2, module, profile_shift_2, pressure_angle)
    series = mesh_stiffness_series(GearMesh(gear_1, gear_2, face_width, young_modulus, poisson_ratio, shear_factor), order)
    return series.mean, series.cosine, series.sine


def _checked_order(order: int) -> int:
    return whole(order, "order", "mesh stiffness series", at_least=0, at_most=500, refusal=CaseError)
