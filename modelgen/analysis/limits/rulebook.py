"""Rule files: the rules that come with modelgen, those of others, and how they are read.

Part of ``limits``; imports ``bound_rule``, what one rule is. A file holds ``format = 1`` and a table [rules.NAME] for each rule;
the files in ``rules/`` come with modelgen. A file's name stands for all its rules.
"""

from __future__ import annotations

import functools
import os
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from modelgen.analysis.limits.bound_rule import COMPARISONS, WORD, Bound, Limit, Rule, RuleInput, in_unit
from modelgen.errors import CaseError, ModelgenError, nearest
from modelgen.model.chosen_limits import ChosenLimit
from modelgen.model.values import plain_number
from modelgen.units import finite, read_any

__all__ = ["Limit", "Rule", "RuleInput", "chosen_rules", "in_unit", "read_rules", "rule", "rules", "rules_named"]

FOLDER = Path(__file__).parent / "rules"
FORMAT = 1
KEYS = ("bounds", "nodes", "orders", "particular")  # what a rule speaks of


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


def rules_named(name: str) -> tuple[Rule, ...]:
    """The rule of a name, or all rules of the file of that name. Raises CaseError for an unknown one.

    >>> [each.name for each in rules_named("iacs_m68")]
    ['iacs_m68_continuous', 'iacs_m68_transient']
    """
    path = FOLDER / f"{name}.toml"
    if path.stem == name and os.path.isfile(path):
        return tuple(rules()[each] for each in read_rules(path))
    return (rule(name),)


def chosen_rules(limits: Iterable[ChosenLimit]) -> list[Rule]:
    """The rules that a model chooses, with their elements and inputs. Raises CaseError for what a rule does not know or lacks."""
    found = []
    for limit in limits:
        named = rules_named(limit.rule)
        for key in limit.inputs:
            if not any(key in each.inputs for each in named):
                known = sorted({name for each in named for name in each.inputs})
                raise CaseError(f"rule {limit.rule!r}", f"has no input {key!r}", nearest(key, known))
        for each in named:
            bound = each.given(*limit.elements, **{key: value for key, value in limit.inputs.items() if key in each.inputs})
            bound.complete()
            found.append(bound)
    return found


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
    _check_keys(table, {*texts, "verified"}, {"beside", "limit", "cases", "inputs", *KEYS}, where)
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
        scope = _read_scope(table, inputs, where)
    except ModelgenError:
        raise
    except (TypeError, ValueError, AttributeError, KeyError) as error:
        raise CaseError(where, f"is not whole ({error!r:.80})", "compare it with the rules of modelgen") from None
    plain = {key: table[key] for key in (*texts, "verified")}
    return Rule(name=name, cases=cases, inputs=inputs, beside=table.get("beside", ""), **plain, **scope)


def _read_input(name: str, table: Any, where: str) -> RuleInput:
    where = f"{where}, input {name}"
    _check_keys(table, {"unit", "doc"}, {"least", "largest", "default", "choices", "known"}, where)
    read_any(f"1 {table['unit']}", where)
    bounds = {key: finite(plain_number(table[key], where), where) for key in ("least", "largest", "default") if key in table}
    choices = {key: finite(plain_number(value, where), where) for key, value in table.get("choices", {}).items()}
    return RuleInput(name, table["unit"], table["doc"], choices=choices, known=table.get("known", False) is True, **bounds)


def _read_cases(cases: Any, comparison: str, inputs: Mapping[str, RuleInput], where: str) -> Iterator[Any]:
    for case in cases:
        _check_keys(case, {"when", "limit"}, set(), where)
        formulas = tuple(case["limit"]) if isinstance(case["limit"], list) else (case["limit"],)
        if len(formulas) != 1 + (comparison == "outside"):
            what = f"has {len(formulas)} limits for {comparison!r}"
            raise CaseError(where, what, "'outside' takes a lower and an upper one, the others one")
        for word in [*case["when"], *(word for text in formulas for word in WORD.findall(text))]:
            if word not in inputs:
                raise CaseError(where, f"uses {word!r}, which is no input of it", nearest(word, inputs))
        yield {key: (float(low), float(high)) for key, (low, high) in case["when"].items()}, formulas


def _read_scope(table: Mapping[str, Any], inputs: Mapping[str, RuleInput], where: str) -> dict[str, Any]:
    """What the rule speaks of, and where its text allows less of an input."""
    bounds = []
    for each in table.get("bounds", []):
        _check_keys(each, {"input", "largest", "when", "says"}, set(), where)
        for word in (each["input"], *each["when"]):
            if word not in inputs:
                raise CaseError(where, f"uses {word!r}, which is no input of it", nearest(word, inputs))
        when = {key: tuple(inputs[key].choices[name] for name in names) for key, names in each["when"].items()}
        bounds.append(Bound(each["input"], float(each["largest"]), when, each["says"]))
    nodes, orders = table.get("nodes"), tuple(table.get("orders", ()))
    for word in [word for text in orders for word in WORD.findall(text)]:
        if word not in inputs:
            raise CaseError(where, f"uses {word!r}, which is no input of it", nearest(word, inputs))
    if nodes is not None and (isinstance(nodes, bool) or not isinstance(nodes, int)):
        raise CaseError(where, f"nodes is {nodes!r:.60}", "write the number of nodes of the modes that the rule speaks of")
    return {"bounds": tuple(bounds), "nodes": nodes, "orders": orders, "particular": table.get("particular", False) is True}


def _check_keys(table: Any, needed: set[str], allowed: set[str], where: str) -> None:
    if not isinstance(table, dict):
        raise CaseError(where, f"is {table!r:.60}", "write a table")
    for key in table:
        if key not in needed | allowed:
            raise CaseError(where, f"has an unknown key {key!r}", nearest(key, sorted(needed | allowed)))
    for key in sorted(needed - set(table)):
        raise CaseError(where, f"has no {key}", "every rule says what it judges, where it is from and whether its text was seen")
