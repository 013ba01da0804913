"""A test bench for every element in the vocabulary, in every setting of its switches: a new element is on it by itself.

On the bench each flange carries a disk of its own and the first one an applied torque; parameters are drawn from their
declarations. Asking for the fixture ``bench`` runs a test on all of them, ``still_bench`` with everything that has a default
left there, so that nothing varies with time unless the element cannot help it.
"""

from __future__ import annotations

import functools
import itertools
import zlib
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

import modelgen.elements  # noqa: F401 - makes the vocabulary known
from modelgen.equations import assemble
from modelgen.errors import ModelError
from modelgen.lowering import Compiled, lower
from modelgen.model import Choice, Clock, Derived, Driveline, Element, Flange, Param

collect_ignore = ["joints.py"]  # elements shared by tests; looked through for doctests, its kinds would be declared twice

TORQUE = 1.7  # N*m, applied to the first disk


@dataclass(frozen=True)
class Setting:
    """An element class with its switches."""

    kind: str
    switches: tuple[tuple[str, str], ...]

    def __str__(self) -> str:
        return "-".join([self.kind, *(value for _, value in self.switches)])

    @property
    def cls(self) -> type[Element]:
        return Element.vocabulary[self.kind]

    def exists(self, declared: Param | Derived) -> bool:
        return declared.exists(dict(self.switches))


def settings() -> list[Setting]:
    """Every element that modelgen brings, in every setting of its switches that can be given all its parameters."""
    found = []
    for kind, cls in Element.vocabulary.items():
        if not cls.__module__.startswith("modelgen."):
            continue  # made by another test
        choices = cls.declared(Choice)
        for options in itertools.product(*(choice.options for choice in choices.values())):
            setting = Setting(kind, tuple(zip(choices, options, strict=True)))
            params = cls.declared(Param)
            needs = {
                of for derived in cls.declared(Derived).values() if setting.exists(derived) for of in derived.of if of in params
            }
            if all(setting.exists(params[of]) for of in needs):
                found.append(setting)
    return found


def value_of(param: Param, rng: np.random.Generator, still: bool) -> Any:
    """A lawful value by the declaration alone; all of size one, so that nothing hides in rounding."""
    if param.default is not None and still:
        return param.default
    if param.series:
        return tuple(rng.uniform(1, 2, 3)) if param.positive else tuple(rng.uniform(-0.1, 0.1, 3))
    if param.integer:
        return int(rng.integers(30, 45))
    if param.default:
        return param.default * rng.uniform(0.95, 1.05)
    if param.least is not None and param.largest is not None:
        return rng.uniform(param.least, param.largest)
    if param.positive:
        return rng.uniform(1, 2) * (0.1 if param.unit == "m" else 1)
    return rng.uniform(0.05, 0.2) if param.nonnegative else rng.uniform(-0.1, 0.1)


