"""Which laws have a kink, or a jump, just where the driveline rests: no linear model stands for them there.

Below every linear question. The operating point is moved a little along one direction that is parallel to nothing, forth and
back. The slopes of a smooth law then differ in proportion to the step; where they differ by the same amount at a step of an
eighth, the law has two slopes at the point itself. Laws without switching operations are not looked at.
"""

from __future__ import annotations

import functools

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.energy_shares import FlangeMap, element_stiffness
from modelgen.lowering import Compiled
from modelgen.solvers.operating_point import OperatingPoint

Array = NDArray[np.float64]
STEP = 1e-8  # rad, and per angle: above what is left of the search for the static state, below every gap
FINER = 8.0
STAYS = 0.5  # share of a difference that is left at the finer step where there is a kink; of a smooth law an eighth, or a root
CLEAR = 1e-6  # of the larger slope: a difference of slopes
JUMP = 1e-9  # of the larger torque: a difference of torques
SWITCHES = frozenset({ca.OP_FABS, ca.OP_SIGN, ca.OP_FMIN, ca.OP_FMAX, ca.OP_IF_ELSE_ZERO, ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE,
                      ca.OP_FLOOR, ca.OP_CEIL, ca.OP_FMOD, ca.OP_COPYSIGN})  # fmt: skip


def kinked_elements(model: Compiled, point: OperatingPoint) -> tuple[str, ...]:
    """Names of the elements whose torques have two slopes, or two values, by the angles at the operating point."""
    n = len(point.angle)
    if not n or not _switches(model):
        return ()
    # Square roots of primes have no simple ratio, so no surface on which laws switch lies along the direction.
    weights = np.sqrt(np.array([k for k in range(2, 12 * n + 12) if all(k % m for m in range(2, int(k**0.5) + 1))][:n]))
    direction = point.coordinates.to_angles @ (weights * np.where(np.arange(n) % 2, -1.0, 1.0))
    direction = direction / np.abs(direction).max()
    step = STEP * (1 + float(np.abs(point.angle).max()))
    coarse, fine = (_differences(model, point, size * direction) for size in (step, step / FINER))
    kinked = np.zeros(len(FlangeMap.of(model).flange_element), dtype=bool)
    for (wide, size), (narrow, _), clear in zip(coarse, fine, (CLEAR, JUMP), strict=True):
        kinked |= np.any((wide > clear * size[:, None]) & (narrow > STAYS * wide), axis=1)
    found = np.unique(FlangeMap.of(model).flange_element[kinked])
    return tuple(model.equations.instances[k].name for k in found)


def kink_words(names: tuple[str, ...]) -> str:
    """What a linear answer says of them; nothing without any."""
    if not names:
        return ""
    return (
        f"the law of {', '.join(names)} has a kink at the operating point: what is linear takes one slope there, that of one side"
        " or a mean, and tells nothing of how the driveline moves"
    )


def _differences(model: Compiled, point: OperatingPoint, step: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Of slopes (flanges, groups) and of torques (flanges, 1) at the point and on both sides, with their sizes (flanges,)."""
    still, own = np.zeros(len(step)), model.mean_model.own_start
    slopes, torques = [], []
    for angle in (point.angle + step, point.angle, point.angle - step):
        given = (angle, still, own, point.p, point.mean)
        slopes.append(element_stiffness(model)(*given)[0].full())
        torques.append(np.asarray(model.mean_model.elements(*given)[0]).reshape(-1, 1))
    slope, torque = ((np.ptp(each, axis=0), np.abs(each).max(axis=(0, 2), initial=0.0)) for each in (slopes, torques))
    return slope, torque


@functools.lru_cache(maxsize=16)
def _switches(model: Compiled) -> bool:
    """Whether any law of the driveline holds a switching operation at all."""
    function = model.mean_model.elements
    return any(function.instruction_id(k) in SWITCHES for k in range(function.n_instructions()))
