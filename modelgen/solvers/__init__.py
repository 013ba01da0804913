"""Time: from one right-hand side and numbers to a trajectory with a named ending.

Stands below ``lowering`` and above ``analysis``. ``problem`` says what a solver sees and gives back, ``outcome`` how a run can
end, ``registry`` which solvers there are. ``adaptive_rk4`` is the product's own (paper, Eq. 23-32) and shares its loop
(``march``) with ``collocation``; ``cvodes``, ``idas``, ``erk`` and ``rosenbrock`` are CasADi's and share ``chunks``.
"""

from modelgen.solvers.case import Case
from modelgen.solvers.crosscheck import CrosscheckResult, CrosscheckRun, crosscheck
from modelgen.solvers.operating_point import OperatingPoint, operating_point
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Budget, SolverOptions
from modelgen.solvers.registry import SOLVERS
from modelgen.solvers.simulate import simulate
from modelgen.solvers.solution import Solution

__all__ = [
    "SOLVERS",
    "Budget",
    "Case",
    "CrosscheckResult",
    "CrosscheckRun",
    "OperatingPoint",
    "Outcome",
    "Solution",
    "SolverOptions",
    "crosscheck",
    "operating_point",
    "simulate",
]
