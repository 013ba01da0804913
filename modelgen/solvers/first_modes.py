"""The modes in which a run starts, as far as the state alone decides them: which flank bears, which way a brake slips.

Below ``simulate``. What holds a speed is asked for its torque only after that, or a brake would seem to be overloaded by a torque
that a stop or a flank beside it takes; ``events`` follows the guards that are then still beyond zero.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from modelgen.lowering.switching import Switching
from modelgen.solvers.guards import guard_floors
from modelgen.solvers.problem import InitialValueProblem


def with_first_modes(problem: InitialValueProblem) -> InitialValueProblem:
    """The problem with the flags of the modes that its first state is in.

    A problem in which no guard sees the modes of others is given back as it is: the order does not matter there.
    """
    switching = problem.switching
    if switching is None:
        return problem
    of_state = _see_no_mode(switching)
    if all(of_state):
        return problem
    values = np.asarray(switching.guards(problem.t0, problem.x0, problem.p)).ravel()
    rounding = guard_floors(switching, problem, tolerance=0.0)[1]
    p = problem.p.copy()
    for _ in range(sum(len(mode.values) for mode in switching.modes)):
        changed = False
        for index, crossing in enumerate(switching.crossings):
            if crossing.variable is None or crossing.leave is None or crossing.enter is None or crossing.reset is not None:
                continue
            mode = switching.modes[crossing.variable]
            beyond = crossing.direction * values[index] > rounding[index]
            if of_state[index] and beyond and mode.of(p) == crossing.leave != crossing.enter:
                mode.put(p, crossing.enter)
                changed = True
        if not changed:
            break
    return replace(problem, p=p)


def _see_no_mode(switching: Switching) -> list[bool]:
    """Whether each guard is the same in all modes."""
    flags = {mode.first + k for mode in switching.modes for k in range(len(mode.values))}
    seeing = {row for row, column in zip(*switching.guards.jac_sparsity(0, 2).get_triplet(), strict=True) if column in flags}
    return [row not in seeing for row in range(len(switching.crossings))]
