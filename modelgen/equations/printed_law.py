"""The printed form of one law: its equations in order, what its symbols mean, and the table of the elements that follow it.

Part of the grammar's printed form, between ``typesetting`` and ``latex``. A law is printed once for all its elements.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

import sympy

from modelgen.equations.document import Block, Formulas, Heading, Paragraph, Quoted, Table, number, unit
from modelgen.equations.notation import Notation, bare_symbol, notation, plain_notation, upright
from modelgen.equations.printed_modes import mode_blocks
from modelgen.equations.records import DerivedParameter, Equations, Instance, Parameter, Template
from modelgen.equations.typesetting import Typesetter
from modelgen.model import Clock, Derived, Element, Multiplier, Param, State, quantity
from modelgen.model.declarations import TIME, UNIT_CONSTANTS

WIDEST = 5
"""Parameters that stand as columns beside the elements; more of them stand as rows."""

POWERS = {"stored_energy": r"E_{\text{stored}}", "dissipated_power": r"P_{\text{lost}}", "supplied_power": r"P_{\text{supplied}}"}
Rows = tuple[sympy.Symbol, ...]


class PrintedLaw:
    """One template with its printed symbols: ``symbols`` in the order in which factors are written, ``series`` by name."""

    def __init__(self, equations: Equations, index: int) -> None:
        self.eq = equations
        self.template: Template = equations.templates[index]
        self.instances = [instance for instance in equations.instances if instance.template == index]
        kind = Element.vocabulary.get(self.template.kind)
        known = (Param, Derived, quantity, State, Clock, Multiplier)
        self.declared = {} if kind is None else {key: each for of in known for key, each in kind.declared(of).items()}
        self.owner: dict[sympy.Symbol, Parameter | DerivedParameter] = {}
        self.owner.update({symbol: parameter for parameter in equations.parameters for symbol in parameter.symbols})
        self.owner.update({symbol: derived for derived in equations.derived for symbol in derived.symbols})
        self.definitions = self._in_declared_order()
        self.series: dict[str, Notation] = {}
        self.symbols = self._symbols()

    @property
    def title(self) -> str:
        """Name of the element class in words."""
        return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", self.template.title).capitalize()

    # -- symbols -------------------------------------------------------------------------------------------------------------

    def _in_declared_order(self) -> dict[str, sympy.Expr]:
        """The named quantities as the class declares them, but none before those it needs."""
        written = self.template.law["definitions"]
        waiting = [name for name in self.declared if name in written] + [name for name in written if name not in self.declared]
        ordered: dict[str, sympy.Expr] = {}
        while waiting:
            needed = {sympy.Symbol(name, real=True) for name in waiting}
            name = next(name for name in waiting if not written[name].free_symbols & needed)
            ordered[name] = written[name]
            waiting.remove(name)
        return ordered

    def _symbols(self) -> dict[sympy.Symbol, Notation]:
        t = self.template
        found: dict[sympy.Symbol, Notation] = {}
        single = [(name, rows[0]) for name, rows in t.parameters if rows and rows[0].name == name]
        for name, symbol in sorted(single, key=lambda each: bool(each[1].is_integer)):
            found[symbol] = self._unlike(name, found)
        for name, rows in t.parameters:
            if rows and rows[0].name != name:
                self.series[name] = self._unlike(name, found, row="1")
                found.update({symbol: self.series[name].row(str(row)) for row, symbol in enumerate(rows, 1)})
        for flange in t.flanges:
            found[sympy.Symbol(f"{flange}.inertia", positive=True)] = self._at(Notation("J"), flange)
        for clock in t.clocks:
            shown = notation(clock)
            found[clock_symbol(clock, "frequency")] = (
                Notation(r"\omega").of(clock) if shown.letter.startswith(r"\text") else shown
            )
        stages = {d.name: d.depends for d in t.definitions}
        for name in sorted(self.definitions, key=lambda name: ("parameter", "time", "state").index(stages[name])):
            expression, shown = self.definitions[name], notation(name)
            # A quantity that only passes on a parameter of the same symbol keeps it, and needs no equation.
            alias = found.get(expression) if isinstance(expression, sympy.Symbol) else None
            found[sympy.Symbol(name, real=True)] = shown if str(alias) == str(shown) else self._unlike(name, found)
        for name, symbol, *_ in t.states:
            found[symbol] = self._unlike(name, found)
        for letter, part in ((r"\theta", "angle"), (r"\omega", "speed")):
            found.update(
                {sympy.Symbol(f"{flange}.{part}", real=True): self._at(Notation(letter), flange) for flange in t.flanges}
            )
        found.update({symbol: self._unlike(symbol.name, found) for symbol in t.multipliers})
        for modes in t.modes:
            # A condition of a case: "if stick"; nowhere else does a flag stay in a printed law.
            found.update(zip(modes.symbols, (Notation(upright(value)) for value in modes.values), strict=True))
        found[TIME] = Notation("t")
        return found

    def _unlike(self, name: str, found: Mapping[sympy.Symbol, Notation], row: str = "") -> Notation:
        """The symbol of a name, or the name itself where another has taken the symbol."""
        declaration = self.declared.get(name)
        shown = (
            notation(name, declaration.doc if isinstance(declaration, Param) else "")
            if self.template.flanges
            else plain_notation(name)
        )
        taken = str(shown.row(row) if row else shown) in {str(other) for other in found.values()}
        return Notation(upright(name)) if taken else shown

    def _at(self, shown: Notation, flange: str) -> Notation:
        if len(self.template.flanges) == 1:
            return shown
        return shown.row(flange) if len(flange) == 1 else shown.of(flange)

    def typesetter(self) -> Typesetter:
        """What prints expressions of this law."""
        series = {self.series[name]: rows for name, rows in self.template.parameters if name in self.series}
        waves = {clock_symbol(c, "angle"): clock_symbol(c, "frequency") * TIME for c in self.template.clocks}
        moving = [sympy.Symbol(d.name, real=True) for d in self.template.definitions if d.depends == "state"]
        return Typesetter(self.symbols, moving=moving, series=series, waves=waves)

    # -- the section on the law ------------------------------------------------------------------------------------------------

    def blocks(self, like: PrintedLaw | None) -> Iterator[Block]:
        """The section on this law; ``like`` is an earlier law of the same element class."""
        count = len(self.instances)
        whose = self.instances[0].name + (f" to {self.instances[-1].name}" if count > 1 else "")
        yield Heading(3, f"{self.title} ({count})" if like is None and count > 1 else f"{self.title}: {whose}")
        typeset = self.typesetter()
        rows, used = self._rows(typeset)
        if rows:
            yield Formulas(tuple(rows))
        if typeset.notes:
            yield Paragraph("with " + "; ".join(f"${note}$" for note in typeset.notes))
        yield from self.modes(typeset)
        if self.template.law["kinetic_energy"] is not None:
            yield Paragraph("Inertia and torque follow from the kinetic energy by Lagrange's equations.")
        for (f, g), inertia in self.template.mass.items():
            used |= inertia.free_symbols
            if f == g:
                node = "its node" if len(self.template.flanges) == 1 else f"node ${f}$"
                yield Paragraph(f"Its inertia ${typeset(inertia)}$ turns with {node}.")
        meanings = self._meanings(used)
        if rows and like is not None and meanings == like._meanings(like._rows(like.typesetter())[1]):
            yield Paragraph(f"Symbols as for {like.instances[0].name}.")
        elif rows and meanings:
            yield Table(("symbol", "name", "unit", "meaning"), meanings)
        yield from self._elements()

    def modes(self, typeset: Typesetter) -> Iterator[Block]:
        """What the law says of its modes."""
        constants = [symbol for _, symbols in self.template.parameters for symbol in symbols]
        yield from mode_blocks(self.template.law["modes"], typeset, constants)

    def _rows(self, typeset: Typesetter) -> tuple[list[str], set[sympy.Symbol]]:
        """The equations of the law, aligned, and the symbols in them."""
        t, ones = self.template, dict.fromkeys(UNIT_CONSTANTS, sympy.Integer(1))
        timed = {d.name for d in t.definitions if d.depends == "time"}
        rows, used = [], set[sympy.Symbol]()

        def add(left: str, right: sympy.Expr) -> None:
            used.update(right.free_symbols)
            rows.append(f"{left} &= {typeset(right.xreplace(ones))}")

        for name, expression in self.definitions.items():
            symbol = sympy.Symbol(name, real=True)
            used.add(symbol)
            shown = self.symbols[symbol]
            if isinstance(expression, sympy.Symbol) and str(self.symbols.get(expression)) == str(shown):
                used.add(expression)
                continue
            add(f"{shown}(t)" if name in timed and not shown.argument else str(shown), expression)
        for state, rate in t.law["rates"].items():
            used.add(state)
            add(str(self.symbols[state].dotted()), rate)
        if t.law["kinetic_energy"] is not None:
            add(r"E_{\text{kinetic}}", t.law["kinetic_energy"])
        for flange, torque in t.law["torques"].items():
            add(rf"T_{{\text{{on {'the node' if len(t.flanges) == 1 else flange}}}}}", torque)
        for constraint in t.constraints:
            total = sympy.Add(*(c * sympy.Symbol(f"{flange}.angle", real=True) for flange, c in constraint.items()))
            used.update(total.free_symbols)
            rows.append(f"{typeset(total)} &= 0")
        for name, left in POWERS.items():
            if t.law[name] != 0:
                add(left, t.law[name])
        used |= t.law["modes"].symbols()
        return rows, used

    def _meanings(self, used: set[sympy.Symbol]) -> tuple[tuple[str, ...], ...]:
        """Printed symbol, name, unit and meaning of what stands in the law."""
        t, rows = self.template, []

        def add(shown: Notation | str, name: str, of: str, meaning: str) -> None:
            rows.append((f"${shown}$", f"`{name}`" if name else "", unit(of) or "—", Quoted(meaning)))

        for name, symbols in t.parameters:
            if used & set(symbols):
                shown = self.series[name].row("n") if name in self.series else self.symbols[symbols[0]]
                add(shown, name, self._parameter(self.instances[0], symbols).unit, self._meaning(name))
        inertias = [sympy.Symbol(f"{flange}.inertia", positive=True) for flange in t.flanges]
        if shown_inertias := ", ".join(str(self.symbols[symbol]) for symbol in inertias if symbol in used):
            add(shown_inertias, "", "kg*m^2", "inertia that turns rigidly with the node")
        for clock in t.clocks:
            if used & {clock_symbol(clock, "angle"), clock_symbol(clock, "frequency")}:
                add(self.symbols[clock_symbol(clock, "frequency")], clock, "rad/s", self._meaning(clock))
        units = {d.name: d.unit for d in t.definitions}
        for name in self.definitions:
            add(self.symbols[sympy.Symbol(name, real=True)], name, units[name], self._meaning(name))
        for name, symbol, of, *_ in t.states:
            add(self.symbols[symbol], name, of, self._meaning(name))
        for symbol in t.multipliers:
            of = getattr(self.declared.get(symbol.name), "unit", "1")
            add(self.symbols[symbol], symbol.name, of, self._meaning(symbol.name))
        return tuple(rows)

    def _meaning(self, name: str) -> str:
        """What a declaration says about itself, in one line without a final stop; nothing where it only gives its symbol."""
        declaration = self.declared.get(name)
        text = getattr(declaration, "doc", "") if not isinstance(declaration, quantity) else declaration.__doc__
        line = (text or "").strip().split("\n")[0]
        line = line if line.endswith("...") else line.removesuffix(".")
        return "" if bare_symbol(line) is not None else line

    # -- the elements that follow the law ------------------------------------------------------------------------------------

    def _parameter(self, instance: Instance, symbols: Sequence[sympy.Symbol]) -> Parameter | DerivedParameter:
        return self.owner[instance.symbols[symbols[0]]]

    def _elements(self) -> Iterator[Block]:
        columns: list[tuple[str, list[str]]] = []
        for flange in self.template.flanges:
            nodes = [self.eq.nodes[instance.nodes[flange]].name for instance in self.instances]
            if nodes != [instance.name for instance in self.instances]:
                head = "node" if len(self.template.flanges) == 1 else f"node ${flange}$"
                columns.append((head, [f"`{name}`" for name in nodes]))
        given = [(name, rows) for name, rows in self.template.parameters if rows]
        given = [(name, rows) for name, rows in given if isinstance(self._parameter(self.instances[0], rows), Parameter)]
        values = [(self._head(name, rows), [self._cell(each, rows) for each in self.instances]) for name, rows in given]
        differing = [(head, cells) for head, cells in values if len(cells) == 1 or len(set(cells)) > 1]
        names = [f"`{instance.name}`" for instance in self.instances]
        if len(differing) > WIDEST:
            yield Table(("", *names), tuple((head, *cells) for head, cells in (*columns, *values)))
            return
        columns += differing
        yield Table(("element", *(head for head, _ in columns)), tuple(zip(names, *(cells for _, cells in columns), strict=True)))
        if common := [f"{head} = {cells[0]}" for head, cells in values if (head, cells) not in differing]:
            yield Paragraph("All of them: " + "; ".join(common) + ".")

    def _head(self, name: str, rows: Rows) -> str:
        shown = self.series[name].row("n") if name in self.series else self.symbols[rows[0]]
        text = f"`{name}`" if shown.letter.startswith(r"\text") else f"${shown}$"
        of = unit(self._parameter(self.instances[0], rows).unit)
        return f"{text} [{of}]" if of else text

    def _cell(self, instance: Instance, rows: Rows) -> str:
        parameter = self._parameter(instance, rows)
        assert isinstance(parameter, Parameter)  # derived ones stand in no cell
        if parameter.name in self.eq.balanced:
            return "balanced"
        if parameter.name.startswith(f"{instance.name}."):
            rows_there = f"{len(rows)} row" + "s" * (len(rows) > 1)
            return rows_there if parameter.series else number(parameter.values[0])
        return f"`{parameter.name}`" + ("" if parameter.series else f" = {number(parameter.values[0])}")


def clock_symbol(clock: str, part: str) -> sympy.Symbol:
    """Symbol of a clock's ``angle`` or ``frequency`` in a law."""
    return sympy.Symbol(f"{clock}.{part}", real=True)
