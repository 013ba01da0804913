"""Question: does the driveline keep its limits, by how much, and where do the limits come from?

``check_limits(values, rules)`` holds values by name, such as those of an ``AnglesResult``, against rules (``rulebook``). A
value is named ``element.quantity``; a rule judges the values of its quantity. A rule whose own text was not seen says so in every
row.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from modelgen.analysis.limits.bound_rule import Limit, Rule, in_unit
from modelgen.analysis.limits.known_value import facts_of
from modelgen.analysis.limits.rulebook import rule
from modelgen.analysis.time_domain.angles import AnglesResult
from modelgen.errors import CaseError, nearest


@dataclass(frozen=True)
class LimitRow:
    """One value against one rule; ``value``, ``beside`` and ``limits`` in ``unit``.

    ``margin`` is the share of the limit that is left, negative beyond it; None where the rule does not reach (``verdict`` "not
    judged", ``remark`` says why). ``inserted`` is the formula with its numbers. ``beside`` is a second measure of the same
    thing, for information. ``limits`` are two for the comparison "outside".
    """

    rule: str
    title: str
    element: str
    quantity: str
    measure: str
    value: float
    unit: str
    comparison: str
    limits: tuple[float, ...]
    margin: float | None
    verdict: str
    formula: str
    inserted: str
    applies: str
    citation: str
    verified: bool
    provenance: str
    beside: float | None = None
    remark: str = ""

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        limit = " and ".join(f"{each:.4g}" for each in self.limits)
        left = "" if self.margin is None else f", {100 * abs(self.margin):.3g} % {'left' if self.margin >= 0 else 'beyond it'}"
        equals = "" if self.formula == self.inserted else f" = {self.formula} = {self.inserted}"
        judged = self.remark if self.margin is None else f"{self.comparison} {limit}{unit}{equals}{left}"
        beside = "" if self.beside is None else f" (half peak to peak {self.beside:.4g}{unit})"
        source = self.rule if self.verified else f"{self.rule}, not verified"
        return f"{self.verdict:<10} {self.element}.{self.quantity} {self.value:.4g}{unit}{beside}: {judged} [{source}]"


@dataclass(frozen=True)
class LimitsResult:
    """Every value against every rule that judges it."""

    model: str
    rows: tuple[LimitRow, ...]
    remarks: tuple[str, ...] = ()

    def with_verdict(self, verdict: str) -> tuple[LimitRow, ...]:
        """The rows with the verdict "pass", "fail" or "not judged"."""
        return tuple(row for row in self.rows if row.verdict == verdict)

    @property
    def ok(self) -> bool:
        """Whether no value is beyond its limit, and at least one was judged."""
        return bool(self.with_verdict("pass")) and not self.with_verdict("fail")

    @property
    def unverified(self) -> tuple[str, ...]:
        """Names of the applied rules whose own text was not seen."""
        return tuple(dict.fromkeys(row.rule for row in self.rows if not row.verified))

    def __str__(self) -> str:
        counts = ", ".join(f"{len(self.with_verdict(verdict))} {verdict}" for verdict in ("pass", "fail", "not judged"))
        sources = dict.fromkeys(f"[{row.rule}] {row.measure}; {row.citation}; {row.provenance}" for row in self.rows)
        return "\n".join([f"limits of {self.model!r}: {counts}", *map(str, self.rows), *sources, *self.remarks])


def check_limits(
    values: AnglesResult | Mapping[str, Any], rules: Iterable[Rule | str] | Rule | str, model: str = ""
) -> LimitsResult:
    """Values against rules, as a table of pass, fail and margin.

    ``values``: a result, or a mapping from ``element.quantity`` to a text with a unit, a pair (number, unit), or a plain number
    for what has no unit. ``rules``: rules or names of rules. Raises CaseError for a rule that finds nothing to judge or lacks an
    input, UnitError for a value without its unit.

    >>> print(check_limits({"coupling.vibratory_torque": "1.2 kN*m"},
    ...     rule("coupling_vibratory_torque").given(continuous_vibratory_torque="1.5 kN*m"), "train").rows[0].verdict)
    pass
    """
    remarks: tuple[str, ...] = ()
    if isinstance(values, AnglesResult):
        model = model or values.model
        if not values.window.settled:
            remarks = ("the window is not settled: start-up vibration is still in these values",)
        values = angle_values(values)
    if not isinstance(values, Mapping):
        remedy = "give an AnglesResult, or values by name; for modes, separation_margins(result, excitations)"
        raise CaseError("check_limits, values", f"are {type(values).__name__}", remedy)
    chosen = [rule(each) if isinstance(each, str) else each for each in ([rules] if isinstance(rules, (Rule, str)) else rules)]
    rows = [_judged(each, element, name, values) for each in chosen for element, name in _subjects(each, values)]
    return LimitsResult(model, tuple(rows), (*remarks, *(text for each in chosen for text in _scope(each, values))))


def _scope(applied: Rule, values: Mapping[str, Any]) -> list[str]:
    """What a rule was judged for, where its text speaks of some modes and orders only, and the values know theirs."""
    known = {fact for name, value in values.items() if str(name).endswith(f".{applied.quantity}") for fact in facts_of(value)}
    modes = [f"modes with {applied.nodes} node{'s' * (applied.nodes != 1)}"] if "nodes" in known and applied.nodes else []
    orders = sorted(applied.orders_meant(), reverse=True) if "order" in known else []
    what = " and ".join([*modes, *([f"orders {' and '.join(f'{order:g}' for order in orders)}"] if orders else [])])
    return [f"{applied.where} was judged for {what} only, of which its text speaks"] if what else []


def angle_values(result: AnglesResult) -> dict[str, tuple[float, str]]:
    """The values of an ``AnglesResult`` by name, physical, with their units."""
    values: dict[str, tuple[float, str]] = {}
    for name, angles in result.inertias.items():
        for quantity, swing in (("vibration_angle", angles.vibration), ("elastic_angle", angles.elastic)):
            values[f"{name}.{quantity}"] = (swing.peak, "rad")
            values[f"{name}.{quantity}_half_pp"] = (swing.half_pp, "rad")
    for name, twist in result.twists.items():
        values[f"{name}.twist"], values[f"{name}.twist_half_pp"] = (twist.peak, "rad"), (twist.half_pp, "rad")
    for name, mesh in result.meshes.items():
        values[f"{name}.mesh_force"] = (max(abs(mesh.least), abs(mesh.largest)), "N")
    return values


def _subjects(applied: Rule, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Element and full name of every value that a rule judges."""
    found = {}
    for name in values:
        element, dot, quantity = str(name).rpartition(".")
        if not dot:
            raise CaseError(f"value {name!r}", "does not name an element and a quantity", "write element.quantity")
        if quantity == applied.quantity:
            found[element] = name
    if not found:
        known = sorted({str(name).rpartition(".")[2] for name in values})
        what = f"judges {applied.quantity!r}, of which there is no value"
        raise CaseError(applied.where, what, nearest(applied.quantity, known))
    found = {element: name for element, name in found.items() if applied.speaks_of(facts_of(values[name]))}
    if not found:
        words = " and ".join(_scope(applied, values)).partition(" judged for ")[2].partition(" only,")[0]
        raise CaseError(applied.where, f"speaks of {words}, of which there is no value", "ask for them, or leave the rule out")
    if applied.particular and not applied.subjects and len(found) > 1:
        what = f"is for particular parts and names none; there are {', '.join(found)}"
        raise CaseError(applied.where, what, "name those that it is for")
    for subject in applied.subjects:
        if subject not in found:
            raise CaseError(applied.where, f"there is no {subject}.{applied.quantity}", nearest(subject, found))
    return [(element, name) for element, name in found.items() if not applied.subjects or element in applied.subjects]


def _judged(applied: Rule, element: str, name: str, values: Mapping[str, Any]) -> LimitRow:
    value = in_unit(values[name], applied.unit, f"value {name!r}")
    other = f"{element}.{applied.beside}" if applied.beside else ""
    beside = in_unit(values[other], applied.unit, f"value {other!r}") if other in values else None
    applied = applied.knowing(facts_of(values[name]))
    limit = applied.limit()
    margin = None if limit is None else _margin(applied, value, limit)
    return LimitRow(
        rule=applied.name,
        title=applied.title,
        element=element,
        quantity=applied.quantity,
        measure=applied.measure,
        value=value,
        unit=applied.unit,
        comparison=applied.comparison,
        limits=limit.values if limit else (),
        margin=margin,
        verdict="not judged" if margin is None else "pass" if margin >= 0 else "fail",
        formula=limit.formula if limit else "",
        inserted=limit.inserted if limit else "",
        applies=applied.applies,
        citation=applied.citation,
        verified=applied.verified,
        provenance=applied.provenance,
        beside=beside,
        remark="" if limit else f"the rule holds for {applied.reach} only",
    )


def _margin(applied: Rule, value: float, limit: Limit) -> float:
    if applied.comparison == "outside":
        low, high = limit.values
        # Inside, the nearer way out counts.
        return max((low - value) / low, (value - high) / high)
    (bound,) = limit.values
    if bound <= 0:
        raise CaseError(applied.where, f"gives the limit {bound:g} {applied.unit}", f"check its inputs: {limit.inserted}")
    size = value if applied.comparison == "at least" else abs(value)
    return size / bound - 1 if applied.comparison == "at least" else 1 - size / bound
