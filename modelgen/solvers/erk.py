"""CasADi's explicit Runge-Kutta pair of order 5(4), with dense output.

Part of ``solvers``. Cheap steps for smooth models that are not stiff; at equal tolerance it needs about half the evaluations of
step doubling. Its dense output is of order 4: values between steps err some twenty times more than the steps, next to a kink of
the right-hand side a hundred times more.
"""

from __future__ import annotations

from modelgen.solvers.chunks import RUNGE_KUTTA_COUNTS, Plugin, integrate_in_chunks
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory

PLUGIN = Plugin("erk", 7, RUNGE_KUTTA_COUNTS, own_steps=True)


def solve_erk(problem: InitialValueProblem, options: SolverOptions) -> Trajectory:
    """Integrate with the pair; with ``fixed_step``, every chunk is divided into equal steps of at most that size."""
    return integrate_in_chunks(problem, options, PLUGIN)
