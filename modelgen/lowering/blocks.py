"""Templates as CasADi functions: each law is translated once and then called for every instance.

Part of the compiler. A law falls into three stages by what it depends on: parameters only, time too, or the state too. The
stages stay apart, so that a mean model can take the place of the middle one.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import casadi as ca
import sympy

from modelgen.equations.records import Definition, Template
from modelgen.lowering.visitor import Visitor
from modelgen.model.declarations import TIME

Table = dict[sympy.Symbol, ca.SX]


@dataclass(frozen=True)
class Slots:
    """Template symbols in the order in which a stage takes their values."""

    parameters: tuple[sympy.Symbol, ...]
    inertias: tuple[sympy.Symbol, ...]
    clocks: tuple[sympy.Symbol, ...]
    motion: tuple[sympy.Symbol, ...]
    flags: tuple[sympy.Symbol, ...]
    multipliers: tuple[sympy.Symbol, ...]


class Block:
    """The three stages of one template.

    ``fixed(parameters, inertias)``, ``timed(..., fixed, clocks)``, ``state(..., fixed, timed, clocks, motion, flags,
    multipliers)`` return the values of the definitions of their stage; the last one also torques, mass terms, rates and energies.
    Of the arguments of ``state``, ``regions`` takes those without flags and multipliers and gives the expressions of all regions;
    ``events`` takes all, and gives guards, what resets set as it is, its values after, and held speeds.
    """

    def __init__(self, template: Template) -> None:
        self.template = template
        stages = {stage: [d for d in template.definitions if d.depends == stage] for stage in ("parameter", "time", "state")}
        self.fixed_names, self.timed_names, self.state_names = ([d.name for d in stages[key]] for key in stages)
        self.explicit_mean = tuple(d.mean is not None for d in stages["time"])
        self.slots = _slots(template)
        table: Table = {}
        parameters, inertias, clocks, motion, flags, multipliers = (
            _vector(name, symbols, table) for name, symbols in vars(self.slots).items()
        )

        given = [parameters, inertias]
        fixed = self._values(stages["parameter"], table)
        self.fixed = ca.Function("fixed", given, [fixed])
        given = [*given, _vector("fixed", [d.symbol for d in stages["parameter"]], table)]
        means = [self._visit(d.mean, table) if d.mean is not None else ca.SX(0) for d in stages["time"]]
        self.mean = ca.Function("mean", given, [ca.vertcat(*means)])
        given = [*given, clocks]
        timed = self._values(stages["time"], table)
        self.timed = ca.Function("timed", given, [timed])
        seen = [*given, _vector("timed", [d.symbol for d in stages["time"]], table), motion]
        given = [*seen, flags, multipliers]
        t = template
        results = [
            self._values(stages["state"], table),
            self._column([t.torques.get(f, sympy.Integer(0)) for f in t.flanges], table),
            self._column(t.rates.values(), table),
            self._column([t.stored_energy, t.dissipated_power, t.supplied_power], table),
            self._column(t.mass.values(), table),
        ]
        self.state = ca.Function("state", given, results)
        # Regions see no flag, so theirs is a function of the motion alone.
        self.regions = ca.Function("regions", seen, [self._column([x for m in t.modes for x in m.regions.values()], table)])
        resets = [reset for guard in t.guards for reset in guard.resets]
        columns = (
            [guard.expression for guard in t.guards],
            [reset.present for reset in resets],
            [reset.value for reset in resets],
            [hold.speed for hold in t.holds],
        )
        self.events = ca.Function("events", given, [self._column(column, table) for column in columns])

    def _visit(self, expression: sympy.Expr, table: Table) -> ca.SX:
        return Visitor(table, self.template.kind)(expression)

    def _column(self, expressions: Iterable[sympy.Expr], table: Table) -> ca.SX:
        visit = Visitor(table, self.template.kind)
        return ca.vertcat(*(visit(x) for x in expressions))

    def _values(self, definitions: Iterable[Definition], table: Table) -> ca.SX:
        """Definitions of one stage; each may use those before it, so the table learns them one by one."""
        for d in definitions:
            table[d.symbol] = self._visit(d.expression, table)
        return ca.vertcat(*(table[d.symbol] for d in definitions))


def _slots(template: Template) -> Slots:
    clocks: list[sympy.Symbol] = [TIME]
    for name in template.clocks:
        clocks += [sympy.Symbol(f"{name}.{part}", real=True) for part in ("angle", "frequency")]
    clocks += [harmonic.symbol for harmonic in template.harmonics]
    motion = [symbol for relative in template.relatives for symbol in (relative.angle, relative.rate)]
    for flange in template.flanges:
        motion += [sympy.Symbol(f"{flange}.{part}", real=True) for part in ("angle", "speed")]
    motion += [symbol for _, symbol, *_ in template.states]
    return Slots(
        parameters=tuple(symbol for _, symbols in template.parameters for symbol in symbols),
        inertias=tuple(sympy.Symbol(f"{flange}.inertia", positive=True) for flange in template.flanges),
        clocks=tuple(clocks),
        motion=tuple(motion),
        flags=tuple(symbol for modes in template.modes for symbol in modes.symbols),
        multipliers=template.multipliers,
    )


def _vector(name: str, symbols: Iterable[sympy.Symbol], table: Table) -> ca.SX:
    """A CasADi vector with one entry per symbol; the table learns which."""
    listed = list(symbols)
    vector = ca.SX.sym(name, len(listed))
    table.update({symbol: vector[index] for index, symbol in enumerate(listed)})
    return vector
