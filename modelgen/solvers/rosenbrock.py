"""CasADi's Rosenbrock-Wanner method of order 5(4): linearly implicit, L-stable, without Newton iterations.

Part of ``solvers``. One Jacobian and one factorization per step; good for stiff models, and accurate for its tolerance.
"""

from __future__ import annotations

from modelgen.solvers.chunks import RUNGE_KUTTA_COUNTS, Plugin, integrate_in_chunks
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory

PLUGIN = Plugin("rosenbrock", 12, RUNGE_KUTTA_COUNTS, own_steps=True, stiff=True)


def solve_rosenbrock(problem: InitialValueProblem, options: SolverOptions) -> Trajectory:
    """Integrate with the method; with ``fixed_step``, every chunk is divided into equal steps of at most that size."""
    return integrate_in_chunks(problem, options, PLUGIN)
