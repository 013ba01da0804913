"""The program of a driveline: its right-hand side and channels in given modes, and what its events need.

Part of ``lower``: the sentence that its files are the words of, said once with modes found by comparison and once with modes
kept as flags (``switched``). Where a mode holds a speed s(t, x), its multipliers follow from ds/dt = 0: with x' linear in them,
A lambda = -b over all held speeds, and a row whose mode does not hold reads lambda = 0. For a speed of flanges held by a torque
on them, A is G M^-1 G^T. Brogliato, Nonsmooth Mechanics, 3rd ed., ch. 5; Pfeiffer, Glocker, Multibody Dynamics with Unilateral
Contacts, ch. 5. Beside a small inertia the rounding of lambda alone would move the speed, so what is left of ds/dt is taken out
of x' again, twice (iterative refinement; Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., ch. 12).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

from modelgen.equations.records import Instance, Template
from modelgen.errors import LoweringError
from modelgen.lowering.arguments import Arguments, arguments_at
from modelgen.lowering.channels import channels_of
from modelgen.lowering.clocks import Clocks
from modelgen.lowering.fixed import Fixed
from modelgen.lowering.forces import Balance, balance_of, forces_at
from modelgen.lowering.motion import Motion, coordinates_of

REFINEMENTS = 2  # of the rates of held speeds; each takes out what the rounding of double precision has left


@dataclass(frozen=True, eq=False)
class Program:
    """Expressions of t, x, p (and flags): time derivative of x, channels by name.

    ``finish`` brings what was built beside them into the same form, with multipliers solved and clocks running. ``held`` is the
    matrix whose solution they are, (number of multipliers) squared.
    """

    ode: ca.SX
    outputs: dict[str, ca.SX]
    arguments: list[Arguments]
    balance: Balance
    finish: Callable[[ca.SX], ca.SX]
    held: ca.SX


def program_of(fixed: Fixed, clocks: Clocks, x: ca.SX, motion: Motion, flags: list[ca.SX] | None = None) -> Program:
    """The program in the modes that the flags say, one column per instance, or in those found by comparison."""
    counts = [len(fixed.equations.templates[each.template].multipliers) for each in fixed.equations.instances]
    multipliers = [ca.SX.sym("multiplier", count) for count in counts]
    arguments = arguments_at(fixed, motion, clocks.values, clocks.timed, flags, multipliers)
    forces = forces_at(fixed, arguments, motion)
    balance = balance_of(fixed, forces)
    n = fixed.order
    rates = x[n : 2 * n, 0]  # the column, or a slice of one number has the shape (1, 0)
    ode = clocks.running(ca.vertcat(rates, *coordinates_of(fixed, balance.acceleration), *forces.rates))
    unknown = ca.vertcat(*multipliers)
    if not unknown.numel():
        return Program(ode, channels_of(fixed, motion, forces, balance), arguments, balance, clocks.running, ca.SX(0, 0))
    holds = _held_speeds(fixed, clocks, x, ode, arguments, unknown)
    solved = holds.solve(holds.rate(ca.substitute(ode, unknown, ca.SX.zeros(unknown.numel()))))

    def finish(expression: ca.SX) -> ca.SX:
        return ca.substitute(clocks.running(expression), unknown, solved)

    ode, moved_by = finish(ode), ca.jacobian(ode, unknown)
    for _ in range(REFINEMENTS):
        ode = ode + ca.mtimes(moved_by, holds.solve(holds.rate(ode)))
    return Program(ode, channels_of(fixed, motion, forces, balance), arguments, balance, finish, holds.matrix)


@dataclass(frozen=True, eq=False)
class _Holds:
    """The held speeds s(t, x), the mask of those whose mode holds, and the matrix of all multipliers.

    ``rate(x')`` is ds/dt; ``solve(ds/dt)`` gives the multipliers that take it away where a mode holds, and 0 elsewhere.
    """

    speed: ca.SX
    mask: ca.SX
    matrix: ca.SX
    time: ca.SX
    x: ca.SX

    def rate(self, ode: ca.SX) -> ca.SX:
        return ca.jtimes(self.speed, self.x, ode) + ca.jtimes(self.speed, self.time, ca.SX(1))

    def solve(self, rate: ca.SX) -> ca.SX:
        right = -self.mask * rate
        return right / self.matrix if right.numel() == 1 else ca.solve(self.matrix, right)


def _held_speeds(fixed: Fixed, clocks: Clocks, x: ca.SX, ode: ca.SX, arguments: list[Arguments], unknown: ca.SX) -> _Holds:
    """What is held, and by what. Raises LoweringError where multipliers do not follow from such a system."""
    speeds, masks = [], []
    for instance, given in zip(fixed.equations.instances, arguments, strict=True):
        template = fixed.equations.templates[instance.template]
        if template.holds:
            held = ca.vertsplit(fixed.block(instance).events(*given.all)[3])
            places = [[hold.multiplier for hold in template.holds].index(symbol) for symbol in template.multipliers]
            speeds += [held[place] for place in places]
            masks += [_flag(fixed, instance, template, given, place) for place in places]
    speed, mask = clocks.running(ca.vertcat(*speeds)), clocks.running(ca.vertcat(*masks))
    rate = ca.jtimes(speed, x, ode) + ca.jtimes(speed, clocks.time, ca.SX(1))
    matrix = ca.jacobian(rate, unknown)
    if ca.depends_on(matrix, unknown):
        names = ", ".join(each.name for each in fixed.equations.instances if fixed.equations.templates[each.template].holds)
        remedy = "let torques and rates be linear in them"
        raise LoweringError(f"driveline {fixed.equations.name!r}", f"the multipliers of {names} do not follow", remedy)
    rows = ca.densify(ca.mtimes(ca.diag(mask), matrix) + ca.diag(1 - mask))
    return _Holds(speed, mask, rows, clocks.time, x)


def _flag(fixed: Fixed, instance: Instance, template: Template, given: Arguments, place: int) -> ca.SX:
    flags = fixed.block(instance).slots.flags
    return given.flags[flags.index(template.holds[place].flag)]
