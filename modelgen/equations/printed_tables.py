"""The tables at the end of the printed equations: base frequencies, parameters and outputs of the whole driveline.

Part of the grammar's printed form, between ``typesetting`` and ``latex``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from functools import reduce

import sympy

from modelgen.equations.conditions import Exact
from modelgen.equations.document import Block, Heading, Paragraph, Quoted, Table, number, unit, with_unit
from modelgen.equations.printed_law import PrintedLaw
from modelgen.equations.records import DerivedParameter, Equations
from modelgen.equations.typesetting import Typesetter


def fraction(ratio: sympy.Expr) -> str:
    """A ratio as a fraction where it is exact."""
    return f"{ratio.p}/{ratio.q}".removesuffix("/1") if ratio.is_Rational else number(float(ratio))


def frequency_blocks(equations: Equations, speed: float, exact: Exact, typeset: Typesetter) -> Iterator[Block]:
    """Base frequencies as multiples of the operating speed [rad/s], and when all of them repeat."""
    yield Heading(2, "Base frequencies")
    yield Paragraph(r"Each is an exact multiple of the operating speed $\Omega$.")
    rows = []
    multiples = [exact(clock.multiple) for clock in equations.clocks]
    for index, (clock, multiple) in enumerate(zip(equations.clocks, multiples, strict=True)):
        users = [f"`{instance.name}`" for instance in equations.instances if index in instance.clocks.values()]
        driven = users[0] if len(users) == 1 else f"{users[0]} … {users[-1]}" if users else "—"
        formula = "" if clock.multiple.is_number else f"${typeset(clock.multiple)}$"
        hertz = float(multiple) * speed / (2 * math.pi)
        rows.append((f"`{clock.name}`", fraction(multiple), formula, number(hertz), driven))
    yield Table(("base", r"per $\Omega$", "follows from", "frequency [Hz]", "drives"), tuple(rows))
    if len(multiples) > 1 and all(multiple.is_Rational for multiple in multiples):
        turns = 1 / reduce(_common, (Fraction(int(m.p), int(m.q)) for m in multiples))
        period = with_unit(float(turns) * 2 * math.pi / speed, "s")
        yield Paragraph(f"All of them repeat together after {turns} turns of `{equations.reference}`, that is {period}.")


def parameter_blocks(equations: Equations, typeset: Typesetter) -> Iterator[Block]:
    """Shared parameters, then series and derived parameters row by row."""
    shared = [p for p in equations.parameters if "." not in p.name and not p.series]
    columns = [(p.name, p.unit, p.values, p.note) for p in equations.parameters if p.series and p.values]
    columns += [(d.name, d.unit, _derived(equations, d), _first_line(d.function.__doc__)) for d in equations.derived if d.symbols]
    if shared or columns:
        yield Heading(2, "Parameters")
        yield Paragraph("Those of one element stand with its law above.")
    if shared:
        rows = []
        for p in shared:
            value = number(p.values[0]) if p.expression is None else f"${typeset(p.expression)}$ = {number(p.values[0])}"
            rows.append((f"`{p.name}`", value, unit(p.unit) or "—", Quoted(p.note)))
        noted = any(p.note for p in shared)
        yield Table(("name", "value", "unit", *["note"] * noted), tuple(row if noted else row[:3] for row in rows))
    for length in dict.fromkeys(len(values) for _, _, values, _ in columns):
        alike = [column for column in columns if len(column[2]) == length]
        head = ("row", *(f"`{name}` [{unit(of) or '1'}]" for name, of, _, _ in alike))
        yield Table(head, tuple((str(row + 1), *(number(values[row]) for _, _, values, _ in alike)) for row in range(length)))
    if notes := tuple((f"`{name}`", Quoted(note)) for name, _, _, note in columns if note):
        yield Table(("series", "note"), notes)


def output_blocks(equations: Equations, laws: list[PrintedLaw]) -> Iterator[Block]:
    """The channels, once for all elements that have the same."""
    yield Heading(2, "Outputs")
    yield Paragraph("Each element has the channels of its law, named `element.channel`.")
    titles = {instance.name: laws[instance.template].title.lower() for instance in equations.instances}
    known: dict[str, list[str]] = {}
    for output in equations.outputs:
        element, _, channel = output.name.rpartition(".")
        known.setdefault(element, []).append(f"`{channel}` [{unit(output.unit) or '1'}]")
    rows: dict[tuple[str, frozenset[str]], tuple[str, str]] = {}
    for element, channels in known.items():
        of = titles.get(element, f"whole driveline (`{element}`)")
        rows.setdefault((of, frozenset(channels)), (of, ", ".join(channels)))
    yield Table(("of every", "channels"), tuple(rows.values()))


def _derived(equations: Equations, derived: DerivedParameter) -> tuple[float, ...]:
    given = {p.name: list(p.values) if p.series else p.values[0] for p in equations.parameters}
    arguments = {key: given[source] if isinstance(source, str) else source for key, source in derived.arguments.items()}
    return tuple(float(value) for value in derived.function(**arguments))


def _first_line(text: str | None) -> str:
    return (text or "").strip().split("\n")[0]


def _common(first: Fraction, second: Fraction) -> Fraction:
    """The largest fraction of which both are whole multiples."""
    return Fraction(
        math.gcd(first.numerator * second.denominator, second.numerator * first.denominator),
        first.denominator * second.denominator,
    )
