"""What every peer gets: numbers of a driveline, a start, output times, and how large an error is. No code of modelgen's solvers.

States of the peers are the angles of all inertias counted from uniform rotation, then their rates. Sums of harmonics are laid out
as series on one base frequency each, so that every peer may use recurrences where its manual allows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from modelgen import Driveline, assemble, lower
from modelgen.analysis.referee.mujoco_model import Wave, referee_of
from modelgen.lowering import Compiled
from modelgen.solvers import operating_point

CHANNELS = (".twist", ".twist_rate", ".deflection", ".deflection_rate")


@dataclass(frozen=True)
class Series:
    """Rows on one base frequency [rad/s]: value of a row = sum over orders 1..H of cosine[h] cos(h w t) + sine[h] sin(h w t)."""

    base: float
    cosine: np.ndarray
    sine: np.ndarray


@dataclass(frozen=True)
class Workload:
    """One run: inertias, shafts (a, b, k, c), meshes, torque means and series, start, output times.

    ``meshes``: rows of a, b, radius a, radius b, half backlash, damping per root of stiffness, mean stiffness, mean error.
    ``mesh_series``: for each mesh the rows stiffness, error, error rate. ``torque_series``: pairs of hinges and rows.
    """

    inertia: np.ndarray
    shafts: np.ndarray
    meshes: np.ndarray
    torque_mean: np.ndarray
    torque_series: tuple[tuple[np.ndarray, Series], ...]
    mesh_series: tuple[Series, ...]
    start: np.ndarray
    times: np.ndarray

    def channels(self, states: np.ndarray) -> np.ndarray:
        """Twists and deflections with their rates (samples, channels) from the states (samples, 2 n); means in time drop out."""
        n = len(self.inertia)
        rows = []
        for half in (states[:, :n], states[:, n:]):
            rows += [half[:, int(a)] - half[:, int(b)] for a, b, *_ in self.shafts]
            rows += [ra * half[:, int(a)] - rb * half[:, int(b)] for a, b, ra, rb, *_ in self.meshes]
        return np.array(rows).T


def error(found: np.ndarray, exact: np.ndarray) -> float:
    """Largest over the channels of |difference| per half the peak-to-peak of the channel; infinite for what is not finite."""
    if not np.isfinite(found).all():
        return np.inf
    return float((np.abs(found - exact).max(axis=0) / (np.ptp(exact, axis=0) / 2)).max())


def series_of(waves: list[Wave]) -> Series | None:
    """The rows laid out by order of their lowest frequency; None where nothing varies."""
    frequencies = sorted({f for wave in waves for f in wave.amplitudes})
    if not frequencies:
        return None
    base = frequencies[0]
    orders = [round(f / base) for f in frequencies]
    assert max(abs(f / base - o) for f, o in zip(frequencies, orders, strict=True)) < 1e-9
    cosine, sine = np.zeros((len(waves), max(orders))), np.zeros((len(waves), max(orders)))
    for row, wave in enumerate(waves):
        for f, amplitude in wave.amplitudes.items():
            cosine[row, round(f / base) - 1], sine[row, round(f / base) - 1] = amplitude.real, -amplitude.imag
    return Series(base, cosine, sine)


def workload(line: Driveline, end: float, samples: int, model: Compiled | None = None, **values: float) -> Workload:
    """The numbers of a driveline at its static start."""
    model = model or lower(assemble(line))
    point = operating_point(model, values)
    sheet = referee_of(line, model, point)
    shafts = [(*link.ends, link.stiffness, link.damping) for link in sheet.links if not link.waves]
    assert all(link.coefficients == (1.0, -1.0) for link in sheet.links if not link.waves)
    meshes, mesh_series = [], []
    for link in sheet.links:
        if link.waves:
            (a, b), (ra, rb) = link.ends, link.coefficients
            means = (link.waves["stiffness"].mean, link.waves["error"].mean)
            meshes.append((a, b, ra, -rb, link.gap, link.damping, *means))
            mesh_series.append(series_of([link.waves[name] for name in ("stiffness", "error", "error_rate")]))
    groups: dict[float, list[int]] = {}
    for hinge, wave in enumerate(sheet.torques):
        if wave.amplitudes:
            groups.setdefault(round(min(wave.amplitudes), 9), []).append(hinge)
    torque_series = tuple((np.array(hinges), series_of([sheet.torques[h] for h in hinges])) for hinges in groups.values())
    angles = np.asarray(point.angle)
    return Workload(
        inertia=sheet.inertia,
        shafts=np.array(shafts).reshape(-1, 4),
        meshes=np.array(meshes).reshape(-1, 8),
        torque_mean=np.array([wave.mean for wave in sheet.torques]),
        torque_series=torque_series,  # type: ignore[arg-type]  # hinges with waves have series
        mesh_series=tuple(mesh_series),  # type: ignore[arg-type]
        start=np.concatenate([angles, np.zeros_like(angles)]),
        times=np.linspace(0.0, end, samples),
    )
