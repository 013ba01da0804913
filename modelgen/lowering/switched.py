"""The model with its modes kept as flags: what a solver that locates events works with.

Part of the compiler, beside ``lower``. The parameter vector grows at its tail: the flags of all modes, then the values of the
sections. Within a mode the right-hand side is as smooth as the laws; nothing is built again when a mode or a value changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from modelgen.equations.mode_records import Transition
from modelgen.equations.records import Instance
from modelgen.errors import ModelError
from modelgen.lowering.clocks import Clocks
from modelgen.lowering.fixed import Fixed
from modelgen.lowering.forces import Balance
from modelgen.lowering.mass import Terms, solve_symmetric
from modelgen.lowering.motion import Motion, coordinates_of
from modelgen.lowering.program import program_of
from modelgen.lowering.sampling import sampled
from modelgen.lowering.switching import Crossing, ModeVariable, Switching
from modelgen.lowering.visitor import Visitor


@dataclass(frozen=True, eq=False)
class SwitchingParts:
    """Expressions of t, x, p and ``flags``: time derivative of x, channels, guards, and a column of x after each reset."""

    modes: tuple[ModeVariable, ...]
    crossings: tuple[Crossing, ...]
    flags: ca.SX
    ode: ca.SX
    outputs: ca.SX
    guards: ca.SX
    resets: ca.SX


@dataclass(frozen=True, eq=False)
class SwitchedModel:
    """A compiled model with its modes as flags: functions of (t, x, p), where p has ``tail`` behind the model's own parameters.

    ``tail`` holds the flags of the modes at the start, and the values of the sections. ``channels_function`` takes
    (t, x, flags, p) with the model's own p, for many instants in one call.
    """

    switching: Switching
    rhs_function: ca.Function
    jacobian_function: ca.Function
    output_function: ca.Function
    channels_function: ca.Function
    outputs: tuple[str, ...]
    tail: np.ndarray

    def extended(self, p: np.ndarray) -> np.ndarray:
        """The model's parameter vector with the modes of the start and the values of the sections at its tail."""
        return np.concatenate([np.asarray(p, dtype=float), self.tail])

    def flags_of(self, modes: np.ndarray) -> np.ndarray:
        """Flags (number of flags, n) of modes (n, number of variables), given by the numbers of their values."""
        rows = [modes[:, k] == value for k, mode in enumerate(self.switching.modes) for value in range(len(mode.values))]
        return np.array(rows, dtype=float).reshape(len(rows), len(modes))

    def channels(
        self, times: np.ndarray, states: np.ndarray, modes: np.ndarray, p: np.ndarray, names: Sequence[str] | None = None
    ) -> dict[str, np.ndarray]:
        """Output channels over a trajectory: times (n,), states (n, nx), modes (n, number of variables), the model's own p."""
        rows = list(range(len(self.outputs))) if names is None else [self.outputs.index(name) for name in names]
        values = sampled(self.channels_function, [times[None, :], states.T, self.flags_of(np.asarray(modes))], p, rows)
        return {self.outputs[row]: values[index] for index, row in enumerate(rows)}


def switched_model(
    parts: SwitchingParts,
    t: ca.SX,
    x: ca.SX,
    p: ca.SX,
    outputs: Sequence[str],
    watched: Sequence[int],
    crossings: Sequence[Crossing],
) -> SwitchedModel:
    """The functions of the parts; ``watched`` are the channels of sections and ``crossings`` what these are.

    The values of the sections are left zero in the tail.
    """
    levels = ca.SX.sym("level", len(watched))
    everything = ca.vertcat(p, parts.flags, levels)
    guards = ca.densify(ca.vertcat(parts.guards, parts.outputs[list(watched)] - levels if watched else ca.SX(0, 1)))

    def function(name: str, result: ca.SX) -> ca.Function:
        return ca.Function(name, [t, x, everything], [result], ["t", "x", "p"], [name])

    tail = np.zeros(parts.flags.numel() + len(watched))
    for mode in parts.modes:
        tail[mode.first - p.numel() + mode.start] = 1.0
    return SwitchedModel(
        switching=Switching(
            modes=parts.modes,
            crossings=(*parts.crossings, *crossings),
            guards=function("guards", ca.cse(guards)),
            p_size=everything.numel(),
            resets=function("resets", ca.cse(ca.densify(parts.resets))) if parts.resets.numel() else None,
        ),
        rhs_function=function("rhs", ca.densify(parts.ode)),
        jacobian_function=function("jacobian", ca.jacobian(parts.ode, x)),
        output_function=function("outputs", ca.densify(parts.outputs)),
        channels_function=ca.Function("channels", [t, x, parts.flags, p], [ca.densify(parts.outputs)]),
        outputs=tuple(outputs),
        tail=tail,
    )


