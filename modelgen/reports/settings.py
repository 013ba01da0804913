"""The model as it is run: a driveline with the options of the command line applied to it.

Part of ``reports``. Everything ends in the driveline itself, so that the ``model.toml`` of a run says what was run.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from modelgen.errors import CaseError, NamingError, nearest
from modelgen.model import Choice, Clock, Driveline, Element, Flange, NamedParameter, Orders, Param, Shared
from modelgen.units import read_quantity

FIXED, SCALED = 0.1, "0.1*{zeta}/0.035"
"""The two readings of the mesh damping ratio over a sweep of the shafts' zeta: the paper's value, or one that follows zeta."""


def settle(
    line: Driveline,
    assignments: Iterable[str] = (),
    speed: str | None = None,
    damping: str | None = None,
    mesh_damping: str | None = None,
    mesh_reading: str | None = None,
) -> Driveline:
    """The driveline with ``NAME=VALUE`` assignments and named switches applied. Raises NamingError, ModelError or UnitError."""
    of_line, of_elements = _read(line, assignments)
    if speed is not None:
        of_line["speed"] = speed
    for kind, value in (("shaft", damping), ("gear_pair", mesh_damping)):
        if value is not None:
            chosen = [element.name for element in line.elements if element.kind == kind]
            if not chosen:
                problem = f"has no {kind}, whose damping could be {value!r}"
                raise CaseError(f"driveline {line.name!r}", problem, "leave the option out")
            for name in chosen:
                of_elements.setdefault(name, {}).setdefault("damping", value)  # what --set names is the more particular
    elements = tuple(each.copy(**of_elements[each.name]) if each.name in of_elements else each for each in line.elements)
    line = replace(line, elements=elements).set(**{name: _value(line, name, text) for name, text in of_line.items()})
    if mesh_reading is not None:
        line = _read_mesh_damping(line, mesh_reading, of_line)
    return line


def _read_mesh_damping(line: Driveline, reading: str, of_line: Mapping[str, str]) -> Driveline:
    """The driveline with the gear pairs' damping ratio fixed, or scaled with that of the shafts."""
    zeta, xi = (common_ratio(line, kind) for kind in ("shaft", "gear_pair"))
    if not isinstance(zeta, str) or not isinstance(xi, str):
        problem = "does not share one damping ratio among its shafts and another among its gear pairs"
        raise CaseError(f"driveline {line.name!r}", problem, "name both as parameters, such as zeta and xi")
    if reading == "fixed":
        return line if line.parameters[xi].expression is None else line.set(**{xi: FIXED})
    if xi in of_line:
        raise CaseError(f"--set {xi}", "is given, and the scaled reading of the mesh damping sets it too", "leave one out")
    return line.set(**{xi: NamedParameter(expression=SCALED.format(zeta=zeta))})


def common_ratio(line: Driveline, kind: str) -> str | float | None:
    """The damping ratio of every element of a kind: the parameter they share, or their common value; None if they differ."""
    held = [each.values.get("damping_ratio") for each in line.elements if each.kind == kind]
    ratios = {ratio.name if isinstance(ratio, Shared) else ratio for ratio in held}
    only = ratios.pop() if len(ratios) == 1 else None
    return only if isinstance(only, (str, float)) else None


def common_switch(line: Driveline, kind: str, switch: str = "damping") -> str | None:
    """The setting of a switch of every element of a kind; None if there is none or they differ."""
    settings = {each.choices[switch] for each in line.elements if each.kind == kind}
    return settings.pop() if len(settings) == 1 else None


def _read(line: Driveline, assignments: Iterable[str]) -> tuple[dict[str, str], dict[str, dict[str, Any]]]:
    """Assignments to the driveline's own parameters, and to each element's."""
    of_line: dict[str, str] = {}
    of_elements: dict[str, dict[str, Any]] = {}
    for text in assignments:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            example = '--set zeta=0.02 or --set coupling.stiffness="4e5 N*m/rad"'
            raise CaseError(f"--set {text!r}", "is no assignment", f"write NAME=VALUE, such as {example}")
        owner, dot, key = name.partition(".")
        if not dot:
            _known_parameter(line, name)
            of_line[name] = value
            continue
        chosen = [element for element in line.elements if owner in (element.name, element.kind)]
        if not chosen:
            known = [*line.names, *dict.fromkeys(element.kind for element in line.elements)]
            raise NamingError(f"--set {name}", f"there is no element or kind {owner!r}", nearest(owner, known))
        for element in chosen:
            known = _settable(element)
            if key.partition("[")[0] not in known:
                raise NamingError(f"--set {name}", f"{element.where} has no parameter {key!r}", nearest(key, known))
            of_elements.setdefault(element.name, {})[key] = _listed(element, key, value)
    return of_line, of_elements


def _settable(element: Element) -> list[str]:
    """Names of everything that an element can be given."""
    declared = (element.declared(Param), element.declared(Choice), element.declared(Clock), element.declared(Orders))
    return [name for group in (*declared, element.declared(Flange)) for name in group]


def _listed(element: Element, key: str, text: str) -> Any:
    """Orders and series as lists of what stands between commas; anything else as it is given."""
    if key in element.declared(Orders):
        parts = [part.strip() for part in text.split(",")]
        return [int(part) for part in parts] if all(part.isdecimal() for part in parts) else text
    param = element.declared(Param).get(key)
    if param is not None and param.series and any(character.isdigit() for character in text.partition(" ")[0]):
        return [part.strip() for part in text.split(",")]
    return text


def _known_parameter(line: Driveline, name: str) -> None:
    if name == "speed" or name.partition("[")[0] in line.parameters:
        return
    own = [f"{element.name}.{key}" for element in line.elements for key in element.values]
    hint = nearest(name, ["speed", *line.parameters, *own])
    raise NamingError(f"--set {name}", f"driveline {line.name!r} has no parameter {name!r}", hint)


def _value(line: Driveline, name: str, text: str) -> Any:
    """A value in the unit that the parameter has; a speed keeps its text, which names its unit."""
    if name == "speed":
        return text
    old = line.parameters[name.partition("[")[0]]
    if isinstance(old.value, tuple) and "[" not in name:
        what = f"is a series of {len(old.value)} numbers"
        raise CaseError(f"--set {name}", what, f"change it in the model file, or a row of it, such as {name}[1]")
    return read_quantity(text, old.unit, f"--set {name}")
