"""What may be handed over where a driveline is made: lists as lists, tables as tables. Part of ``model``, for ``driveline``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from modelgen.errors import ModelError

LISTS = {"elements": "[Inertia(...), ...]", "connections": '[("shaft.b", "wheel")]', "balanced": '["load"]'}
TABLES = {"parameters": '{"zeta": 0.02}', "bases": '{"firing": 3}', "assemblies": '{"engine": ["crank"]}', "speeds": '{"sun": 0}'}


def check_kinds(line: Any, where: str) -> None:
    """Raises ModelError for a field of a driveline that is no list, or no table, where it has to be one."""
    for name, example in LISTS.items():
        value = getattr(line, name)
        if isinstance(value, (str, Mapping)) or not isinstance(value, Iterable):
            raise ModelError(where, f"{name} are {value!r:.60}", f"give a list such as {example}")
    for name, example in TABLES.items():
        value = getattr(line, name)
        if not isinstance(value, Mapping):
            raise ModelError(where, f"{name} are {value!r:.60}", f"give a dict such as {example}")
