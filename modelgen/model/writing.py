"""Writing model files: a driveline as TOML text that reads back as an equal driveline, value for value.

Part of the language, beside ``files`` that reads them. Numbers are written in SI with the shortest digits that give the same
double again.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from modelgen.errors import refuse_unless
from modelgen.model.chosen_limits import ChosenLimit
from modelgen.model.declarations import Param
from modelgen.model.driveline import Driveline
from modelgen.model.element import Element
from modelgen.model.named import NamedParameter
from modelgen.model.values import Shared

FORMAT = 1


def write_model(line: Driveline, path: str | Path) -> Path:
    """Writes the driveline as a model file, whole or not at all; reading it again gives an equal driveline."""
    refuse_unless(line, Driveline, "write_model")
    path = Path(path)
    text = model_text(line)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    temporary.write_text(text, encoding="utf-8")
    os.replace(temporary, path)
    return path


def model_text(line: Driveline) -> str:
    """The text of a model file for the driveline."""
    import tomli_w  # only writing needs it

    data: dict[str, Any] = {"format": FORMAT, "name": line.name}
    if line.description:
        data["description"] = line.description
    operation: dict[str, Any] = {}
    if line.speed is not None:
        operation["speed"] = f"{line.speed!r} rad/s"
    if line.speeds:
        operation["speeds"] = {name: f"{value!r} rad/s" for name, value in line.speeds.items()}
    if line.reference is not None:
        operation["reference"] = line.reference
    if line.balanced:
        operation["balance"] = list(line.balanced)
    if line.balance_may_drive:
        operation["balance_may_drive"] = True
    if line.drifts:
        operation["drifts"] = True
    if operation:
        data["operation"] = operation
    if line.bases:
        data["bases"] = {k: {"order": str(b.order), **({"shaft": b.shaft} if b.shaft else {})} for k, b in line.bases.items()}
    if line.parameters:
        data["parameters"] = {key: _parameter_data(named) for key, named in line.parameters.items()}
    if line.connections:
        data["connections"] = [list(pair) for pair in line.connections]
    if line.assemblies:
        data["assemblies"] = {key: list(names) for key, names in line.assemblies.items()}
    if line.limits:
        data["limits"] = [_limit_data(limit) for limit in line.limits]
    data["elements"] = {element.name: _element_data(element) for element in line.elements}
    return tomli_w.dumps(data)


def _limit_data(limit: ChosenLimit) -> dict[str, Any]:
    data: dict[str, Any] = {"rule": limit.rule}
    if limit.elements:
        data["elements"] = list(limit.elements)
    if limit.inputs:
        data["inputs"] = dict(limit.inputs)
    return data


def _parameter_data(named: NamedParameter) -> Any:
    if named.expression is not None:
        data: dict[str, Any] = {"expression": named.expression, "unit": named.unit}
    elif isinstance(named.value, tuple):
        data = {"unit": named.unit, "values": list(named.value)}
    else:
        data = {"value": named.value if named.unit == "1" else f"{named.value!r} {named.unit}"}
    if named.note:
        data["note"] = named.note
    return data["value"] if set(data) == {"value"} else data


def _element_data(element: Element) -> dict[str, Any]:
    params = element.declared(Param)
    data: dict[str, Any] = {"kind": element.kind}
    for key, value in element.given().items():
        if isinstance(value, Shared):
            data[key] = value.name
        elif key not in params:
            data[key] = list(value) if isinstance(value, tuple) else value
        elif isinstance(value, tuple):
            data[key] = {"unit": params[key].unit, "values": list(value)}
        elif params[key].unit == "1":
            data[key] = int(value) if params[key].integer else value
        else:
            data[key] = f"{value!r} {params[key].unit}"
    if element.note:
        data["note"] = element.note
    return data
