"""An element: one physical thing, its flanges, its parameters, and the laws it answers for.

First stage of the flow. A subclass declares (``modelgen.model.declarations``) and answers questions; defining it is enough to
make it known to model files. An instance holds values and the names of what its flanges are joined to; it never holds results.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Mapping
from numbers import Integral
from types import MappingProxyType
from typing import Any, ClassVar, TypeVar

import sympy

from modelgen.errors import ModelError, NamingError, nearest
from modelgen.model.declarations import Choice, Clock, Declaration, Flange, FlangeSymbols, Orders, Param, Switched
from modelgen.model.modes import Guard, Modes
from modelgen.model.names import identifier
from modelgen.model.questions import refuse_idle, refuse_misspelt
from modelgen.model.values import Shared, read_value, with_whole_series

Kind = TypeVar("Kind")
_OWN_NAMES = ("name", "note", "kind", "where", "targets", "choices", "harmonics", "clocks", "values", "lengths")


class Element:
    """Base of all elements. Subclasses declare flanges and parameters and answer the questions below.

    A complete new element, a shaft whose stiffness grows with the square of its twist:

    >>> from modelgen.model import Element, Flange, Param, quantity
    >>> class HardeningShaft(Element):
    ...     '''Shaft with T = k u + k3 u^3, u = angle a - angle b.'''
    ...     a, b = Flange(), Flange()
    ...     stiffness = Param("N*m/rad", positive=True)
    ...     cubic = Param("N*m/rad^3", nonnegative=True)
    ...     @quantity("rad")
    ...     def twist(self):
    ...         return self.a.angle - self.b.angle
    ...     @quantity("N*m")
    ...     def torque(self):
    ...         return self.stiffness * self.twist + self.cubic * self.twist**3
    ...     def torques(self):
    ...         return {self.a: -self.torque, self.b: self.torque}
    >>> HardeningShaft("coupling", a="engine", b="pump", stiffness="40 kN*m/rad", cubic=2.0e6)
    HardeningShaft('coupling', a='engine', b='pump', stiffness=40000.0, cubic=2000000.0)
    >>> del Element.vocabulary["hardening_shaft"]
    """

    vocabulary: ClassVar[dict[str, type[Element]]] = {}
    kind: ClassVar[str]
    sense: ClassVar[int] = 1
    """-1 where forward on one flange is backward in space on the other, as in an external gear pair."""
    balanced_by: ClassVar[str | None] = None
    """The parameter that ``Driveline.balance`` may scale, for elements that load the driveline."""

    def __init_subclass__(cls) -> None:
        cls.kind = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).lower()
        known = Element.vocabulary.get(cls.kind)
        if known is not None and (known.__module__, known.__qualname__) != (cls.__module__, cls.__qualname__):
            where = f"element class {cls.__name__}"
            raise NamingError(where, f"the kind {cls.kind!r} is already taken by {known.__module__}", "rename the class")
        for key, value in vars(cls).items():
            if isinstance(value, Declaration) and (hasattr(Element, key) or key in _OWN_NAMES):
                where = f"element class {cls.__name__}"
                raise NamingError(where, f"declares {key!r}, a name that every element uses itself", "choose another name")
        refuse_misspelt(cls, Element)
        Element.vocabulary[cls.kind] = cls

    def __init__(self, name: str, /, *targets: str, note: str = "", **values: Any) -> None:
        self.name = identifier(name, self.kind)
        self.note = note
        self.where = f"{self.kind} {name!r}"
        refuse_idle(type(self), Element, self.where)
        flanges = self.declared(Flange)
        if len(targets) > len(flanges):
            raise ModelError(
                self.where, f"is joined to {len(targets)} things", f"it has {len(flanges)} flange(s): {', '.join(flanges)}"
            )
        joined = dict(zip(flanges, targets, strict=False))
        for flange in flanges:
            if flange in values:
                if flange in joined:
                    raise ModelError(self.where, f"flange {flange!r} is given twice", "give it once")
                joined[flange] = values.pop(flange)
        for flange, target in joined.items():
            if not isinstance(target, str):
                raise ModelError(
                    self.where, f"flange {flange!r} is joined to {target!r}", "give the name of an element or element.flange"
                )
        self.targets: Mapping[str, str] = MappingProxyType(joined)
        self.choices: Mapping[str, str] = MappingProxyType(self._read_choices(values))
        self.harmonics: Mapping[str, tuple[int, ...]] = MappingProxyType(self._read_orders(values))
        self.clocks: Mapping[str, str] = MappingProxyType(self._read_clocks(values))
        self.values: Mapping[str, float | tuple[float, ...] | Shared] = MappingProxyType(self._read_params(values))
        self.lengths: dict[str, int] = {key: len(value) for key, value in self.values.items() if isinstance(value, tuple)}
        if values:
            key = next(iter(values))
            known = [*flanges, *self.choices, *self.declared(Orders), *self.declared(Clock), *self._params()]
            raise NamingError(self.where, f"has no parameter {key!r}", nearest(key, known))

    # -- what the class declares ---------------------------------------------------------------------------------------

    @classmethod
    def declared(cls, kind: type[Kind]) -> dict[str, Kind]:
        """The class's declarations of one kind, in the order of their definition."""
        found: dict[str, Kind] = {}
        for owner in reversed(cls.__mro__):
            found.update({key: value for key, value in vars(owner).items() if isinstance(value, kind)})
        return found

    def _params(self) -> dict[str, Param]:
        return {key: param for key, param in self.declared(Param).items() if param.exists(self.choices)}

    # -- reading values ------------------------------------------------------------------------------------------------

    def _read_choices(self, values: dict[str, Any]) -> dict[str, str]:
        chosen = {}
        for key, choice in self.declared(Choice).items():
            value = values.pop(key, choice.default)
            if value not in choice.options:
                raise ModelError(self.where, f"{key} is {value!r}", nearest(str(value), choice.options))
            chosen[key] = value
        return chosen

    def _read_orders(self, values: dict[str, Any]) -> dict[str, tuple[int, ...]]:
        read = {}
        for key, declared in self.declared(Orders).items():
            if key in values:
                self._refuse_unless_used(key, declared)
                orders = values.pop(key)
                whole = isinstance(orders, Iterable) and all(isinstance(n, Integral) and not isinstance(n, bool) for n in orders)
                if not whole or not all(0 < n <= 1000 for n in orders) or len(set(orders)) != len(tuple(orders)):
                    raise ModelError(self.where, f"{key} are {orders!r:.60}", "give different whole numbers from 1 to 1000")
                read[key] = tuple(map(int, orders))
        return read

    def _read_clocks(self, values: dict[str, Any]) -> dict[str, str]:
        read = {}
        for key, clock in self.declared(Clock).items():
            if clock.flange is None and key in values:
                base = values.pop(key)
                if not isinstance(base, str):
                    raise ModelError(self.where, f"{key} is {base!r:.60}", "give the name of a base frequency")
                read[key] = base
        return read

    def _read_params(self, values: dict[str, Any]) -> dict[str, float | tuple[float, ...] | Shared]:
        read: dict[str, float | tuple[float, ...] | Shared] = {}
        for key, param in self.declared(Param).items():
            if not param.exists(self.choices):
                if key in values:
                    self._refuse_unless_used(key, param)
                continue
            value = values.pop(key, param.default)
            if value is None:
                raise ModelError(
                    self.where, f"{key} is missing", f"give it in {param.unit}" if param.unit != "1" else "give a number"
                )
            read[key] = read_value(value, param, f"{self.where}, {key}")
        return read

    def _refuse_unless_used(self, key: str, declared: Switched) -> None:
        for switch, allowed in declared.when.items():
            if self.choices[switch] not in (allowed if isinstance(allowed, tuple) else (allowed,)):
                unused = f"{key} is given, but {switch}={self.choices[switch]!r} does not use it"
                raise ModelError(self.where, unused, "drop it or change the switch")

    # -- the questions an element answers; symbols in, expressions out -------------------------------------------------

    def torques(self) -> Mapping[FlangeSymbols, Any]:
        """Torque [N*m] that the element exerts on the node of each flange."""
        return {}

    def inertias(self) -> Mapping[FlangeSymbols, Any]:
        """Moment of inertia [kg*m^2] that turns with each flange."""
        return {}

    def kinetic_energy(self) -> Any:
        """Kinetic energy [J] where an inertia depends on angle or couples flanges; its torques follow by Lagrange. Or None."""
        return None

    def constraints(self) -> Iterable[Any]:
        """Linear combinations of flange angles that are always zero; they are eliminated exactly."""
        return ()

    def rates(self) -> Mapping[sympy.Symbol, Any]:
        """Time derivative of each own state."""
        return {}

    def stored_energy(self) -> Any:
        """Potential energy [J]."""
        return 0

    def dissipated_power(self) -> Any:
        """Power [W] turned into heat."""
        return 0

    def supplied_power(self) -> Any:
        """Power [W] that comes from outside, apart from the explicit time dependence of ``stored_energy``."""
        return 0

    def modal_damping(self) -> Any:
        """Damping ratio for all elastic modes, if the element asks for modal damping. Or None."""
        return None

    def regions(self) -> Mapping[sympy.Symbol, Any]:
        """Where a mode holds: its expression is zero or positive. The first of a variable wins; elsewhere it is at rest."""
        return {}

    def guards(self) -> Iterable[Guard]:
        """What changes a mode that has memory, or makes the state jump, or ends the run."""
        return ()

    def holds(self) -> Mapping[sympy.Symbol, tuple[Any, sympy.Symbol]]:
        """Speed that does not change while a mode holds, and the multiplier that keeps it so."""
        return {}

    # -- an element as a value -----------------------------------------------------------------------------------------

    def given(self) -> dict[str, Any]:
        """Everything that differs from the defaults, as keyword arguments that make the same element again."""
        params, choices = self.declared(Param), self.declared(Choice)
        result: dict[str, Any] = dict(self.targets)
        result.update({key: value for key, value in self.choices.items() if value != choices[key].default})
        result.update(self.harmonics)
        result.update(self.clocks)
        result.update({key: value for key, value in self.values.items() if value != params[key].default})
        return result

    def copy(self, name: str | None = None, **changes: Any) -> Element:
        """The same element with other values, or under another name; a changed switch drops the values it does not use.

        A row of a series is named as in ``**{"stiffness_cosine[1]": "3e7 N/m"}``; rows count from 1.
        """
        changes = with_whole_series(changes, self.values, self.where)
        choices = {**self.choices, **{key: value for key, value in changes.items() if key in self.choices}}
        declared = self.declared(Switched)
        kept = {key: value for key, value in self.given().items() if key not in declared or declared[key].exists(choices)}
        return type(self)(name or self.name, **{"note": self.note, **kept, **changes})

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and isinstance(other, Element) and self._identity() == other._identity()

    def __hash__(self) -> int:
        return hash(self._identity())

    def _identity(self) -> tuple[Any, ...]:
        parts = (self.targets, self.choices, self.harmonics, self.clocks, self.values)
        return (self.name, self.note, *(tuple(sorted(part.items(), key=str)) for part in parts))

    def __repr__(self) -> str:
        shown = "".join(f", {key}={_brief(value)}" for key, value in self.given().items())
        return f"{type(self).__name__}({self.name!r}{shown})"

    @classmethod
    def describe(cls) -> str:
        """What the element is and what it asks for, a line for each parameter and for its modes."""
        lines = [f"{cls.kind}: {inspect.getdoc(cls) or ''}", "flanges: " + ", ".join(cls.declared(Flange))]
        for key, choice in cls.declared(Choice).items():
            lines.append(f"  {key} = {' | '.join(choice.options)}  {choice.doc}")
        for key, param in cls.declared(Param).items():
            default = "required" if param.default is None else f"default {param.default}"
            lines.append(f"  {key} [{param.unit}] {default}  {param.doc}")
        for key, modes in cls.declared(Modes).items():
            lines.append(f"  {key}: {' or '.join(modes.values)}  {modes.doc}")
        return "\n".join(lines)


def _brief(value: Any) -> str:
    if isinstance(value, Shared):
        return repr(value.name)
    if isinstance(value, tuple) and len(value) > 4:
        return f"({value[0]!r}, ... {len(value)} values)"
    return repr(value)


def harmonic_rows(
    where: str, orders: tuple[int, ...], cosine: tuple[Any, ...], sine: tuple[Any, ...]
) -> list[tuple[int, Any, Any]]:
    """(order, cosine coefficient, sine coefficient) of a Fourier series; a series left out counts as zeros. Raises ModelError."""
    orders = orders or tuple(range(1, max(len(cosine), len(sine)) + 1))
    if {len(cosine), len(sine)} - {0, len(orders)}:
        found = f"has {len(cosine)} cosine and {len(sine)} sine rows for {len(orders)} orders"
        raise ModelError(where, found, "give one cosine and one sine per order, or leave one series out")
    zeros = (sympy.Integer(0),) * len(orders)
    return list(zip(orders, cosine or zeros, sine or zeros, strict=True))
