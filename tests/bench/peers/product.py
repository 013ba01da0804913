"""modelgen itself among its peers: its native solver and lanes, by method, with and without events."""

from __future__ import annotations

import numpy as np

from modelgen.lowering import Compiled
from modelgen.solvers import Case, operating_point
from modelgen.solvers.lanes import solve_lanes
from modelgen.solvers.native import solve_native
from modelgen.solvers.problem import SolverOptions
from modelgen.solvers.registry import solve
from modelgen.solvers.simulate import initial_value_problem


class Modelgen:
    """``events``: "on" or "off"; ``backend``: "c" (and lanes for sweeps), or "vm"."""

    tolerances = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)

    def __init__(
        self, model: Compiled, values: list[dict[str, float]], end: float, samples: int, method: str, events: str
    ) -> None:
        self.name = f"modelgen {method}{', events' if events == 'on' else ''}"
        self.method = method
        self.points = [operating_point(model, each) for each in values]
        options = {"events": events}
        self.problems = [
            initial_value_problem(Case(model, end=end, samples=samples, parameters=each, options=options), point)[0]
            for each, point in zip(values, self.points, strict=True)
        ]
        self.single(1e-3)  # built before the clock runs
        self.sweep(1e-3)

    def _angles(self, states: np.ndarray, k: int) -> np.ndarray:
        place = self.points[k].coordinates.to_angles
        n = len(place)
        return np.hstack([states[:, :n] @ place.T, states[:, n : 2 * n] @ place.T])

    def single(self, tolerance: float) -> np.ndarray:
        run = solve_native(self.problems[0], SolverOptions(tolerance=tolerance), self.method)
        return self._angles(run.states, 0)

    def sweep(self, tolerance: float) -> np.ndarray:
        runs = solve_lanes(self.problems, SolverOptions(tolerance=tolerance), method=self.method).trajectories
        return np.array([self._angles(run.states, k) for k, run in enumerate(runs)])


class VirtualMachine(Modelgen):
    """CasADi's virtual machine under the product's own loop, for one run."""

    tolerances = (1e-4, 1e-6)

    def __init__(self, model: Compiled, values: list[dict[str, float]], end: float, samples: int) -> None:
        super().__init__(model, values, end, samples, "rk4", "off")
        self.name = "modelgen rk4, virtual machine"

    def single(self, tolerance: float) -> np.ndarray:
        return self._angles(solve(self.problems[0], "rk4", SolverOptions(tolerance=tolerance, backend="vm")).states, 0)
