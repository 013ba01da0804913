"""What a driveline consists of when it is drawn: disks, torques and ground on each node, shafts and wheels between nodes.

From ``Equations`` to ``drawing``. Elements are told apart by their laws, not by their names, so that elements somebody else
has defined are drawn too: what has an inertia is a disk, what supplies power is a torque, what has teeth is a pair of wheels.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from modelgen.equations.records import Equations, Instance
from modelgen.plots.quantities import Display, display, quantity_text

SIZES = ("stiffness", "damping", "damping_coefficient")
"""Parameters that say most about an element to ground; the first one it has is printed."""


@dataclass(frozen=True)
class Disk:
    """An inertia: its name and moment of inertia [kg*m^2], None where it is no plain number."""

    name: str
    inertia: float | None


@dataclass(frozen=True)
class Arrow:
    """An applied torque; ``drives`` says whether its mean turns forward."""

    name: str
    drives: bool


@dataclass(frozen=True)
class Anchor:
    """An element between a node and ground; ``springs`` where it sees the angle, else it sees the speed only."""

    name: str
    springs: bool
    size: str


@dataclass(frozen=True)
class Shaft:
    """Any element between two nodes of a shaft line; ``stiffness`` [N*m/rad], None where it has no such number."""

    name: str
    stiffness: float | None


@dataclass(frozen=True)
class Wheels:
    """A gear pair with its tooth numbers, 0 where it has none."""

    name: str
    first: int
    second: int
    teeth: tuple[int, int]


@dataclass(frozen=True)
class Parts:
    """All of them: by node, by name for what joins two nodes; ``rpm`` of each node, empty without an operating speed."""

    disks: Mapping[int, tuple[Disk, ...]]
    arrows: Mapping[int, tuple[Arrow, ...]]
    anchors: Mapping[int, tuple[Anchor, ...]]
    shafts: Mapping[str, Shaft]
    wheels: Mapping[str, Wheels]
    rpm: Mapping[int, float]

    @property
    def stiffness(self) -> Display:
        """One unit for the stiffness of all shafts, by the middle one of them."""
        known = sorted(shaft.stiffness for shaft in self.shafts.values() if shaft.stiffness)
        return display("N*m/rad", known[len(known) // 2] if known else 1.0)


class Values:
    """Parameter values of the elements of a driveline, as the model states them."""

    def __init__(self, equations: Equations) -> None:
        self.equations = equations
        self.value = {s: v for p in equations.parameters for s, v in zip(p.symbols, p.values, strict=True)}
        self.unit = {s: p.unit for p in equations.parameters for s in p.symbols}

    def number(self, expression: Any) -> float | None:
        """Value of an expression in the driveline's parameters; None where it depends on more than these."""
        known = expression.xreplace({s: self.value[s] for s in expression.free_symbols if s in self.value})
        return None if getattr(known, "free_symbols", None) else float(known)

    def of(self, instance: Instance, name: str) -> tuple[float, str] | None:
        """Value and unit of a parameter of an element, None where it has no such number."""
        for key, symbols in self.equations.templates[instance.template].parameters:
            if key == name and len(symbols) == 1:
                symbol = instance.symbols[symbols[0]]
                return (self.value[symbol], self.unit[symbol]) if symbol in self.value else None
        return None

    def size(self, instance: Instance) -> str:
        """The most telling parameter as text, empty where there is none."""
        found = next((entry for name in SIZES if (entry := self.of(instance, name)) is not None), None)
        return quantity_text(*found) if found else ""


def parts(equations: Equations) -> Parts:
    """What stands on every node of a driveline and between them."""
    values = Values(equations)
    disks: dict[int, tuple[Disk, ...]] = {}
    arrows: dict[int, tuple[Arrow, ...]] = {}
    anchors: dict[int, tuple[Anchor, ...]] = {}
    shafts: dict[str, Shaft] = {}
    wheels: dict[str, Wheels] = {}
    for instance in equations.instances:
        template = equations.templates[instance.template]
        nodes = list(instance.nodes.values())
        for (flange, other), mass in template.mass.items():
            if flange == other:
                node = instance.nodes[flange]
                disks[node] = (*disks.get(node, ()), Disk(instance.name, values.number(mass.xreplace(dict(instance.symbols)))))
        if len(nodes) > 1:
            teeth = [values.of(instance, name) for name in ("teeth_a", "teeth_b")]
            counts = (int(teeth[0][0]), int(teeth[1][0])) if teeth[0] and teeth[1] else (0, 0)
            wheels[instance.name] = Wheels(instance.name, nodes[0], nodes[1], counts)
            stiffness = values.of(instance, "stiffness")
            shafts[instance.name] = Shaft(instance.name, stiffness[0] if stiffness else None)
        elif template.supplied_power != 0:
            arrows[nodes[0]] = (*arrows.get(nodes[0], ()), Arrow(instance.name, _drives(values, instance)))
        elif not template.mass:
            springs = bool(template.absolute_angles) or any(relative.sees_angle for relative in template.relatives)
            anchor = Anchor(instance.name, springs, values.size(instance))
            anchors[nodes[0]] = (*anchors.get(nodes[0], ()), anchor)
    return Parts(disks, arrows, anchors, shafts, wheels, _speeds(equations, values))


def _drives(values: Values, instance: Instance) -> bool:
    mean, scale = (values.of(instance, name) for name in ("mean", "scale"))
    mean = mean or values.of(instance, "after")
    return (mean[0] if mean else 1.0) * (scale[0] if scale else 1.0) >= 0


def _speeds(equations: Equations, values: Values) -> dict[int, float]:
    if equations.speed is None:
        return {}
    speed = values.value[equations.speed] * 30 / 3.141592653589793
    found = {}
    for index, node in enumerate(equations.nodes):
        ratio = values.number(node.over(equations.mean_speeds))
        if ratio is not None:
            found[index] = speed * ratio
    return found
