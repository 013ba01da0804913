"""SymPy expressions as LaTeX that reads like a textbook: rows as one sum, roots gathered, factors and terms in order.

Part of the grammar's printed form. SymPy orders factors by name and splits roots of positive symbols; here every symbol has a
rank and a printed form instead, and expressions are rewritten into equal ones that are shorter.
"""

# ruff: noqa: N802, N815 - the names by which SymPy's printer finds the form of a class

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from typing import Any

import sympy
from sympy.printing.latex import LatexPrinter
from sympy.simplify.fu import TR10i

from modelgen.equations.notation import Notation
from modelgen.model import PeriodicTable
from modelgen.model.declarations import TIME

FEWEST_ROWS = 4
"""Harmonics from which on a Fourier series is written with a sum sign."""


class Typesetter:
    """Prints expressions over known symbols; ``symbols`` is ordered, and products are written in that order.

    A sum begins with what moves: ``moving`` symbols stand before constants. ``series`` names the rows of each series in order, so
    that sums over them are found; ``waves`` are the clock angles whose sines and cosines make such a series, each with what is
    printed for it. What a sum runs over, where it is not 1, 2, ..., n, is noted in ``notes``.
    """

    def __init__(
        self,
        symbols: Mapping[sympy.Symbol, Notation | str],
        moving: Iterable[sympy.Symbol] = (),
        series: Mapping[Notation, Sequence[sympy.Symbol]] | None = None,
        waves: Mapping[sympy.Symbol, sympy.Expr] | None = None,
    ) -> None:
        self.series, self.waves = dict(series or {}), dict(waves or {})
        self.notes: list[str] = []
        self._ranked: dict[sympy.Symbol, sympy.Symbol] = {}
        self._texts: dict[str, str] = {}
        for symbol, text in symbols.items():
            self._add(symbol, str(text))
        self._rows = {symbol: (name, row) for name, rows in self.series.items() for row, symbol in enumerate(rows, 1)}
        self._printer = _Printer(self._texts, {self._ranked[symbol].name for symbol in moving if symbol in self._ranked})

    def _add(self, symbol: sympy.Symbol, text: str, rank: str = "") -> None:
        # Without the assumptions of the original, so that roots of products stay together; the name gives the rank.
        self._ranked[symbol] = sympy.Symbol(rank or f"{len(self._ranked):05d}")
        self._texts[self._ranked[symbol].name] = text

    def __call__(self, expression: sympy.Basic) -> str:
        """The expression as LaTeX."""
        return str(self._printer.doprint(self._prepared(expression)))

    def terms(self, expression: sympy.Expr) -> list[str]:
        """The terms of a sum as LaTeX, in their order, each with its sign."""
        ordered = sorted(sympy.Add.make_args(self._prepared(expression)), key=self._printer.place)
        return [self._printer.doprint(term) for term in ordered]

    def _prepared(self, expression: sympy.Basic) -> sympy.Basic:
        if isinstance(expression, sympy.Expr):
            expression = expression.replace(lambda e: e.is_Add, self._summed)
            expression = _shorter_waves(expression).xreplace(self.waves)
        missing = sorted((s for s in expression.free_symbols if s not in self._ranked), key=str)
        for symbol in missing:
            self._add(symbol, str(symbol))
        return _gathered(expression.xreplace(self._ranked))

    # -- Fourier rows as a sum -----------------------------------------------------------------------------------------------

    def _summed(self, total: sympy.Add) -> sympy.Expr:
        """The same sum, with the harmonics of each clock under one sum sign where they follow one pattern."""
        rest, found = list(total.args), []
        for angle in self.waves:
            rows: dict[int, sympy.Expr] = {}
            used = []
            for term in rest:
                factor, wave = _split_wave(term, angle)
                order = wave.args[0] / angle if isinstance(wave, sympy.sin | sympy.cos) else None
                if order is not None and order.is_Integer and order > 0:
                    rows[int(order)] = rows.get(int(order), sympy.Integer(0)) + factor * wave
                    used.append(term)
            if len(rows) >= FEWEST_ROWS and (pattern := self._pattern(dict(sorted(rows.items())))) is not None:
                rest = [term for term in rest if term not in used]
                found.append(pattern)
        return sympy.Add(*rest, *found)

    def _pattern(self, rows: Mapping[int, sympy.Expr]) -> sympy.Expr | None:
        """The sum over all rows if one general term gives each of them exactly, or None."""
        count, orders = len(rows), list(rows)
        index = sympy.Symbol("n", integer=True)
        order = index
        if orders != list(range(1, count + 1)):
            index, order = sympy.Symbol("i", integer=True), sympy.Symbol("n_i", positive=True)
        last = rows[orders[-1]]
        general: dict[sympy.Symbol, sympy.Symbol] = {}
        for symbol in sorted(last.free_symbols & set(self._rows), key=str):
            name, row = self._rows[symbol]
            shift = row - count
            shown = f"{index}" if shift == 0 else f"{index}{shift:+d}"
            general[symbol] = sympy.Symbol(str(name.row(shown)), real=True)
        term = last.xreplace(general).replace(sympy.sin, lambda x: sympy.sin(_general(x, orders[-1], order)))
        term = term.replace(sympy.cos, lambda x: sympy.cos(_general(x, orders[-1], order)))
        for position, (each, row_term) in enumerate(rows.items(), 1):
            known = {s: self.series[self._rows[symbol][0]] for symbol, s in general.items()}
            shifts = {s: self._rows[symbol][1] - count for symbol, s in general.items()}
            if any(not 0 < position + shifts[s] <= len(known[s]) for s in known):
                return None
            swap = {s: known[s][position + shifts[s] - 1] for s in known}
            if (term.xreplace({**swap, order: sympy.Integer(each)}) - row_term).expand() != 0:
                return None
        for original, symbol in general.items():
            self._add(symbol, symbol.name, self._ranked[original].name + "n")
        for symbol in {index, order}:
            self._add(symbol, symbol.name, f" {symbol.name}")  # before everything: n omega t
        if order != index:
            self.notes.append(f"n_1, \\ldots, n_{{{count}}} = " + ", ".join(map(str, orders)))
        return sympy.Sum(_shorter_waves(term), (index, 1, count))


