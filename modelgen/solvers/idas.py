"""IDAS of the SUNDIALS suite through CasADi: backward differentiation formulas for differential-algebraic equations.

Part of ``solvers``. For ordinary differential equations it is a second, independent implementation of what CVODES does.
"""

from __future__ import annotations

from modelgen.solvers.chunks import SUNDIALS_COUNTS, Plugin, integrate_in_chunks
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory

PLUGIN = Plugin("idas", 2, SUNDIALS_COUNTS, {"disable_internal_warnings": True}, noisy=True)


def solve_idas(problem: InitialValueProblem, options: SolverOptions) -> Trajectory:
    """Integrate with IDAS; the tolerance bounds the root mean square over the states of the local error."""
    return integrate_in_chunks(problem, options, PLUGIN)
