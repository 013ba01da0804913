"""Which solvers there are, what each has use for, and the one door to all of them.

Part of ``solvers``; the command line and ``simulate`` choose from them by name. An explicit method is a table of numbers, in the
package or in a folder of the user (``lowering.methods``), and nothing else.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

from modelgen.errors import CaseError, LoweringError, nearest
from modelgen.lowering.methods import method_files, package_files, read_tableau
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

    ``locates_events``: finds where a mode changes, and starts anew there. ``crosscheck_tolerance``: at which its own error is
    some 1e-7 of the swing of the 16-degree truck.
    """

    run: Callable[[InitialValueProblem, SolverOptions], Trajectory]
    order: int
    description: str
    crosscheck_tolerance: float
    extra_options: frozenset[str] = frozenset()
    locates_events: bool = False


def _explicit(name: str) -> Solver:
    """The solver of a table: everything that is known of it stands there."""
    table = read_tableau(name)
    return Solver(
        functools.partial(solve_explicit, method=name),
        table.order,
        table.description,
        table.crosscheck_tolerance,
        EXPLICIT | {"extrapolate"} if table.is_doubled else EXPLICIT,
        table.locates_events,
    )


EXPLICIT = frozenset({"fixed_step", "rule", "backend"})
_OF_CASADI = {
    "cvodes": Solver(solve_cvodes, 5, "CVODES: backward differentiation of order 1 to 5 (implicit, for stiff models)", 1e-9),
    "idas": Solver(solve_idas, 5, "IDAS: the same for differential-algebraic equations (implicit)", 1e-9),
    "collocation": Solver(
        *(solve_collocation, 5, "Radau IIA collocation with step doubling (implicit, the most robust and the dearest)", 1e-6),
        frozenset({"fixed_step", "rule", "extrapolate"}),
        locates_events=True,
    ),
    "erk": Solver(solve_erk, 5, "Runge-Kutta pair 5(4) (explicit, cheap steps)", 1e-8, frozenset({"fixed_step"})),
    "rosenbrock": Solver(
        solve_rosenbrock, 5, "Rosenbrock-Wanner 5(4) (linearly implicit, L-stable)", 1e-8, frozenset({"fixed_step"})
    ),
}
_OF_TABLES = sorted(((name, _explicit(name)) for name in package_files()), key=lambda each: each[1].order)
SOLVERS: Mapping[str, Solver] = MappingProxyType({**dict(_OF_TABLES), **_OF_CASADI})
"""The solvers of the package; ``every_solver`` adds those of the user's tables."""


def every_solver() -> Mapping[str, Solver]:
    """All solvers by name: those of the package, then those of the tables in ``MODELGEN_METHODS``. Raises LoweringError."""
    own = [name for name in method_files() if name not in package_files()]
    for name in own:
        if name in _OF_CASADI:
            raise LoweringError(f"method {name!r}", "has the name of a solver of the package", "give it another name")
    return {**SOLVERS, **{name: _explicit(name) for name in own}} if own else SOLVERS


def solver_named(name: str) -> Solver:
    """The solver of a name; raises CaseError with the nearest one for a name that is not known.

    >>> solver_named("rk5")
    Traceback (most recent call last):
    ...
    modelgen.errors.CaseError: solver: there is none named 'rk5'; nearest is 'rk4'
    """
    if isinstance(name, str) and name in SOLVERS:
        return SOLVERS[name]
    every = every_solver()
    if not isinstance(name, str) or name not in every:
        raise CaseError("solver", f"there is none named {name!r}", nearest(str(name), every))
    return every[name]


def method_digest(name: str) -> str:
    """SHA-256 of the numbers of a user's table; empty for a solver of the package, which its name says."""
    return "" if name in SOLVERS else hashlib.sha256(repr(read_tableau(name)).encode()).hexdigest()


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
            fitting = [other for other, candidate in every_solver().items() if option.name in candidate.extra_options]
            problem_words = f"has no use for {option.name} = {getattr(options, option.name)!r}"
            raise CaseError(f"solver '{name}'", problem_words, f"leave it out, or take {' or '.join(fitting)}")


def solve(problem: InitialValueProblem, name: str, options: SolverOptions) -> Trajectory:
    """Run the solver of a name; raises CaseError for an unknown name and for an option that the solver has no use for."""
    refuse_unused(name, options)
    solver = solver_named(name)
    if problem.switching is not None and not solver.locates_events:
        fitting = [other for other, candidate in every_solver().items() if candidate.locates_events]
        raise CaseError(f"solver '{name}'", "cannot locate events", f'take {" or ".join(fitting)}, or events "off"')
    return solver.run(problem, options)