def _split_wave(term: sympy.Expr, angle: sympy.Symbol) -> tuple[sympy.Expr, sympy.Expr]:
    """A factor and a wave of the clock; the whole and 1 where the term is no such product."""
    factors = sympy.Mul.make_args(term)
    waves = [factor for factor in factors if isinstance(factor, sympy.sin | sympy.cos) and angle in factor.free_symbols]
    rest = sympy.Mul(*(factor for factor in factors if factor not in waves))
    return (rest, waves[0]) if len(waves) == 1 and angle not in rest.free_symbols else (term, sympy.Integer(1))


def _general(argument: sympy.Expr, number: int, order: sympy.Symbol) -> sympy.Expr:
    factor, rest = argument.as_coeff_Mul()
    return order * rest * sympy.sign(factor) if abs(factor) == number else argument


def _shorter_waves(expression: sympy.Expr) -> sympy.Expr:
    """a sin x cos y + a cos x sin y as a sin(x + y), wherever that leaves fewer waves."""

    def shorter(whole: sympy.Expr) -> sympy.Expr:
        if len(whole.atoms(sympy.sin, sympy.cos)) < 4 or whole.has(sympy.Sum, sympy.Piecewise):
            return whole
        joined = TR10i(whole.expand())
        joined = joined.replace(lambda e: isinstance(e, sympy.sin | sympy.cos), lambda e: e.func(sympy.factor_terms(e.args[0])))
        before, after = (each.count(sympy.sin) + each.count(sympy.cos) for each in (whole, joined))
        return joined if after < before else whole

    return expression.replace(lambda e: e.is_Add, shorter) if isinstance(expression, sympy.Expr) else expression


