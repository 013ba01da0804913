"""Drivelines with linear constraints over three and more flanges, and the same as matrices over nodes, for the tests of laws.

A system is plain data: inertias, springs (to ground where the second end is None), constraint rows over names, constant torques.
``driveline`` writes it as elements in any order; ``matrices`` writes M, C, K, G, f over the nodes, knowing nothing of modelgen.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from modelgen import Driveline, Element, Flange, GroundSpring, HarmonicTorque, Inertia, Param, Shaft


class Hold(Element):
    """A node that ground holds."""

    flange = Flange()

    def constraints(self) -> list[Any]:
        return [self.flange.angle]


class Joint3(Element):
    """One linear constraint over three flanges."""

    a, b, c = Flange(), Flange(), Flange()
    one, two, three = Param("1"), Param("1"), Param("1")

    def constraints(self) -> list[Any]:
        return [self.one * self.a.angle + self.two * self.b.angle + self.three * self.c.angle]


class PlanetarySet(Element):
    """Sun, ring and carrier of a rigid planetary set (Willis): z_s (s - c) + z_r (r - c) = 0, all in one sense of rotation."""

    sun, ring, carrier = Flange(), Flange(), Flange()
    teeth_sun, teeth_ring = (Param("1", integer=True, positive=True) for _ in range(2))

    def constraints(self) -> list[Any]:
        s, r, c = self.sun.angle, self.ring.angle, self.carrier.angle
        return [self.teeth_sun * (s - c) + self.teeth_ring * (r - c)]


class Ravigneaux(Element):
    """Large sun, small sun, ring and common carrier: the small sun drives the ring through a pair of planets."""

    large, small, ring, carrier = Flange(), Flange(), Flange(), Flange()
    teeth_large, teeth_small, teeth_ring = (Param("1", integer=True, positive=True) for _ in range(3))

    def constraints(self) -> list[Any]:
        large, small, ring, carrier = (x.angle for x in (self.large, self.small, self.ring, self.carrier))
        return [
            self.teeth_large * (large - carrier) + self.teeth_ring * (ring - carrier),
            -self.teeth_small * (small - carrier) + self.teeth_ring * (ring - carrier),
        ]


@dataclass(frozen=True)
class System:
    """Inertias [kg*m^2], springs (a, b or None, k, c), constraint rows over names, constant torques [N*m], and the joints."""

    inertias: dict[str, float]
    springs: tuple[tuple[str, str | None, float, float], ...]
    rows: tuple[dict[str, float], ...]
    torques: dict[str, float]
    joints: tuple[Element, ...]

    def elements(self) -> list[Element]:
        parts: list[Element] = [Inertia(name, inertia=value) for name, value in self.inertias.items()]
        for index, (a, b, k, c) in enumerate(self.springs):
            if b is None:
                parts.append(GroundSpring(f"spring_{index}", a, stiffness=k, damping=c))
            else:
                parts.append(Shaft(f"spring_{index}", a, b, stiffness=k, damping="value", damping_coefficient=c))
        parts += [HarmonicTorque(f"torque_{name}", name, mean=value) for name, value in self.torques.items()]
        return [*parts, *self.joints]

    def driveline(self, seed: int | None = None, reference: str | None = None) -> Driveline:
        """As elements, in the order of writing or in a random one."""
        parts = self.elements()
        if seed is not None:
            parts = [parts[k] for k in np.random.default_rng(seed).permutation(len(parts))]
        return Driveline("joined", elements=parts, reference=reference, drifts=True)

    def matrices(self) -> tuple[np.ndarray, ...]:
        """M, C, K, G, f over the nodes, in the order of ``inertias``."""
        names, n = list(self.inertias), len(self.inertias)
        damping, stiffness, joints = np.zeros((n, n)), np.zeros((n, n)), np.zeros((len(self.rows), n))
        for a, b, k, c in self.springs:
            arm = np.zeros(n)
            arm[names.index(a)] = 1.0
            if b is not None:
                arm[names.index(b)] = -1.0
            stiffness += k * np.outer(arm, arm)
            damping += c * np.outer(arm, arm)
        for index, row in enumerate(self.rows):
            for name, value in row.items():
                joints[index, names.index(name)] = value
        force = np.array([self.torques.get(name, 0.0) for name in names])
        return np.diag(list(self.inertias.values())), damping, stiffness, joints, force


def _planetary(held: str) -> System:
    return System(
        {"M": 0.3, "S": 0.02, "R": 0.4, "C": 0.1, "L": 2.0},
        (("M", "S", 8e3, 2.0), ("C", "L", 3e4, 5.0), *((("R", None, 5e4, 3.0),) if held == "nothing" else ())),
        ({"S": 24.0, "R": 66.0, "C": -90.0}, *(({held: 1.0},) if held != "nothing" else ())),
        {"M": 40.0, "L": -90.0},
        (
            PlanetarySet("set", "S", "R", "C", teeth_sun=24, teeth_ring=66),
            *((Hold("hold", held),) if held != "nothing" else ()),
        ),
    )


SYSTEMS = {
    "planetary set on an elastic ring": _planetary("nothing"),
    "planetary set, ring held": _planetary("R"),
    "planetary set, sun held": _planetary("S"),
    "planetary set, carrier held": _planetary("C"),
    "open differential": System(
        {"E": 0.2, "D": 0.05, "A": 0.01, "B": 0.012, "left": 1.1, "right": 0.9},
        (("E", "D", 1.5e4, 1.0), ("A", "left", 7e3, 0.5), ("B", "right", 9e3, 0.8)),
        ({"D": 2.0, "A": -1.0, "B": -1.0},),
        {"E": 60.0, "left": -20.0},
        (Joint3("differential", "D", "A", "B", one=2.0, two=-1.0, three=-1.0),),
    ),
    "summing gear": System(
        {"one": 0.4, "two": 0.7, "S": 0.02, "R": 0.2, "C": 0.15, "out": 3.0},
        (("one", "S", 9e3, 1.0), ("two", "R", 2e4, 2.0), ("C", "out", 4e4, 4.0)),
        ({"S": 30.0, "R": 70.0, "C": -100.0},),
        {"one": 20.0, "two": 45.0, "out": -60.0},
        (PlanetarySet("sum", "S", "R", "C", teeth_sun=30, teeth_ring=70),),
    ),
    "Ravigneaux set": System(
        {"input": 0.3, "large": 0.03, "small": 0.02, "ring": 0.2, "carrier": 0.1, "out": 2.5},
        (("input", "small", 1e4, 1.5), ("large", None, 3e4, 2.0), ("ring", "out", 3e4, 3.0)),
        (
            {"large": 38.0, "ring": 86.0, "carrier": -124.0},
            {"small": -30.0, "ring": 86.0, "carrier": -56.0},
        ),
        {"input": 50.0, "out": -70.0},
        (Ravigneaux("set", "large", "small", "ring", "carrier", teeth_large=38, teeth_small=30, teeth_ring=86),),
    ),
    "gear with an elastic housing": System(
        {"motor": 0.2, "pinion": 0.01, "housing": 1.2, "wheel": 0.3, "fan": 2.0},
        (("motor", "pinion", 1e4, 1.0), ("housing", None, 2e5, 30.0), ("wheel", "fan", 3e4, 3.0)),
        ({"pinion": 21.0, "wheel": 58.0, "housing": -79.0},),
        {"motor": 30.0, "fan": -80.0},
        (Joint3("gear", "pinion", "wheel", "housing", one=21.0, two=58.0, three=-79.0),),
    ),
    "two sets on the same shafts": System(
        {"M": 0.3, "S": 0.02, "R": 0.4, "C": 0.1},
        (("M", "S", 8e3, 2.0),),
        ({"S": 20.0, "R": 40.0, "C": -60.0}, {"S": 20.0, "R": 60.0, "C": -80.0}),
        {"M": 5.0, "C": -2.0},
        (
            PlanetarySet("first", "S", "R", "C", teeth_sun=20, teeth_ring=40),
            PlanetarySet("second", "S", "R", "C", teeth_sun=20, teeth_ring=60),
        ),
    ),
}
