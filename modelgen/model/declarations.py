"""What an element class declares: flanges, parameters, switches, states, clocks and named quantities.

First stage of the flow: an element is a class whose attributes are these declarations and whose methods are pure functions of
the SymPy symbols they stand for. One declaration gives the symbol, the unit check, the input check and the line in the docs.
The symbols belong to the class, not to the instance: every shaft shares one law, and instances differ in values only. That is
what lets the compiler treat two hundred shafts as one template and a table.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy

from modelgen.units import dimension_of

if TYPE_CHECKING:
    from modelgen.model.element import Element

TIME = sympy.Symbol("t", real=True)
"""Time in seconds, the same symbol everywhere."""

UNIT_CONSTANTS = {sympy.Symbol("1 m^2", positive=True): "m^2"}
"""Ones with a unit, for laws whose printed form does not agree in its units; they are 1 after the check of dimensions."""

UNIT_AREA = next(iter(UNIT_CONSTANTS))


class Declaration:
    """Common part: the attribute name, remembered when the class is made."""

    name: str

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name


@dataclass(frozen=True)
class FlangeSymbols:
    """What a law sees of a flange: angle [rad], speed [rad/s], and the inertia [kg*m^2] rigidly on its node."""

    name: str
    angle: sympy.Symbol
    speed: sympy.Symbol
    inertia: sympy.Symbol


class Flange(Declaration):
    """A shaft end where elements meet: they share its angle, and their torques on it add up.

    In a law, ``self.a.angle`` and ``self.a.speed`` are symbols; ``self.a.inertia`` asks for the sum of inertias rigidly on that
    node (through rigid gears too, referred to it), and a node that has none is then an error by name.
    """

    def __init__(self, doc: str = "") -> None:
        self.doc = doc

    @functools.cached_property
    def symbols(self) -> FlangeSymbols:
        angle, speed = (sympy.Symbol(f"{self.name}.{part}", real=True) for part in ("angle", "speed"))
        return FlangeSymbols(self.name, angle, speed, sympy.Symbol(f"{self.name}.inertia", positive=True))

    def __get__(self, instance: Element | None, owner: type) -> Any:
        return self if instance is None else self.symbols


Condition = Mapping[str, str | tuple[str, ...]]


class Switched(Declaration):
    """What exists for some settings of the element's switches only: ``when`` maps switches to the options that use it."""

    when: Condition

    def exists(self, choices: Mapping[str, Any]) -> bool:
        """Whether it exists for these settings of the switches."""
        return all(choices[key] in (value if isinstance(value, tuple) else (value,)) for key, value in self.when.items())


class Param(Switched):
    """A number, or with ``series=True`` a row of numbers, with its unit and its lawful range.

    ``unit`` is an SI unit text; ``default=None`` means that a value must be given; ``when={"damping": "value"}`` makes the
    parameter exist only for that setting of a switch. In a law it is a symbol (a tuple of symbols for a series).
    """

    def __init__(
        self,
        unit: str = "1",
        *,
        default: float | tuple[float, ...] | None = None,
        positive: bool = False,
        nonnegative: bool = False,
        least: float | None = None,
        largest: float | None = None,
        integer: bool = False,
        series: bool = False,
        when: Condition | None = None,
        doc: str = "",
    ) -> None:
        dimension_of(unit)
        self.unit, self.default, self.series, self.when, self.doc = unit, default, series, dict(when or {}), doc
        self.positive, self.nonnegative, self.integer = positive, nonnegative, integer
        self.least, self.largest = least, largest

    def symbol(self, row: int | None = None) -> sympy.Symbol:
        """The symbol itself, or the one of row 1, 2, ... of a series."""
        name = self.name if row is None else f"{self.name}_{row}"
        return sympy.Symbol(name, real=True, positive=self.positive or None, integer=self.integer or None)

    def symbols(self, length: int | None) -> tuple[sympy.Symbol, ...]:
        return (self.symbol(),) if length is None else tuple(self.symbol(row) for row in range(1, length + 1))

    def __get__(self, instance: Element | None, owner: type) -> Any:
        if instance is None:
            return self
        symbols = self.symbols(instance.lengths.get(self.name) if self.series else None)
        return symbols if self.series else symbols[0]


