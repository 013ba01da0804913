"""Which solvers there are, what each has use for, and the one door to all of them.

Part of ``solvers``; the command line and ``simulate`` choose from ``SOLVERS`` by name.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

from modelgen.errors import CaseError, nearest
from modelgen.solvers.collocation import solve_collocation
from modelgen.solvers.cvodes import solve_cvodes
from modelgen.solvers.erk import solve_erk
from modelgen.solvers.explicit import solve_explicit
from modelgen.solvers.idas import solve_idas
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.rosenbrock import solve_rosenbrock

_OPTIONS = tuple(name for name in SolverOptions.__dataclass_fields__ if name != "tolerance")
EVERY = frozenset({"tolerance", "first_step", "largest_step", "budget", "events", "progress", "cancel"})


@dataclass(frozen=True)
class Solver:
    """A solver: what runs it, its order, one line about it, the options that it has use for beside those of every solver.

    ``locates_events``: finds where a mode changes, and starts anew there.
    """

    run: Callable[[InitialValueProblem, SolverOptions], Trajectory]
    order: int
    description: str
    extra_options: frozenset[str] = frozenset()
    locates_events: bool = False


SOLVERS: Mapping[str, Solver] = MappingProxyType(
    {
        "rk4": Solver(
            solve_explicit,
            4,
            "Runge-Kutta 4 with step doubling, the paper's (explicit; order 5 with extrapolation)",
            frozenset({"fixed_step", "rule", "extrapolate", "backend"}),
            locates_events=True,
        ),
        "dopri5": Solver(
            functools.partial(solve_explicit, method="dopri5"),
            5,
            "Dormand-Prince 5(4) (explicit, cheap steps)",
            frozenset({"fixed_step", "rule", "backend"}),
            locates_events=True,
        ),
        "verner65": Solver(
            functools.partial(solve_explicit, method="verner65"),
            6,
            "Verner 6(5) (explicit, fast at most tolerances; its dense output is too rough to locate events)",
            frozenset({"fixed_step", "rule", "backend"}),
        ),
        "dop853": Solver(
            functools.partial(solve_explicit, method="dop853"),
            8,
            "Dormand-Prince 8(5,3), of order 8 (explicit, for tight tolerances)",
            frozenset({"fixed_step", "rule", "backend"}),
            locates_events=True,
        ),
        "cvodes": Solver(solve_cvodes, 5, "CVODES: backward differentiation of order 1 to 5 (implicit, for stiff models)"),
        "idas": Solver(solve_idas, 5, "IDAS: the same for differential-algebraic equations (implicit)"),
        "collocation": Solver(
            solve_collocation,
            5,
            "Radau IIA collocation with step doubling (implicit, the most robust and the dearest)",
            frozenset({"fixed_step", "rule", "extrapolate"}),
            locates_events=True,
        ),
        "erk": Solver(solve_erk, 5, "Runge-Kutta pair 5(4) (explicit, cheap steps)", frozenset({"fixed_step"})),
        "rosenbrock": Solver(
            solve_rosenbrock, 5, "Rosenbrock-Wanner 5(4) (linearly implicit, L-stable)", frozenset({"fixed_step"})
        ),
    }
)


def solver_named(name: str) -> Solver:
    """The solver of a name; raises CaseError with the nearest one for a name that is not known.

    >>> solver_named("rk5")
    Traceback (most recent call last):
    ...
    modelgen.errors.CaseError: solver: there is none named 'rk5'; nearest is 'rk4'
    """
    if not isinstance(name, str) or name not in SOLVERS:
        raise CaseError("solver", f"there is none named {name!r}", nearest(str(name), SOLVERS))
    return SOLVERS[name]


def solver_options(tolerance: float, options: Mapping[str, Any]) -> SolverOptions:
    """Options of a solver from plain names; an unknown one is refused with the nearest."""
    for name in options:
        if name not in _OPTIONS:
            raise CaseError("case, options", f"has {name!r}", nearest(name, _OPTIONS))
    return SolverOptions(tolerance=tolerance, **options)


def refuse_unused(name: str, options: SolverOptions) -> None:
    """Raises CaseError for an option that the solver of a name has no use for, with the solvers that have."""
    solver = solver_named(name)
    standard = SolverOptions(tolerance=options.tolerance)
    for option in fields(options):
        used = option.name in EVERY or option.name in solver.extra_options
        if not used and getattr(options, option.name) != getattr(standard, option.name):
            fitting = [other for other, candidate in SOLVERS.items() if option.name in candidate.extra_options]
            problem_words = f"has no use for {option.name} = {getattr(options, option.name)!r}"
            raise CaseError(f"solver '{name}'", problem_words, f"leave it out, or take {' or '.join(fitting)}")


def solve(problem: InitialValueProblem, name: str, options: SolverOptions) -> Trajectory:
    """Run the solver of a name; raises CaseError for an unknown name and for an option that the solver has no use for."""
    refuse_unused(name, options)
    solver = solver_named(name)
    if problem.switching is not None and not solver.locates_events:
        fitting = [other for other, candidate in SOLVERS.items() if candidate.locates_events]
        raise CaseError(f"solver '{name}'", "cannot locate events", f'take {" or ".join(fitting)}, or events "off"')
    return solver.run(problem, options)
