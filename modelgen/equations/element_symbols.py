"""What the laws of one element may speak of: its symbols, their dimensions, and which of them are parameters.

Part of the grammar, first step from an element class to a template (``modelgen.equations.template``); it knows no element by
name. Everything an element's method returns enters through ``ElementSymbols.read``.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

import sympy

from modelgen.errors import ModelError, NamingError
from modelgen.model import Clock, Derived, Element, Flange, Modes, Multiplier, Param, State, quantity
from modelgen.model.declarations import TIME, UNIT_CONSTANTS
from modelgen.units import Dimension, dimension_of


class ElementSymbols:
    """The declarations of an element under its settings of the switches, and the symbols they stand for."""

    def __init__(self, element: Element) -> None:
        self.element, self.where = element, element.where
        self.flanges = {name: flange.symbols for name, flange in element.declared(Flange).items()}
        self.angles = {symbols.angle: name for name, symbols in self.flanges.items()}
        self.speeds = {symbols.speed: name for name, symbols in self.flanges.items()}
        self.states = element.declared(State)
        self.clocks = {name: clock.symbols for name, clock in element.declared(Clock).items()}
        self.quantities = element.declared(quantity)
        self.modes = {name: modes for name, modes in element.declared(Modes).items() if modes.exists(element.choices)}
        self.multipliers = element.declared(Multiplier)
        self._params = {k: p for k, p in element.declared(Param).items() if p.exists(element.choices)}
        self._derived = {k: d for k, d in element.declared(Derived).items() if d.exists(element.choices)}

    @functools.cached_property
    def parameters(self) -> dict[str, tuple[sympy.Symbol, ...]]:
        """Symbols of every parameter, own and derived, by its name."""
        lengths = self.element.lengths
        own = {name: param.symbols(lengths.get(name) if param.series else None) for name, param in self._params.items()}
        return {**own, **{name: each.symbols(self.element) for name, each in self._derived.items()}}

    @functools.cached_property
    def constants(self) -> set[sympy.Symbol]:
        """Symbols of all parameters."""
        return {symbol for symbols in self.parameters.values() for symbol in symbols}

    @property
    def single_parameters(self) -> set[sympy.Symbol]:
        """Symbols of the element's own parameters that are one number."""
        return {param.symbol() for param in self._params.values() if not param.series}

    @property
    def motion(self) -> set[sympy.Symbol]:
        """Angles and speeds of the flanges."""
        return {*self.angles, *self.speeds}

    @functools.cached_property
    def flags(self) -> dict[sympy.Symbol, tuple[str, str]]:
        """Variable and mode of every flag."""
        return {symbol: (name, value) for name, modes in self.modes.items() for value, symbol in modes.symbols.symbols.items()}

    @property
    def switched(self) -> set[sympy.Symbol]:
        """Flags and multipliers: what a law may use, but no region."""
        return {*self.flags, *(each.symbol for each in self.multipliers.values())}

    @functools.cached_property
    def dimensions(self) -> dict[sympy.Symbol, Dimension]:
        """Dimension of every symbol that a law may use. Raises NamingError where two things share a symbol."""
        units: list[tuple[sympy.Symbol, str]] = [(TIME, "s"), *UNIT_CONSTANTS.items()]
        for flange in self.flanges.values():
            units += [(flange.angle, "rad"), (flange.speed, "rad/s"), (flange.inertia, "kg*m^2")]
        for clock in self.clocks.values():
            units += [(clock.angle, "rad"), (clock.frequency, "rad/s")]
        for name, symbols in self.parameters.items():
            unit = (self._params.get(name) or self._derived[name]).unit
            units += [(symbol, unit) for symbol in symbols]
        units += [(state.symbol, state.unit) for state in self.states.values()]
        units += [(named.symbol, named.unit) for named in self.quantities.values()]
        units += [(flag, "1") for flag in self.flags] + [(each.symbol, each.unit) for each in self.multipliers.values()]
        twice = [symbol.name for index, (symbol, _) in enumerate(units) if symbol in {other for other, _ in units[:index]}]
        if twice:
            raise NamingError(self.where, f"declares two things that its laws both call {twice[0]!r}", "rename one of them")
        return {symbol: dimension_of(unit) for symbol, unit in units}

    def read(self, value: Any, what: str) -> sympy.Expr:
        """What a law returned, as an expression of the element's own symbols. Raises ModelError for anything else."""
        if isinstance(value, sympy.Expr):
            unknown = value.free_symbols - self.dimensions.keys() - UNIT_CONSTANTS.keys()
            if unknown:
                names = ", ".join(sorted(map(str, unknown)))
                raise ModelError(self.where, f"{what} uses {names}", "use only the element's own declarations")
            return value
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ModelError(self.where, f"{what} is {value!r}", "return a SymPy expression")
        return sympy.Integer(value) if isinstance(value, int) or value == 0 else sympy.Float(value)

    def flange_name(self, symbols: Any, what: str) -> str:
        """Name of the flange that a law used as a key."""
        if symbols not in self.flanges.values():
            raise ModelError(self.where, f"{what} names {symbols!r}", "use the element's own flanges as keys, such as self.a")
        return str(symbols.name)

    def written_out(self, expression: sympy.Expr, definitions: Mapping[str, sympy.Expr]) -> sympy.Expr:
        """The expression without names of quantities, so that derivatives see what they stand for."""
        laws = {self.quantities[name].symbol: law for name, law in definitions.items()}
        while expression.free_symbols & laws.keys():
            expression = expression.xreplace(laws)
        return expression
