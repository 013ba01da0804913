"""Balanced loads: the scales at which the mean torques do no work along any of the given speeds.

Part of ``lowering``, on the functions of the mean model; ``ParameterTable.vector`` balances by it. With one operating speed all
loads share one factor; with several there is one load for each, and R^T (mean torques) = 0 with a column of R for each given
speed.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from modelgen.equations.records import Equations
from modelgen.errors import BalanceError
from modelgen.lowering.mean_model import MeanModel

Array = NDArray[np.float64]


class LoadBalance:
    """Sets the scales of a driveline's balanced loads in a parameter vector."""

    def __init__(self, equations: Equations, mean_model: MeanModel, slices: Mapping[str, slice]) -> None:
        self.where = f"driveline {equations.name!r}"
        self.mean_model, self.may_drive = mean_model, equations.balance_may_drive
        self.entries = {name: slices[name].start for name in equations.balanced}

    def __call__(self, p: Array, fixed: Collection[str]) -> None:
        """Scales the balanced loads in ``p``, but for those ``fixed`` by name.

        Raises BalanceError where the loads cannot balance the mean torques, or would have to drive.
        """
        names = [name for name in self.entries if name not in fixed]
        if not names:
            return
        entries = [self.entries[name] for name in names]
        given = p[entries].copy()
        _, speed, by_speed = self.mean_model.ratios_at(p)
        count = by_speed.shape[1]
        if count > 1 and len(names) != count:
            what = f"balances {len(names)} load{'s' * (len(names) > 1)}, but {count} mean speeds are given"
            raise BalanceError(self.where, what, "balance one load for each of them")
        arms = by_speed.T if count > 1 else speed[None, :]

        def torque(factors: Array) -> Array:
            p[entries] = factors * given
            return self._torque(p, len(speed))

        alone = torque(np.zeros(len(names)))
        choices = np.eye(len(names)) if count > 1 else np.ones((1, len(names)))
        loaded = [torque(row) for row in choices]
        p[entries] = given
        without = arms @ alone
        loads = np.array([arms @ each - without for each in loaded]).T
        factors = self._one_factor(speed, without[0], loads[0, 0]) if count == 1 else self._factors(names, without, loads)
        powers = np.array([speed @ (each - alone) for each in loaded])
        drives = (factors < 0) & (powers < 0)  # what absorbed power would supply it
        if np.any(drives) and not self.may_drive:
            first = int(np.argmax(drives))
            listed = ", ".join(repr(name.rpartition(".")[0]) for name in (names if count == 1 else [names[first]]))
            what = f"balance would scale {listed} by {factors[first]:.4g}, which turns the load into a drive"
            allow = "balance(..., may_drive=True), in a model file balance_may_drive = true"
            raise BalanceError(self.where, what, f"correct a torque or its sign, or allow it: {allow}")
        p[entries] = given * factors

    def _torque(self, p: Array, groups: int) -> Array:
        """Mean torque [N*m] on each group at zero angles."""
        mean = self.mean_model
        return mean.torque_at(p, mean.means_at(p), np.zeros(groups), mean.own_start)

    def _one_factor(self, speed: Array, without: float, load: float) -> Array:
        """The factor of all loads at one operating speed: power without them, and what they add [W]."""
        if not np.any(speed):
            what = "has loads to balance, but ground holds every shaft at rest in the mean"
            raise BalanceError(self.where, what, "take out the balance, or what ties the driveline to ground")
        if load == 0.0 and abs(without) > 1e12 * np.abs(speed).max():
            what = f"the balanced loads are lost in rounding beside {without:.3g} W of the other mean torques"
            raise BalanceError(self.where, what, "check the mean torques")
        if load == 0.0:
            raise BalanceError(self.where, "the balanced loads have no mean torque", "give them a mean, or balance other loads")
        return np.array([without / -load])

    def _factors(self, names: Sequence[str], without: Array, loads: Array) -> Array:
        """One factor for each load at several given speeds."""
        if np.linalg.matrix_rank(loads) < len(without):
            raise BalanceError(self.where, f"the loads {', '.join(names)} do not balance every given speed", "take others")
        return np.asarray(np.linalg.solve(loads, -without))
