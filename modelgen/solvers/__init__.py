"""Time: from one right-hand side and numbers to a trajectory with a named ending.

Stands below ``lowering`` and above ``analysis``. ``problem`` says what a solver sees and gives back, ``outcome`` how a run can
end, ``registry`` which solvers there are. The product's own (``doubled_step``, paper, Eq. 23-32; ``tableau_step`` for methods
that are files of numbers) enter by ``explicit`` and share their loop (``march``) with ``collocation``; ``guards``, ``location``
and ``events`` make it stop where something happens. The same in generated C: ``native`` and ``lanes``. ``cvodes``, ``idas``,
``erk`` and ``rosenbrock`` are CasADi's and share ``chunks``.
"""

from modelgen.solvers.bound_model import BoundModel, bind, operating_point
from modelgen.solvers.case import Case
from modelgen.solvers.crosscheck import CrosscheckResult, CrosscheckRun, crosscheck
from modelgen.solvers.operating_point import OperatingPoint
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Budget, SolverOptions
from modelgen.solvers.registry import SOLVERS
from modelgen.solvers.simulate import simulate
from modelgen.solvers.solution import Solution

__all__ = [
    "SOLVERS",
    "BoundModel",
    "Budget",
    "Case",
    "CrosscheckResult",
    "CrosscheckRun",
    "OperatingPoint",
    "Outcome",
    "Solution",
    "SolverOptions",
    "bind",
    "crosscheck",
    "operating_point",
    "simulate",
]
