"""A driveline as a model of MuJoCo, written in that engine's own primitives: the referee's side of ``referee``.

Inertias are bodies on hinges, shafts are tendons with stiffness and damping, meshes are tendons with the base radii as
coefficients and the backlash as the dead band of their spring. What varies with time (torques, mesh stiffness and damping, mesh
error) is set for the instant of every evaluation. Only numbers are taken from the model: sums of harmonics, damping
coefficients and laws of force are written here anew, or are MuJoCo's, so that a mistake in one side shows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.lowering import Compiled
from modelgen.model import Driveline, Element
from modelgen.model.values import Shared
from modelgen.solvers.operating_point import OperatingPoint

Array = NDArray[np.float64]
ROWS_PER_MESH = ("stiffness", "error", "error_rate")


@dataclass
class Wave:
    """A row that varies with time: a mean and complex amplitudes by circular frequency, value = mean + Re sum(a exp(i w t))."""

    mean: float = 0.0
    amplitudes: dict[float, complex] = field(default_factory=dict)

    def add(self, frequency: float, sine: float, cosine: float) -> None:
        """Add sine sin(w t) + cosine cos(w t)."""
        self.amplitudes[frequency] = self.amplitudes.get(frequency, 0j) + complex(cosine, -sine)


@dataclass(frozen=True)
class Link:
    """A shaft or a mesh: its name, what it joins, its coefficients there, and its damping (per root of stiffness for a mesh)."""

    name: str
    ends: tuple[int, int]
    coefficients: tuple[float, float]
    stiffness: float
    damping: float
    gap: float = 0.0
    waves: Mapping[str, Wave] | None = None


@dataclass(frozen=True)
class Referee:
    """Numbers of a driveline in MuJoCo's terms, one hinge per group of rigidly joined flanges."""

    name: str
    inertia: Array
    mean_speed: Array
    torques: tuple[Wave, ...]
    links: tuple[Link, ...]
    places: Mapping[str, tuple[int, float]]

    def xml(self, step: float) -> str:
        """The model in MuJoCo's format, integrated by its own Runge-Kutta method of order 4 with a fixed step [s]."""
        bodies = "".join(
            f'<body><joint name="j{k}" type="hinge" axis="0 0 1"/>'
            f'<inertial pos="0 0 0" mass="1" diaginertia="{j!r} {j!r} {j!r}"/></body>'
            for k, j in enumerate(self.inertia.tolist())
        )
        tendons = "".join(
            f'<fixed name="t{k}" stiffness="{link.stiffness!r}" damping="{0.0 if link.waves else link.damping!r}" '
            f'springlength="{-link.gap!r} {link.gap!r}">'
            + "".join(f'<joint joint="j{e}" coef="{c!r}"/>' for e, c in zip(link.ends, link.coefficients, strict=True))
            + "</fixed>"
            for k, link in enumerate(self.links)
        )
        option = f'<option timestep="{step!r}" integrator="RK4" gravity="0 0 0"><flag contact="disable"/></option>'
        return f"<mujoco>{option}<worldbody>{bodies}</worldbody><tendon>{tendons}</tendon></mujoco>"


def referee_of(line: Driveline, model: Compiled, point: OperatingPoint) -> Referee:
    """The numbers of a driveline. Raises CaseError for an element that has no counterpart among MuJoCo's primitives."""
    return _Reader(line, model, point).referee()


