"""One bound model: what a question is asked of, whatever was handed over.

Part of ``solvers``, on ``operating_point`` and ``linear_model``; every question of ``analysis`` begins with ``bind``. A
driveline, its name, its equations, its compiled model and a case of it all lead to a compiled model that holds its values;
operating point and linear model belong to it, and are found when they are first asked for.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from os import PathLike
from types import MappingProxyType
from typing import Any

from modelgen.drivelines import load
from modelgen.equations import Equations, assemble
from modelgen.errors import CaseError
from modelgen.lowering import Compiled, lower
from modelgen.model import Driveline
from modelgen.solvers.linear_model import LinearModel, linearize
from modelgen.solvers.operating_point import OperatingPoint, point_of

TAKEN = "a Driveline, Equations, a Compiled model, a BoundModel, a Case, or the name or path of a model"


@dataclass(frozen=True, eq=False)
class BoundModel:
    """A compiled model with all its parameters.

    ``model``: its ``model.parameters`` hold the values, so that whatever is asked of it answers for them.
    """

    model: Compiled

    @property
    def name(self) -> str:
        """Name of the driveline."""
        return self.model.name

    @functools.cached_property
    def parameters(self) -> Mapping[str, float | tuple[float, ...]]:
        """Every parameter by name, in its SI unit, with the loads in balance. Raises BalanceError where they cannot be."""
        table, p = self.model.parameters, self.model.parameters.vector()
        values = {name: tuple(p[table.slices[name]].tolist()) for name in table.names}
        return MappingProxyType({name: value if table.parameters[name].series else value[0] for name, value in values.items()})

    @functools.cached_property
    def operating_point(self) -> OperatingPoint:
        """The static state, with balanced parameters. Raises BalanceError or CaseError where there is none."""
        return point_of(self.model)

    @functools.cached_property
    def linear(self) -> LinearModel:
        """The linear model about the operating point: mass, damping, hysteresis and stiffness over the groups."""
        return linearize(self.model, self.operating_point)

    def __str__(self) -> str:
        given = "".join(f", {name} = {value!r:.40}" for name, value in self.model.parameters.given.items())
        return f"{self.name!r} with its parameters{given}"

    __repr__ = __str__


def bind(
    x: Any,
    *,
    speed: Any = None,
    speeds: Mapping[str, Any] | None = None,
    parameters: Mapping[str, Any] | None = None,
    question: str = "bind",
) -> BoundModel:
    """A model with its values: of a driveline, its equations, a compiled or bound model, a case, a catalogue name or a path.

    ``speed``: the operating speed [rad/s] or a text such as "1500 rpm"; ``speeds``: those of other shafts by name, where
    constraints leave several free. ``parameters``: values by name, SI numbers or texts with units, that differ from its own.
    A driveline is compiled once, and found again when it is asked again.
    Raises CaseError for anything else, NamingError for an unknown name, and what assembling raises.

    >>> bound = bind("fracturing-truck", speed="1500 rpm", parameters={"zeta": 0.02})
    >>> bound.parameters["zeta"], round(bound.parameters["speed"], 3)
    (0.02, 157.08)
    >>> bound.operating_point.frequencies()[1:3].round(2).tolist()
    [45.24, 75.25]
    >>> bind(3)
    Traceback (most recent call last):
    ...
    modelgen.errors.CaseError: bind: is asked of int; give a Driveline, Equations, a Compiled model, a BoundModel, a Case, ...
    """
    values = dict(parameters or {})
    if isinstance(x, (str, PathLike)):
        x = load(x)  # type: ignore[arg-type]  # it says itself what it cannot take
    if isinstance(x, Driveline) and (speed is not None or speeds is not None):
        x = replace(x, speed=x.speed if speed is None else speed, speeds=x.speeds if speeds is None else speeds)
        speed = speeds = None
    model = compiled_of(x, question)
    values |= {"speed": speed} if speed is not None else {}
    values |= {f"speeds.{name}": value for name, value in (speeds or {}).items()}
    if isinstance(x, BoundModel) and not values:
        return x
    return BoundModel(model.with_values(values))


def compiled_of(x: Any, question: str) -> Compiled:
    """The compiled model of what a question is asked of, with the values that it holds. Raises CaseError for anything else."""
    if isinstance(x, (str, PathLike)):
        x = load(x)  # type: ignore[arg-type]
    if isinstance(x, Compiled):
        return x
    if isinstance(x, Driveline):
        return _compiled(x)
    if isinstance(x, Equations):
        return lower(x)
    held = getattr(x, "model", x)  # of a BoundModel or a Case
    if held is None and x is not None:
        raise CaseError(question, "the case has no compiled model", "a loaded case cites its model only; give it the driveline")
    if not isinstance(held, Compiled):
        raise CaseError(question, f"is asked of {type(x).__name__}", f"give {TAKEN}")
    return held


@functools.lru_cache(maxsize=16)
def _compiled(line: Driveline) -> Compiled:
    return lower(assemble(line))


def operating_point(x: Any, values: Mapping[str, Any] | None = None, must_rest: bool = True) -> OperatingPoint:
    """The operating point for the model's parameters with some changed by name.

    With ``must_rest=False`` a driveline without an equilibrium has one too, with every angle at zero and the reason in
    ``no_rest``: enough to integrate from a given state.

    Raises BalanceError when the mean torques do not balance and the driveline is not declared to drift, CaseError when there is
    no equilibrium.

    >>> operating_point("fracturing-truck").frequencies()[1:4].round(3).tolist()
    [45.236, 75.253, 124.143]
    """
    bound = bind(x, parameters=values, question="operating_point")
    return bound.operating_point if must_rest else point_of(bound.model, must_rest=False)
