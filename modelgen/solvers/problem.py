"""What a solver sees and what it gives back: numbers and one function, no elements.

Part of ``solvers``: ``simulate`` turns a compiled model and a case into an ``InitialValueProblem``; every solver turns that and
``SolverOptions`` into a ``Trajectory``. CasADi broadcasts scalars and accepts rows for columns without a word, so shapes are
checked here, once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from numbers import Real
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError
from modelgen.lowering.step_control import BOUND, SMALLEST_STEP
from modelgen.lowering.switching import Switching
from modelgen.solvers.event_log import EventLog
from modelgen.solvers.outcome import Outcome

Vector = NDArray[np.float64]

RULES = ("smooth", "paper")
BACKENDS = ("vm", "c", "auto")
EVENTS = ("auto", "on", "off")


def finite_vector(name: str, value: Any, length: int | None = None) -> Vector:
    """A read-only float64 copy of a one-dimensional, finite array of the given length; anything else is refused."""
    where = f"initial value problem, {name}"
    if isinstance(value, np.ndarray) and value.dtype.kind not in "fiu":
        raise CaseError(where, f"holds {value.dtype} values", "give real numbers")
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise CaseError(where, f"is not an array of numbers but {type(value).__name__}", "give a NumPy array") from None
    if array.ndim != 1 or (length is not None and array.size != length):
        wanted = f"({length},)" if length is not None else "(n,)"
        raise CaseError(where, f"has shape {array.shape}, wanted {wanted}", "nothing is broadcast; give one number per entry")
    bad = np.flatnonzero(~np.isfinite(array))
    if bad.size:
        raise CaseError(where, f"entry {bad[0]} is {array[bad[0]]}", "give finite numbers")
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class InitialValueProblem:
    """x' = f(t, x, p), x(t0) = x0, wanted at ``times``; the run ends at the last of them.

    ``rhs`` is a CasADi function (t, x, p) -> x' with dense columns of nx and np entries. ``scale`` (nx, positive, in the unit of
    each state) is the size that a tolerance refers to. ``times`` [s] increase and start at ``t0`` or later. ``switching``: the
    events to be located, if any; p then holds the flags of its modes.
    Raises CaseError for a wrong shape, an order that does not increase, or a value that is not finite.

    >>> t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p")
    >>> decay = ca.Function("decay", [t, x, p], [-p * x])
    >>> InitialValueProblem(decay, ("x",), x0=[1.0], p=[2.0], scale=[1.0], t0=0.0, times=[0.5, 1.0]).horizon
    1.0
    >>> InitialValueProblem(decay, ("x",), x0=1.0, p=[2.0], scale=[1.0], t0=0.0, times=[1.0])
    Traceback (most recent call last):
    ...
    modelgen.errors.CaseError: initial value problem, x0: has shape (), wanted (1,); nothing is broadcast; ...
    """

    rhs: ca.Function
    names: tuple[str, ...]
    x0: Vector
    p: Vector
    scale: Vector
    t0: float
    times: Vector
    switching: Switching | None = None

    def __post_init__(self) -> None:
        nx, parameters = _shape_of(self.rhs)
        if isinstance(self.names, str) or len(self.names) != nx:
            raise CaseError("initial value problem, names", f"are {len(self.names)}, states are {nx}", "name every state once")
        arrays = {
            "x0": finite_vector("x0", self.x0, nx),
            "p": finite_vector("p", self.p, parameters),
            "scale": finite_vector("scale", self.scale, nx),
            "times": finite_vector("times", self.times),
        }
        for name, array in arrays.items():
            object.__setattr__(self, name, array)
        object.__setattr__(self, "names", tuple(self.names))
        object.__setattr__(self, "t0", _finite_number("initial value problem, t0", self.t0))
        if (wrong := np.flatnonzero(self.scale <= 0)).size:
            state = wrong[0]
            problem = f"that of '{self.names[state]}' is {self.scale[state]:g}"
            raise CaseError("initial value problem, scale", problem, "every state needs a positive size")
        _check_times(self.times, self.t0)

    @property
    def horizon(self) -> float:
        """The time from the start to the last output [s]."""
        return float(self.times[-1]) - self.t0


def _shape_of(rhs: Any) -> tuple[int, int]:
    """Numbers of states and of parameters, after a look at the whole signature."""
    where = "initial value problem, rhs"
    if not isinstance(rhs, ca.Function):
        raise CaseError(where, f"is a {type(rhs).__name__}", "give a casadi.Function (t, x, p) -> xdot")
    if (rhs.n_in(), rhs.n_out()) != (3, 1):
        raise CaseError(where, f"has {rhs.n_in()} inputs and {rhs.n_out()} outputs", "wanted are (t, x, p) -> xdot")
    nx, parameters = rhs.numel_in(1), rhs.numel_in(2)
    if nx == 0:
        raise CaseError(where, "has no states", "there is nothing to integrate")
    wanted = {"t": (1, 1), "x": (nx, 1)} | ({"p": (parameters, 1)} if parameters else {})
    for index, (name, size) in enumerate(wanted.items()):
        if rhs.size_in(index) != size or not rhs.sparsity_in(index).is_dense():
            raise CaseError(
                where, f"input {name} is not a dense column but {rhs.sparsity_in(index).dim(True)}", "use densify or vec"
            )
    if rhs.size_out(0) != (nx, 1) or not rhs.sparsity_out(0).is_dense():
        raise CaseError(where, f"output is {rhs.sparsity_out(0).dim(True)}, wanted a dense column of {nx}", "use densify")
    return nx, parameters


def _check_times(times: Vector, t0: float) -> None:
    where = "initial value problem, times"
    if not times.size:
        raise CaseError(where, "is empty", "give at least the end of the run")
    if times[0] < t0:
        raise CaseError(where, f"starts at {times[0]:.9g} s, before t0 = {t0:.9g} s", "time runs forward")
    if (back := np.flatnonzero(np.diff(times) <= 0)).size:
        index = back[0] + 1
        found = f"entry {index} ({times[index]:.9g} s) does not come after the one before"
        raise CaseError(where, found, "give increasing times")


def _finite_number(where: str, value: Any) -> float:
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real) or not math.isfinite(value):
        raise CaseError(where, f"is {value!r}", "give a finite number")
    return float(value)


def _positive(where: str, value: Any) -> None:
    if _finite_number(where, value) <= 0:
        raise CaseError(where, f"is {value!r}", "give a positive number")


@dataclass(frozen=True)
class Budget:
    """What a run may cost and how far it may stray; exceeding it ends the run with a named outcome, never with an error.

    ``max_steps`` tried, accepted or not; ``max_seconds`` of wall clock; ``smallest_step`` as a fraction of the horizon;
    ``bound``: a state further than bound * scale from its start has diverged; ``max_events`` located. The fraction and the bound
    are meant to catch what is hopeless, not what is unusual. (CasADi's integrators take steps in chunks; their count is looked at
    between chunks.)
    """

    max_steps: int = 20_000_000
    max_seconds: float = 600.0
    smallest_step: float = SMALLEST_STEP
    bound: float = BOUND
    max_events: int = 1_000_000

    def __post_init__(self) -> None:
        for entry in fields(self):
            _positive(f"budget, {entry.name}", getattr(self, entry.name))
        for name in ("max_steps", "max_events"):
            if not 1 <= getattr(self, name) == int(getattr(self, name)):
                raise CaseError(f"budget, {name}", f"is {getattr(self, name)!r}", "give a whole number")
        if self.smallest_step >= 1:
            raise CaseError("budget, smallest_step", f"is {self.smallest_step!r}", "it is a fraction of the horizon, below 1")
        if self.bound > 1e150:
            raise CaseError("budget, bound", f"is {self.bound!r}", "squares of it must remain finite; stay below 1e150")


@dataclass(frozen=True)
class SolverOptions:
    """One set of names for all solvers; a solver refuses what it has no use for (see ``registry``).

    ``tolerance``: largest error of a step, relative to the scale of each state (never to its present value).
    ``first_step``, ``largest_step`` [s]: by default estimated, and unlimited. ``fixed_step`` [s]: no error control; the run is
    divided into equal steps of at most this size. ``rule``: "smooth", or the paper's halving and doubling.
    ``backend``: CasADi's virtual machine ("vm"), generated C ("c"), or "auto": the virtual machine for runs of a few thousand
    steps, which are over before C is built, and C for longer ones where there is a compiler. ``extrapolate``: add
    Eq. 31's difference to the result, which raises the order by one. ``progress`` is called with the fraction done, ``cancel``
    returns True to stop; both some twenty times a second.

    ``events``: "on" locates every change of mode and restarts there, "off" leaves it to the error control. "auto" is on where a
    law jumps or has memory, a state is reset, a guard ends the run, or sections are asked for (there "off" is refused); laws that
    are only kinked, such as backlash, are left to the error control. Off costs more steps at every kink, up to twice the
    evaluations where there are many; on costs one look at the guards per step, a tenth of the time in C and some 15 % on the
    virtual machine, and no evaluation where nothing fires.
    """

    tolerance: float
    first_step: float | None = None
    largest_step: float | None = None
    fixed_step: float | None = None
    rule: str = "smooth"
    backend: str = "auto"
    extrapolate: bool = True
    events: str = "auto"
    budget: Budget = field(default_factory=Budget)
    progress: Callable[[float], None] | None = None
    cancel: Callable[[], bool] | None = None

    def __post_init__(self) -> None:
        _positive("solver options, tolerance", self.tolerance)
        for name in ("first_step", "largest_step", "fixed_step"):
            if getattr(self, name) is not None:
                _positive(f"solver options, {name}", getattr(self, name))
        if self.fixed_step is not None and (self.first_step is not None or self.largest_step is not None):
            raise CaseError("solver options, fixed_step", "is given beside first_step or largest_step", "give one or the other")
        if self.backend not in BACKENDS:
            raise CaseError("solver options, backend", f"is {self.backend!r}", f"known are {', '.join(BACKENDS)}")
        if self.rule not in RULES:
            raise CaseError("solver options, rule", f"is {self.rule!r}", f"known are {', '.join(RULES)}")
        if self.events not in EVENTS:
            raise CaseError("solver options, events", f"is {self.events!r}", f"known are {', '.join(EVENTS)}")
        if not isinstance(self.extrapolate, bool):
            raise CaseError("solver options, extrapolate", f"is {self.extrapolate!r}", "give True or False")
        if not isinstance(self.budget, Budget):
            raise CaseError("solver options, budget", f"is {self.budget!r}", "give a Budget")


@dataclass(frozen=True)
class Statistics:
    """What a run cost: steps accepted and rejected, evaluations of the right-hand side, seconds, extreme steps [s] if known.

    ``backend``: "vm", "c", or "vm, for want of a compiler" where C was to be taken and there is none.
    """

    steps: int
    rejected: int
    evaluations: int
    seconds: float
    smallest_step: float | None = None
    largest_step: float | None = None
    backend: str = "vm"


@dataclass(frozen=True, eq=False)
class Trajectory:
    """The states (n, nx) at the output times that were reached (n,), and how the run ended.

    A run that failed carries what it had computed until then. Every number in it is finite, whatever the outcome.
    """

    times: Vector
    states: Vector
    outcome: Outcome
    message: str
    statistics: Statistics
    events: EventLog | None = None
