"""The linear model about an operating point, of the motion and of everything that is seen of it.

Part of ``solvers``, on ``operating_point``; the linear questions rest on it. With q the deviations of the group angles and z
the own states of the elements, M q'' + C q' + (K + i H) q = f holds in the extended unknowns (q, z), and a channel is y = Y_q q
+ Y_v q' + i Y_h q. It comes from the compiled torques and outputs by differentiation; no element is named, and what varies with
time stands at its mean.

Loss factor: a damper whose coefficient is stated at a ``reference_frequency`` (c = eta k / omega_ref) is a complex stiffness
i eta k in the frequency domain, the same at every frequency. Such parts go into H and Y_h.
Source: D. J. Inman, Engineering Vibration (2014), sec. 2.7 (hysteretic damping).
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.lowering import Compiled
from modelgen.solvers.operating_point import OperatingPoint

Array = NDArray[np.float64]
STATED_AT = "reference_frequency"
NEVER = 1e200  # rad/s: a reference frequency at which a loss factor gives no viscous coefficient


@dataclass(frozen=True, eq=False)
class LinearModel:
    """Matrices over (groups, own states) and gains of channels about an operating point.

    ``mass`` [kg*m^2], ``damping`` [N*m*s/rad], ``hysteresis`` and ``stiffness`` [N*m/rad] (n, n); ``by_angle``, ``by_speed``,
    ``by_hysteresis`` (channels, n); ``rest`` (channels,): their values at the operating point.
    """

    model: Compiled
    point: OperatingPoint
    channels: tuple[str, ...]
    mass: Array
    damping: Array
    hysteresis: Array
    stiffness: Array
    by_angle: Array
    by_speed: Array
    by_hysteresis: Array
    rest: Array


def linearize(
    model: Compiled, point: OperatingPoint, channels: tuple[str, ...] = (), complex_stiffness: bool = True
) -> LinearModel:
    """The linear model about a point. With ``complex_stiffness=False`` loss factors are viscous, right at their frequency only.

    Raises CaseError for a channel that does not exist.
    """
    function = _derivatives(model, tuple(model.output_index(name) for name in channels))
    n, own = len(point.angle), model.mean_model.own_start
    size = n + len(own)
    stated = stated_frequencies(model) if complex_stiffness else []

    def at(reference: float | None) -> tuple[Array, ...]:
        p = point.p.copy()
        if reference is not None:
            p[stated] = reference
        return tuple(each.full() for each in function(point.angle, np.zeros(n), own, p, point.mean))

    values, mass, by_angle, by_speed = at(None)
    by_hysteresis = np.zeros_like(by_speed)
    if stated:
        by_hysteresis = at(1.0)[3]
        by_speed = at(NEVER)[3]
        by_hysteresis = by_hysteresis - by_speed

    def square(gain: Array, diagonal: float = 0.0) -> Array:
        matrix = np.zeros((size, size))
        matrix[:, : gain.shape[1]] = -gain[:size]
        matrix[n:, n:] += diagonal * np.eye(size - n)
        return matrix

    def wide(gain: Array) -> Array:
        return np.hstack([gain[size:], np.zeros((len(channels), size - gain.shape[1]))])

    inertia = np.zeros((size, size))
    inertia[:n, :n] = mass
    return LinearModel(
        model=model,
        point=point,
        channels=channels,
        mass=inertia,
        damping=square(by_speed, 1.0),
        hysteresis=square(by_hysteresis),
        stiffness=square(by_angle),
        by_angle=wide(by_angle),
        by_speed=wide(by_speed),
        by_hysteresis=wide(by_hysteresis),
        rest=values[size:, 0],
    )


@functools.lru_cache(maxsize=16)
def seen(model: Compiled, rows: tuple[int, ...]) -> ca.Function:
    """(angle, speed, own, p, w) -> torques on the groups, rates of own states, the output channels of these rows."""
    given = model.mean_model.torque.sx_in()
    torque, rates = model.mean_model.torque(*given)
    outputs = model.mean_model.outputs(*given)
    return ca.Function("seen", given, [ca.densify(ca.vertcat(torque, rates, outputs[list(rows)]))])


@functools.lru_cache(maxsize=16)
def _derivatives(model: Compiled, rows: tuple[int, ...]) -> ca.Function:
    """The same with the mass matrix and the derivatives by (angles, own states) and by the speeds."""
    given = seen(model, rows).sx_in()
    angle, speed, own = given[:3]
    value = seen(model, rows)(*given)
    mass = model.mean_model.linear(*given)[0]
    return ca.Function("derivatives", given, [value, mass, ca.jacobian(value, ca.vertcat(angle, own)), ca.jacobian(value, speed)])


@functools.lru_cache(maxsize=64)
def mapped(function: ca.Function, count: int) -> ca.Function:
    """The function over ``count`` columns at once; making it costs more than calling it."""
    return function.map(count)


def stated_frequencies(model: Compiled) -> list[int]:
    """Entries of p that are frequencies at which a loss factor is turned into a coefficient."""
    index = {symbol: row for row, symbol in enumerate(model.parameters.symbols)}
    found = set()
    for instance in model.equations.instances:
        for name, symbols in model.equations.templates[instance.template].parameters:
            if name == STATED_AT:
                found |= {index[instance.symbols[symbol]] for symbol in symbols}
    return sorted(found)
