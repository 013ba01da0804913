"""Model files: a driveline as TOML text with units, read strictly; ``writing`` writes them without loss.

Part of the language. A file holds ``format = 1``, the operating point, shared parameters, base frequencies, defaults per kind of
element, and one table per element whose ``kind`` comes from the vocabulary; it can never name a Python module. Numbers
with a dimension carry a unit text; nothing in a file is ever evaluated, expressions are read by an allow-list.
"""

from __future__ import annotations

import math
import re
import stat
import tomllib
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from modelgen.errors import ModelFileError, ModelgenError, nearest
from modelgen.model.chosen_limits import KEYS, ChosenLimit, chosen_limit
from modelgen.model.declarations import Choice, Param, Switched
from modelgen.model.driveline import Driveline
from modelgen.model.element import Element
from modelgen.model.named import BaseFrequency, NamedParameter, base_frequency
from modelgen.model.nesting import DEEPEST, nesting
from modelgen.model.values import plain_number
from modelgen.model.writing import FORMAT, model_text, write_model
from modelgen.units import read_any, to_si

__all__ = ["model_text", "parse_model", "read_model", "write_model"]

LARGEST_FILE = 1024 * 1024
_TABLES = (
    "format",
    "name",
    "description",
    "operation",
    "parameters",
    "bases",
    "defaults",
    "elements",
    "connections",
    "assemblies",
    "limits",
)
_OPERATION = ("speed", "reference", "balance", "drifts", "balance_may_drive", "speeds")


def read_model(path: str | Path) -> Driveline:
    """The driveline in a model file. Raises ModelFileError with file, line and remedy for anything that is not lawful."""
    if not isinstance(path, (str, PathLike)):
        raise ModelFileError("read_model", f"is given {type(path).__name__}", "give the path of a model file")
    path = Path(path)
    try:
        # A pipe or a device could be endless, or wait for ever.
        if not stat.S_ISREG(path.stat().st_mode):
            raise ModelFileError(str(path), "is no file", "give a model file")
        with path.open("rb") as file:
            raw = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise ModelFileError(str(path), f"cannot be read: {error.strerror}", "check the path") from None
    if len(raw) > LARGEST_FILE:
        raise ModelFileError(str(path), f"has more than {LARGEST_FILE} bytes", "model files are small: is this one?")
    try:
        text = raw.decode("utf-8-sig")  # some editors of Windows write a mark at the beginning
    except UnicodeDecodeError as error:
        raise ModelFileError(str(path), f"is not UTF-8 text at byte {error.start}", "save it as UTF-8") from None
    return parse_model(text, str(path))


def parse_model(text: str, source: str = "model text") -> Driveline:
    """The driveline in the text of a model file; ``source`` opens the error messages."""
    if nesting(text) > DEEPEST:
        raise ModelFileError(source, f"nests deeper than {DEEPEST}", "model files are flat")
    try:
        data = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        raise ModelFileError(source, f"is not TOML: {error}", "see toml.io") from None
    return _Reader(data, text, source).driveline()


