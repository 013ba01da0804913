"""Rules that results are held against, as data: quantity, limit, range of use, citation, and whether its text was seen.

Part of ``limits``; ``check`` applies them, ``rulebook`` reads them from files. A limit is an expression in the rule's inputs, in
the units that the rule states, and is read by the allow-list of model files: what is shown is what is computed.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from modelgen.analysis.limits.known_value import KnownValue
from modelgen.errors import CaseError, nearest
from modelgen.model.expressions import read_expression
from modelgen.model.values import plain_number
from modelgen.units import dimension_of, finite, read_any, to_si

AGREES = 1e-3  # relative difference of an input given twice that is one of digits
COMPARISONS = ("at most", "at least", "outside")
WORD = re.compile(r"(?<![\w.])[A-Za-z_]\w*(?!\w|\s*\()", re.ASCII)  # a name that is not called


@dataclass(frozen=True)
class RuleInput:
    """A number that a rule asks for: unit, range (positive unless ``least`` is given), default, and named choices.

    ``known``: the values that are judged know it (their diameter, their speed), so that nobody need give it.
    """

    name: str
    unit: str
    doc: str
    least: float | None = None
    largest: float | None = None
    default: float | None = None
    choices: Mapping[str, float] = field(default_factory=dict)
    known: bool = False

    def read(self, value: Any, where: str) -> float:
        """The value in the input's own unit. Raises CaseError or UnitError."""
        where = f"{where}, {self.name}"
        if isinstance(value, str) and self.choices and re.fullmatch(r"\s*[A-Za-z_]\w*\s*", value):
            if value.strip() not in self.choices:
                raise CaseError(where, f"is {value!r}", nearest(value.strip(), self.choices))
            return self.choices[value.strip()]
        number = in_unit(value, self.unit, where)
        shown = f"is {number:g}" + (f" {self.unit}" if self.unit != "1" else "")
        if self.least is None and number <= 0:
            raise CaseError(where, shown, "give a positive value")
        if self.least is not None and number < self.least:
            raise CaseError(where, shown, f"give {self.least:g} or more")
        if self.largest is not None and number > self.largest:
            raise CaseError(where, f"{shown}, the rule counts at most {self.largest:g}", f"it is: {self.doc}")
        return number


@dataclass(frozen=True)
class Bound:
    """The ``largest`` value of an ``input`` where others have one of the ``when`` values; ``says`` what that is, in words."""

    input: str
    largest: float
    when: Mapping[str, tuple[float, ...]]
    says: str


def _words(formulas: Iterable[str]) -> list[str]:
    return [word for text in formulas for word in WORD.findall(text)]


@dataclass(frozen=True)
class Limit:
    """A limit in the unit of its rule (two for "outside": lower, upper), its formula, and the formula with numbers put in."""

    values: tuple[float, ...]
    formula: str
    inserted: str