@dataclass(frozen=True, eq=False)
class Bench:
    """One element on its bench, compiled."""

    setting: Setting
    element: Element
    line: Driveline
    model: Compiled
    p: np.ndarray

    @property
    def disks(self) -> list[str]:
        return [f"disk_{flange}" for flange in self.setting.cls.declared(Flange)]

    def states(self, count: int) -> list[tuple[float, np.ndarray]]:
        """Random instants and states."""
        rng = np.random.default_rng(zlib.crc32(str(self.setting).encode()))
        return [(rng.uniform(0, 10), rng.uniform(-0.5, 0.5, len(self.model.states))) for _ in range(count)]

    @functools.cached_property
    def book(self) -> ca.Function:
        """(t, x, p) -> one row per entry of BOOKS.

        "explicit" is the part of the stored energy's rate that is there when nothing moves: the derivative by time with all
        angles held, so without the uniform rotation that the states are counted from.
        """
        e = self.model.expressions
        return self._book(e["t"], e["x"], e["p"], e["ode"], e["outputs"])

    @functools.cached_property
    def switched_book(self) -> ca.Function:
        """The same with modes as flags in p."""
        switched = self.model.switched()
        t, x, p = (
            ca.SX.sym(name, size) for name, size in (("t", 1), ("x", len(self.model.states)), ("p", switched.switching.p_size))
        )
        return self._book(t, x, p, switched.rhs_function(t, x, p), switched.output_function(t, x, p))

    def _book(self, t: ca.SX, x: ca.SX, p: ca.SX, ode: ca.SX, outputs: ca.SX) -> ca.Function:
        model, own_p = self.model, p[: self.model.parameters.size]
        out = {name: outputs[model.output_index(f"total.{name}")] for name in TOTALS}
        energy, stored = out["kinetic_energy"] + out["stored_energy"], out["stored_energy"]
        rate, stored_rate = (ca.jtimes(each, x, ode) + ca.jtimes(each, t, ca.SX(1)) for each in (energy, stored))
        n, own = len(model.equations.steps), sum(state.kind == "own" for state in model.equations.states)
        mean = model.mean_model.ratios(own_p)[1]
        turning = model.mean_model.coordinates(mean, ca.SX(n, 1), ca.SX(own, 1), own_p)
        explicit = ca.jtimes(stored, t, ca.SX(1)) - ca.jtimes(stored, x, ca.vertcat(turning[:n], ca.SX(n + own, 1)))
        powers = [out["dissipated_power"], out["supplied_power"], explicit]
        return ca.Function("book", [t, x, p], [ca.vertcat(energy, rate, stored, stored_rate, *powers)])

    def books(self, t: float, x: np.ndarray) -> dict[str, float]:
        return dict(zip(BOOKS, self.book(t, x, self.p).full().ravel().tolist(), strict=True))

    def inertia(self, disk: str) -> float:
        return float(self.line[disk].values["inertia"])


BOOKS = ("energy", "rate", "stored", "stored rate", "dissipated", "supplied", "explicit")
TOTALS = ("kinetic_energy", "stored_energy", "dissipated_power", "supplied_power")


@functools.cache
def _bench(setting: Setting, still: bool) -> Bench:
    from modelgen.elements import Inertia, SteppedTorque

    rng = np.random.default_rng(zlib.crc32(f"{setting} {still}".encode()))
    flanges, disks = list(setting.cls.declared(Flange)), []
    params = {key: value_of(p, rng, still) for key, p in setting.cls.declared(Param).items() if setting.exists(p)}
    clocks = {key: "cycle" for key, clock in setting.cls.declared(Clock).items() if clock.flange is None}
    joined = {flange: f"disk_{flange}" for flange in flanges}
    element = setting.cls("element", **joined, **clocks, **dict(setting.switches), **params)
    for flange in flanges:
        disks.append(Inertia(f"disk_{flange}", inertia=rng.uniform(1, 2)))
    push = [] if still else [SteppedTorque("push", disks[0].name, before=TORQUE, after=TORQUE)]
    line = Driveline("bench", [*disks, element, *push], speed=1.3, reference=disks[0].name, bases={"cycle": "3/2"})
    model = lower(assemble(line))
    for _ in range(20):
        try:
            return Bench(setting, element, line, model, model.parameters.vector())
        except ModelError:  # lawful one by one, but not together: drawn anew
            params = {key: value_of(p, rng, still) for key, p in setting.cls.declared(Param).items() if setting.exists(p)}
            element = element.copy(**params)
            line = replace(line, elements=(*disks, element, *push))
            model = lower(assemble(line))
    raise AssertionError(f"no lawful values of {setting} in 20 draws")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    for fixture in ("bench", "still_bench"):
        if fixture in metafunc.fixturenames:
            metafunc.parametrize(fixture, settings(), indirect=True, ids=str)


@pytest.fixture
def bench(request: pytest.FixtureRequest) -> Bench:
    return _bench(request.param, still=False)


@pytest.fixture
def still_bench(request: pytest.FixtureRequest) -> Bench:
    return _bench(request.param, still=True)
