"""The record that carries the equations of motion, and its parts. Second of the seven records.

Symbols live in two worlds: a *template* speaks of "a.angle" and "stiffness"; an *instance* says which node and which parameter
of the driveline these are. Nothing here is numeric; ``modelgen.lowering`` turns the record into functions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy

from modelgen.equations.conditions import Condition
from modelgen.equations.mode_records import DiscreteModes, Hold, Transition
from modelgen.model import Driveline


@dataclass(frozen=True)
class Definition:
    """A named quantity of a template; ``depends`` is "parameter", "time" or "state", the stage it can be evaluated in."""

    name: str
    symbol: sympy.Symbol
    expression: sympy.Expr
    unit: str
    depends: str
    mean: sympy.Expr | None = None
    hidden: bool = False


@dataclass(frozen=True)
class Relative:
    """A combination sum(c_f * angle_f) of flange angles that a law sees; ``rate`` is the same of the speeds."""

    name: str
    unit: str
    angle: sympy.Symbol
    rate: sympy.Symbol
    coefficients: Mapping[str, sympy.Expr]
    sees_angle: bool


@dataclass(frozen=True)
class Harmonic:
    """A symbol that stands for sin or cos of ``order`` times a clock's angle."""

    symbol: sympy.Symbol
    clock: str
    order: int
    wave: str


@dataclass(frozen=True)
class Template:
    """The law of an element class for one setting of its switches, shared by all its instances."""

    kind: str
    title: str
    flanges: tuple[str, ...]
    parameters: tuple[tuple[str, tuple[sympy.Symbol, ...]], ...]
    clocks: tuple[str, ...]
    harmonics: tuple[Harmonic, ...]
    states: tuple[tuple[str, sympy.Symbol, str, float, float | None], ...]
    definitions: tuple[Definition, ...]
    relatives: tuple[Relative, ...]
    absolute_angles: tuple[str, ...]
    torques: Mapping[str, sympy.Expr]
    mass: Mapping[tuple[str, str], sympy.Expr]
    constraints: tuple[Mapping[str, sympy.Expr], ...]
    rates: Mapping[sympy.Symbol, sympy.Expr]
    stored_energy: sympy.Expr
    dissipated_power: sympy.Expr
    supplied_power: sympy.Expr
    modal_ratio: str | None
    guards: tuple[Transition, ...]
    sense: int
    law: Mapping[str, Any]
    """The expressions as the element wrote them, case by case, for printing and for proofs: definitions, torques, energies."""
    modes: tuple[DiscreteModes, ...] = ()
    multipliers: tuple[sympy.Symbol, ...] = ()
    holds: tuple[Hold, ...] = ()


@dataclass(frozen=True)
class Instance:
    """One element: which template, which parameters of the driveline, which nodes."""

    name: str
    template: int
    symbols: Mapping[sympy.Symbol, sympy.Symbol]
    nodes: Mapping[str, int]
    clocks: Mapping[str, int]
    forms: tuple[int, ...]
    states: tuple[int, ...] = ()


@dataclass(frozen=True)
class Parameter:
    """A parameter, or a series of them, with its SI value."""

    name: str
    unit: str
    symbols: tuple[sympy.Symbol, ...]
    values: tuple[float, ...]
    series: bool = False
    expression: sympy.Expr | None = None
    positive: bool = False
    nonnegative: bool = False
    least: float | None = None
    largest: float | None = None
    integer: bool = False
    note: str = ""


@dataclass(frozen=True)
class DerivedParameter:
    """Parameters computed by a NumPy function from others before the parameter stage."""

    name: str
    unit: str
    symbols: tuple[sympy.Symbol, ...]
    function: Callable[..., Any]
    arguments: Mapping[str, str | tuple[int, ...] | float]


@dataclass(frozen=True)
class Node:
    """Flanges that share an angle, which is sum(row[g] * angle_g) over the groups; an empty row is held to ground."""

    name: str
    flanges: tuple[str, ...]
    row: Mapping[int, sympy.Expr]

    def over(self, angles: Sequence[Any]) -> Any:
        """The node's angle (or speed) where the groups have these."""
        return sympy.Add(*(c * angles[group] for group, c in self.row.items()))

    @property
    def group(self) -> int | None:
        """The group that it turns with in a fixed ratio; None where it follows several, or none."""
        return next(iter(self.row)) if len(self.row) == 1 else None

    @property
    def ratio(self) -> sympy.Expr | None:
        """Its angle per angle of that group; None where it follows several groups, or none."""
        return None if self.group is None else self.row[self.group]


@dataclass(frozen=True)
class Form:
    """A relative angle over groups: sum(c_g * angle_g); ``state`` if it is a coordinate. ``to_ground``: of one flange alone."""

    name: str
    unit: str
    coefficients: Mapping[int, sympy.Expr]
    sees_angle: bool
    state: int | None = None
    to_ground: bool = False


@dataclass(frozen=True)
class Step:
    """How a group's angle follows from the states: it is a root's own state, or it is solved from a form.

    A form with one group that is not yet placed is solved for it; otherwise ``over`` gives the angle over the states.
    """

    group: int
    state: int
    form: int | None
    over: Mapping[int, sympy.Expr] | None = None


