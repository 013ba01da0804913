"""The driveline: named elements, how they are joined, shared parameters, and one operating speed.

First of the seven records. It is a value: every method that changes something returns a new driveline.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from modelgen.errors import ModelError, NamingError, nearest
from modelgen.model.chosen_limits import ChosenLimit, chosen_limits
from modelgen.model.declarations import Flange
from modelgen.model.element import Element, Shared
from modelgen.model.given_kinds import check_kinds
from modelgen.model.named import BaseFrequency, NamedParameter, base_frequency, named_parameter
from modelgen.model.names import identifier, model_name
from modelgen.model.speeds import mean_speeds, read_speed
from modelgen.model.values import ROW
from modelgen.units import read_quantity

RESERVED = ("speed", "total", "time", "modal", "modal_damping")
"""Names that the driveline itself uses: operating speed, sums over all elements, time, and modal damping."""


@dataclass(frozen=True)
class Driveline:
    """Named elements and their connections; the first of the seven records.

    ``speed`` is the mean speed of the ``reference`` shaft. Where constraints leave several mean speeds free, as in a planetary
    set without a held member, ``speeds={"sun": "1500 rpm", "ring": 0}`` gives as many; the reference shaft's is ``speed``.

    A branched driveline, an engine that drives a pump through a gear pair and a fan through a belt-like shaft:

    >>> from modelgen import Driveline, GearPair, HarmonicTorque, Inertia, Shaft
    >>> line = Driveline(
    ...     "branched", speed="1500 rpm", reference="engine",
    ...     elements=[
    ...         Inertia("engine", inertia="2.5 kg*m^2"),
    ...         Inertia("fan", inertia="0.4 kg*m^2"),
    ...         Inertia("pinion", inertia="0.05 kg*m^2"),
    ...         Inertia("wheel", inertia="0.8 kg*m^2"),
    ...         Inertia("pump", inertia="1.2 kg*m^2"),
    ...         Shaft("fan_shaft", "engine", "fan", stiffness="20 kN*m/rad"),
    ...         Shaft("coupling", "engine", "pinion", stiffness="90 kN*m/rad"),
    ...         GearPair("mesh", "pinion", "wheel", teeth_a=21, teeth_b=63, module="4 mm", mean_stiffness="8e8 N/m"),
    ...         Shaft("pump_shaft", "wheel", "pump", stiffness="60 kN*m/rad"),
    ...         HarmonicTorque("firing", "engine", mean="300 N*m", cosine=[500.0], base="firing_order"),
    ...         HarmonicTorque("load", "pump", mean="-900 N*m"),
    ...     ],
    ...     bases={"firing_order": ("engine", 2)},
    ... )
    >>> print(line)
    driveline 'branched': 11 elements (5 inertia, 3 shaft, 1 gear_pair, 2 harmonic_torque) at 1500 rpm of 'engine'
    """

    name: str
    elements: tuple[Element, ...] = ()
    connections: tuple[tuple[str, str], ...] = ()
    parameters: Mapping[str, NamedParameter] = field(default_factory=dict)
    speed: float | None = None
    reference: str | None = None
    bases: Mapping[str, BaseFrequency] = field(default_factory=dict)
    balanced: tuple[str, ...] = ()
    assemblies: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    drifts: bool = False
    description: str = ""
    speeds: Mapping[str, Any] = field(default_factory=dict)
    balance_may_drive: bool = False
    limits: tuple[ChosenLimit, ...] = ()

    def __post_init__(self) -> None:
        where = f"driveline {self.name!r}"
        model_name(self.name, "driveline")
        check_kinds(self, where)
        put = object.__setattr__
        put(self, "elements", tuple(self.elements))
        for each in self.elements:
            if not isinstance(each, Element):
                raise ModelError(where, f"holds {each!r:.60} among its elements", "give elements such as Inertia(...)")
        for pair in self.connections:
            if not (isinstance(pair, (tuple, list)) and len(pair) == 2 and all(isinstance(text, str) for text in pair)):
                raise ModelError(where, f"holds the connection {pair!r:.60}", 'give pairs such as ("shaft.b", "wheel")')
        put(self, "connections", tuple((first, second) for first, second in self.connections))
        put(self, "balanced", tuple(self.balanced))
        put(self, "parameters", MappingProxyType({key: named_parameter(key, value) for key, value in self.parameters.items()}))
        put(self, "bases", MappingProxyType({key: base_frequency(key, value) for key, value in self.bases.items()}))
        put(self, "assemblies", MappingProxyType({key: tuple(value) for key, value in self.assemblies.items()}))
        for name, value in mean_speeds(where, self.speed, self.reference, self.speeds).items():
            put(self, name, value)
        if self.speed is not None:
            put(self, "speed", read_speed(self.speed, f"{where}, speed"))
            if self.speed <= 0:
                raise ModelError(
                    where, f"the operating speed is {self.speed:g} rad/s", "give a positive speed: angles count forward"
                )
        if not isinstance(self.balance_may_drive, bool):
            raise ModelError(where, f"balance may drive is {self.balance_may_drive!r:.60}", "give True or False")
        if self.reference is not None and not isinstance(self.reference, str):
            raise ModelError(where, f"the reference shaft is {self.reference!r:.60}", "give the name of an inertia")
        self._check_names(where)
        for name in self.balanced:
            if self[name].balanced_by is None:
                able = [each.name for each in self.elements if each.balanced_by]
                raise ModelError(self[name].where, "is no load that can be scaled", nearest(name, able))
        names = self.names
        put(self, "limits", chosen_limits(self.limits))
        for limit in self.limits:
            for name in limit.elements:
                if name not in names:
                    raise NamingError(f"limit {limit.rule!r}", f"is for {name!r}, which is no element", nearest(name, names))
        for assembly, members in self.assemblies.items():
            identifier(assembly, where, "assembly")
            for name in members:
                if name not in names:
                    raise NamingError(f"assembly {assembly!r}", f"holds {name!r}, which is no element", nearest(str(name), names))

    def _check_names(self, where: str) -> None:
        taken: dict[str, str] = {}
        for kind, names in (
            ("parameter", self.parameters),
            ("base frequency", self.bases),
            ("element", [element.name for element in self.elements]),
        ):
            for name in names:
                identifier(name, where, kind)
                if name in RESERVED:
                    raise NamingError(where, f"{kind} {name!r} has a name that modelgen uses itself", "choose another name")
                if name in taken:
                    raise NamingError(where, f"the name {name!r} is given twice ({taken[name]} and {kind})", "rename one of them")
                taken[name] = kind

    # -- looking up ------------------------------------------------------------------------------------------------------

    @functools.cached_property
    def names(self) -> Mapping[str, Element]:
        """Elements by name, in order."""
        return MappingProxyType({element.name: element for element in self.elements})

    def __getitem__(self, name: str) -> Element:
        names = self.names
        if not isinstance(name, str) or name not in names:
            raise NamingError(f"driveline {self.name!r}", f"has no element {name!r}", nearest(str(name), names))
        return names[name]

    def __contains__(self, element: object) -> bool:
        """Whether an element stands in the line, by its name or as such."""
        return element in self.names if isinstance(element, str) else element in self.elements

    def __iter__(self) -> Iterator[Element]:
        """The elements, in order."""
        return iter(self.elements)

    def __hash__(self) -> int:
        tables = (self.parameters, self.bases, self.assemblies)  # equal in whatever order
        return hash((self.name, self.elements, self.connections, self.speed, *(frozenset(each.items()) for each in tables)))

    def flange(self, text: str, where: str) -> tuple[str, str]:
        """Element and flange that ``"shaft.b"`` names; the flange may be left out where the element has only one."""
        name, dot, flange = text.partition(".")
        names = self.names
        if name not in names:
            raise NamingError(where, f"is joined to {text!r}, but there is no element {name!r}", nearest(name, names))
        flanges = names[name].declared(Flange)
        if not dot:
            if len(flanges) != 1:
                hint = " or ".join(f"{name}.{each}" for each in flanges)
                raise ModelError(where, f"is joined to {text!r}, which has {len(flanges)} flanges", f"write {hint}")
            return name, next(iter(flanges))
        if flange not in flanges:
            raise NamingError(where, f"{names[name].where} has no flange {flange!r}", nearest(flange, flanges))
        return name, flange

    # -- a driveline that differs in something -----------------------------------------------------------------------------

    def add(self, *elements: Element) -> Driveline:
        """With more elements."""
        return replace(self, elements=(*self.elements, *elements))

    def connect(self, first: str, second: str) -> Driveline:
        """With two flanges joined, each named ``element.flange``, or ``element`` where it has only one."""
        for text in (first, second):
            self.flange(text, f"connection {first!r} - {second!r}")
        return replace(self, connections=(*self.connections, (first, second)))

    def balance(self, *loads: str, may_drive: bool = False) -> Driveline:
        """With the named loads scaled so that the mean power closes at whatever speed, ratio and parameters are set.

        A scale below zero would turn a load, which takes power, into a drive: refused when it is found, unless ``may_drive``.
        """
        return replace(self, balanced=loads, balance_may_drive=may_drive)

    def set(self, **values: Any) -> Driveline:
        """With other values of the driveline's own parameters, of a row of one (``"firing_sine[3]"``), or of its ``speed``."""
        speed = values.pop("speed", self.speed)
        parameters: dict[str, Any] = dict(self.parameters)
        for key, value in values.items():
            if row := ROW.fullmatch(key):
                key, value = row[1], self._with_row(row[1], int(row[2]), value, parameters)
            if key not in parameters:
                raise NamingError(f"driveline {self.name!r}", f"has no parameter {key!r}", nearest(key, [*parameters, "speed"]))
            new, old = named_parameter(key, value), parameters[key]
            if not isinstance(value, (str, NamedParameter)):
                new = replace(new, unit=old.unit)
            parameters[key] = replace(new, note=new.note or old.note)
        return replace(self, parameters=parameters, speed=speed)

    def _with_row(self, key: str, row: int, value: Any, parameters: Mapping[str, Any]) -> Any:
        """A series of the driveline's own with one row changed. Raises NamingError for a row that is not there."""
        where, old = f"driveline {self.name!r}", parameters.get(key)
        if old is None:
            raise NamingError(where, f"has no parameter {key!r}", nearest(key, [*parameters, "speed"]))
        if not isinstance(old.value, tuple) or not 1 <= row <= len(old.value):
            held = len(old.value) if isinstance(old.value, tuple) else 0
            raise NamingError(where, f"has no row {key}[{row}]; {key!r} has {held} rows", "rows count from 1")
        number = read_quantity(value, old.unit, f"{where}, {key}[{row}]") if isinstance(value, str) else value
        return replace(old, value=(*old.value[: row - 1], number, *old.value[row:]))

    def change(self, kind_or_name: str, **values: Any) -> Driveline:
        """With other values or switches of one element, or of every element of a kind."""
        chosen = {e.name for e in self.elements if kind_or_name in (e.name, e.kind)}
        if not chosen:
            known = [*self.names, *{element.kind for element in self.elements}]
            raise NamingError(
                f"driveline {self.name!r}", f"has no element or kind {kind_or_name!r}", nearest(kind_or_name, known)
            )
        return replace(self, elements=tuple(e.copy(**values) if e.name in chosen else e for e in self.elements))

    def include(self, prefix: str, other: Driveline) -> Driveline:
        """With another driveline taken in as a sub-assembly; its elements are renamed ``prefix_name``, its parameters shared.

        Base frequencies keep their shaft, limits of named elements their elements. The operating speed and the reference shaft
        stay those of this driveline.
        """
        rename = {element.name: identifier(f"{prefix}_{element.name}", f"assembly {prefix!r}") for element in other.elements}

        def moved(target: str) -> str:
            name, dot, flange = target.partition(".")
            return rename.get(name, name) + dot + flange

        elements = [
            element.copy(rename[element.name], **{key: moved(target) for key, target in element.targets.items()})
            for element in other.elements
        ]
        bases = dict(other.bases)
        for key, base in bases.items():
            shaft = base.shaft or other.reference
            bases[key] = replace(base, shaft=moved(shaft) if shaft else None)
        for key, value in (*other.parameters.items(), *bases.items()):
            mine = self.parameters.get(key) or self.bases.get(key)
            if mine is not None and mine != value:
                raise NamingError(f"assembly {prefix!r}", f"{key!r} differs from the driveline's own", "rename one of them")
        inner = {f"{prefix}_{key}": tuple(rename[name] for name in names) for key, names in other.assemblies.items()}
        return replace(
            self,
            elements=(*self.elements, *elements),
            connections=(*self.connections, *((moved(a), moved(b)) for a, b in other.connections)),
            parameters={**self.parameters, **other.parameters},
            bases={**self.bases, **bases},
            balanced=(*self.balanced, *(rename[name] for name in other.balanced)),
            assemblies={**self.assemblies, prefix: tuple(rename.values()), **inner},
            limits=(*self.limits, *(limit.renamed(rename) for limit in other.limits if limit.elements)),
        )

    def parameter_of(self, element: Element, key: str) -> NamedParameter | None:
        """The shared parameter that an element's value refers to, or None where the value is its own."""
        value = element.values[key]
        if not isinstance(value, Shared):
            return None
        if value.name not in self.parameters:
            where = f"{element.where}, {key}"
            raise NamingError(where, f"there is no parameter {value.name!r}", nearest(value.name, self.parameters))
        return self.parameters[value.name]

    def clock_base(self, element: Element, clock: str) -> str:
        """Name of the base frequency that an unbound clock of an element runs on."""
        base = element.clocks.get(clock)
        if base is None:
            raise ModelError(element.where, f"{clock} is missing", "name a base frequency of the driveline")
        if base not in self.bases:
            raise NamingError(element.where, f"there is no base frequency {base!r}", nearest(base, self.bases))
        return base

    def __str__(self) -> str:
        kinds: dict[str, int] = {}
        for element in self.elements:
            kinds[element.kind] = kinds.get(element.kind, 0) + 1
        listed = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
        at = f" at {self.speed * 30 / 3.141592653589793:.6g} rpm of {self.reference!r}" if self.speed is not None else ""
        return f"driveline {self.name!r}: {len(self.elements)} elements ({listed}){at}"

    __repr__ = __str__
