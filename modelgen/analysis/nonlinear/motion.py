"""Motion without the rigid rotation: which states vibrate, and every channel with its exact time derivative.

Below ``sections`` and ``strobes``. A free driveline turns as a whole; where no law sees that angle, and none its speed, neither
belongs to the vibration: both states are left out of sections and of every comparison of states. The rate of a channel comes from
the equations of motion (chain rule along the motion), never from differences of samples.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.lowering import Compiled
from modelgen.solvers.operating_point import OperatingPoint
from modelgen.solvers.scales import state_scales

Array = NDArray[np.float64]
NEUTRAL = 1e-9  # share of a rate's size that a rigid speed may have in it, which is rounding
BLOCK = 256  # instants per call


def vibrating_states(model: Compiled, point: OperatingPoint) -> list[int]:
    """Positions in x of the states that vibrate: all but rigid angles that no law sees, and their rates where none sees those.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble, lower, operating_point
    >>> model = lower(assemble(Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])))
    >>> [model.states[k] for k in vibrating_states(model, operating_point(model))]
    ['shaft.twist', 'shaft.twist_rate']
    """
    order, scale = len(model.equations.steps), state_scales(model, point, point.start)
    neutral = set(model.equations.rigid)
    places = (point.start, point.start + scale, point.start - 3.0 * scale)
    size = np.abs([model.jacobian(0.0, place, point.p) * scale for place in places]).max(axis=0)
    row = size.max(axis=1, initial=0.0)
    for angle in model.equations.rigid:
        felt = size[:, order + angle] > NEUTRAL * row
        if set(np.flatnonzero(felt)) <= {angle}:
            neutral.add(order + angle)
    return [k for k in range(len(model.states)) if k not in neutral]


def motion_of(model: Compiled, times: Array, states: Array, p: Array, names: Sequence[str]) -> tuple[Array, Array]:
    """Values and time derivatives (instants, channels) of output channels along a motion [unit of each, and that per s].

    Raises CaseError for an unknown channel.
    """
    rows = tuple(model.output_index(name) for name in names)
    count = len(times)
    if not count or not rows:
        return np.zeros((count, len(rows))), np.zeros((count, len(rows)))
    whole = -(-count // BLOCK) * BLOCK
    padded = np.pad(np.asarray(times, dtype=float), (0, whole - count), mode="edge")
    columns = np.pad(states, ((0, whole - count), (0, 0)), mode="edge").T
    values = np.empty((2 * len(rows), whole))
    for first in range(0, whole, BLOCK):
        part = slice(first, first + BLOCK)
        values[:, part] = _moving(model, rows)(padded[None, part], columns[:, part], p)
    return values[: len(rows), :count].T, values[len(rows) :, :count].T


@functools.lru_cache(maxsize=16)
def _moving(model: Compiled, rows: tuple[int, ...]) -> ca.Function:
    """(t, x, p) -> channels, then their time derivatives; for a block of instants."""
    e = model.expressions
    value = ca.densify(e["outputs"][list(rows)])
    rate = ca.jtimes(value, e["x"], e["ode"]) + ca.jtimes(value, e["t"], ca.SX(1))
    return ca.Function("moving", [e["t"], e["x"], e["p"]], [ca.vertcat(value, ca.densify(rate))]).map(BLOCK)
