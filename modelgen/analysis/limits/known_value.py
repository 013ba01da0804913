"""A value that limits judge, with what is known of it: its unit, and facts that a rule would otherwise ask for.

Below ``separation`` and ``check``. The mode and order of a critical speed, the diameter and the speed of a stress come from the
model and the command that computed the value; a rule takes them from here, and nobody gives them twice.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


class KnownValue(float):
    """A number in ``unit`` with ``facts`` by name: texts with units, pairs (number, unit) or plain numbers.

    >>> value = KnownValue(0.98, nodes=1, order=6.0)
    >>> value, value.unit, value.facts["order"]
    (0.98, '1', 6.0)
    """

    unit: str
    facts: Mapping[str, Any]

    def __new__(cls, number: float, unit: str = "1", **facts: Any) -> KnownValue:
        """The number with what is known of it."""
        made = super().__new__(cls, number)
        made.unit, made.facts = unit, facts
        return made


def facts_of(value: Any) -> Mapping[str, Any]:
    """What is known of a value; nothing of a plain one."""
    return value.facts if isinstance(value, KnownValue) else {}
