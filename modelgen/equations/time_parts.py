"""What depends on time is set apart: sine and cosine of clocks become shared harmonics, and definitions get their stages.

Part of the grammar, after the relative angles (``modelgen.equations.relative_angles``). An expression belongs to the stage
"parameter", "time" or "state", the earliest in which it can be evaluated; what depends on time alone has a mean over a period.
"""

from __future__ import annotations

from collections.abc import Iterable

import sympy

from modelgen.equations.element_symbols import ElementSymbols
from modelgen.equations.records import Definition, Harmonic
from modelgen.equations.relative_angles import Key, Laws, definitions_in
from modelgen.model.declarations import TIME

WHOLE = ("region", "guard", "present", "reset", "hold")
"""Laws of the switching: they are looked at by themselves, and never averaged over time."""


def share_harmonics(symbols: ElementSymbols, laws: Laws) -> tuple[dict[Key, sympy.Expr], tuple[Harmonic, ...]]:
    """The laws with symbols for sin(n * clock angle) and cos(n * clock angle), and what these symbols stand for."""
    waves: dict[sympy.Basic, Harmonic] = {}
    for name, clock in symbols.clocks.items():
        for law in laws.values():
            if clock.angle not in law.free_symbols:
                continue
            for wave in sorted(law.atoms(sympy.sin, sympy.cos), key=str):
                order = wave.args[0] / clock.angle
                if isinstance(order, sympy.Integer) and order > 0 and wave not in waves:
                    shape = "sin" if isinstance(wave, sympy.sin) else "cos"
                    waves[wave] = Harmonic(sympy.Symbol(f"{name}.{shape}_{order}", real=True), name, int(order), shape)
    swap = {wave: harmonic.symbol for wave, harmonic in waves.items()}
    return {key: law.xreplace(swap) for key, law in laws.items()}, tuple(waves.values())


def set_time_apart(symbols: ElementSymbols, laws: Laws) -> tuple[dict[Key, sympy.Expr], tuple[Definition, ...]]:
    """The laws and the definitions with their stages; parts of laws that depend on time only become hidden definitions."""
    stages = _Stages(symbols, laws.values())
    for name, expression in definitions_in(laws):
        named, stage = symbols.quantities[name], stages.of(expression)
        if stage == "state":
            expression = stages.split(expression, f"{name}_time")
        mean = None
        if named.mean is not None and stage == "time":
            mean = symbols.read(named.mean(symbols.element), f"mean of {name}")
        stages.define(Definition(name, named.symbol, expression, named.unit, stage, mean))
    others = {key: law for key, law in laws.items() if key[0] != "definition"}
    parted = {key: law if key[0] in WHOLE else stages.split(law, "_".join(key) + "_time") for key, law in others.items()}
    return parted, tuple(stages.definitions)


class _Stages:
    """Knows which symbols vary with time and which with the state, and collects the definitions in order of evaluation."""

    def __init__(self, symbols: ElementSymbols, laws: Iterable[sympy.Expr]) -> None:
        self.definitions: list[Definition] = []
        self.stated = symbols.motion | symbols.switched | {state.symbol for state in symbols.states.values()}
        of_clocks = {s for law in laws for s in law.free_symbols if "." in s.name and s.name.split(".")[0] in symbols.clocks}
        self.timed = {TIME, *of_clocks, *(clock.angle for clock in symbols.clocks.values())}
        self.timed -= {clock.frequency for clock in symbols.clocks.values()}

    def of(self, expression: sympy.Basic) -> str:
        """The stage of an expression."""
        free = expression.free_symbols
        if free & self.stated or any(symbol.name.startswith("relative_") for symbol in free):
            return "state"
        return "time" if free & self.timed else "parameter"

    def define(self, definition: Definition) -> None:
        """Adds a definition; what uses its symbol from now on is of its stage or a later one."""
        self.definitions.append(definition)
        if definition.depends == "state":
            self.stated.add(definition.symbol)
        elif definition.depends == "time":
            self.timed.add(definition.symbol)

    def split(self, x: sympy.Basic, name: str) -> sympy.Basic:
        """Sets parts that depend on time only apart from an expression that depends on the state too."""
        if isinstance(x, sympy.Symbol) or not x.free_symbols & self.timed or not isinstance(x, sympy.Expr):
            return x
        if self.of(x) == "time":
            symbol = sympy.Symbol(f"{name}_{len(self.definitions)}", real=True)
            self.define(Definition(symbol.name, symbol, x, "1", "time", hidden=True))
            return symbol
        if isinstance(x, (sympy.Add, sympy.Mul)):
            alone = [arg for arg in x.args if self.of(arg) != "state"]
            if any(self.of(arg) == "time" for arg in alone):
                rest = [arg for arg in x.args if self.of(arg) == "state"]
                joined = x.func(*alone)
                apart = joined if isinstance(joined, sympy.Symbol) else self.split(joined, name)
                return x.func(apart, *(self.split(arg, name) for arg in rest))
        if isinstance(x, sympy.Piecewise):
            return x
        return x.func(*(self.split(arg, name) for arg in x.args))
