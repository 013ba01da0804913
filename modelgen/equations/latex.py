"""The equations of a driveline as a document: laws, nodes, coordinates, base frequencies, parameters, states and outputs.

Part of the grammar: the one printed form of ``Equations``, in Markdown for the web and notebooks and in LaTeX for a report. Plain
text leaves it, never a symbol. Every law stands once, with the elements that follow it in a table.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import sympy

from modelgen.equations.conditions import Exact
from modelgen.equations.document import (
    Block,
    Formulas,
    Heading,
    Paragraph,
    Quoted,
    Table,
    latex_text,
    markdown_text,
    number,
    unit,
    with_unit,
)
from modelgen.equations.notation import Notation, plain_notation, upright
from modelgen.equations.printed_law import PrintedLaw
from modelgen.equations.printed_tables import fraction, frequency_blocks, output_blocks, parameter_blocks
from modelgen.equations.records import Equations, Form, Node
from modelgen.equations.symbolic import FlatEquations
from modelgen.equations.typesetting import Typesetter
from modelgen.model.declarations import TIME

LINE = 120
"""Characters of LaTeX after which a sum goes on in the next line."""

THETA, DDOT_THETA = r"\theta", r"\ddot\theta"


def latex(equations: Equations) -> str:
    """The document as a LaTeX fragment for ``\\\\input``; it needs amsmath and longtable.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])
    >>> [row for row in latex(assemble(line)).splitlines() if "ddot" in row]  # doctest: +NORMALIZE_WHITESPACE
    ['J_{\\\\text{engine}} \\\\ddot\\\\theta_{\\\\text{engine}} &= - T_{\\\\text{shaft}} \\\\\\\\',
     'J_{\\\\text{load}} \\\\ddot\\\\theta_{\\\\text{load}} &= T_{\\\\text{shaft}}']
    """
    return latex_text(_Document(equations).blocks())


def markdown(equations: Equations) -> str:
    """The document as GitHub Markdown, which notebooks read too.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])
    >>> print(markdown(assemble(line)).splitlines()[0])
    # Equations of motion: two_disks
    """
    return markdown_text(_Document(equations).blocks())


class _Document:
    def __init__(self, equations: Equations) -> None:
        self.eq, self.flat = equations, FlatEquations(equations)
        self.laws = [PrintedLaw(equations, index) for index in range(len(equations.templates))]
        self.exact = Exact({s: v for p in equations.parameters for s, v in zip(p.symbols, p.values, strict=True)})
        self.speed = next((p.values[0] for p in equations.parameters if p.symbols == (equations.speed,)), None)

    def blocks(self) -> list[Block]:
        """The whole document."""
        if not self.eq.groups:
            return list(self._plain())
        typeset = Typesetter(self._symbols())
        parts = [self._head(), self._laws(), self._nodes(typeset), self._coordinates(typeset)]
        if self.eq.clocks and self.speed is not None:
            parts.append(frequency_blocks(self.eq, self.speed, self.exact, typeset))
        parts += [parameter_blocks(self.eq, typeset), output_blocks(self.eq, self.laws)]
        return [block for part in parts for block in part]

    def _head(self) -> Iterator[Block]:
        eq = self.eq
        yield Heading(1, f"Equations of motion: {eq.name}")
        if eq.description.strip():
            yield Paragraph(Quoted(eq.description))
        at = ""
        if self.speed is not None:
            value = f"{with_unit(self.speed, 'rad/s')} ({number(self.speed * 30 / math.pi)} rpm)"
            at = f" The operating speed is $\\Omega$ = {value} of `{eq.reference}`."
        elements, laws = _count(len(eq.instances), "element"), _count(len(eq.templates), "law")
        yield Paragraph(
            f"{_count(len(eq.groups), 'degree')} of freedom; {elements} of {laws} join {_count(len(eq.nodes), 'node')}.{at}"
        )
        yield Paragraph(
            r"Angles $\theta$ and speeds $\omega=\dot\theta$ count forward, each in its own shaft's sense. A torque is what an "
            "element exerts on a node. Units are SI, and the radian is a plain number."
        )

    # -- laws and nodes --------------------------------------------------------------------------------------------------------

    def _laws(self) -> Iterator[Block]:
        yield Heading(2, "Laws of the elements")
        first: dict[str, PrintedLaw] = {}
        for law in self.laws:
            yield from law.blocks(like=first.get(law.title))
            first.setdefault(law.title, law)

    def _symbols(self) -> dict[sympy.Symbol, Notation | str]:
        """Printed forms of everything in the flat equations: a law's symbols with the element's name as a subscript."""
        found: dict[sympy.Symbol, Notation | str] = {}
        if self.eq.speed is not None:
            found[self.eq.speed] = r"\Omega"
        for instance in self.eq.instances:
            law = self.laws[instance.template]
            for symbol, there in instance.symbols.items():
                if there.name.startswith(f"{instance.name}."):
                    shown = law.symbols[symbol]
                    found.setdefault(there, shown.of(instance.name))
        for parameter in self.eq.parameters:
            for row, symbol in enumerate(parameter.symbols, 1):
                shown = plain_notation(parameter.name)
                found.setdefault(symbol, shown.row(str(row)) if parameter.series else shown)
        for instance in self.eq.instances:
            law = self.laws[instance.template]
            timed = {d.name for d in law.template.definitions if d.depends == "time"}
            for name in law.template.law["definitions"]:
                shown = law.symbols[sympy.Symbol(name, real=True)].of(instance.name)
                found[sympy.Symbol(f"{instance.name}.{name}", real=True)] = f"{shown}(t)" if name in timed else shown
            for name, symbol, *_ in law.template.states:
                found[sympy.Symbol(f"{instance.name}.{name}", real=True)] = law.symbols[symbol].of(instance.name)
        for letter, printed in (("theta", r"\theta"), ("omega", r"\omega")):
            found.update({sympy.Symbol(f"{letter}_{name}", real=True): Notation(printed).of(name) for name in self.eq.groups})
        found[TIME] = "t"
        return found

    def _nodes(self, typeset: Typesetter) -> Iterator[Block]:
        eq, flat = self.eq, self.flat
        yield Heading(2, "Equations of motion of the nodes")
        mass, torques = flat.mass(), flat.element_torques()
        rows = []
        for row, name in enumerate(eq.groups):
            left = " + ".join(
                f"{_factor(typeset(mass[row, column]))} {Notation(DDOT_THETA).of(other)}"
                for column, other in enumerate(eq.groups)
                if mass[row, column] != 0
            )
            terms = typeset.terms(torques[row]) + ([rf"T_{{\text{{modal}},{upright(name)}}}"] if eq.modal_ratio else [])
            first, *more = _lines(terms)
            rows += [f"{left} &= {first}", *(rf"&\quad {line}" for line in more)]
        yield Formulas(tuple(rows))
        if eq.modal_ratio:
            yield Paragraph(
                r"Modal damping: the torques $-C (\omega - r \Omega)$ with $C = \sum_i 2 \zeta \omega_i M v_i v_i^T M$ over the "
                rf"elastic modes $v_i$ of the mean-stiffness driveline, $v_i^T M v_i = 1$; $\zeta$ = `{eq.modal_ratio}`."
            )
        if geared := [node for node in eq.nodes if node.row != {node.group: 1}]:
            what = "Rigid gears" if all(node.group is not None for node in geared) else "Constraints"
            yield Paragraph(f"{what} tie further nodes to these:")
            yield Formulas(
                tuple(f"{Notation(THETA).of(node.name)} &= {typeset(node.over(flat.angles))}" for node in geared)
            )
        rpm = ["mean speed [rpm]"] if self.speed is not None else []
        yield Table(("node", "speed ratio", *rpm, "joins"), tuple(self._node_row(node) for node in eq.nodes))

    def _node_row(self, node: Node) -> tuple[str, ...]:
        ratio = self.exact(node.over(self.eq.ratios))
        turning = float(self.exact(node.over(self.eq.mean_speeds)))
        rpm = [number(turning * self.speed * 30 / math.pi)] if self.speed is not None else []
        joined = [name for name in (self._flange(flange) for flange in node.flanges) if name != node.name]
        return f"`{node.name}`", fraction(ratio), *rpm, ", ".join(f"`{name}`" for name in joined)

    def _flange(self, flange: str) -> str:
        """Name of a flange, shortened to that of its element where it is the only one."""
        element = flange.partition(".")[0]
        template = next(self.eq.templates[i.template] for i in self.eq.instances if i.name == element)
        return element if len(template.flanges) == 1 else flange

    # -- coordinates and base frequencies ------------------------------------------------------------------------------------

    def _coordinates(self, typeset: Typesetter) -> Iterator[Block]:
        eq, flat = self.eq, self.flat
        yield Heading(2, "Coordinates")
        roots = sum(step.form is None for step in eq.steps)
        counted = [(roots, "rigid angle"), (len(eq.steps) - roots, "relative angle")]
        text = "States: " + " and ".join(_count(count, what) for count, what in counted if count) + ", then their rates"
        own = sum(state.kind == "own" for state in eq.states)
        text += f", then {_count(own, 'state')} of the elements' own." if own else "."
        if roots and self.speed is not None:
            text += " Rigid angles are counted from uniform rotation."
        if eq.rigid:
            text += (
                " No law sees the rigid rotation: adding to its angle changes nothing else, and the vibration is solved apart."
            )
        yield Paragraph(text)
        rows = []
        for step in eq.steps:
            state = eq.states[step.state]
            if step.form is None:
                turned = eq.mean_speeds[step.group] * flat.operating_speed * TIME
                meaning = flat.angles[step.group] - turned
            else:
                meaning = self._form(eq.forms[step.form])
            rows.append((f"`{state.name}`", unit(state.unit), f"${typeset(meaning)}$"))
        yield Table(("state", "unit", "is"), tuple(rows))
        own_rows = tuple((f"`{s.name}`", unit(s.unit) or "—", number(s.start)) for s in eq.states if s.kind == "own")
        yield Paragraph("The rate of each has the same name with `_rate`.")
        if own_rows:
            yield Table(("own state", "unit", "start"), own_rows)

    def _form(self, form: Form) -> sympy.Expr:
        """A relative angle in the angles of the groups, its lever arms by their names where they have one."""
        arms: dict[sympy.Expr, sympy.Symbol] = {}
        instance = next(each for each in self.eq.instances if form.name.startswith(f"{each.name}."))
        table = self.flat.table_of(instance)
        for d in self.eq.templates[instance.template].definitions:
            if d.depends == "parameter":
                symbol = table[sympy.Symbol(d.name, real=True)]
                arms[d.expression.xreplace(table).xreplace({known: arm for arm, known in arms.items()})] = symbol
        terms = []
        for group, coefficient in form.coefficients.items():
            size = -coefficient if coefficient.could_extract_minus_sign() else coefficient
            terms.append(arms.get(size, size) * self.flat.angles[group] * (1 if size == coefficient else -1))
        return sympy.Add(*terms)

    # -- plain systems -------------------------------------------------------------------------------------------------------

    def _plain(self) -> Iterator[Block]:
        """The document of equations that come from no driveline."""
        eq, law = self.eq, self.laws[0]
        typeset = law.typesetter()
        yield Heading(1, f"Equations: {eq.name}")
        if eq.description.strip():
            yield Paragraph(Quoted(eq.description))
        yield Formulas(
            tuple(f"{law.symbols[state].dotted()} &= {typeset(rate)}" for state, rate in law.template.law["rates"].items())
        )
        yield from law.modes(typeset)
        if outputs := law.template.law["definitions"]:
            yield Paragraph("with the outputs")
            yield Formulas(tuple(f"{plain_notation(name)} &= {typeset(each)}" for name, each in outputs.items()))
        yield Table(("state", "start", "unit"), tuple((f"`{s.name}`", number(s.start), unit(s.unit) or "—") for s in eq.states))
        if eq.parameters:
            rows = tuple((f"`{p.name}`", number(p.values[0]), unit(p.unit) or "—") for p in eq.parameters)
            yield Table(("parameter", "value", "unit"), rows)


def _count(count: int, what: str) -> str:
    return f"{count} {what}" + ("" if count == 1 else "s")


def _factor(text: str) -> str:
    """A coefficient, in parentheses where it is a sum."""
    return rf"\left({text}\right)" if " + " in text or " - " in text else text


def _lines(terms: list[str]) -> list[str]:
    """A sum of terms broken into lines."""
    lines = [""]
    for term in terms:
        if len(lines[-1]) > LINE:
            lines.append("")
        sign = "" if term.startswith("-") or lines == [""] else "+ "
        lines[-1] = f"{lines[-1]} {sign}{term}".lstrip()
    return lines if terms else ["0"]
