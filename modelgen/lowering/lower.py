"""Equations to Compiled: CasADi expressions of a whole driveline, put together from its blocks. The compiler's main sentence.

Third stage of the flow. Each word of the sentence has a file: ``fixed`` (what parameters alone decide), ``clocks`` (time),
``motion`` (angles and speeds), ``arguments`` (what a law sees, and its modes), ``forces`` (laws, sums, accelerations),
``channels`` (outputs); ``program`` says them in order. The same words, said of physical angles and means, give the functions
that equilibrium and linearization use: ``mean_model``; said with modes kept as flags, those that events need: ``switched``.
Below them stand ``blocks`` (one law as CasADi functions), ``visitor`` (one expression) and ``operations`` (one operation).
"""

from __future__ import annotations

import casadi as ca

from modelgen.equations.records import Equations
from modelgen.errors import refuse_unless
from modelgen.lowering.balance import LoadBalance
from modelgen.lowering.clocks import _multiple as _multiple
from modelgen.lowering.clocks import clocks_of
from modelgen.lowering.compiled import Compiled
from modelgen.lowering.fixed import fixed_part
from modelgen.lowering.mean_model import mean_model
from modelgen.lowering.motion import motion_of_states
from modelgen.lowering.program import program_of
from modelgen.lowering.switched import switching_parts


def lower(equations: Equations) -> Compiled:
    """CasADi functions of the equations. Raises LoweringError for a law that has no numeric counterpart.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble, lower
    >>> model = lower(assemble(Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=7.0)])))
    >>> model.rhs(0.0, [0.0, 1.0, 0.0, 0.0], model.parameters.vector()).tolist()  # twist 1 rad
    [0.0, 0.0, -1.4, -4.9]
    """
    refuse_unless(equations, Equations, "lower")
    fixed = fixed_part(equations)
    clocks = clocks_of(fixed)
    x = ca.SX.sym("x", len(equations.states))
    motion = motion_of_states(fixed, clocks.time, x)
    program = program_of(fixed, clocks, x, motion)
    y = ca.vertcat(*program.outputs.values())
    ode, y = ca.cse(program.ode), ca.cse(program.finish(y))
    means = mean_model(fixed, clocks, x)
    if equations.balanced:
        fixed.parameters.balance = LoadBalance(equations, means, fixed.parameters.slices)
    return Compiled(
        equations=equations,
        parameters=fixed.parameters,
        expressions={"t": clocks.time, "x": x, "p": fixed.parameters.vector_symbol, "ode": ode, "outputs": y},
        states=tuple(state.name for state in equations.states),
        outputs=tuple(program.outputs),
        units=tuple(output.unit for output in equations.outputs),
        mean_model=means,
        switching_parts=lambda: switching_parts(fixed, clocks, x, motion),
    )
