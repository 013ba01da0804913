"""The explicit solvers: step doubling and the pairs from tableaus, on either backend.

Part of ``solvers``; entered by the registry, which binds the method's name.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from modelgen.errors import LoweringError
from modelgen.lowering.methods import read_tableau
from modelgen.solvers.coordinates import scaled_rate
from modelgen.solvers.doubled_step import doubled_method
from modelgen.solvers.march import march
from modelgen.solvers.native import solve_native
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.tableau_step import tableau_method
from modelgen.solvers.watch import Watch

SHORT = 3e8
"""Instructions of the virtual machine that a run may take before generated C is worth its building: some tenths of a second."""
OVERHEAD = 20_000
"""What a step costs besides its evaluations, in such instructions."""


def solve_explicit(problem: InitialValueProblem, options: SolverOptions, method: str = "rk4") -> Trajectory:
    """Integrate with error control or fixed steps, by the rule of step sizes and on the backend that the options name.

    ``method``: the name of a table, which is doubled where it has no error of its own (as "rk4"). "auto" begins on the virtual
    machine; a run that does not end within a number of steps set by the size of the model (never by the clock, so that a run
    gives the same digits every time) begins anew in generated C, where there is a compiler.
    """
    if options.backend == "c":
        return solve_native(problem, options, method)
    if options.backend == "vm":
        return _on_virtual_machine(problem, options, method)
    cost = OVERHEAD + 11 * problem.rhs.n_instructions() if problem.rhs.is_a("SXFunction") else math.inf
    few = max(1, int(SHORT / cost))
    if cost == math.inf or few >= options.budget.max_steps:
        return _on_virtual_machine(problem, options, method)
    options = replace(options, progress=_rising(options.progress))  # a run that begins anew does not fall back
    brief = replace(options, budget=replace(options.budget, max_steps=few))
    first = _on_virtual_machine(problem, brief, method)
    if first.outcome is not Outcome.MAX_STEPS:
        return first
    try:
        return solve_native(problem, options, method)
    except LoweringError:
        found = _on_virtual_machine(problem, options, method)
        return replace(found, statistics=replace(found.statistics, backend="vm, for want of a compiler"))


def _rising(progress: Callable[[float], None] | None) -> Callable[[float], None] | None:
    """The progress report, told only what is more than it was told before."""
    if progress is None:
        return None
    known = -1.0

    def tell(fraction: float) -> None:
        nonlocal known
        if fraction > known:
            known = fraction
            progress(fraction)

    return tell


def _on_virtual_machine(problem: InitialValueProblem, options: SolverOptions, method: str) -> Trajectory:
    watch = Watch(options)  # building the step counts
    rate = scaled_rate(problem.rhs)
    tableau = read_tableau(method)
    made = doubled_method(rate, tableau, options.extrapolate) if tableau.is_doubled else tableau_method(rate, tableau)
    return march(problem, options, made, watch)
