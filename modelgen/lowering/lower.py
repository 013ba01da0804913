"""Equations to Compiled: CasADi expressions of a whole driveline, put together from its blocks. The compiler's main sentence.

Third stage of the flow. Each word of the sentence has a file: ``fixed`` (what parameters alone decide), ``clocks`` (time),
``motion`` (angles and speeds), ``forces`` (laws, sums, accelerations), ``channels`` (outputs). The same words, said of physical
angles and means, give the functions that equilibrium and linearization use: ``mean_model``. Below them stand ``blocks`` (one law
as CasADi functions), ``visitor`` (one expression) and ``operations`` (one operation).
"""

from __future__ import annotations

import casadi as ca

from modelgen.equations.records import Equations
from modelgen.lowering.channels import channels_of
from modelgen.lowering.clocks import _multiple as _multiple
from modelgen.lowering.clocks import clocks_of
from modelgen.lowering.compiled import Compiled
from modelgen.lowering.fixed import fixed_part
from modelgen.lowering.forces import balance_of, forces_at
from modelgen.lowering.mean_model import mean_model
from modelgen.lowering.motion import coordinates_of, motion_of_states


def lower(equations: Equations) -> Compiled:
    """CasADi functions of the equations. Raises LoweringError for a law that has no numeric counterpart.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble, lower
    >>> model = lower(assemble(Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=7.0)])))
    >>> model.rhs(0.0, [0.0, 1.0, 0.0, 0.0], model.parameters.vector()).tolist()  # twist 1 rad
    [0.0, 0.0, -1.4, -4.9]
    """
    fixed = fixed_part(equations)
    clocks = clocks_of(fixed)
    x = ca.SX.sym("x", len(equations.states))
    motion = motion_of_states(fixed, clocks.time, x)
    forces = forces_at(fixed, motion, clocks.values, clocks.timed)
    balance = balance_of(fixed, forces)
    outputs = channels_of(fixed, motion, forces, balance)

    n = fixed.order
    rates = x[n : 2 * n, 0]  # the column, or a slice of one number has the shape (1, 0)
    ode = ca.vertcat(rates, *coordinates_of(fixed, balance.acceleration), *forces.rates)
    ode, y = (ca.cse(clocks.running(each)) for each in (ode, ca.vertcat(*outputs.values())))
    return Compiled(
        equations=equations,
        parameters=fixed.parameters,
        expressions={"t": clocks.time, "x": x, "p": fixed.parameters.vector_symbol, "ode": ode, "outputs": y},
        states=tuple(state.name for state in equations.states),
        outputs=tuple(outputs),
        units=tuple(output.unit for output in equations.outputs),
        mean_model=mean_model(fixed, clocks, x),
    )
