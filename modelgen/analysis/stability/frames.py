"""Frames of deviations carried along a motion: by what their directions are stretched, stretch by stretch.

Below ``exponents``. A frame is made orthonormal after each stretch (QR with R's diagonal the stretching); a single direction only
keeps its unit length.
Source: G. Benettin et al., Meccanica 15 (1980) 9.
"""

from __future__ import annotations

from collections.abc import Callable
from math import ceil

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.stability.course import Course
from modelgen.analysis.stability.propagators import complete_runs, propagators
from modelgen.analysis.stability.variational import parts, with_tangents
from modelgen.solvers.problem import SolverOptions

Array = NDArray[np.float64]
BATCH = 512
"""Stretches whose propagators are found at once."""
TINY = 1e-300
PILOT, SHORTENINGS = 64, 3
LIMIT = 14.0
"""Logarithm of the ratio of the largest to the least stretching that still leaves digits to the least."""
Progress = Callable[[float], None] | None
Logs = tuple[Array, Array]
"""Logarithms of the stretching (stretches, exponents), and integrals of tr J (stretches,)."""


def all_directions(
    course: Course, ends: Array, length: float, options: SolverOptions, _: np.random.Generator, progress: Progress
) -> Logs:
    """Every direction: the motion first, a batch of stretches at a time, then their propagators side by side."""
    frame = np.eye(course.problem.x0.size)
    logs, volumes = np.empty((len(ends), len(frame))), np.empty(len(ends))
    before: tuple[Array, Array] | None = None
    for first in range(0, len(ends), BATCH):
        found = propagators(course.advance(ends[first : first + BATCH]), length, options, before)
        before = found.ends[-1], found.modes[-1]
        for k, matrix in enumerate(found.matrices, start=first):
            frame, triangle = np.linalg.qr(matrix @ frame)
            logs[k] = np.log(np.maximum(np.abs(np.diag(triangle)), TINY))
        volumes[first : first + BATCH] = found.volumes
        if progress is not None:
            progress((first + len(found.volumes)) / len(ends))
    return logs, volumes


def one_direction(
    course: Course, ends: Array, length: float, options: SolverOptions, chance: np.random.Generator, progress: Progress
) -> Logs:
    """The direction that grows fastest: a single tangent vector beside the motion, made a unit vector after each stretch."""
    tangent = chance.standard_normal((course.problem.x0.size, 1))
    logs, volumes = np.empty((len(ends), 1)), np.empty(len(ends))
    batches = (ends[first : first + BATCH] for first in range(0, len(ends), BATCH))
    for k, stretch in enumerate(each for batch in batches for each in course.advance(batch)):
        tangent /= np.linalg.norm(tangent)
        run = parts(stretch, complete_runs([with_tangents(stretch, tangent, length)], options)[0].states[-1])
        tangent = run.tangents
        logs[k], volumes[k] = np.log(max(float(np.linalg.norm(tangent)), TINY)), run.volume
        if progress is not None:
            progress((k + 1) / len(ends))
    return logs, volumes


def tamed(course: Course, length: float, span: float, options: SolverOptions) -> float:
    """The length of a stretch [s], divided until the frame stays told apart over the first stretches: by what it is stretched,
    not by what eigenvalues promise."""
    for _ in range(SHORTENINGS):
        count = min(PILOT, int(span / length))
        if count < 1:
            return length
        ends = np.asarray(course.time + length * np.arange(1, count + 1), dtype=float)
        logs = all_directions(course.copy(), ends, length, options, np.random.default_rng(), None)[0]
        spread = float(np.ptp(logs, axis=1).max())
        if spread <= LIMIT:
            return length
        length /= ceil(spread / LIMIT) + 1
    return length
