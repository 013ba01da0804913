"""Sums of flange angles become relative angles, so that a uniform rotation drops out exactly, not by cancellation.

Part of the grammar, between the laws as an element wrote them and its template (``modelgen.equations.template``). A sum of
speeds becomes the rate of the relative angle with the same coefficients; an angle that stands alone ties its node to ground.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import sympy

from modelgen.equations.dimensions import DimensionCheck
from modelgen.equations.element_symbols import ElementSymbols
from modelgen.equations.records import Relative
from modelgen.errors import ModelError
from modelgen.model.declarations import TIME
from modelgen.units import NUMBER

Key = tuple[str, ...]
"""Which law of an element: ("definition", name), ("torque", flange), ("rate", state), ("mass", flange, flange), or a power.

Those of its modes: ("region", variable, mode), ("guard", name), ("present" or "reset", guard, row), ("hold", multiplier).
"""
Laws = Mapping[Key, sympy.Expr]
Coefficients = dict[str, sympy.Expr]


def definitions_in(laws: Laws) -> Iterator[tuple[str, sympy.Expr]]:
    """Name and expression of every named quantity among the laws, in order of use."""
    return ((key[1], expression) for key, expression in laws.items() if key[0] == "definition")


def constant_definitions(symbols: ElementSymbols, laws: Laws) -> dict[sympy.Symbol, sympy.Expr]:
    """Quantities that depend on parameters only, written out in parameters."""
    fixed: dict[sympy.Symbol, sympy.Expr] = {}
    for name, expression in definitions_in(laws):
        if expression.free_symbols <= symbols.constants | set(fixed):
            fixed[symbols.quantities[name].symbol] = expression.xreplace(fixed)
    return fixed


def combination_of_angles(
    symbols: ElementSymbols, expression: sympy.Expr, fixed: Mapping[sympy.Symbol, sympy.Expr]
) -> Coefficients:
    """Coefficients of a linear combination of flange angles; raises ModelError if it is anything else."""
    result = {}
    for name, flange in symbols.flanges.items():
        coefficient = expression.diff(flange.angle)
        if coefficient != 0:
            result[name] = coefficient.xreplace(fixed)
    rest = expression.xreplace({angle: sympy.Integer(0) for angle in symbols.angles})
    if rest != 0 or any(c.free_symbols & {*symbols.motion, TIME} for c in result.values()) or not result:
        what = f"constraint {expression} is no linear combination of angles"
        raise ModelError(symbols.where, what, "write n_a * angle_a - n_b * angle_b")
    return result


def relate(
    symbols: ElementSymbols, laws: Laws, fixed: Mapping[sympy.Symbol, sympy.Expr]
) -> tuple[dict[Key, sympy.Expr], tuple[Relative, ...], tuple[str, ...]]:
    """The laws in relative angles, those relative angles, and the flanges whose angle is still seen as it is.

    What is still seen stands inside sine or cosine, as in an inertia that depends on angle.
    """
    return _Relation(symbols, fixed).of(laws)


@dataclass
class _Combination:
    """A sum of flange angles found in a law, with the symbols that stand for it and for its rate."""

    coefficients: Coefficients
    angle: sympy.Symbol
    rate: sympy.Symbol
    sees_angle: bool


class _Relation:
    """Collects the relative angles of one element while its laws are rewritten."""

    def __init__(self, symbols: ElementSymbols, fixed: Mapping[sympy.Symbol, sympy.Expr]) -> None:
        self.symbols, self.fixed = symbols, fixed
        self.constant = symbols.constants | set(fixed)
        self.found: list[_Combination] = []

    def of(self, laws: Laws) -> tuple[dict[Key, sympy.Expr], tuple[Relative, ...], tuple[str, ...]]:
        related = self._grounded({key: self._rewritten(law) for key, law in laws.items()})
        used = set().union(*(law.free_symbols for law in related.values()))
        return related, self._relatives(related), tuple(name for symbol, name in self.symbols.angles.items() if symbol in used)

    def _rewritten(self, e: sympy.Basic) -> sympy.Basic:
        if not e.args or not e.free_symbols & self.symbols.motion:
            return e
        e = e.func(*(self._rewritten(arg) for arg in e.args))
        if isinstance(e, sympy.Add):
            e = self._gathered(e, self.symbols.angles, is_angle=True)
        if isinstance(e, sympy.Add):
            e = self._gathered(e, self.symbols.speeds, is_angle=False)
        return e

    def _gathered(self, e: sympy.Add, flange_of: Mapping[sympy.Symbol, str], is_angle: bool) -> sympy.Expr:
        """A sum with its angles, or its speeds, replaced by one relative angle, or rate."""
        terms: Coefficients = {}
        rest = []
        for arg in e.args:
            c, x = arg.as_independent(*self.symbols.angles, *self.symbols.speeds, as_Add=False)
            if x in flange_of:
                terms[flange_of[x]] = terms.get(flange_of[x], sympy.Integer(0)) + c
            else:
                rest.append(arg)
        if len(terms) < 2:
            return e
        coefficients, lead = {f: terms[f] for f in self.symbols.flanges if f in terms}, sympy.Integer(1)
        if not self._is_constant(coefficients):
            # A common factor that varies stays outside: c(t) * speed a - c(t) * speed b is c(t) * (speed a - speed b).
            lead = next(iter(coefficients.values()))
            coefficients = {f: sympy.cancel(c / lead) for f, c in coefficients.items()}
            if not self._is_constant(coefficients):
                return e
        combination, factor = self._combination(coefficients, is_angle)
        factor *= lead
        return sympy.Add(factor * (combination.angle if is_angle else combination.rate), *rest)

    def _is_constant(self, coefficients: Coefficients) -> bool:
        return all(c.free_symbols <= self.constant for c in coefficients.values())

    def _combination(self, coefficients: Coefficients, is_angle: bool) -> tuple[_Combination, sympy.Expr]:
        """The known combination that these coefficients are a multiple of, or a new one, and the factor between them."""
        shape = self._shape(coefficients)
        for known in self.found:
            if self._shape(known.coefficients) == shape:
                known.sees_angle |= is_angle
                first = next(iter(coefficients))
                return known, coefficients[first] / known.coefficients[first]
        return self._new(coefficients, is_angle), sympy.Integer(1)

    def _shape(self, coefficients: Coefficients) -> Coefficients:
        """The coefficients per first coefficient, which multiples share."""
        first = next(iter(coefficients.values()))
        return {f: sympy.cancel((c / first).xreplace(self.fixed)) for f, c in coefficients.items()}

    def _new(self, coefficients: Coefficients, sees_angle: bool) -> _Combination:
        name = f"relative_{len(self.found) + 1}"
        angle, rate = (sympy.Symbol(f"{name}.{part}", real=True) for part in ("angle", "rate"))
        self.found.append(_Combination(coefficients, angle, rate, sees_angle))
        return self.found[-1]

    def _grounded(self, laws: dict[Key, sympy.Expr]) -> dict[Key, sympy.Expr]:
        """An angle seen by itself, not only through sine and cosine, ties the node to ground: it becomes a relative angle too."""
        periodic: dict[sympy.Basic, sympy.Dummy] = {}
        for law in laws.values():
            for wave in law.atoms(sympy.sin, sympy.cos, sympy.tan):
                if wave.free_symbols & set(self.symbols.angles):
                    periodic.setdefault(wave, sympy.Dummy())
        back = {dummy: wave for wave, dummy in periodic.items()}
        for angle, name in self.symbols.angles.items():
            if any(angle in law.xreplace(periodic).free_symbols for law in laws.values()):
                new = self._new({name: sympy.Integer(1)}, sees_angle=True)
                swap = {angle: new.angle, self.symbols.flanges[name].speed: new.rate}
                laws = {key: law.xreplace(periodic).xreplace(swap).xreplace(back) for key, law in laws.items()}
        return laws

    def _relatives(self, laws: Laws) -> tuple[Relative, ...]:
        """The records of what was found; one that a named quantity equals takes its name and unit."""
        quantities = self.symbols.quantities
        names = {expression: name for name, expression in reversed([*definitions_in(laws)])}
        relatives, check = [], DimensionCheck(self.symbols.dimensions, self.symbols.where)
        for index, each in enumerate(self.found, 1):
            name = names.get(each.angle, f"relative_{index}" if index > 1 else "relative")
            size = check.of(next(iter(each.coefficients.values())), name)
            unit = quantities[name].unit if name in quantities else "rad" if size in (None, NUMBER) else str(size)
            coefficients = {f: c.xreplace(self.fixed) for f, c in each.coefficients.items()}
            relatives.append(Relative(name, unit, each.angle, each.rate, coefficients, each.sees_angle))
        return tuple(relatives)
