"""Model files: a driveline as TOML text with units, read strictly and written without loss.

Part of the language. A file holds ``format = 1``, the operating point, shared parameters, base frequencies, defaults per kind of
element, and one table per element whose ``kind`` comes from the vocabulary; it can never name a Python module. Numbers
with a dimension carry a unit text; nothing in a file is ever evaluated, expressions are read by an allow-list.
"""

from __future__ import annotations

import math
import os
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from modelgen.errors import ModelFileError, ModelgenError, nearest
from modelgen.model.declarations import Param
from modelgen.model.driveline import BaseFrequency, Driveline, NamedParameter, base_frequency
from modelgen.model.element import Element, Shared
from modelgen.units import read_any, to_si

FORMAT = 1
LARGEST_FILE = 1024 * 1024
DEEPEST = 32
_TABLES = ("format", "name", "description", "operation", "parameters", "bases", "defaults", "elements", "connections", "assemblies")
_OPERATION = ("speed", "reference", "balance", "drifts")


def read_model(path: str | Path) -> Driveline:
    """The driveline in a model file. Raises ModelFileError with file, line and remedy for anything that is not lawful."""
    path = Path(path)
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise ModelFileError(str(path), f"has {path.stat().st_size} bytes", f"model files have at most {LARGEST_FILE}")
        raw = path.read_bytes()
    except OSError as error:
        raise ModelFileError(str(path), f"cannot be read: {error.strerror}", "check the path") from None
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError as error:
        raise ModelFileError(str(path), f"is not UTF-8 text at byte {error.start}", "save it as UTF-8") from None
    return parse_model(text, str(path))


def parse_model(text: str, source: str = "model text") -> Driveline:
    """The driveline in the text of a model file; ``source`` opens the error messages."""
    if _depth(text) > DEEPEST:
        raise ModelFileError(source, f"nests deeper than {DEEPEST}", "model files are flat")
    try:
        data = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        raise ModelFileError(source, f"is not TOML: {error}", "see toml.io") from None
    return _Reader(data, text, source).driveline()


def _depth(text: str) -> int:
    """An upper bound of the nesting of arrays and inline tables."""
    depth = deepest = 0
    for character in text:
        depth = max(0, depth + (character in "[{") - (character in "]}"))
        deepest = max(deepest, depth)
    return deepest


