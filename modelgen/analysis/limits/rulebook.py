"""Rules that results are held against, as data: quantity, limit, range of use, citation, and whether its text was seen.

Part of ``limits``; ``check`` applies them. The files in ``rules/`` hold the rules that come with modelgen, ``read_rules``
reads others. A limit is an expression in the rule's inputs, in the units that the rule states, and is read by the allow-list of
model files: what is shown is what is computed.
"""

from __future__ import annotations

import functools
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from modelgen.errors import CaseError, ModelgenError, nearest
from modelgen.model.expressions import read_expression
from modelgen.model.values import plain_number
from modelgen.units import dimension_of, finite, read_any, to_si

FOLDER = Path(__file__).parent / "rules"
FORMAT = 1
COMPARISONS = ("at most", "at least", "outside")
_WORD = re.compile(r"(?<![\w.])[A-Za-z_]\w*(?!\w|\s*\()", re.ASCII)  # a name that is not called


@dataclass(frozen=True)
class RuleInput:
    """A number that a rule asks for: unit, range (positive unless ``least`` is given), default, and named choices."""

    name: str
    unit: str
    doc: str
    least: float | None = None
    largest: float | None = None
    default: float | None = None
    choices: Mapping[str, float] = field(default_factory=dict)

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
        given = self.given(**values).values if values else self.values
        known = {key: each.default for key, each in self.inputs.items() if each.default is not None} | dict(given)
        for key, each in self.inputs.items():
            if key not in known:
                wanted = " or ".join([f"a number in {each.unit}" if each.unit != "1" else "a number", *each.choices])
                raise CaseError(self.where, f"needs {key} ({each.doc})", f"write rule.given({key}=...) with {wanted}")
        for ranges, formulas in self.cases:
            if all(low <= known[key] <= high for key, (low, high) in ranges.items()):
                # A negative number keeps its sign under a power only in parentheses.
                exact = [_WORD.sub(lambda word: f"({known[word[0]]!r})", text) for text in formulas]
                shown = [_WORD.sub(lambda word: f"{known[word[0]]:.6g}", text) for text in formulas]
                numbers = tuple(finite(float(read_expression(text, {}, self.where)), self.where) for text in exact)
                return Limit(numbers, " and ".join(formulas), " and ".join(shown))
        return None

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
    number, given = value if isinstance(value, tuple) and len(value) == 2 else (value, "1")
    number = plain_number(number, where, unit)
    if given == "1" and not dimension_of(si).is_number:
        return to_si(number, "", si, where)  # refuses it: a number with a dimension names its unit
    return number * to_si(1.0, given, si, where) / factor


@functools.lru_cache(maxsize=1)
def rules() -> Mapping[str, Rule]:
    """The rules that come with modelgen, by name.

    >>> sorted(name for name, each in rules().items() if each.verified)[:2]
    ['kr_crankshaft_continuous', 'kr_crankshaft_transient']
    """
    return {name: each for path in sorted(FOLDER.glob("*.toml")) for name, each in read_rules(path).items()}


def rule(name: str) -> Rule:
    """A rule that comes with modelgen. Raises CaseError for an unknown name."""
    if name not in rules():
        raise CaseError(f"rule {name!r}", "is unknown", nearest(name, rules()))
    return rules()[name]


def read_rules(path: str | Path) -> dict[str, Rule]:
    """The rules in a file. Raises CaseError for a file that cannot be read, or a rule that is not whole."""
    try:
        data = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise CaseError(str(path), f"cannot be read: {error}", "give a rule file in TOML") from None
    if data.get("format") != FORMAT or not isinstance(data.get("rules"), dict) or set(data) != {"format", "rules"}:
        raise CaseError(str(path), "is no rule file", f"write format = {FORMAT} and tables [rules.NAME]")
    return {name: _read_rule(name, table, f"{path}, [rules.{name}]") for name, table in data["rules"].items()}


def _read_rule(name: str, table: Any, where: str) -> Rule:
    texts = ("title", "quantity", "measure", "unit", "comparison", "applies", "citation", "seen")
    _check_keys(table, {*texts, "verified"}, {"beside", "limit", "cases", "inputs"}, where)
    for key in (*texts, "beside"):
        if not isinstance(table.get(key, ""), str):
            raise CaseError(where, f"{key} is {table[key]!r:.60}", "write a text")
    if not isinstance(table["verified"], bool):
        raise CaseError(where, f"verified is {table['verified']!r:.60}", "write true where the rule's text was seen, else false")
    if table["comparison"] not in COMPARISONS:
        raise CaseError(where, f"comparison is {table['comparison']!r}", nearest(table["comparison"], COMPARISONS))
    if ("limit" in table) == ("cases" in table):
        raise CaseError(where, "does not hold one of limit and cases", "give exactly one of them")
    try:
        read_any(f"1 {table['unit']}", where)
        inputs = {key: _read_input(key, each, where) for key, each in table.get("inputs", {}).items()}
        one = [{"when": {}, "limit": table.get("limit")}]
        cases = tuple(_read_cases(table.get("cases", one), table["comparison"], inputs, where))
    except ModelgenError:
        raise
    except (TypeError, ValueError, AttributeError, KeyError) as error:
        raise CaseError(where, f"is not whole ({error!r:.80})", "compare it with the rules of modelgen") from None
    plain = {key: table[key] for key in (*texts, "verified")}
    return Rule(name=name, cases=cases, inputs=inputs, beside=table.get("beside", ""), **plain)


def _read_input(name: str, table: Any, where: str) -> RuleInput:
    where = f"{where}, input {name}"
    _check_keys(table, {"unit", "doc"}, {"least", "largest", "default", "choices"}, where)
    read_any(f"1 {table['unit']}", where)
    bounds = {key: finite(plain_number(table[key], where), where) for key in ("least", "largest", "default") if key in table}
    choices = {key: finite(plain_number(value, where), where) for key, value in table.get("choices", {}).items()}
    return RuleInput(name, table["unit"], table["doc"], choices=choices, **bounds)


def _read_cases(cases: Any, comparison: str, inputs: Mapping[str, RuleInput], where: str) -> Iterator[Any]:
    for case in cases:
        _check_keys(case, {"when", "limit"}, set(), where)
        formulas = tuple(case["limit"]) if isinstance(case["limit"], list) else (case["limit"],)
        if len(formulas) != 1 + (comparison == "outside"):
            what = f"has {len(formulas)} limits for {comparison!r}"
            raise CaseError(where, what, "'outside' takes a lower and an upper one, the others one")
        for word in [*case["when"], *(word for text in formulas for word in _WORD.findall(text))]:
            if word not in inputs:
                raise CaseError(where, f"uses {word!r}, which is no input of it", nearest(word, inputs))
        yield {key: (float(low), float(high)) for key, (low, high) in case["when"].items()}, formulas


def _check_keys(table: Any, needed: set[str], allowed: set[str], where: str) -> None:
    if not isinstance(table, dict):
        raise CaseError(where, f"is {table!r:.60}", "write a table")
    for key in table:
        if key not in needed | allowed:
            raise CaseError(where, f"has an unknown key {key!r}", nearest(key, sorted(needed | allowed)))
    for key in sorted(needed - set(table)):
        raise CaseError(where, f"has no {key}", "every rule says what it judges, where it is from and whether its text was seen")