class _Reader:
    def __init__(self, line: Driveline, model: Compiled, point: OperatingPoint) -> None:
        self.line, self.model, self.p = line, model, point.p
        rows = model.mean_model.nodes_at(point.p)
        self.place: dict[str, tuple[int, float]] = {}
        for node, row in zip(model.equations.nodes, rows, strict=True):
            if (group := node.group) is None:
                what = f"node {node.name!r} follows several shafts, which the referee's hinges cannot say"
                raise CaseError(f"driveline {line.name!r}", what, "leave the constraint out, or compare by crosscheck")
            self.place.update(dict.fromkeys(node.flanges, (group, float(row[group]))))
        speed = line.speed or 0.0
        if line.speed is not None:
            speed = model.parameters.value(point.p, "speed")
        self.mean_speed = speed * np.asarray(point.coordinates.ratio, dtype=float)
        self.inertia = np.zeros(len(model.equations.groups))
        self.torques = [Wave() for _ in self.inertia]
        self.links: list[Link] = []
        self.places: dict[str, tuple[int, float]] = {}

    def referee(self) -> Referee:
        known = {"inertia": self._inertia, "harmonic_torque": self._torque, "shaft": self._shaft, "gear_pair": self._mesh}
        order = {"inertia": 0}
        for element in sorted(self.line.elements, key=lambda each: order.get(each.kind, 1)):
            if element.kind not in known:
                what = f"a {element.kind} has no counterpart among the referee's primitives"
                raise CaseError(element.where, what, f"the referee knows {', '.join(known)}")
            known[element.kind](element)
        return Referee(self.line.name, self.inertia, self.mean_speed, tuple(self.torques), tuple(self.links), self.places)

    def _values(self, element: Element, key: str) -> list[float]:
        """The numbers of a parameter, its own or shared."""
        given = element.values.get(key)
        name = given.name if isinstance(given, Shared) else f"{element.name}.{key}"
        where = self.model.parameters.slices.get(name)
        return [] if where is None else self.p[where].tolist()

    def _value(self, element: Element, key: str) -> float:
        return float(self._values(element, key)[0])

    def _at(self, element: Element, flange: str) -> tuple[int, float]:
        return self.place[f"{element.name}.{flange}"]

    def _inertia(self, element: Element) -> None:
        group, ratio = self._at(element, "flange")
        self.inertia[group] += ratio**2 * self._value(element, "inertia")
        self.places[element.name] = (group, ratio)

    def _torque(self, element: Element) -> None:
        group, ratio = self._at(element, "flange")
        size = ratio * self._value(element, "scale")
        wave, phase = self.torques[group], self._value(element, "phase")
        wave.mean += size * self._value(element, "mean")
        base = self._base_frequency(element) if element.clocks else 0.0
        for order, sine, cosine in _series(element, self._values(element, "sine"), self._values(element, "cosine"), "orders"):
            # a sin(n (w t + phase)) + b cos(n (w t + phase)) is the real part of (b - i a) exp(i n phase) exp(i n w t)
            turned = complex(cosine, -sine) * complex(math.cos(order * phase), math.sin(order * phase))
            wave.add(order * base, -size * turned.imag, size * turned.real)

    def _base_frequency(self, element: Element) -> float:
        clock = next(each for each in self.model.equations.clocks if each.name == element.clocks["base"])
        found = self.model.mean_model.frequencies_at(self.p)
        return float(found[self.model.equations.clocks.index(clock)])

    def _ends(self, element: Element) -> tuple[tuple[int, float], tuple[int, float]]:
        return self._at(element, "a"), self._at(element, "b")

    def _shaft(self, element: Element) -> None:
        (a, ratio_a), (b, ratio_b) = self._ends(element)
        k = self._value(element, "stiffness")
        kind = element.choices["damping"]
        if kind == "modal":
            raise CaseError(element.where, "has modal damping, which is no primitive", "take damping = per_shaft for both sides")
        if kind == "per_shaft":
            at_a, at_b = self.inertia[a] / ratio_a**2, self.inertia[b] / ratio_b**2
            c = 2 * self._value(element, "damping_ratio") * math.sqrt(k / (1 / at_a + 1 / at_b))
        elif kind == "value":
            c = self._value(element, "damping_coefficient")
        else:
            c = self._value(element, "loss_factor") * k / self._value(element, "reference_frequency")
        self.links.append(Link(element.name, (a, b), (ratio_a, -ratio_b), k, c))

    def _mesh(self, element: Element) -> None:
        (a, ratio_a), (b, ratio_b) = self._ends(element)
        if element.choices["viscous"] != "always" or element.choices["mesh"] in ("table", "rectangular"):
            what = f"has viscous = {element.choices['viscous']!r} and mesh = {element.choices['mesh']!r}"
            raise CaseError(element.where, what, 'the referee takes viscous = "always" and a Fourier mesh')
        teeth_a, teeth_b = self._value(element, "teeth_a"), self._value(element, "teeth_b")
        if element.choices["radii"] == "given":
            radius_a = self._value(element, "base_radius_a")
        else:
            radius_a = self._value(element, "module") * teeth_a * math.cos(self._value(element, "pressure_angle")) / 2
        radius_b = radius_a * teeth_b / teeth_a
        frequency = teeth_a * ratio_a * float(self.mean_speed[a])
        stiffness, error, rate = (Wave() for _ in ROWS_PER_MESH)
        mean, rows = self._stiffness_rows(element)
        stiffness.mean = mean
        for order, sine, cosine in rows:
            stiffness.add(order * frequency, sine, cosine)
        size, phase = self._value(element, "error_amplitude"), self._value(element, "error_phase")
        error.mean = self._value(element, "error_mean")
        error.add(frequency, size * math.cos(phase), size * math.sin(phase))
        rate.add(frequency, -size * frequency * math.sin(phase), size * frequency * math.cos(phase))
        at_a, at_b = self.inertia[a] / ratio_a**2, self.inertia[b] / ratio_b**2
        kind = element.choices["damping"]
        if kind == "literal":
            raise CaseError(element.where, "has the literal mesh damping", 'the referee takes "corrected" or "value"')
        ratio = self._value(element, "damping_ratio") if kind == "corrected" else math.nan
        per_root = 2 * ratio / math.sqrt(radius_a**2 / at_a + radius_b**2 / at_b)  # c = 2 xi sqrt(k m)
        damping = per_root if kind == "corrected" else -self._value(element, "damping_coefficient")
        waves = dict(zip(ROWS_PER_MESH, (stiffness, error, rate), strict=True))
        gap = self._value(element, "half_backlash")
        self.links.append(Link(element.name, (a, b), (radius_a * ratio_a, -radius_b * ratio_b), mean, damping, gap, waves))

    def _stiffness_rows(self, element: Element) -> tuple[float, list[tuple[int, float, float]]]:
        if element.choices["mesh"] == "fourier":
            sine, cosine = self._values(element, "stiffness_sine"), self._values(element, "stiffness_cosine")
            return self._value(element, "mean_stiffness"), list(_series(element, sine, cosine, "stiffness_orders"))
        mean, *rows = self._values(element, "geometry_rows")
        half = len(rows) // 2
        return mean, list(_series(element, rows[half:], rows[:half], "stiffness_orders"))


