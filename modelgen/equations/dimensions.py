"""Dimensions of laws, checked symbolically: a sum of unlike things is found when the element is used, not in its results.

Part of the grammar. The radian counts as a number, as in SI.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction

import sympy
from sympy.core.function import AppliedUndef
from sympy.core.relational import Relational
from sympy.logic.boolalg import Boolean

from modelgen.errors import UnitError
from modelgen.model.tables import PeriodicSteps, PeriodicTable
from modelgen.units import NUMBER, Dimension, dimension_of

_ANY = None  # the dimension of zero: it agrees with everything


class DimensionCheck:
    """Infers the dimension of expressions over symbols of known dimension; raises UnitError where a sum does not agree."""

    def __init__(self, symbols: Mapping[sympy.Symbol, Dimension], where: str) -> None:
        self.symbols, self.where, self.seen = symbols, where, dict[sympy.Basic, "Dimension | None"]()

    def require(self, expression: sympy.Expr, unit: str, what: str) -> None:
        """Raises UnitError unless the expression has the dimension of the unit."""
        found = self.of(expression, what)
        if found is not _ANY and found != dimension_of(unit):
            raise UnitError(self.where, f"{what} is {_short(expression)} [{found}]", f"its unit is {unit} [{dimension_of(unit)}]")

    def of(self, expression: sympy.Basic, what: str) -> Dimension | None:
        """Dimension of the expression; None for an exact zero."""
        if expression not in self.seen:
            self.seen[expression] = self._infer(expression, what)
        return self.seen[expression]

    def _infer(self, e: sympy.Basic, what: str) -> Dimension | None:
        if isinstance(e, sympy.Symbol):
            return self.symbols[e]
        if isinstance(e, (sympy.Number, sympy.NumberSymbol)):
            return _ANY if e.is_zero else NUMBER
        if isinstance(e, sympy.Mul):
            result = NUMBER
            for factor in e.args:
                dimension = self.of(factor, what)
                if dimension is _ANY:
                    return _ANY
                result = result * dimension
            return result
        if isinstance(e, sympy.Pow):
            below = self.of(e.base, what)
            self._number(e.exp, what)
            if below is _ANY or below == NUMBER:
                return below
            if not isinstance(e.exp, sympy.Rational):
                raise UnitError(
                    self.where,
                    f"{what} raises {_short(e.base)} [{below}] to {_short(e.exp)}",
                    "only numbers may have such powers",
                )
            return below ** Fraction(int(e.exp.p), int(e.exp.q))
        if isinstance(e, (sympy.Add, sympy.Max, sympy.Min, Relational)):
            return self._alike(e.args, what, "adds" if isinstance(e, sympy.Add) else "compares")
        if isinstance(e, sympy.Piecewise):
            for _, condition in e.args:
                self.of(condition, what)
            return self._alike([value for value, _ in e.args], what, "chooses between")
        if isinstance(e, Boolean):
            for part in e.args:
                self.of(part, what)
            return NUMBER
        if isinstance(e, (sympy.Abs, sympy.floor, sympy.ceiling)):
            return self.of(e.args[0], what)
        if isinstance(e, (sympy.sign, sympy.Heaviside)):
            self.of(e.args[0], what)
            return NUMBER
        if isinstance(e, (PeriodicTable, PeriodicSteps)):
            self._number(e.args[0], what)
            return self._alike(e.args[1:], what, "tabulates")
        if isinstance(e, (sympy.atan2, sympy.Mod)):
            alike = self._alike(e.args, what, "compares")
            return NUMBER if isinstance(e, sympy.atan2) else alike
        if isinstance(e, sympy.Function) and not isinstance(e, AppliedUndef):
            for part in e.args:
                self._number(part, what)
            return NUMBER
        raise UnitError(
            self.where, f"{what} uses {type(e).__name__}, whose dimension is not known", "write it with ordinary functions"
        )

    def _alike(self, parts: Iterable[sympy.Basic], what: str, verb: str) -> Dimension | None:
        first: tuple[sympy.Basic, Dimension] | None = None
        for part in parts:
            dimension = self.of(part, what)
            if dimension is _ANY:
                continue
            if first is None:
                first = (part, dimension)
            elif dimension != first[1]:
                raise UnitError(
                    self.where,
                    f"{what} {verb} {_short(first[0])} [{first[1]}] and {_short(part)} [{dimension}]",
                    _hint(first[1], dimension),
                )
        return _ANY if first is None else first[1]

    def _number(self, e: sympy.Basic, what: str) -> None:
        dimension = self.of(e, what)
        if dimension not in (_ANY, NUMBER):
            raise UnitError(
                self.where, f"{what} takes a function or power of {_short(e)} [{dimension}]", "make the argument a number"
            )


def _hint(first: Dimension, second: Dimension) -> str:
    second_unit = Dimension(time=NUMBER.time + 1)
    if first / second in (second_unit, second_unit**-1):
        return "did you mean a speed where an angle stands, or an angle where a speed stands?"
    return "check the units of its parameters"


def _short(e: sympy.Basic) -> str:
    text = str(e)
    return text if len(text) <= 60 else text[:57] + "..."