@dataclass(frozen=True)
class BaseClock:
    """A base frequency: ``multiple`` times the operating speed, exact in the whole-number parameters."""

    name: str
    multiple: sympy.Expr


@dataclass(frozen=True)
class StateVariable:
    """A state: kind is "rigid", "vibrating" or "own", each with a rate except own states; scale None is worked out per case."""

    name: str
    unit: str
    kind: str
    is_rate: bool = False
    start: float = 0.0
    scale: float | None = None


@dataclass(frozen=True)
class Output:
    """A named channel with its unit."""

    name: str
    unit: str


@dataclass(frozen=True)
class Equations:
    """M q'' = f(t, q, q', p) of a whole driveline, as templates and instances; the second of the seven records.

    Angles are counted from uniform rotation at the operating speed. ``states`` are the rigid angles (roots) and the vibrating
    relative angles, then their rates, then the elements' own states. ``rigid`` lists the states of rigid rotations whose angle
    drops out of every law: adding to them changes nothing. ``groups`` are the angles that the constraints leave independent,
    ``redundant`` the constraints that say nothing new, ``conditions`` what a parameter vector must keep for that to stay right.
    ``ratios`` and ``mean_speeds`` are speeds of the groups per speed of the reference shaft, without and with ground;
    ``by_speed`` gives the latter per each of the given speeds, ``rotations`` the groups' angles over those of the free rotations.
    """

    name: str
    description: str
    templates: tuple[Template, ...]
    instances: tuple[Instance, ...]
    parameters: tuple[Parameter, ...]
    derived: tuple[DerivedParameter, ...]
    nodes: tuple[Node, ...]
    groups: tuple[str, ...]
    grounded: tuple[bool, ...]
    ratios: tuple[sympy.Expr, ...]
    mean_speeds: tuple[sympy.Expr, ...]
    by_speed: tuple[tuple[sympy.Expr, ...], ...]
    forms: tuple[Form, ...]
    steps: tuple[Step, ...]
    rotations: tuple[Mapping[int, sympy.Expr], ...]
    clocks: tuple[BaseClock, ...]
    states: tuple[StateVariable, ...]
    outputs: tuple[Output, ...]
    rigid: tuple[int, ...]
    reference: str | None
    speed: sympy.Symbol | None
    modal_ratio: str | None
    balanced: tuple[str, ...]
    drifts: bool
    inputs: tuple[str, ...] = ()
    tables: tuple[str, ...] = ()
    constraints: tuple[Mapping[int, sympy.Expr], ...] = ()
    redundant: tuple[int, ...] = ()
    conditions: tuple[Condition, ...] = ()
    modes: Mapping[str, tuple[str, ...]] = ()  # type: ignore[assignment]  # empty where no element has modes
    guards: tuple[tuple[str, Transition], ...] = ()
    assemblies: Mapping[str, tuple[str, ...]] = ()  # type: ignore[assignment]  # empty for a flat driveline
    balance_may_drive: bool = False
    source: Driveline | None = field(default=None, compare=False, repr=False)  # what it was assembled from, if from a driveline

    def latex(self) -> str:
        """The equations as a LaTeX fragment for a report; plain text."""
        from modelgen.equations.latex import latex  # it prints this record, so it stands below it

        return latex(self)

    def markdown(self) -> str:
        """The equations as Markdown for the web and for notebooks; plain text."""
        from modelgen.equations.latex import markdown

        return markdown(self)

    def mass_matrix(self) -> sympy.Matrix:
        """M [kg*m^2] over the groups; see ``modelgen.equations.symbolic``."""
        from modelgen.equations.symbolic import mass_matrix

        return mass_matrix(self)

    def forces(self, named: bool = False) -> sympy.Matrix:
        """f [N*m] of M q'' = f(t, q, q', p), written out, or with ``named`` in terms of the elements' named quantities."""
        from modelgen.equations.symbolic import forces

        return forces(self, named)

    def linearized(self, named: bool = False) -> tuple[sympy.Matrix, sympy.Matrix, sympy.Matrix]:
        """M, C = -df/dq', K = -df/dq as expressions of angles, speeds and parameters."""
        from modelgen.equations.symbolic import linearized

        return linearized(self, named)

    def __str__(self) -> str:
        if not self.groups:
            counts = f"{len(self.states)} states, {len(self.parameters)} parameters, {len(self.outputs)} outputs"
            return f"equations of {self.name!r}: {counts}"
        rigid = sum(not state.is_rate and state.kind == "rigid" for state in self.states)
        vibrating = sum(not state.is_rate and state.kind == "vibrating" for state in self.states)
        own = sum(state.kind == "own" for state in self.states)
        numbers = sum(len(each.symbols) for each in self.parameters)
        laws = f"{len(self.instances)} elements of {len(self.templates)} laws"
        angles = f"{rigid} rigid and {vibrating} vibrating angles, their rates" + (f", {own} own" if own else "")
        rows = [
            f"equations of {self.name!r}: {len(self.groups)} degrees of freedom",
            f"  {len(self.states)} states: {angles}",
            f"  {numbers} parameters in {len(self.parameters)} names, {sum(bool(each.symbols) for each in self.derived)} derived",
            f"  {laws}, {len(self.clocks)} base frequencies, {len(self.outputs)} outputs",
        ]
        return "\n".join(rows)

    __repr__ = __str__
