"""The limits that a model chooses, held against a run, in a form that reports and programs read.

Part of ``reports``; the rules themselves, with what is known of them, stand among those of ``analysis``. A model that chooses
no rule is held against none.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from modelgen.analysis.limits.check import LimitRow, LimitsResult, check_limits
from modelgen.analysis.limits.rulebook import chosen_rules
from modelgen.errors import CaseError
from modelgen.reports.diameters import diameters
from modelgen.reports.limit_values import SEPARATION, response_values, separation_values
from modelgen.reports.response import Response

ANGLE = "vibration_angle"
QUANTITY = "vibration_peak"
"""What a rule for angles judges, in the words of ``summary.json``."""


@dataclass(frozen=True)
class Verdict:
    """The inertia with the largest angle, and all whose angle exceeds the limit, largest first; values in degrees."""

    worst: LimitRow
    exceeding: tuple[LimitRow, ...]

    @property
    def ok(self) -> bool:
        """Whether no angle exceeds the limit."""
        return not self.exceeding

    @property
    def limit(self) -> float:
        """The limit [deg]."""
        return self.worst.limits[0]


def judged(response: Response) -> LimitsResult | None:
    """Every rule that the model chooses, held against the run; None where it chooses none.

    What a rule lacks to be judged is a remark, no refusal: the run is done.
    """
    line, model = response.line, response.model
    chosen = chosen_rules(line.limits)
    if not chosen:
        return None
    values = response_values(response, diameters(line, model))
    if any(each.quantity in SEPARATION for each in chosen):
        orders = [order for each in chosen for order in each.orders_meant()]
        values |= separation_values(model, None, 0.01, response.request.rated, orders)
    rows: list[LimitRow] = []
    remarks: list[str] = []
    for each in chosen:
        try:
            found = check_limits(values, each, line.name)
        except CaseError as error:
            remarks.append(f"not judged: {error}")
        else:
            rows += found.rows
            remarks += found.remarks
    return replace(LimitsResult(line.name, tuple(rows)), remarks=tuple(remarks))


def verdict(found: LimitsResult | None) -> Verdict | None:
    """The verdict on the angles of all inertias by the first rule chosen for them; None where none is, or nothing to judge."""
    angles = [row for row in found.rows if row.quantity == ANGLE] if found else []
    rows = sorted((row for row in angles if row.rule == angles[0].rule), key=lambda row: -row.value)
    return Verdict(rows[0], tuple(row for row in rows if row.verdict == "fail")) if rows else None
