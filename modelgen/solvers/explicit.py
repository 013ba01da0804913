"""The explicit solvers: step doubling and the pairs from tableaus, on either backend.

Part of ``solvers``; entered by the registry, which binds the method's name.
"""

from __future__ import annotations

import contextlib

from modelgen.errors import LoweringError
from modelgen.lowering.tableau import read_tableau
from modelgen.solvers.adaptive_rk4 import rk4_method
from modelgen.solvers.coordinates import scaled_rate
from modelgen.solvers.march import march
from modelgen.solvers.native import solve_native
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.tableau_step import tableau_method
from modelgen.solvers.watch import Watch


def solve_explicit(problem: InitialValueProblem, options: SolverOptions, method: str = "rk4") -> Trajectory:
    """Integrate with error control or fixed steps, by the rule of step sizes and on the backend that the options name.

    ``method``: "rk4" with step doubling, or the name of a tableau with an error estimate. "auto" takes generated C for what C can
    do where there is a compiler.
    """
    if options.backend == "c":
        return solve_native(problem, options, method)
    if options.backend == "auto":
        with contextlib.suppress(LoweringError):
            return solve_native(problem, options, method)
    watch = Watch(options)  # building the step counts
    rate = scaled_rate(problem.rhs)
    made = rk4_method(rate, options.extrapolate) if method == "rk4" else tableau_method(rate, read_tableau(method))
    return march(problem, options, made, watch)
