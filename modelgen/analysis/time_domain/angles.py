"""Question: how large are the torsional angles, in every definition in use, and the mesh forces?

Definitions (each with ``peak`` = largest absolute value and ``half_pp`` = half peak to peak over the window):
``vibration``: the angle less its best straight line in time, as a torsiograph reads it; rolling of the whole train included.
``elastic``: theta_i - r_i sum(J r theta)/sum(J r^2), less its mean: the train's own deformation.
``twist``: the difference across an element. Referred values are physical ones divided by r_i, the speed ratio of the shaft.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.speed_ratios import referred_ratios
from modelgen.analysis.time_domain.window import Window, settled_window
from modelgen.errors import CaseError, refuse_unless
from modelgen.solvers.bound_model import bind
from modelgen.solvers.crosscheck import without_line
from modelgen.solvers.operating_point import OperatingPoint
from modelgen.solvers.solution import Solution

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Swing:
    """Size of an angle over a window [rad]: largest absolute value and half peak to peak."""

    peak: float
    half_pp: float


@dataclass(frozen=True)
class InertiaAngles:
    """Angles of one inertia, physical; divide by ``referred_ratio`` to refer them to the reference shaft."""

    vibration: Swing
    elastic: Swing
    referred_ratio: float


@dataclass(frozen=True)
class MeshForces:
    """Mesh force [N] over the window, and the share of time on the driving flank, in the gap, on the back flank."""

    least: float
    largest: float
    mean: float
    driving: float
    free: float
    back: float


@dataclass(frozen=True)
class AnglesResult:
    """Angles of every inertia, twist of every shaft [rad], forces of every mesh, over one window."""

    model: str
    window: Window
    inertias: Mapping[str, InertiaAngles]
    twists: Mapping[str, Swing]
    meshes: Mapping[str, MeshForces]


def angle_channels(names: tuple[str, ...]) -> tuple[str, ...]:
    """The output channels that ``angles`` needs."""
    return tuple(
        name for name in names if name.endswith((".angle_deviation", ".elastic_angle", ".twist", ".force", ".penetration"))
    )


def angles(solution: Solution, window: Window | None = None, point: OperatingPoint | None = None) -> AnglesResult:
    """Angles and mesh forces of a solution over a window, by default the settled one of its model.

    Raises CaseError where the solution does not cover it.
    """
    refuse_unless(solution, Solution, "angles")
    bound = bind(solution.case, question="angles")
    point = point or bound.operating_point
    window = window or settled_window(bound, point)
    refuse_unless(window, Window, "angles, window")
    refuse_unless(point, OperatingPoint, "angles, point")
    slack = 1e-9 * max(1.0, abs(window.last))
    part = solution.between(window.first - slack, window.last + slack)
    gap = window.period / 10
    if len(part.times) < 3 or part.times[0] > window.first + gap or part.times[-1] < window.last - gap:
        covered = f"{solution.times[0]:.6g} to {solution.times[-1]:.6g} s" if len(solution.times) else "nothing"
        wanted = f"{window.first:.6g} to {window.last:.6g} s"
        raise CaseError("angles", f"the solution covers {covered}, the window is {wanted}", "simulate to the end of the window")
    t = part.times
    ratio = referred_ratios(solution.case.model, point)
    inertias = {}
    for name in part.channels:
        if name.endswith(".angle_deviation"):
            element = name.removesuffix(".angle_deviation")
            elastic = part[f"{element}.elastic_angle"]
            inertias[element] = InertiaAngles(
                vibration=_swing(without_line(t, part[name])),
                elastic=_swing(elastic - _mean(t, elastic)),
                referred_ratio=ratio[element],
            )
    twists = {n.removesuffix(".twist"): _swing(v) for n, v in part.channels.items() if n.endswith(".twist")}
    meshes = {}
    for name, force in part.channels.items():
        if name.endswith(".force") and f"{name.removesuffix('.force')}.penetration" in part.channels:
            depth = part[f"{name.removesuffix('.force')}.penetration"]
            shares = [float(np.mean(side)) for side in (depth > 0, depth == 0, depth < 0)]
            meshes[name.removesuffix(".force")] = MeshForces(float(force.min()), float(force.max()), _mean(t, force), *shares)
    return AnglesResult(solution.model_name, window, inertias, twists, meshes)


def _swing(values: Array) -> Swing:
    return Swing(float(np.abs(values).max()), float(np.ptp(values)) / 2)


def _mean(times: Array, values: Array) -> float:
    """Mean over time by the trapezoidal rule; a sample at both ends of a whole period counts half each."""
    return float(np.trapezoid(values, times) / (times[-1] - times[0]))
