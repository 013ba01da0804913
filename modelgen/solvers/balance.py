"""Balanced loads: the scales at which the mean torques do no work along any of the given speeds.

Below ``operating_point``, on ``equilibrium``. With one operating speed all loads share one factor; with several there is one load
for each, and R^T (mean torques) = 0 with a column of R for each given speed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import BalanceError
from modelgen.lowering import Compiled
from modelgen.solvers.equilibrium import Coordinates, mean_torque, mean_values, own_start

Array = NDArray[np.float64]


def balance(model: Compiled, p: Array, fixed: set[str], coordinates: Coordinates) -> None:
    """Sets the scales of the balanced loads in the parameter vector, but for those ``fixed`` by name.

    Raises BalanceError where the loads cannot balance the mean torques, or would have to drive.
    """
    names = [name for name in model.equations.balanced if name not in fixed]
    if not names:
        return
    where = f"driveline {model.name!r}"
    entries = [model.parameters.slices[name].start for name in names]
    given = p[entries].copy()
    count = coordinates.by_speed.shape[1]
    if count > 1 and len(names) != count:
        what = f"balances {len(names)} load{'s' * (len(names) > 1)}, but {count} mean speeds are given"
        raise BalanceError(where, what, "balance one load for each of them")
    own, zeros = own_start(model), np.zeros(len(model.equations.groups))
    arms = coordinates.by_speed.T if count > 1 else coordinates.speed[None, :]

    def torque(factors: Array) -> Array:
        p[entries] = factors * given
        return mean_torque(model, p, mean_values(model, p), zeros, own)

    alone = torque(np.zeros(len(names)))
    choices = np.eye(len(names)) if count > 1 else np.ones((1, len(names)))
    loaded = [torque(row) for row in choices]
    without = arms @ alone
    loads = np.array([arms @ each - without for each in loaded]).T
    factors = _one_factor(where, coordinates, without[0], loads[0, 0]) if count == 1 else _factors(where, names, without, loads)
    powers = np.array([coordinates.speed @ (each - alone) for each in loaded])
    drives = (factors < 0) & (powers < 0)  # what absorbed power would supply it
    if np.any(drives) and not model.equations.balance_may_drive:
        first = int(np.argmax(drives))
        listed = ", ".join(repr(name.rpartition(".")[0]) for name in (names if count == 1 else [names[first]]))
        raise BalanceError(
            where,
            f"balance would scale {listed} by {factors[first]:.4g}, which turns the load into a drive",
            "correct a torque or its sign, or allow it: balance(..., may_drive=True), in a model file balance_may_drive = true",
        )
    p[entries] = given * factors


def _one_factor(where: str, coordinates: Coordinates, without: float, load: float) -> Array:
    """The factor of all loads at one operating speed: power without them, and what they add [W]."""
    if not np.any(coordinates.speed):
        what = "has loads to balance, but ground holds every shaft at rest in the mean"
        raise BalanceError(where, what, "take out the balance, or what ties the driveline to ground")
    if load == 0.0 and abs(without) > 1e12 * np.abs(coordinates.speed).max():
        what = f"the balanced loads are lost in rounding beside {without:.3g} W of the other mean torques"
        raise BalanceError(where, what, "check the mean torques")
    if load == 0.0:
        raise BalanceError(where, "the balanced loads have no mean torque", "give them a mean, or balance other loads")
    return np.array([without / -load])


def _factors(where: str, names: Sequence[str], without: Array, loads: Array) -> Array:
    """One factor for each load at several given speeds."""
    if np.linalg.matrix_rank(loads) < len(without):
        raise BalanceError(where, f"the loads {', '.join(names)} do not balance every given speed", "take others")
    return np.asarray(np.linalg.solve(loads, -without))