def _series(element: Element, sine: list[float], cosine: list[float], orders: str) -> Iterator[tuple[int, float, float]]:
    count = max(len(sine), len(cosine))
    zeros = [0.0] * count
    named = element.harmonics.get(orders) or tuple(range(1, count + 1))
    yield from zip(named, sine or zeros, cosine or zeros, strict=True)


class Timed:
    """All rows that vary with time, evaluated together: torques on the hinges, then stiffness, error and error rate per mesh."""

    def __init__(self, referee: Referee) -> None:
        self.meshes = [k for k, link in enumerate(referee.links) if link.waves]
        rows: list[Wave] = list(referee.torques)
        for name in ROWS_PER_MESH:
            rows += [referee.links[k].waves[name] for k in self.meshes]  # type: ignore[index]  # chosen for having waves
        frequencies = sorted({frequency for row in rows for frequency in row.amplitudes})
        place = {frequency: k for k, frequency in enumerate(frequencies)}
        self.frequencies, self.mean = np.array(frequencies), np.array([row.mean for row in rows])
        amplitudes = np.zeros((len(rows), len(frequencies)), dtype=complex)
        for k, row in enumerate(rows):
            for frequency, amplitude in row.amplitudes.items():
                amplitudes[k, place[frequency]] = amplitude
        self.matrix = np.hstack([amplitudes.real, -amplitudes.imag])
        self.hinges, self.count = len(referee.torques), len(self.meshes)

    def __call__(self, t: float) -> tuple[Array, Array, Array, Array]:
        """Torques, mesh stiffnesses, mesh errors, their rates at t [s]."""
        angle = self.frequencies * t
        values = self.mean + self.matrix @ np.concatenate([np.cos(angle), np.sin(angle)])
        n, m = self.hinges, self.count
        return values[:n], values[n : n + m], values[n + m : n + 2 * m], values[n + 2 * m :]


def mesh_damping(referee: Referee, stiffness: Array) -> Array:
    """Damping coefficient [N s/m] of every mesh at its present stiffness."""
    links = [link for link in referee.links if link.waves]
    given: Any = [
        link.damping * math.sqrt(k) if link.damping >= 0 else -link.damping for link, k in zip(links, stiffness, strict=True)
    ]
    return np.array(given)
