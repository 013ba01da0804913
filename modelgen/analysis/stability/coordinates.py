"""The motion in vibrating coordinates: a case as a problem without the rigid rotation, and the way back.

Below ``exponents`` and ``orbits``. Where no law sees a rigid angle, nor its speed, the other states move by themselves; the pair
that is left out has exponents of exactly 0 and multipliers of exactly 1, and is listed apart, never counted.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.nonlinear.motion import vibrating_states
from modelgen.errors import CaseError
from modelgen.lowering import Compiled
from modelgen.lowering.switching import Switching
from modelgen.solvers.bound_model import bind
from modelgen.solvers.case import Case
from modelgen.solvers.operating_point import OperatingPoint
from modelgen.solvers.problem import InitialValueProblem
from modelgen.solvers.registry import solver_named
from modelgen.solvers.simulate import initial_value_problem

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Vibration:
    """A case without its rigid rotation.

    ``problem``: over the vibrating states only; ``whole``: over all states; ``kept``, ``neutral``: positions in the whole state.
    """

    model: Compiled
    point: OperatingPoint
    whole: InitialValueProblem
    problem: InitialValueProblem
    kept: tuple[int, ...]

    @property
    def neutral(self) -> tuple[int, ...]:
        """Positions of the states that are left out."""
        return tuple(k for k in range(self.whole.x0.size) if k not in self.kept)

    @property
    def neutral_names(self) -> tuple[str, ...]:
        """Names of the states that are left out."""
        return tuple(self.whole.names[k] for k in self.neutral)

    @property
    def autonomous(self) -> bool:
        """Whether time itself is in no rate."""
        return bool(self.problem.rhs.jac_sparsity(0, 0).nnz() == 0)

    def state(self, z: Array) -> Array:
        """The whole state of a vibrating one, the neutral states at rest."""
        x = np.zeros(self.whole.x0.size)
        x[list(self.kept)] = z
        return x


def vibration_of(case: Case) -> Vibration:
    """The case in vibrating coordinates. Raises CaseError for a case without a model, or where nothing vibrates.

    Events are on unless the case says otherwise: where a law only bends, as at the edge of a backlash, the tangents' rates jump.
    """
    if case.model.switching is not None and solver_named(case.solver).locates_events:
        case = case.change(options={"events": "on"} | dict(case.options))
    point = bind(case.model).operating_point
    whole, _ = initial_value_problem(case, point)
    kept = tuple(vibrating_states(case.model, point))
    if not kept:
        raise CaseError(f"driveline {case.model.name!r}", "has no state that vibrates", "give it a shaft, or a state of its own")
    return Vibration(case.model, point, whole, without(whole, kept), kept)


def without(problem: InitialValueProblem, kept: tuple[int, ...]) -> InitialValueProblem:
    """The problem over the states ``kept``; the others, on which these do not depend, are held at zero."""
    if len(kept) == problem.x0.size:
        return problem
    rows = list(kept)
    return replace(
        problem,
        rhs=_reduced(problem.rhs, kept, rows=True),
        names=tuple(problem.names[k] for k in kept),
        x0=problem.x0[rows],
        scale=problem.scale[rows],
        switching=problem.switching and _reduced_switching(problem.switching, kept),
    )


@functools.lru_cache(maxsize=32)
def _reduced(function: ca.Function, kept: tuple[int, ...], rows: bool) -> ca.Function:
    """A function (t, x, p) -> one column or more as one of the states kept; ``rows``: only their rows of the result."""
    symbols = ca.SX if function.is_a("SXFunction") else ca.MX
    t, z, p = symbols.sym("t"), symbols.sym("z", len(kept)), symbols.sym("p", function.numel_in(2))
    entries = [symbols(0)] * function.numel_in(1)
    for position, state in enumerate(kept):
        entries[state] = z[position]
    value = function(t, ca.vertcat(*entries), p)
    value = ca.densify(value[list(kept), :] if rows else value)
    return ca.Function(function.name(), [t, z, p], [value], ["t", "x", "p"], ["value"])


@functools.lru_cache(maxsize=32)
def _reduced_switching(switching: Switching, kept: tuple[int, ...]) -> Switching:
    return replace(
        switching,
        guards=_reduced(switching.guards, kept, rows=False),
        resets=switching.resets and _reduced(switching.resets, kept, rows=True),
    )
