"""The limit that a run holds its angles against, and the verdict in a form that reports and programs read.

Part of ``cli``; the rule itself, with what is known of it, stands among those of ``analysis``.
"""

from __future__ import annotations

from dataclasses import dataclass

from modelgen.analysis import AnglesResult
from modelgen.analysis.limits.check import LimitRow, check_limits

RULE = "syt_5211_angle"
QUANTITY = "vibration_peak"
"""What the rule judges, in the words of ``summary.json``."""


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


def verdict(found: AnglesResult) -> Verdict | None:
    """The verdict on all inertias; None for a driveline without any."""
    if not found.inertias:
        return None
    rows = sorted(check_limits(found, RULE).rows, key=lambda row: -row.value)
    return Verdict(rows[0], tuple(row for row in rows if row.verdict == "fail"))
