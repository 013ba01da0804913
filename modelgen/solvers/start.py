"""Where a run starts: at rest, in given states, in given values of channels, or where an earlier run ended.

Between ``operating_point`` and ``simulate``. States are set as they are, on top of the static state. Values of channels, such as
``"motor.speed"`` or ``"coupling.torque"``, are absolute, and are met from uniform rotation with nothing twisted: what is not
named stays at rest relative to it. Speeds are met with the least change in kinetic energy, angles with the least change of the
relative angles, weighted by the inertias that they move.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.lowering import Compiled
from modelgen.solvers.case_values import read_start
from modelgen.solvers.operating_point import OperatingPoint

Array = NDArray[np.float64]
MET = 1e-12  # of the size of a channel: how closely its value is met
ITERATIONS = 50


def starting_state(model: Compiled, point: OperatingPoint, start: str | Mapping[str, Any], time: float = 0.0) -> Array:
    """The state that a run starts from at a time [s]. Raises CaseError for values that contradict each other."""
    at_rest = point.start if point.begin is None else point.begin
    own = np.array([state.start if state.kind == "own" else 0.0 for state in model.equations.states])
    if isinstance(start, str):
        return at_rest.copy() if start == "static" else own
    values = read_start(model, start)
    of_channels = {name: value for name, value in values.items() if name not in model.states}
    state = own if of_channels else at_rest.copy()
    for name, value in values.items():
        if name in model.states:
            state[model.state_index(name)] = value
    return _met(model, point, state, values, time) if of_channels else state


def _met(model: Compiled, point: OperatingPoint, state: Array, values: Mapping[str, float], time: float) -> Array:
    """The state with these values of channels, nearest to the given one; states that are named stay."""
    seeker = _Seeker(model, point, values, time)
    # Channels of the speeds alone first, then those of the angles; what is left may need both.
    for kinds in (("rates",), ("angles",), ("rates", "angles")):
        state = seeker.improved(state, kinds)
    missed = seeker.missed(state)
    if missed:
        listed = ", ".join(f"{name!r} = {values[name]:g} (found {found:.6g} {model.unit(name)})" for name, found in missed)
        raise CaseError(
            f"case of {model.name!r}, start", f"cannot meet {listed}", "name fewer channels, or values that do not contradict"
        )
    return state


class _Seeker:
    """Newton's method for an underdetermined system, with the least change in the metric of each kind of state."""

    def __init__(self, model: Compiled, point: OperatingPoint, values: Mapping[str, float], time: float) -> None:
        self.model, self.point, self.p, self.time = model, point, point.p, time
        self.names = tuple(name for name in values if name not in model.states)
        self.wanted = np.array([values[name] for name in self.names])
        self.rows = tuple(model.output_index(name) for name in self.names)
        self.function = _with_derivative(model, self.rows)
        order = len(model.equations.steps)
        fixed = {model.state_index(name) for name in values if name in model.states}
        c = point.coordinates
        mobility = c.to_states @ np.linalg.solve(point.mass, c.to_states.T) if order else np.zeros((0, 0))
        spread = np.diag(np.abs(np.diag(c.to_angles.T @ point.mass @ c.to_angles))) if order else mobility
        self.metric = {"rates": mobility, "angles": np.linalg.inv(spread) if order else spread}
        self.free = {
            "rates": [k for k in range(order, 2 * order) if k not in fixed],
            "angles": [k for k in range(order) if k not in fixed],
        }
        self.order = order

    def improved(self, state: Array, kinds: Sequence[str]) -> Array:
        """The state after changing these kinds of states for the channels that see no others, or all of them."""
        free = [k for kind in kinds for k in self.free[kind]]
        rows = self._seeing(kinds)
        if not free or not rows:
            return state
        metric = np.zeros((len(state), len(state)))
        n = self.order
        for kind in kinds:
            block = slice(n, 2 * n) if kind == "rates" else slice(0, n)
            metric[block, block] = self.metric[kind]
        metric = metric[np.ix_(free, free)]
        try:
            factor = np.linalg.cholesky((metric + metric.T) / 2 + 1e-300 * np.eye(len(free)))
        except np.linalg.LinAlgError:
            factor = self._wide_factor(kinds, free)
        state = self._out_of_play(state.copy(), rows, free) if kinds == ("angles",) else state.copy()
        for _ in range(ITERATIONS):
            values, slope = self._evaluated(state)
            rest = (self.wanted - values)[rows]
            arms = slope[np.ix_(rows, free)] @ factor
            size = np.maximum(np.abs(arms).sum(axis=1), 1e-300)
            change = factor @ np.linalg.lstsq(arms / size[:, None], rest / size, rcond=1e-12)[0]
            if not np.all(np.isfinite(change)):
                break
            state[free] += change
            if np.all(np.abs(change) <= 1e-15 * np.maximum(np.abs(state[free]), 1e-300)) or not np.abs(rest).any():
                break
        return state

    def _wide_factor(self, kinds: Sequence[str], free: Sequence[int]) -> Array:
        """A factor F of the metric F F^T from those of the inertias, where these lie too far apart for the metric itself."""
        c, n = self.point.coordinates, self.order
        try:
            of_rates = np.linalg.solve(np.linalg.cholesky(self.point.mass), c.to_states.T).T
        except np.linalg.LinAlgError:
            inertias = np.diag(self.point.mass)
            what = f"its inertias, from {inertias.min():.3g} to {inertias.max():.3g} kg*m^2, lie too far apart"
            where = f"case of {self.model.name!r}, start"
            raise CaseError(where, f"{what} to start from channels", "check them and their units, or start from states") from None
        wide = np.zeros((2 * n, 2 * n))
        if "rates" in kinds:
            wide[n:, n:] = of_rates
        if "angles" in kinds:
            wide[:n, :n] = np.sqrt(self.metric["angles"])
        return wide[free]

    def _out_of_play(self, state: Array, rows: Sequence[int], free: Sequence[int]) -> Array:
        """The state moved to where a channel sees its angles that it does not see at first, as a force inside a backlash."""
        seen = set(zip(*self.function.jac_sparsity(0, 1).get_triplet(), strict=True))
        for row in rows:
            values, slope = self._evaluated(state)
            columns = [k for k in free if (row, k) in seen]
            if slope[row, free].any() or values[row] == self.wanted[row]:
                continue
            for reach, sign, column in itertools.product(10.0 ** np.arange(-7, 1), (1.0, -1.0), columns):
                moved = state.copy()
                moved[column] += sign * reach
                found, slope = self._evaluated(moved)
                if slope[row, column] and (found[row] - values[row]) * (self.wanted[row] - values[row]) > 0:
                    state = moved
                    break
        return state

    def missed(self, state: Array) -> list[tuple[str, float]]:
        """Channels whose values are not met, with what they have."""
        values, slope = self._evaluated(state)
        size = np.maximum(np.abs(self.wanted), np.abs(slope) @ np.maximum(np.abs(state), 1e-12))
        wrong = ~(np.abs(values - self.wanted) <= np.maximum(1e3 * MET * size, 1e-300))
        return [(self.names[k], float(values[k])) for k in np.flatnonzero(wrong)]

    def _seeing(self, kinds: Sequence[str]) -> list[int]:
        """Channels to be met with these kinds of states: those of the rates alone, those that see angles, or all."""
        if len(kinds) == 2:
            return list(range(len(self.names)))
        seen = set(zip(*self.function.jac_sparsity(0, 1).get_triplet(), strict=True))
        angles = {row for row, column in seen if column < self.order}
        rates = {row for row, column in seen if self.order <= column < 2 * self.order}
        return sorted(angles if kinds == ("angles",) else rates - angles)

    def _evaluated(self, state: Array) -> tuple[Array, Array]:
        values, slope = self.function(self.time, state, self.p)
        return np.asarray(values).ravel(), slope.full()


@functools.lru_cache(maxsize=16)
def _with_derivative(model: Compiled, rows: tuple[int, ...]) -> ca.Function:
    """(t, x, p) -> channels of these rows and their derivative by the state."""
    e = model.expressions
    chosen = ca.densify(e["outputs"][list(rows)])
    return ca.Function("channels", [e["t"], e["x"], e["p"]], [chosen, ca.jacobian(chosen, e["x"])])