class _Reader:
    def __init__(self, data: dict[str, Any], text: str, source: str) -> None:
        self.data, self.text, self.source = data, text, source

    def at(self, *keys: str) -> str:
        """File, line and table for a message."""
        header = re.escape(".".join(keys)) if keys else ""
        found = re.search(rf"^\s*\[\s*{header}\s*\]|^\s*{header}\s*=", self.text, re.MULTILINE) if keys else None
        line = f", line {self.text.count(chr(10), 0, found.end()) + 1}" if found else ""
        return f"{self.source}{line}" + (f", [{'.'.join(keys)}]" if keys else "")

    def refuse(self, keys: tuple[str, ...], problem: str, remedy: str) -> ModelFileError:
        return ModelFileError(self.at(*keys), problem, remedy)

    def known(self, table: Mapping[str, Any], names: tuple[str, ...], *keys: str) -> None:
        for key in table:
            if key not in names:
                raise self.refuse(keys, f"has an unknown key {key!r}", nearest(key, names))

    def table(self, value: Any, *keys: str) -> dict[str, Any]:
        if not isinstance(value, dict):
            raise self.refuse(keys, f"is {type(value).__name__} {str(value)[:40]!r}", "write it as a table")
        return value

    def driveline(self) -> Driveline:
        data = self.data
        if data.get("format") != FORMAT or isinstance(data.get("format"), bool):
            found = f"has format {data['format']!r}" if "format" in data else "has no format"
            raise self.refuse((), found, f"write format = {FORMAT} at the top")
        self.known(data, _TABLES)
        self.finite(data, ())
        operation = self.table(data.get("operation", {}), "operation")
        self.known(operation, _OPERATION, "operation")
        elements = self.elements()
        try:
            return Driveline(
                name=self.text_of(data, "name"),
                description=self.text_of(data, "description", ""),
                elements=tuple(elements),
                connections=tuple(self.pair(each) for each in self.list_of(data.get("connections", []), "connections")),
                parameters={k: self.parameter(k, v) for k, v in self.table(data.get("parameters", {}), "parameters").items()},
                speed=self.speed(operation),
                reference=operation.get("reference"),
                bases={k: self.base(k, v) for k, v in self.table(data.get("bases", {}), "bases").items()},
                balanced=tuple(map(str, self.list_of(operation.get("balance", []), "operation"))),
                drifts=operation.get("drifts") is True,
                assemblies={k: tuple(v) for k, v in self.table(data.get("assemblies", {}), "assemblies").items()},
            )
        except ModelFileError:
            raise
        except ModelgenError as error:
            raise ModelFileError(f"{self.source}: {error.where}", error.problem, error.remedy) from None

    def finite(self, value: Any, keys: tuple[str, ...]) -> None:
        if isinstance(value, float) and not math.isfinite(value):
            raise self.refuse(keys, f"holds {value}", "give finite numbers")
        if not isinstance(value, (dict, list, str, int, float)):
            raise self.refuse(keys, f"holds a {type(value).__name__}", "give numbers, texts and tables")
        for key, entry in value.items() if isinstance(value, dict) else ((None, e) for e in value) if isinstance(value, list) else ():
            self.finite(entry, (*keys, key) if key else keys)

    def text_of(self, table: Mapping[str, Any], key: str, default: str | None = None) -> str:
        value = table.get(key, default)
        if not isinstance(value, str):
            raise self.refuse((), f"{key} is {value!r}" if key in table else f"{key} is missing", f'write {key} = "..."')
        return value

    def list_of(self, value: Any, *keys: str) -> list[Any]:
        if not isinstance(value, list):
            raise self.refuse(keys, f"holds {value!r}", "write a list")
        return value

    def pair(self, value: Any) -> tuple[str, str]:
        if not (isinstance(value, list) and len(value) == 2 and all(isinstance(each, str) for each in value)):
            raise self.refuse(("connections",), f"holds {value!r}", 'write pairs such as ["shaft.b", "wheel"]')
        return value[0], value[1]

    def speed(self, operation: Mapping[str, Any]) -> Any:
        speed = operation.get("speed")
        if speed is not None and not isinstance(speed, str):
            raise self.refuse(("operation",), f"speed is {speed!r}", 'give it with a unit, such as "1900 rpm"')
        return speed

    def base(self, key: str, value: Any) -> BaseFrequency:
        table = self.table(value, "bases", key)
        self.known(table, ("order", "shaft"), "bases", key)
        order = table.get("order")
        if isinstance(order, bool) or not isinstance(order, (int, str)):
            raise self.refuse(("bases", key), f"order is {order!r}", 'write a whole number or a fraction such as "1/2"')
        return base_frequency(key, (table.get("shaft"), order))

    def parameter(self, key: str, value: Any) -> NamedParameter:
        keys = ("parameters", key)
        where = f"{self.source}, parameter {key!r}"
        if isinstance(value, dict):
            self.known(value, ("value", "values", "unit", "expression", "note"), *keys)
            note, unit = str(value.get("note", "")), str(value.get("unit", "1"))
            if "expression" in value:
                return NamedParameter(0.0, unit, self.text_of(value, "expression"), note)
            if "values" in value:
                si = "1" if unit == "1" else read_any(f"1 {unit}", where)[1]
                return NamedParameter(self.series(value, si, where), si, None, note)
            named = self.parameter(key, value.get("value"))
            return NamedParameter(named.value, named.unit, None, note)
        if isinstance(value, str):
            number, unit = read_any(value, where)
            return NamedParameter(number, unit)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self.refuse(keys, f"is {value!r}", "give a number, a text with a unit, or a table")
        return NamedParameter(float(value))

    def series(self, table: Mapping[str, Any], si: str, where: str) -> tuple[float, ...]:
        values, unit = table["values"], str(table.get("unit", "1"))
        if not isinstance(values, list) or not all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values):
            raise ModelFileError(where, "values is no list of numbers", "write values = [1.0, 2.0]")
        return tuple(to_si(float(v), "" if unit == "1" else unit, si, where) for v in values)

    # -- elements --------------------------------------------------------------------------------------------------------------

    def elements(self) -> list[Element]:
        defaults = self.table(self.data.get("defaults", {}), "defaults")
        for kind, table in defaults.items():
            if kind not in Element.vocabulary:
                raise self.refuse(("defaults", kind), f"{kind!r} is no kind of element", nearest(kind, Element.vocabulary))
            self.table(table, "defaults", kind)
        tables = self.table(self.data.get("elements", {}), "elements")
        return [self.element(name, self.table(table, "elements", name), defaults) for name, table in tables.items()]

    def element(self, name: str, table: dict[str, Any], defaults: Mapping[str, dict[str, Any]]) -> Element:
        keys = ("elements", name)
        kind = table.get("kind")
        if not isinstance(kind, str) or kind not in Element.vocabulary:
            raise self.refuse(keys, f"kind is {kind!r}", nearest(str(kind), Element.vocabulary))
        cls = Element.vocabulary[kind]
        given = {**defaults.get(kind, {}), **table}
        del given["kind"]
        note = given.pop("note", "")
        params = cls.declared(Param)
        for key, value in given.items():
            if key in params:
                given[key] = self.value(params[key], value, f"{self.source}, element {name!r}, {key}")
            elif not isinstance(value, (str, list)) or key == "name":
                raise self.refuse(keys, f"{key} is {value!r}", "see the element's parameters")
        try:
            return cls(name, note=str(note), **given)
        except ModelgenError as error:
            raise ModelFileError(self.at(*keys), f"{error.where}: {error.problem}", error.remedy) from None

    def value(self, param: Param, value: Any, where: str) -> Any:
        if isinstance(value, dict):
            self.known(value, ("values", "unit"))
            if "values" not in value:
                raise ModelFileError(where, "has no values", f'write {{ unit = "{param.unit}", values = [...] }}')
            return self.series(value, param.unit, where)
        if isinstance(value, (int, float)) and not isinstance(value, bool) and param.unit != "1":
            raise ModelFileError(where, f"{value!r} has no unit", f'write "{value!r} {param.unit}"')
        if isinstance(value, list) and param.unit != "1":
            raise ModelFileError(where, "has no unit", f'write {{ unit = "{param.unit}", values = {value!r} }}')
        return value


# -- writing ---------------------------------------------------------------------------------------------------------------------


def write_model(line: Driveline, path: str | Path) -> Path:
    """Writes the driveline as a model file, whole or not at all; reading it again gives an equal driveline."""
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
    if line.reference is not None:
        operation["reference"] = line.reference
    if line.balanced:
        operation["balance"] = list(line.balanced)
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
    data["elements"] = {element.name: _element_data(element) for element in line.elements}
    return tomli_w.dumps(data)


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