def _gathered(expression: sympy.Basic) -> sympy.Basic:
    """sqrt(a) sqrt(b)/sqrt(c) as sqrt(a b/c), and x (-a - b) as -x (a + b)."""

    def gather(product: sympy.Expr) -> sympy.Expr:
        roots = [f for f in product.args if f.is_Pow and abs(f.exp) == sympy.S.Half]
        below = [f for f in product.args if f.is_Add and all(term.could_extract_minus_sign() for term in f.args)]
        if len(roots) < 2 and not below:
            return product
        rest = [f for f in product.args if f not in roots and f not in below]
        root = sympy.sqrt(sympy.Mul(*(f.base ** (2 * f.exp) for f in roots)))
        return sympy.Mul(*rest, root, *(-f for f in below), (-1) ** len(below))

    return expression.replace(lambda e: e.is_Mul, gather)


class _Printer(LatexPrinter):
    """SymPy's printer with printed forms of ranked symbols, and without the commands that GitHub refuses or strips."""

    def __init__(self, texts: Mapping[str, str], moving: Container[str]) -> None:
        super().__init__({"fold_short_frac": False, "inv_trig_style": "full"})
        self.texts, self.moving = texts, moving

    def doprint(self, expr: sympy.Basic) -> str:
        return str(super().doprint(expr)).replace(r"\operatorname{", r"\mathrm{").replace(r"\: ", r"\ ").replace("}_{", "} _{")

    def _print_Symbol(self, expr: sympy.Symbol, style: str = "plain") -> str:
        return self.texts.get(expr.name, expr.name)

    def _print_Add(self, expr: sympy.Add, order: Any = None) -> str:
        text = ""
        for term in sorted(expr.args, key=self.place):
            shown = self._print(term)
            if not text:
                text = shown
            elif shown.startswith("-"):
                text += " - " + shown[1:].lstrip()
            else:
                text += " + " + shown
        return text

    def place(self, term: sympy.Expr) -> tuple[bool, bool, bool, bool, list[str]]:
        """Positive terms first, among them multiples of time, then what moves by itself; sums last; then by rank."""
        names = sorted(symbol.name for symbol in term.free_symbols)
        time = not term.has(sympy.Function, sympy.Max, sympy.Min) and any(self.texts.get(name) == str(TIME) for name in names)
        moves = term.is_Symbol and term.name in self.moving
        return term.could_extract_minus_sign(), term.has(sympy.Sum, sympy.Piecewise), not time, not moves, names

    def _print_Relational(self, expr: sympy.core.relational.Relational) -> str:
        ranks = [max((symbol.name for symbol in side.free_symbols), default="") for side in expr.args]
        if ranks[0] < ranks[1]:
            expr = expr.reversed
        if expr.lhs.could_extract_minus_sign():
            expr = expr.reversedsign
        return str(super()._print_Relational(expr))

    def _print_Piecewise(self, expr: sympy.Piecewise) -> str:
        rows = []
        for value, condition in expr.args:
            for case in sorted(sympy.Or.make_args(condition), key=self._rank):
                when = r"\text{otherwise}" if case is sympy.true else rf"\text{{if }} {self._print(case)}"
                rows.append(rf"{self._print(value)} & {when}")
        return "\\begin{cases} " + " \\\\\n ".join(rows) + " \\end{cases}"

    @staticmethod
    def _rank(condition: sympy.Basic) -> tuple[list[str], str]:
        return sorted(symbol.name for symbol in condition.free_symbols), str(condition)

    def _print_And(self, expr: sympy.And) -> str:
        return r" \text{ and } ".join(self._print(part) for part in sorted(expr.args, key=self._rank))

    def _print_Or(self, expr: sympy.Or) -> str:
        return r" \text{ or } ".join(self._print(part) for part in sorted(expr.args, key=self._rank))

    def _print_Heaviside(self, expr: sympy.Heaviside, exp: Any = None) -> str:
        shown = rf"\mathrm{{H}}\left({self._print(expr.args[0])}\right)"
        return shown if exp is None else rf"{shown}^{{{exp}}}"

    def _print_PeriodicTable(self, expr: PeriodicTable) -> str:
        phase, *values = (self._print(each) for each in expr.args)
        shown = values if len(values) < FEWEST_ROWS else [values[0], values[1], r"\ldots", values[-1]]
        return rf"\mathrm{{table}}\left({phase};\ {', '.join(shown)}\right)"

    _print_PeriodicSteps = _print_PeriodicTable
