"""Discrete modes of a compiled model: where a law changes, what leads from one mode to another, and what jumps there.

Part of the compiler's result, read by the solvers. A mode is a flag in the parameter vector, 1 where it holds and 0 elsewhere, so
within a mode the right-hand side is as smooth as its laws, a change of mode never builds anything, and lanes need no branch.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from numbers import Real

import casadi as ca
import numpy as np

from modelgen.errors import CaseError

Vector = np.ndarray


@dataclass(frozen=True)
class ModeVariable:
    """A mode of one element (``mesh.flank``): the names of its values, where its flags begin in p, and the value at the start.

    ``memory``: which value holds does not follow from the state alone. ``continuous``: no law jumps where it changes.
    """

    name: str
    values: tuple[str, ...]
    first: int
    start: int = 0
    memory: bool = False
    continuous: bool = True

    def of(self, p: Vector) -> int:
        """The value that the flags in p say."""
        return int(np.argmax(p[self.first : self.first + len(self.values)]))

    def put(self, p: Vector, value: int) -> None:
        """Set the flags in p."""
        p[self.first : self.first + len(self.values)] = 0.0
        p[self.first + value] = 1.0


@dataclass(frozen=True)
class Crossing:
    """What happens where a guard passes zero.

    ``direction``: +1 rising, -1 falling, 0 both. A crossing with a ``variable`` (its number) is watched in the mode ``leave``
    and leads to ``enter`` (numbers of its values); it also fires at once where that mode is entered with the guard already
    beyond zero, in its direction. One without changes no mode, and if it has no reset either it is a section. ``reset``: column
    of the resets that gives the state after it. ``stops``: the run ends there. ``barrier``: no run starts beyond it.
    """

    name: str
    direction: int
    variable: int | None = None
    leave: int | None = None
    enter: int | None = None
    reset: int | None = None
    stops: bool = False
    barrier: bool = False


@dataclass(frozen=True)
class Section:
    """A surface on which a run is looked at: an output channel passing ``value`` [unit of the channel].

    ``direction``: +1 rising, -1 falling, 0 both. ``stop``: the run ends there. It changes nothing else.
    """

    channel: str
    value: float = 0.0
    direction: int = 1
    stop: bool = False

    def __post_init__(self) -> None:
        where = f"section {self.channel!r:.60}"
        if not isinstance(self.channel, str):
            raise CaseError("section", f"its channel is {self.channel!r:.60}", "give the name of an output channel")
        if isinstance(self.value, bool) or not isinstance(self.value, Real) or not math.isfinite(self.value):
            raise CaseError(where, f"its value is {self.value!r:.60}", "give a finite number in the unit of the channel")
        if isinstance(self.direction, bool) or self.direction not in (-1, 0, 1):
            raise CaseError(where, f"its direction is {self.direction!r:.60}", "give 1 (rising), -1 (falling) or 0 (both)")
        if not isinstance(self.stop, bool):
            raise CaseError(where, f"stop is {self.stop!r:.60}", "give True or False")


@dataclass(frozen=True, eq=False)
class Switching:
    """All modes and guards of a model; every function takes (t, x, p) with the flags of all modes in p.

    ``guards`` gives one value per crossing; ``resets`` (nx, number of resets) the states after the crossings that have one, of
    the state and the modes before; ``p_size`` is the length of p with everything in it.
    """

    modes: tuple[ModeVariable, ...]
    crossings: tuple[Crossing, ...]
    guards: ca.Function
    p_size: int
    resets: ca.Function | None = None

    @property
    def required(self) -> bool:
        """Whether a run without events would be wrong: modes with memory, jumps of the state, guards that end the run."""
        crossings = self.crossings
        return any(mode.memory for mode in self.modes) or any(each.reset is not None or each.stops for each in crossings)

    @property
    def jumps(self) -> bool:
        """Whether a law jumps at a border between modes."""
        return not all(mode.continuous for mode in self.modes)

    @functools.cached_property
    def guard_rates(self) -> ca.Function:
        """(t, x, v, p) -> guards, then their time derivatives along the motion, where v = dx/dt."""
        n, m = self.guards.numel_in(1), self.guards.numel_in(2)
        t, x, v, p = ca.SX.sym("t"), ca.SX.sym("x", n), ca.SX.sym("v", n), ca.SX.sym("p", m)
        value = ca.densify(self.guards(t, x, p))
        rate = ca.jtimes(value, x, v) + ca.jtimes(value, t, ca.SX(1))
        return ca.Function("guard_rates", [t, x, v, p], [ca.densify(ca.vertcat(value, rate))], ["t", "x", "v", "p"], ["values"])

    def value_names(self) -> list[str]:
        """One name per flag, such as ``mesh.flank.drive``, in the order of all variables and values."""
        return [f"{mode.name}.{value}" for mode in self.modes for value in mode.values]
