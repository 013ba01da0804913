"""The compiled driveline: CasADi functions with names and units. Third of the seven records.

Calls are strict: CasADi itself would fill a missing argument with zero, repeat a scalar, or take a transposed row. The fast path
(``fast_rhs``) checks once and then costs about a microsecond per call.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import casadi as ca
import numpy as np

from modelgen.equations.records import Equations
from modelgen.errors import CaseError, nearest
from modelgen.lowering.mean_model import MeanModel
from modelgen.lowering.parameters import ParameterTable
from modelgen.lowering.sampling import sampled
from modelgen.lowering.switched import SwitchedModel, SwitchingParts, switched_model
from modelgen.lowering.switching import Crossing, Section, Switching

Vector = Sequence[float] | np.ndarray
Made = TypeVar("Made")


def _shared(make: Callable[[Compiled], Made]) -> functools.cached_property[Made]:
    """A cached property that a model with other values of its own takes from the model that it was made of."""

    @functools.wraps(make)
    def found(model: Compiled) -> Made:
        return make(model) if model.origin is None else getattr(model.origin, make.__name__)

    return functools.cached_property(found)


@dataclass(frozen=True, eq=False)
class Compiled:
    """Numeric functions of one driveline; nothing in it is rebuilt when a parameter changes.

    ``expressions`` hands out plain CasADi SX (keys t, x, p, ode, outputs) for other tools. ``mean_model`` holds the functions for
    equilibrium and linearization.

    All these find discrete modes by comparison. ``switched`` gives the same model with modes as flags at the tail of p, for
    solvers that locate events; ``switching_parts`` builds it when it is first asked for.
    """

    equations: Equations
    parameters: ParameterTable
    expressions: Mapping[str, ca.SX]
    states: tuple[str, ...]
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    mean_model: MeanModel
    switching_parts: Callable[[], SwitchingParts]
    origin: Compiled | None = None

    def with_values(self, values: Mapping[str, Any]) -> Compiled:
        """The same model with other values of its own; it shares every function, and nothing is built anew.

        What is asked of it answers for these values. Raises NamingError, ModelError, UnitError or CaseError as ``vector`` does.
        """
        return replace(self, parameters=self.parameters.with_values(values), origin=self.origin or self) if values else self

    def __eq__(self, other: object) -> bool:
        """Whether two models compute by the same functions, whatever values they hold."""
        return isinstance(other, Compiled) and (self.origin or self) is (other.origin or other)

    def __hash__(self) -> int:
        return id(self.origin or self)

    @property
    def name(self) -> str:
        """Name of the driveline."""
        return self.equations.name

    @_shared
    def rhs_function(self) -> ca.Function:
        """CasADi function (t, x, p) -> time derivative of x."""
        e = self.expressions
        return ca.Function("rhs", [e["t"], e["x"], e["p"]], [ca.densify(e["ode"])], ["t", "x", "p"], ["ode"])

    @_shared
    def jacobian_function(self) -> ca.Function:
        """CasADi function (t, x, p) -> derivative of the right-hand side by x, sparse."""
        e = self.expressions
        return ca.Function("jacobian", [e["t"], e["x"], e["p"]], [ca.jacobian(e["ode"], e["x"])], ["t", "x", "p"], ["jacobian"])

    @_shared
    def output_function(self) -> ca.Function:
        """CasADi function (t, x, p) -> all output channels."""
        e = self.expressions
        return ca.Function("outputs", [e["t"], e["x"], e["p"]], [ca.densify(e["outputs"])], ["t", "x", "p"], ["outputs"])

    @_shared
    def switching(self) -> Switching | None:
        """The modes and guards of the model; None where it has none."""
        switched = self.switched()
        return None if switched is None else switched.switching

    def switched(self, sections: Sequence[Section] = ()) -> SwitchedModel | None:
        """The model with its modes as flags, and with sections as further crossings; None where there is neither.

        Raises CaseError for an unknown channel. Sections that differ in their values alone build nothing anew.
        """
        if not (self.equations.modes or self.equations.guards or sections):
            return None
        key = tuple((each.channel, each.direction, each.stop) for each in sections)
        if key not in self._models:
            self._models[key] = self._with_sections(key)
        model = self._models[key]
        tail = model.tail.copy()
        tail[len(tail) - len(sections) :] = [each.value for each in sections]
        return replace(model, tail=tail)

    @_shared
    def _models(self) -> dict[tuple[tuple[str, int, bool], ...], SwitchedModel]:
        """What has been built, by the sections in it but for their values."""
        return {}

    def _with_sections(self, sections: tuple[tuple[str, int, bool], ...]) -> SwitchedModel:
        rows = [self.output_index(channel) for channel, _, _ in sections]
        crossings = [Crossing(f"section {channel}", direction, stops=stop) for channel, direction, stop in sections]
        e = self.expressions
        return switched_model(self._parts, e["t"], e["x"], e["p"], self.outputs, rows, crossings)

    @_shared
    def _parts(self) -> SwitchingParts:
        if self.equations.modes or self.equations.guards:
            return self.switching_parts()
        e, none = self.expressions, ca.SX(0, 1)
        return SwitchingParts((), (), none, e["ode"], e["outputs"], none, ca.SX(len(self.states), 0))

    def extended(self, p: Vector, sections: Sequence[Section] = ()) -> np.ndarray:
        """The parameter vector with the modes of the start, and the values of the sections, at its tail."""
        p = self._array("p", p, (self.parameters.size,), f"a vector of {self.parameters.size}")
        model = self.switched(sections)
        return p if model is None else model.extended(p)

    def rhs(self, t: float, x: Vector, p: Vector) -> np.ndarray:
        """Time derivative of the state at time t [s]. Raises CaseError unless shapes fit and all numbers are finite."""
        return np.asarray(self.rhs_function(*self._checked(t, x, p))).ravel()

    def jacobian(self, t: float, x: Vector, p: Vector) -> np.ndarray:
        """Derivative of the right-hand side by the state, dense (n, n)."""
        return np.asarray(self.jacobian_function(*self._checked(t, x, p)).full())

    def evaluate(self, t: float, x: Vector, p: Vector) -> dict[str, float]:
        """All output channels at one instant, by name."""
        values = np.asarray(self.output_function(*self._checked(t, x, p))).ravel()
        return dict(zip(self.outputs, values.tolist(), strict=True))

    def channels(
        self, times: np.ndarray, states: np.ndarray, p: Vector, names: Sequence[str] | None = None
    ) -> dict[str, np.ndarray]:
        """Output channels over a trajectory: times (n,), states (n, number of states).

        Raises CaseError for an unknown name, and unless shapes fit and all numbers are finite.
        """
        rows = range(len(self.outputs)) if names is None else [self.output_index(name) for name in names]
        instants, count = np.size(times), len(self.states)
        times = self._array("times", times, (instants,), "one row of times")
        states = self._array("states", states, (instants, count), f"{instants} rows of {count} states")
        p = self._array("p", p, (self.parameters.size,), f"a vector of {self.parameters.size}")
        values = sampled(self.output_function, [times[None, :], states.T], p, list(rows))
        return {self.outputs[row]: values[index] for index, row in enumerate(rows)}

    def output_index(self, name: str) -> int:
        """Row of an output channel. Raises CaseError with the nearest name."""
        if name not in self.outputs:
            raise CaseError(f"driveline {self.name!r}", f"no output {name!r}", nearest(name, self.outputs))
        return self.outputs.index(name)

    def unit(self, name: str) -> str:
        """Unit of an output channel."""
        return self.units[self.output_index(name)]

    def state_index(self, name: str) -> int:
        """Position of a state in x. Raises CaseError with the nearest name."""
        if name not in self.states:
            raise CaseError(f"driveline {self.name!r}", f"no state {name!r}", nearest(name, self.states))
        return self.states.index(name)

    def fast_rhs(self, p: Vector) -> Callable[[float, np.ndarray], np.ndarray]:
        """A right-hand side f(t, x) for tight loops with the parameters fixed; it returns the same array every time."""
        function = self.rhs_function
        _, x, p_checked = self._checked(0.0, np.zeros(len(self.states)), p)
        buffer, trigger = function.buffer()
        t, out = np.zeros(1), np.zeros(len(self.states))
        for index, array in enumerate((t, x, p_checked)):
            buffer.set_arg(index, array.data)
        buffer.set_res(0, out.data)

        def fast(time: float, state: np.ndarray) -> np.ndarray:
            t[0] = time
            x[:] = state
            trigger()
            return out

        fast.keep = (function, buffer, x, p_checked)  # type: ignore[attr-defined]  # the buffers must outlive the call
        return fast

    def _checked(self, t: float, x: Vector, p: Vector) -> tuple[float, np.ndarray, np.ndarray]:
        states, count = len(self.states), self.parameters.size
        time = self._array("t", t, (), "a scalar")
        return (
            float(time),
            self._array("x", x, (states,), f"a vector of {states}"),
            self._array("p", p, (count,), f"a vector of {count}"),
        )

    def _array(self, name: str, value: Any, shape: tuple[int, ...], wanted: str) -> np.ndarray:
        """A copy of an argument as numbers, refused unless it has exactly this shape and is finite."""
        where = f"driveline {self.name!r}, {name}"
        try:
            array = np.array(value, dtype=float)
        except (TypeError, ValueError):
            raise CaseError(where, "does not hold plain numbers", f"give {wanted}") from None
        if array.shape != shape:
            raise CaseError(where, f"has the shape {array.shape}", f"give {wanted}")
        if not np.all(np.isfinite(array)):
            raise CaseError(where, "is not finite", "give finite numbers")
        return array

    @_shared
    def fingerprint(self) -> str:
        """SHA-256 of what the driveline computes: its expressions with their names, not its parameter values."""
        text = hashlib.sha256()
        text.update("\n".join((*self.states, *self.outputs, *self.units, *self.parameters.labels())).encode())
        functions = [self.rhs_function, self.output_function]
        if (switched := self.switched()) is not None:
            switching = switched.switching
            text.update(f"{switching.modes} {switching.crossings}".encode())
            functions += [switched.rhs_function, switching.guards, *([switching.resets] if switching.resets else [])]
        for function in functions:
            text.update(_instructions(function).encode())
        return text.hexdigest()

    def __str__(self) -> str:
        count = self.rhs_function.n_instructions()
        jacobian = self.jacobian_function.nnz_out(0)
        return (
            f"compiled {self.name!r}: {len(self.states)} states, {self.parameters.size} parameters, {len(self.outputs)} outputs\n"
            f"  right-hand side of {count} instructions, Jacobian with {jacobian} entries"
        )

    __repr__ = __str__


def _instructions(function: Any) -> str:
    """The instruction list of an SX function as text; equal for equal computations."""
    rows = []
    for k in range(function.n_instructions()):
        constant = function.instruction_constant(k) if function.instruction_id(k) == ca.OP_CONST else ""
        rows.append(f"{function.instruction_id(k)} {function.instruction_output(k)} {function.instruction_input(k)} {constant!r}")
    return "\n".join(rows)