class Choice(Declaration):
    """A switch between named forms of a law; the first one is the default. In a law it is the chosen text."""

    def __init__(self, *options: str, doc: str = "") -> None:
        self.options, self.default, self.doc = options, options[0], doc

    def __get__(self, instance: Element | None, owner: type) -> Any:
        return self if instance is None else instance.choices[self.name]


class Orders(Switched):
    """Whole-number harmonics of a clock, fixed when the model is compiled, such as ``(1, 2, 6)``; empty for 1, 2, ..., n."""

    def __init__(self, *, when: Condition | None = None, doc: str = "") -> None:
        self.when, self.doc = dict(when or {}), doc

    def __get__(self, instance: Element | None, owner: type) -> Any:
        return self if instance is None else instance.harmonics.get(self.name, ())


class Derived(Switched):
    """Parameters computed from others by a named NumPy function, before anything else is evaluated.

    ``function(**{name: value})`` receives the SI values of the parameters (and orders, as tuples) named in ``of`` and returns
    ``count(element)`` numbers. Sensitivities through it are taken by differences.
    """

    def __init__(
        self,
        unit: str,
        function: Callable[..., Any],
        *,
        of: tuple[str, ...],
        count: Callable[[Any], int],
        when: Condition | None = None,
        doc: str = "",
    ) -> None:
        dimension_of(unit)
        self.unit, self.function, self.of, self.count, self.when, self.doc = unit, function, of, count, dict(when or {}), doc

    def symbols(self, element: Element) -> tuple[sympy.Symbol, ...]:
        return tuple(sympy.Symbol(f"{self.name}_{row}", real=True) for row in range(1, self.count(element) + 1))

    def __get__(self, instance: Element | None, owner: type) -> Any:
        return self if instance is None else self.symbols(instance)


class State(Declaration):
    """A state that the element itself owns (an internal force, a temperature); its rate is given by ``rates()``."""

    def __init__(self, unit: str, *, start: float = 0.0, scale: float | None = None, doc: str = "") -> None:
        dimension_of(unit)
        self.unit, self.start, self.scale, self.doc = unit, start, scale, doc

    @functools.cached_property
    def symbol(self) -> sympy.Symbol:
        return sympy.Symbol(self.name, real=True)

    def __get__(self, instance: Element | None, owner: type) -> Any:
        return self if instance is None else self.symbol


@dataclass(frozen=True)
class ClockSymbols:
    """What a law sees of a clock: its angle [rad], zero at t = 0 and one turn per period, and its frequency [rad/s]."""

    name: str
    angle: sympy.Symbol
    frequency: sympy.Symbol


class Clock(Declaration):
    """A base frequency: an exact rational multiple of the operating speed.

    Bound to a flange, its frequency is ``order`` (a parameter name or a number) times the mean speed of that flange, as for a
    gear mesh. Unbound, each instance names one of the driveline's base frequencies.
    """

    def __init__(self, flange: str | None = None, order: str | int = 1, doc: str = "") -> None:
        self.flange, self.order, self.doc = flange, order, doc

    @functools.cached_property
    def symbols(self) -> ClockSymbols:
        angle, frequency = (sympy.Symbol(f"{self.name}.{part}", real=True) for part in ("angle", "frequency"))
        return ClockSymbols(self.name, angle, frequency)

    def __get__(self, instance: Element | None, owner: type) -> Any:
        return self if instance is None else self.symbols


class quantity(Declaration):  # noqa: N801 - used as a decorator, like property
    """A named intermediate result of a law, with its unit: it is printed, checked for its dimension, and an output channel.

    A quantity that varies with time only may state its mean over a period; without one the mean is taken numerically.
    Inside other laws ``self.twist`` is the symbol of the quantity, so equations stay readable.
    """

    def __init__(self, unit: str, *, mean: Callable[[Any], Any] | None = None) -> None:
        dimension_of(unit)
        self.unit, self.mean = unit, mean

    def __call__(self, law: Callable[[Any], Any]) -> quantity:
        self.law, self.__doc__ = law, law.__doc__
        return self

    @functools.cached_property
    def symbol(self) -> sympy.Symbol:
        return sympy.Symbol(self.name, real=True)

    def __get__(self, instance: Element | None, owner: type) -> Any:
        return self if instance is None else self.symbol