@dataclass(frozen=True)
class Rule:
    """One rule. ``given`` binds the inputs and says which elements it is for; ``limit`` computes the limit.

    ``comparison``: the value must be "at most" or "at least" the limit, or "outside" of two. ``cases`` are (ranges of inputs,
    limits); the first that fits is taken. ``verified``: whether the rule's own text was seen; ``seen`` says what was.
    ``bounds``: where its text allows less of an input. ``nodes``, ``orders``: the modes, and the orders per turn of the
    reference shaft (expressions in the inputs), that it speaks of. ``particular``: it is for parts that must be named.

    >>> from modelgen.analysis.limits.rulebook import rule
    >>> shaft = rule("kr_propulsion_shaft_continuous").given(
    ...     "intermediate", tensile_strength="600 MPa", shape_factor="integral_flange", diameter="340 mm")
    >>> round(shaft.limit(speed_ratio=0.8).values[0], 3)  # N/mm^2
    46.468
    """

    name: str
    title: str
    quantity: str
    measure: str
    unit: str
    comparison: str
    cases: tuple[tuple[Mapping[str, tuple[float, float]], tuple[str, ...]], ...]
    applies: str
    citation: str
    verified: bool
    seen: str
    beside: str = ""
    inputs: Mapping[str, RuleInput] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)
    subjects: tuple[str, ...] = ()
    bounds: tuple[Bound, ...] = ()
    nodes: int | None = None
    orders: tuple[str, ...] = ()
    particular: bool = False

    @property
    def where(self) -> str:
        return f"rule {self.name!r}"

    @property
    def provenance(self) -> str:
        """In words, whether the text of the rule was seen."""
        return f"text seen: {self.seen}" if self.verified else f"not verified, the text of the rule was not seen: {self.seen}"

    def given(self, *subjects: str, **values: Any) -> Rule:
        """The rule for the named elements only (for all, if none is named), with values of its inputs."""
        read = dict(self.values)
        for key, value in values.items():
            if key not in self.inputs:
                raise CaseError(self.where, f"has no input {key!r}", nearest(key, self.inputs))
            read[key] = self.inputs[key].read(value, self.where)
        return replace(self, values=read, subjects=(*self.subjects, *subjects))

    def limit(self, **values: Any) -> Limit | None:
        """The limit for the inputs given before and now; None where the rule does not reach (its speed range, for one).

        Raises CaseError where an input is missing.
        """
        used = {word for ranges, formulas in self.cases for word in (*ranges, *_words(formulas))}
        known = (self.given(**values) if values else self).complete(used)
        for ranges, formulas in self.cases:
            if all(low <= known[key] <= high for key, (low, high) in ranges.items()):
                shown = [WORD.sub(lambda word: f"{known[word[0]]:.6g}", text) for text in formulas]
                numbers = tuple(self._number(text, known) for text in formulas)
                return Limit(numbers, " and ".join(formulas), " and ".join(shown))
        return None

    def complete(self, needed: Iterable[str] | None = None) -> dict[str, float]:
        """The inputs with their defaults. Raises CaseError for one that is missing, or more than the rule's text allows.

        ``needed``: by name; by default all but those that the values will know, as before anything is computed.
        """
        wants = {key for key, each in self.inputs.items() if not each.known} if needed is None else set(needed)
        found = {key: each.default for key, each in self.inputs.items() if each.default is not None} | dict(self.values)
        for key, each in self.inputs.items():
            if key in wants and key not in found:
                wanted = " or ".join([f"a number in {each.unit}" if each.unit != "1" else "a number", *each.choices])
                raise CaseError(self.where, f"needs {key} ({each.doc})", f"write rule.given({key}=...) with {wanted}")
        for bound in self.bounds:
            value = found.get(bound.input)
            if value is None or value <= bound.largest or not all(found.get(key) in when for key, when in bound.when.items()):
                continue
            unit = self.inputs[bound.input].unit
            what = f"is {value:g} {unit}, the rule's text goes up to {bound.largest:g} {unit} for {bound.says}"
            others = {
                key: [name for name, x in self.inputs[key].choices.items() if x not in when] for key, when in bound.when.items()
            }
            told = "; ".join(f"{key} may be {', '.join(names)}" for key, names in others.items() if names)
            raise CaseError(
                f"{self.where}, {bound.input}", what, f"give {bound.largest:g} {unit} or less, or say otherwise: {told}"
            )
        return found

    def knowing(self, facts: Mapping[str, Any]) -> Rule:
        """The rule with what a value knows of itself. Raises CaseError where an input that was given says otherwise."""
        own = {
            key: self.inputs[key].read(facts[key], self.where) for key, each in self.inputs.items() if each.known and key in facts
        }
        for key, value in own.items():
            given = self.values.get(key, value)
            if abs(given - value) > AGREES * abs(value):
                unit = "" if self.inputs[key].unit == "1" else f" {self.inputs[key].unit}"
                what = f"is given as {given:.6g}{unit}, and the values that are judged belong to {value:.6g}{unit}"
                raise CaseError(f"{self.where}, {key}", what, "leave it out, or change the model, --speed or --diameter")
        return replace(self, values={**self.values, **own})

    def orders_meant(self) -> tuple[float, ...]:
        """The orders per turn of the reference shaft that the rule speaks of; none where it speaks of all."""
        known = self.complete(_words(self.orders)) if self.orders else {}
        return tuple(dict.fromkeys(self._number(text, known) for text in self.orders))

    def speaks_of(self, facts: Mapping[str, Any]) -> bool:
        """Whether its text speaks of a value with these facts; of one that knows neither mode nor order it is taken to."""
        if self.nodes is not None and facts.get("nodes", self.nodes) != self.nodes:
            return False
        return not self.orders or "order" not in facts or any(abs(facts["order"] - o) <= 1e-9 * o for o in self.orders_meant())

    def _choice(self, key: str, value: float) -> str:
        return next((name for name, number in self.inputs[key].choices.items() if number == value), f"{value:g}")

    def _number(self, text: str, known: Mapping[str, float]) -> float:
        # A negative number keeps its sign under a power only in parentheses.
        exact = WORD.sub(lambda word: f"({known[word[0]]!r})", text)
        return finite(float(read_expression(exact, {}, self.where)), self.where)

    @property
    def reach(self) -> str:
        """The ranges of inputs in which the rule holds, in words."""
        each = [", ".join(f"{key} {low:g} to {high:g}" for key, (low, high) in ranges.items()) for ranges, _ in self.cases]
        return " or ".join(each)


def in_unit(value: Any, unit: str, where: str) -> float:
    """A number in ``unit``, of a text with a unit, a pair (number, unit), or a plain number where ``unit`` is "1"."""
    factor, si = read_any(f"1 {unit}" if unit != "1" else "1", where)
    if isinstance(value, str):
        value = read_any(value, where)
    elif isinstance(value, KnownValue):
        value = (float(value), value.unit)
    number, given = value if isinstance(value, tuple) and len(value) == 2 else (value, "1")
    number = plain_number(number, where, unit)
    if given == "1" and not dimension_of(si).is_number:
        return to_si(number, "", si, where)  # refuses it: a number with a dimension names its unit
    return number * to_si(1.0, given, si, where) / factor
