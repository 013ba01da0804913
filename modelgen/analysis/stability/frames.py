"""Frames of deviations carried along a motion: by what their directions are stretched, stretch by stretch.

Below ``exponents``. A frame is made orthonormal (QR with R's diagonal the stretching) as often as its directions need to be told
apart: where one outgrows another too far, or a deviation grows without bound, the stretches of that part of the motion are
halved, and doubled again where there is room. A single direction only keeps its unit length.
Source: G. Benettin et al., Meccanica 15 (1980) 9.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.stability.course import Course
from modelgen.analysis.stability.propagators import complete_runs, propagators
from modelgen.analysis.stability.variational import parts, with_tangents
from modelgen.errors import CaseError
from modelgen.solvers.problem import InitialValueProblem, SolverOptions

Array = NDArray[np.float64]
SMALLEST, LARGEST = 32, 512
"""Stretches that are gone through at once: few at first, until it is known how short they must be."""
TINY = 1e-300
LIMIT = 14.0
"""Logarithm of the ratio of the largest to the least stretching that still leaves digits to the least."""
FINEST = 4096
"""Parts of a stretch beyond which a deviation that grows without bound is no matter of the stretch."""
Progress = Callable[[float], None] | None


class Carried(NamedTuple):
    """Logarithms of the stretching (stretches, exponents), integrals of tr J (stretches,), ``states`` at their ends (stretches,
    n), and the most parts that a stretch was divided into.
    """

    logs: Array
    volumes: Array
    states: Array
    parts: int


class _Crossing(NamedTuple):
    """Some stretches crossed: what to go on with, and logarithms and integrals of each."""

    then: Any
    logs: Array
    volumes: Array


def all_directions(
    course: Course, ends: Array, length: float, options: SolverOptions, _: np.random.Generator, progress: Progress
) -> Carried:
    """Every direction: the motion first, a batch of stretches at a time, then their propagators side by side."""

    def cross(before: Any, stretches: Sequence[InitialValueProblem], length: float) -> _Crossing:
        frame, joint = before
        found = propagators(stretches, length, options, joint)
        logs = np.empty((len(stretches), len(frame)))
        for k, matrix in enumerate(found.matrices):
            frame, triangle = np.linalg.qr(matrix @ frame)
            logs[k] = np.log(np.maximum(np.abs(np.diag(triangle)), TINY))
        return _Crossing((frame, (found.ends[-1], found.modes[-1])), logs, found.volumes)

    return _carried(course, ends, length, cross, (np.eye(course.problem.x0.size), None), progress)


def one_direction(
    course: Course, ends: Array, length: float, options: SolverOptions, chance: np.random.Generator, progress: Progress
) -> Carried:
    """The direction that grows fastest: a single tangent vector beside the motion, made a unit vector after each stretch."""

    def cross(before: Any, stretches: Sequence[InitialValueProblem], length: float) -> _Crossing:
        tangent = np.asarray(before)
        logs, volumes = np.empty((len(stretches), 1)), np.empty(len(stretches))
        for k, stretch in enumerate(stretches):
            tangent = tangent / np.linalg.norm(tangent)
            run = parts(stretch, complete_runs([with_tangents(stretch, tangent, length)], options)[0].states[-1])
            tangent = run.tangents
            logs[k], volumes[k] = np.log(max(float(np.linalg.norm(tangent)), TINY)), run.volume
        return _Crossing(tangent, logs, volumes)

    return _carried(course, ends, length, cross, chance.standard_normal((course.problem.x0.size, 1)), progress)


def _carried(
    course: Course,
    ends: Array,
    length: float,
    cross: Callable[[Any, Sequence[InitialValueProblem], float], _Crossing],
    then: Any,
    progress: Progress,
) -> Carried:
    """Goes through all stretches; their parts adapt to what happens in them."""
    logs: list[Array] = []
    volumes: list[Array] = []
    states: list[Array] = []
    finest = fine = 1
    first, batch = 0, SMALLEST
    while first < len(ends):
        chosen, place = ends[first : first + batch], course.copy()
        starts = np.concatenate([[course.time], chosen[:-1]])
        inner = starts[:, None] + (chosen - starts)[:, None] * np.arange(1, fine + 1) / fine
        inner[:, -1] = chosen
        stretches = course.advance(inner.ravel())
        try:
            found = cross(then, stretches, length / fine)
            spread = _spread(found.logs)
        except CaseError:
            if fine >= FINEST:
                raise
            spread = np.inf
        if spread > LIMIT and fine < FINEST:
            course.back_to(place)
            fine *= 2
            continue
        then, finest = found.then, max(finest, fine)
        logs.append(found.logs.reshape(len(chosen), fine, -1).sum(axis=1))
        volumes.append(found.volumes.reshape(len(chosen), fine).sum(axis=1))
        states += [*(stretch.x0 for stretch in stretches[fine::fine]), course.state]
        first, batch = first + len(chosen), min(LARGEST, 2 * batch)
        if fine > 1 and spread < LIMIT / 4:
            fine //= 2
        if progress is not None:
            progress(first / len(ends))
    return Carried(np.concatenate(logs), np.concatenate(volumes), np.array(states), finest)


def _spread(logs: Array) -> float:
    """How far directions were drawn apart at most; of a single one, how far it left its unit length."""
    return float((np.ptp(logs, axis=1) if logs.shape[1] > 1 else np.abs(logs)).max())
