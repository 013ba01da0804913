"""CVODES of the SUNDIALS suite through CasADi: variable-order backward differentiation formulas, implicit.

Part of ``solvers``. Orders one to five; good for stiff models. Lightly damped high frequencies lie where the higher orders lose
stability, so that it then takes more steps than a Runge-Kutta method.
"""

from __future__ import annotations

from modelgen.solvers.chunks import SUNDIALS_COUNTS, Plugin, integrate_in_chunks
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory

PLUGIN = Plugin("cvodes", 2, SUNDIALS_COUNTS, {"disable_internal_warnings": True})


def solve_cvodes(problem: InitialValueProblem, options: SolverOptions) -> Trajectory:
    """Integrate with CVODES; the tolerance bounds the root mean square over the states of the local error."""
    return integrate_in_chunks(problem, options, PLUGIN)
