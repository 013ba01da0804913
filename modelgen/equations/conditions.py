"""Conditions on parameters: sums that must vanish, and divisors that must not, for the chosen coordinates to stay right.

Part of the grammar. Whole numbers are judged exactly, other numbers to 1e-12 of the largest term. ``null_space`` notes the
conditions when a driveline is assembled; ``modelgen.lowering.parameters`` looks at them for every new parameter vector.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import sympy

from modelgen.errors import ModelError

NEGLIGIBLE = 1e-12  # of the largest term


class Exact:
    """Evaluates parameter expressions, exactly where the parameters are whole numbers.

    ``derive`` gives the values of the parameters that are computed from others; it is asked when one of them is needed.
    """

    def __init__(
        self, values: Mapping[sympy.Symbol, float], derive: Callable[[], Mapping[sympy.Symbol, float]] | None = None
    ) -> None:
        self.values, self.derive = dict(values), derive

    def __call__(self, expression: sympy.Expr) -> sympy.Expr:
        missing = [symbol for symbol in expression.free_symbols if symbol not in self.values]
        if missing and self.derive is not None:
            self.values.update(self.derive())
            self.derive = None
        swap = {}
        for symbol in expression.free_symbols:
            if symbol not in self.values:
                raise ModelError(f"parameter {symbol.name!r}", "sets a ratio, but has no value", "make it a parameter")
            value = self.values[symbol]
            swap[symbol] = sympy.Integer(int(value)) if symbol.is_integer else sympy.Float(value)
        return expression.xreplace(swap)

    def vanishes(self, terms: Sequence[sympy.Expr], beside: Sequence[sympy.Expr] = ()) -> bool:
        """Whether a sum is zero: exactly for whole numbers, else to rounding of its largest term, or of one ``beside`` it."""
        values = [self(term) for term in terms]
        total = sympy.Add(*values)
        if total == 0:
            return True
        if not total.has(sympy.Float):
            return False
        size = max(abs(float(value)) for value in (*values, *(self(each) for each in beside)))
        return bool(abs(float(total)) <= NEGLIGIBLE * size)


@dataclass(frozen=True)
class Condition:
    """``terms`` of ``element`` that must cancel (``vanishes``), or must not; judged ``beside`` others of their row.

    ``words``: what is wrong where it is broken, and what to do; by default those of a loop, and of a divisor.
    """

    element: str
    terms: tuple[sympy.Expr, ...]
    beside: tuple[sympy.Expr, ...] = ()
    vanishes: bool = True
    words: tuple[str, str] | None = None

    @property
    def symbols(self) -> set[sympy.Symbol]:
        """The parameters that decide it."""
        return set().union(*(each.free_symbols for each in (*self.terms, *self.beside)))

    def check(self, exact: Exact) -> None:
        """Raises ModelError where the values break it."""
        if exact.vanishes(self.terms, self.beside) == self.vanishes:
            return
        if self.words is not None:
            raise ModelError(self.element, *self.words)
        if self.vanishes:
            what = "closes a loop whose gear ratios do not agree at these values, so it would not turn as it was assembled"
            raise ModelError(self.element, what, "check the tooth numbers on the loop, or assemble anew with these values")
        what = "its constraint no longer sees the angle that was solved from it: a coefficient is zero at these values"
        raise ModelError(self.element, what, "choose other values, or assemble the driveline with these values")
