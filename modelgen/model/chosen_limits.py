"""The limits that a driveline chooses for itself: a rule by name, the elements that it is for, and its inputs.

Part of the language, below ``driveline``; the rules themselves stand among the limits of ``analysis``, which knows their names.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from modelgen.errors import ModelError, nearest

KEYS = ("rule", "elements", "inputs")


@dataclass(frozen=True)
class ChosenLimit:
    """``rule``: the name of a rule, or of a file of rules, all of which are meant; ``elements`` (none: all that it can judge);
    ``inputs``: numbers, or texts with units or choices, by name.

    >>> ChosenLimit("iacs_m68", ("intermediate_shaft",), {"tensile_strength": "600 MPa"}).rule
    'iacs_m68'
    """

    rule: str
    elements: tuple[str, ...] = ()
    inputs: Mapping[str, float | str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        where = f"limit {self.rule!r:.60}"
        if not isinstance(self.rule, str) or not self.rule:
            raise ModelError(where, "names no rule", 'write rule = "syt_5211_angle"; modelgen limits --list names them')
        if isinstance(self.elements, str) or not all(isinstance(each, str) for each in self.elements):
            raise ModelError(where, f"is for the elements {self.elements!r:.60}", 'give a list of names, such as ["shaft"]')
        if not isinstance(self.inputs, Mapping):
            raise ModelError(
                where, f"has the inputs {self.inputs!r:.60}", 'give a table, such as { tensile_strength = "600 MPa" }'
            )
        for key, value in self.inputs.items():
            if isinstance(value, bool) or not isinstance(value, (int, float, str)):
                raise ModelError(f"{where}, {key}", f"is {value!r:.60}", "give a number or a text with a unit")
        object.__setattr__(self, "elements", tuple(self.elements))
        object.__setattr__(self, "inputs", MappingProxyType(dict(self.inputs)))

    def renamed(self, names: Mapping[str, str]) -> ChosenLimit:
        """The same for elements with other names."""
        return ChosenLimit(self.rule, tuple(names.get(each, each) for each in self.elements), self.inputs)


def chosen_limits(values: Any) -> tuple[ChosenLimit, ...]:
    """Limits from a list of rules' names and mappings, or from one of them. Raises ModelError for anything else."""
    if isinstance(values, (str, Mapping, ChosenLimit)):
        values = (values,)
    if not isinstance(values, (list, tuple)):
        raise ModelError("limits", f"are {values!r:.60}", 'give a list, such as [{"rule": "syt_5211_angle"}]')
    return tuple(chosen_limit(each) for each in values)


def chosen_limit(value: Any) -> ChosenLimit:
    """A limit from a rule's name, or a mapping with ``rule``, ``elements`` and ``inputs``. Raises ModelError."""
    if isinstance(value, ChosenLimit):
        return value
    if isinstance(value, str):
        return ChosenLimit(value)
    if not isinstance(value, Mapping):
        raise ModelError("limits", f"hold {value!r:.60}", 'give {"rule": "syt_5211_angle"}, or the name of a rule')
    for key in value:
        if key not in KEYS:
            raise ModelError("limits", f"hold an unknown key {key!r}", nearest(str(key), KEYS))
    return ChosenLimit(value.get("rule", ""), value.get("elements", ()), value.get("inputs", {}))