def switching_parts(fixed: Fixed, clocks: Clocks, x: ca.SX, motion: Motion) -> SwitchingParts:
    """Everything that events need, with every mode of every element as a flag.

    Raises ModelError where speeds are held that depend on each other, so that no torque follows for either.
    """
    eq = fixed.equations
    counts = [fixed.block(each).slots.flags for each in eq.instances]
    flags = [ca.SX.sym("flag", len(symbols)) for symbols in counts]
    program = program_of(fixed, clocks, x, motion, flags)
    _check_held(fixed, clocks, x, flags, program.held)
    modes: list[ModeVariable] = []
    crossings: list[Crossing] = []
    guards: list[ca.SX] = []
    resets: list[ca.SX] = []
    first = fixed.parameters.size
    for instance, given in zip(eq.instances, program.arguments, strict=True):
        template, prefix = eq.templates[instance.template], f"{instance.name}." if instance.name else ""
        index_of = {}
        for m in template.modes:
            index_of[m.name] = len(modes)
            modes.append(ModeVariable(f"{prefix}{m.name}", m.values, first, m.start, m.memory, m.continuous))
            first += len(m.values)
        if not template.guards:
            continue
        values, present, after, _ = fixed.block(instance).events(*given.all)
        guards.append(values)
        place = 0
        for guard in template.guards:
            part = slice(place, place + len(guard.resets))
            crossing = _crossing(prefix, guard, index_of, modes)
            if guard.resets:
                resets.append(_after(fixed, instance, guard, x, program.balance, present[part], after[part]))
                crossing = replace(crossing, reset=len(resets) - 1)
            crossings.append(crossing)
            place = part.stop
    return SwitchingParts(
        modes=tuple(modes),
        crossings=tuple(crossings),
        flags=ca.vertcat(*flags),
        ode=ca.cse(program.ode),
        outputs=ca.cse(program.finish(ca.vertcat(*program.outputs.values()))),
        guards=program.finish(ca.vertcat(*guards)),
        resets=program.finish(ca.horzcat(*resets)) if resets else ca.SX(x.numel(), 0),
    )


def _check_held(fixed: Fixed, clocks: Clocks, x: ca.SX, flags: list[ca.SX], held: ca.SX) -> None:
    """All at once, each in the mode that holds it."""
    names, values = [], []
    for instance in fixed.equations.instances:
        template = fixed.equations.templates[instance.template]
        holding = {hold.flag for hold in template.holds}
        names += [instance.name or fixed.equations.name] * len(template.holds)
        values += [float(flag in holding) for flag in fixed.block(instance).slots.flags]
    if len(names) < 2:
        return
    arguments = [clocks.time, x, fixed.parameters.vector_symbol, ca.vertcat(*flags)]
    start = [state.start for state in fixed.equations.states]
    rows = ca.Function("held", arguments, [held])(0.0, start, fixed.parameters.unbalanced(), values).full()
    sizes = np.sqrt(np.abs(np.diag(rows)))
    if not np.all(sizes > 0) or np.linalg.matrix_rank(rows / np.outer(sizes, sizes), tol=1e-10) < len(names):
        what = f"speeds held by {', '.join(names)} depend on each other, so no torque follows for each"
        raise ModelError(f"driveline {fixed.equations.name!r}", what, "let one element hold what is joined rigidly")


def _crossing(prefix: str, guard: Transition, index_of: dict[str, int], modes: list[ModeVariable]) -> Crossing:
    name = f"{prefix}{guard.name}"
    if guard.variable is None or guard.leave is None or guard.enter is None:
        return Crossing(name, guard.direction, stops=guard.stops, barrier=guard.barrier)
    variable = index_of[guard.variable]
    leave, enter = (modes[variable].values.index(value) for value in (guard.leave, guard.enter))
    return Crossing(name, guard.direction, variable, leave, enter, stops=guard.stops, barrier=guard.barrier)


def _after(
    fixed: Fixed, instance: Instance, guard: Transition, x: ca.SX, balance: Balance, present: ca.SX, after: ca.SX
) -> ca.SX:
    """The state after the resets of a guard.

    Speeds g omega that are set take one impulse P each: M (omega+ - omega) = g^T P with g omega+ as wanted. Brogliato,
    Nonsmooth Mechanics, 3rd ed., Eq. 4.1.
    """
    eq, n, groups = fixed.equations, fixed.order, len(fixed.equations.groups)
    state, table = ca.SX(x), fixed.parameters.table
    local = {symbol: table[other] for symbol, other in instance.symbols.items() if other in table}
    visit = Visitor(local, instance.name or eq.name)
    own = {symbol: index for index, (_, symbol, *_) in zip(instance.states, eq.templates[instance.template].states, strict=True)}
    rows, wanted = [], []
    for row, reset in enumerate(guard.resets):
        if reset.state is not None:
            state[own[reset.state]] = after[row]
            continue
        combination = ca.SX.zeros(1, groups)
        for flange, coefficient in reset.coefficients.items():
            node = instance.nodes[flange]
            for group, ratio in fixed.node_rows[node].items():
                combination[group] += visit(coefficient) * ratio
        rows.append(combination)
        wanted.append(after[row] - present[row])
    if rows:
        g = ca.vertcat(*rows)
        spread = ca.horzcat(*(_mobility(balance.mass, row) for row in rows))
        along = ca.mtimes(g, spread)
        impulse = ca.vertcat(*wanted) / along if len(rows) == 1 else ca.solve(along, ca.vertcat(*wanted))
        change = coordinates_of(fixed, ca.mtimes(spread, impulse))
        for row, each in enumerate(change):
            state[n + row] += each
    return state


def _mobility(mass: Terms, row: ca.SX) -> ca.SX:
    """M^-1 times a row over the groups, as a column."""
    solved = solve_symmetric(mass, {group: row[group] for group in row.sparsity().get_triplet()[1]})
    return ca.vertcat(*(solved.get(group, ca.SX(0)) for group in range(row.numel())))