class _Reader:
    def __init__(self, data: dict[str, Any], text: str, source: str) -> None:
        self.data, self.text, self.source = data, text, source

    def at(self, *keys: str) -> str:
        """File, line and table for a message."""
        line = ""
        for count in range(len(keys), 0, -1):
            header = r"\s*\.\s*".join(map(_key, keys[:count]))
            found = re.search(rf"^[ \t]*(?:\[\s*{header}\s*\]|{header}\s*=)", self.text, re.MULTILINE)
            if found:
                inner = re.compile(rf"^[ \t]*{_key(keys[count])}\s*=", re.MULTILINE) if count < len(keys) else None
                end = ((inner and inner.search(self.text, found.end())) or found).end()
                line = f", line {self.text.count(chr(10), 0, end) + 1}"
                break
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
        if type(data.get("format")) is not int or data["format"] != FORMAT:
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
                speed=self.speed(operation.get("speed"), "operation", "speed"),
                speeds=self.speeds(operation),
                reference=self.text_of(operation, "reference", None, "operation") if "reference" in operation else None,
                bases={k: self.base(k, v) for k, v in self.table(data.get("bases", {}), "bases").items()},
                balanced=tuple(map(str, self.list_of(operation.get("balance", []), "operation", "balance"))),
                drifts=self.switch(operation, "drifts"),
                balance_may_drive=self.switch(operation, "balance_may_drive"),
                assemblies={k: self.assembly(k, v) for k, v in self.table(data.get("assemblies", {}), "assemblies").items()},
                limits=tuple(map(self.limit, self.list_of(data.get("limits", []), "limits"))),
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
        if len(keys) > DEEPEST:
            raise self.refuse(keys[:1], f"nests deeper than {DEEPEST}", "model files are flat")
        if isinstance(value, dict):
            for key, entry in value.items():
                self.finite(entry, (*keys, key))
        elif isinstance(value, list):
            for entry in value:
                self.finite(entry, keys)

    def text_of(self, table: Mapping[str, Any], key: str, default: str | None = None, *keys: str) -> str:
        value = table.get(key, default)
        if not isinstance(value, str):
            raise self.refuse((*keys, key), f"is {value!r:.60}" if key in table else "is missing", f'write {key} = "..."')
        return value

    def list_of(self, value: Any, *keys: str) -> list[Any]:
        if not isinstance(value, list):
            raise self.refuse(keys, f"holds {value!r:.60}", "write a list")
        return value

    def limit(self, value: Any) -> ChosenLimit:
        table = self.table(value, "limits")
        self.known(table, KEYS, "limits")
        self.text_of(table, "rule", None, "limits")
        self.list_of(table.get("elements", []), "limits", "elements")
        return chosen_limit(table)

    def pair(self, value: Any) -> tuple[str, str]:
        if not (isinstance(value, list) and len(value) == 2 and all(isinstance(each, str) for each in value)):
            raise self.refuse(("connections",), f"holds {value!r}", 'write pairs such as ["shaft.b", "wheel"]')
        return value[0], value[1]

    def speed(self, speed: Any, *keys: str) -> Any:
        if speed is not None and not isinstance(speed, str):
            raise self.refuse(keys, f"is {speed!r}", 'give it with a unit, such as "1900 rpm"')
        return speed

    def speeds(self, operation: Mapping[str, Any]) -> dict[str, Any]:
        given = self.table(operation.get("speeds", {}), "operation", "speeds")
        return {name: 0.0 if value == 0 else self.speed(value, "operation", "speeds", name) for name, value in given.items()}

    def switch(self, operation: Mapping[str, Any], key: str) -> bool:
        value = operation.get(key, False)
        if not isinstance(value, bool):
            raise self.refuse(("operation", key), f"is {value!r}", "write true or false")
        return value

    def assembly(self, key: str, value: Any) -> tuple[str, ...]:
        if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
            raise self.refuse(("assemblies", key), f"holds {value!r}", "write a list of names of elements")
        return tuple(value)

    def base(self, key: str, value: Any) -> BaseFrequency:
        table = self.table(value, "bases", key)
        self.known(table, ("order", "shaft"), "bases", key)
        order = table.get("order")
        if isinstance(order, bool) or not isinstance(order, (int, str)):
            raise self.refuse(
                ("bases", key, "order"),
                f"is {order!r}" if "order" in table else "is missing",
                'write a whole number or a fraction such as "1/2"',
            )
        return base_frequency(key, (table.get("shaft"), order))

    def parameter(self, key: str, value: Any) -> NamedParameter:
        keys, where = ("parameters", key), f"parameter {key!r}"
        note, unit = "", "1"
        if isinstance(value, dict):
            self.known(value, ("value", "values", "unit", "expression", "note"), *keys)
            if len(value.keys() & {"value", "values", "expression"}) != 1:
                raise self.refuse(keys, "does not hold one of value, values and expression", "give exactly one of them")
            note, unit = self.text_of(value, "note", "", *keys), self.text_of(value, "unit", "1", *keys)
            if "expression" in value:
                return NamedParameter(0.0, unit, self.text_of(value, "expression", None, *keys), note)
            if "values" in value:
                si = "1" if unit == "1" else read_any(f"1 {unit}", where)[1]
                return NamedParameter(self.series(value, si, keys), si, None, note)
            value = value["value"]
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            raise self.refuse(keys, f"is {value!r:.60}", "give a number, a text with a unit, or a table")
        if isinstance(value, str) and unit != "1":
            raise self.refuse(keys, f"has the unit {unit!r} beside the text {value!r}", "give the unit once")
        number = value if isinstance(value, str) else plain_number(value, where)
        si_value, si = read_any(number if isinstance(number, str) else f"{number!r} {unit if unit != '1' else ''}", where)
        return NamedParameter(si_value, si, None, note)

    def series(self, table: Mapping[str, Any], si: str, keys: tuple[str, ...]) -> tuple[float, ...]:
        values, unit = table["values"], self.text_of(table, "unit", "1", *keys)
        if not isinstance(values, list) or not all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values):
            raise self.refuse(keys, "values is no list of numbers", "write values = [1.0, 2.0]")
        where = f"{keys[-1]!r}"
        return tuple(to_si(plain_number(v, where), "" if unit == "1" else unit, si, where) for v in values)

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
            raise self.refuse(
                keys, f"kind is {kind!r:.60}" if "kind" in table else "kind is missing", nearest(str(kind), Element.vocabulary)
            )
        cls = Element.vocabulary[kind]
        given = {**self.usual(cls, table, defaults.get(kind, {})), **table}
        del given["kind"]
        note = self.text_of({"note": given.pop("note", "")}, "note", None, *keys)
        params = cls.declared(Param)
        try:
            given = {
                key: self.value(params[key], value, (*keys, key)) if key in params else value for key, value in given.items()
            }
            return cls(name, note=note, **given)
        except ModelFileError:
            raise
        except ModelgenError as error:
            raise ModelFileError(self.at(*keys), f"{error.where}: {error.problem}", error.remedy) from None

    def usual(self, cls: type[Element], table: Mapping[str, Any], defaults: Mapping[str, Any]) -> dict[str, Any]:
        """The defaults of a kind that this element can use: its own switches may leave some of them out."""
        chosen = {key: table.get(key, defaults.get(key, choice.default)) for key, choice in cls.declared(Choice).items()}
        switched = cls.declared(Switched)
        return {key: value for key, value in defaults.items() if key not in switched or switched[key].exists(chosen)}

    def value(self, param: Param, value: Any, keys: tuple[str, ...]) -> Any:
        """What the class can read: it takes bare numbers as SI, but in a file a number with a dimension names its unit."""
        if isinstance(value, dict):
            self.known(value, ("values", "unit"), *keys)
            if "values" not in value:
                raise self.refuse(keys, "has no values", f'write {{ unit = "{param.unit}", values = [...] }}')
            return self.series(value, param.unit, keys)
        if isinstance(value, (int, float)) and not isinstance(value, bool) and param.unit != "1":
            raise self.refuse(keys, f"{value!r:.60} has no unit", f'write "{value!r:.60} {param.unit}"')
        if isinstance(value, list) and param.unit != "1" and not all(isinstance(entry, str) for entry in value):
            raise self.refuse(keys, "has no unit", f'write {{ unit = "{param.unit}", values = [...] }}')
        return value


def _key(text: str) -> str:
    """A pattern for a key of TOML, bare or in quotes."""
    return rf"[\"']?{re.escape(text)}[\"']?"
