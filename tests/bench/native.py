"""Seconds against errors on the truck: generated C and lanes beside CasADi's virtual machine. Run by hand, not by pytest.

    python tests/bench/native.py [seconds simulated] [runs in the sweep]

The error of a run is the largest difference of its last quarter from a solution at tolerance 1e-11, in units of half the peak-to-
peak value of each group of states (angles, rates): the fluctuating part. The sweep varies the damping ratio zeta; its error is
given as median and worst. All in one process, side by side; the ratios are what counts.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable

import numpy as np

from modelgen import assemble, load, lower
from modelgen.lowering.native import native_solver
from modelgen.lowering.native.library import solver_of
from modelgen.solvers import Case, operating_point
from modelgen.solvers.lanes import solve_lanes
from modelgen.solvers.native import solve_native
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.registry import solve
from modelgen.solvers.simulate import initial_value_problem

MODEL = "fracturing-truck"
ZETAS = (0.01, 0.08)


def error(run: Trajectory, exact: Trajectory) -> float:
    """Largest difference by group, in units of the fluctuating part."""
    late = slice(-len(exact.times) // 4, None)
    half = np.ptp(exact.states[late], axis=0) / 2
    difference = np.abs(run.states - exact.states)[late].max(axis=0)
    groups = np.array_split(np.arange(half.size), 2)
    return max(float(difference[group].max() / half[group].max()) for group in groups)


def timed(action: Callable[[], object], repetitions: int) -> tuple[float, object]:
    """The best of some repetitions, and the last result."""
    best, result = np.inf, None
    for _ in range(repetitions):
        start = time.perf_counter()
        result = action()
        best = min(best, time.perf_counter() - start)
    return best, result


def main(seconds: float, count: int) -> None:
    model = lower(assemble(load(MODEL)))

    def problem(values: dict[str, float] | None = None) -> InitialValueProblem:
        case = Case(model, end=seconds, samples=401, parameters=values or {})
        return initial_value_problem(case, operating_point(model, values))[0]

    for lanes in (False, True):
        start = time.perf_counter()
        native_solver(model.rhs_function, lanes)
        built = time.perf_counter() - start
        solver_of.cache_clear()
        start = time.perf_counter()
        solver = native_solver(model.rhs_function, lanes)
        loaded = time.perf_counter() - start
        print(f"{solver.lanes} lane(s): {built:.2f} s the first time, {1e3 * loaded:.1f} ms from the cache")
    one = problem()
    exact = solve_native(one, SolverOptions(tolerance=1e-11))
    print(f"\none trajectory of {seconds:g} s\n{'solver':22}{'tolerance':>10}{'seconds':>10}{'error':>11}{'us/step':>9}")
    rows = [("C", solve_native, t, 3) for t in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)]
    rows += [(f"C, {m}", lambda p, o, m=m: solve_native(p, o, m), t, 3) for m in ("dopri5", "dop853") for t in (1e-4, 1e-6, 1e-8)]
    rows += [("virtual machine, rk4", lambda p, o: solve(p, "rk4", o), t, 1) for t in (1e-4, 1e-6)]
    rows += [("cvodes", lambda p, o: solve(p, "cvodes", o), t, 1) for t in (1e-4, 1e-5, 1e-6, 1e-7)]
    for name, run, tolerance, repetitions in rows:
        took, found = timed(lambda r=run, t=tolerance: r(one, SolverOptions(tolerance=t)), repetitions)
        assert isinstance(found, Trajectory)
        print(
            f"{name:22}{tolerance:10.0e}{took:10.4f}{error(found, exact):11.1e}{1e6 * took / found.statistics.steps:9.3f}",
            flush=True,
        )
    sweep = [problem({"zeta": float(zeta)}) for zeta in np.linspace(*ZETAS, count)]
    references = solve_lanes(sweep, SolverOptions(tolerance=1e-11)).trajectories
    print(
        f"\n{count} damping ratios in lanes, per trajectory\n"
        f"{'threads':>7}{'tolerance':>10}{'seconds':>10}{'median':>11}{'worst':>10}"
    )
    for threads in (1, None):
        for tolerance in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7):
            options = SolverOptions(tolerance=tolerance)
            took, found = timed(lambda o=options, n=threads: solve_lanes(sweep, o, n).trajectories, 2)
            assert isinstance(found, tuple)
            errors = [error(run, reference) for run, reference in zip(found, references, strict=True)]
            print(
                f"{threads or 'all':>7}{tolerance:10.0e}{took / count:10.5f}{np.median(errors):11.1e}{max(errors):10.1e}",
                flush=True,
            )


if __name__ == "__main__":
    import os

    with tempfile.TemporaryDirectory() as folder:
        os.environ["MODELGEN_CACHE"] = folder
        main(*(float(sys.argv[1]) if len(sys.argv) > 1 else 2.0, int(sys.argv[2]) if len(sys.argv) > 2 else 64))
