"""A case: everything that decides a run, and nothing else. Fourth of the seven records.

What a sweep hashes and a report cites: the model's fingerprint, parameters, start, horizon, solver, tolerance, seed.
"""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError, nearest
from modelgen.lowering import Compiled, Section
from modelgen.solvers.bound_model import compiled_of
from modelgen.solvers.case_values import (
    MOST_SAMPLES,
    read_number,
    read_positive,
    read_rows,
    read_start,
    read_table,
    read_whole,
)
from modelgen.solvers.earlier_state import in_states_of
from modelgen.solvers.registry import method_digest, refuse_unused, solver_named, solver_options

STARTS = ("static", "zero")


@dataclass(frozen=True, eq=False)
class Case:
    """One run of one model.

    ``model``: whatever ``bind`` takes: a driveline, which is compiled, a compiled or bound model, a name or path. ``end`` [s]:
    end of the run; ``begin`` [s]: its start (numbers, or texts such as "20 ms"). ``parameters``: values by name that differ
    from the model's own; ``case.model`` holds them. ``start``: "static" (equilibrium under the mean torques), "zero" (uniform
    rotation, nothing twisted), values of states by name on top of the static ones, values of channels such as ``{"motor.speed":
    "0 rpm", "coupling.torque": "5 N*m"}`` (absolute; what is not named is at rest relative to the uniform rotation, and not
    twisted), or an earlier solution, whose final state it then is. ``samples`` outputs are equally spaced from ``record_from``
    to ``end``; ``channels`` limits which are kept. ``tolerance`` is relative to the scale of each state. ``options`` are those
    of the solver. ``sections``: channels whose passing of a value is to be located and logged. Raises CaseError for what cannot
    be.

    >>> from modelgen import Driveline, Inertia, Shaft
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])
    >>> Case(line, end=0.1, start={"shaft.twist": 0.01}, samples=11).times()[-3:].round(3).tolist()
    [0.08, 0.09, 0.1]
    """

    model: Compiled
    end: float
    parameters: Mapping[str, Any] = field(default_factory=dict)
    start: str | Mapping[str, float] = "static"
    inputs: Mapping[str, Any] = field(default_factory=dict)
    begin: float = 0.0
    record_from: float | None = None
    samples: int = 2001
    channels: tuple[str, ...] | None = None
    solver: str = "rk4"
    tolerance: float = 1e-6
    options: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0
    sections: tuple[Section, ...] = ()
    _given_model: Compiled | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        put = object.__setattr__
        for name in ("parameters", "options", "inputs"):
            put(self, name, read_table(name, getattr(self, name)))
        if self.inputs:
            raise CaseError("case, inputs", f"names {next(iter(self.inputs))!r}", "this model has no inputs")
        self._read_model()
        self._read_times()
        put(self, "samples", read_whole("samples", self.samples, 2, MOST_SAMPLES))
        put(self, "seed", read_whole("seed", self.seed))
        put(self, "tolerance", read_positive("tolerance", self.tolerance))
        put(self, "start", self._start(self.start))
        solver_named(self.solver)
        refuse_unused(self.solver, solver_options(self.tolerance, self.options))
        self._read_channels()

    def _read_model(self) -> None:
        """A driveline is compiled; the model takes the case's values for its own, and whoever asks it is answered for them."""
        model: Any = self.model
        model = None if model is None else compiled_of(model, "case")
        object.__setattr__(self, "_given_model", model)
        object.__setattr__(self, "model", None if model is None else model.with_values(self.parameters))

    def _read_times(self) -> None:
        put = object.__setattr__
        for name in ("begin", "end"):
            put(self, name, read_number(name, getattr(self, name), "s"))
        first = self.begin if self.record_from is None else read_number("record_from", self.record_from, "s")
        put(self, "record_from", first)
        if not self.begin <= first < self.end:
            times = f"begin {self.begin:g}, record_from {first:g}, end {self.end:g}"
            raise CaseError("case, times", f"are {times} s", "they must follow each other")

    def _read_channels(self) -> None:
        put = object.__setattr__
        if self.channels is not None:
            put(self, "channels", read_rows("channels", self.channels, '("shaft.torque",)'))
            for name in self.channels:
                if not isinstance(name, str):
                    raise CaseError("case, channels", f"hold {name!r:.60}", "give names of channels")
                if self.model is not None:
                    self.model.output_index(name)
        put(self, "sections", read_rows("sections", self.sections, '(Section("element.channel", value),)'))
        for section in self.sections:
            if not isinstance(section, Section):
                raise CaseError("case, sections", f"hold a {type(section).__name__}", 'give Section("element.channel", value)')
            if self.model is not None:
                self.model.output_index(section.channel)

    def _start(self, start: Any) -> str | Mapping[str, float]:
        """The start as a word, or as values of states and channels by name; an earlier solution gives its final state."""
        if isinstance(start, str) and start in STARTS:
            return start
        if hasattr(start, "final"):
            if not start.final:
                raise CaseError("case, start", "is a solution without a single sample", "take one that ran")
            earlier = getattr(getattr(start, "case", None), "model", None)
            start = start.final if self.model is None else in_states_of(self.model, earlier, start.final)
        if not isinstance(start, Mapping):
            remedy = 'give "static", "zero", or values of states by name, of channels, or an earlier solution'
            raise CaseError("case, start", f"is {start!r:.60}", remedy)
        return MappingProxyType(read_start(self.model, start) if self.model is not None else dict(start))

    def times(self) -> NDArray[np.float64]:
        """Output times [s]."""
        return np.linspace(float(self.record_from or 0.0), self.end, self.samples)

    def change(self, **changes: Any) -> Case:
        """The same case with something else; ``parameters`` that are given take the place of the case's own."""
        _check_fields("Case.change", changes)
        return replace(self, **{"model": self._given_model, **changes})

    def data(self) -> dict[str, Any]:
        """The case as plain data, for hashing, saving and citing."""
        return {
            "model": None if self.model is None else self.model.name,
            "fingerprint": None if self.model is None else self.model.fingerprint,
            "parameters": {key: _plain(value) for key, value in sorted(self.parameters.items())},
            "start": self.start if isinstance(self.start, str) else {key: float(v) for key, v in sorted(self.start.items())},
            "begin": self.begin,
            "end": self.end,
            "record_from": self.record_from,
            "samples": self.samples,
            "channels": None if self.channels is None else list(self.channels),
            "solver": self.solver,
            "tolerance": self.tolerance,
            "options": {key: _plain(value) for key, value in sorted(self.options.items()) if key not in ("progress", "cancel")},
            "seed": self.seed,
            "sections": [asdict(section) for section in self.sections],
        }

    def digest(self) -> str:
        """SHA-256 of the case and of the model's own parameter values; equal digests mean equal runs."""
        data = self.data()
        if digest := method_digest(self.solver):
            data["method"] = digest
        if self.model is not None:
            data["values"] = [value.hex() for value in self.model.parameters.unbalanced(self.parameters).tolist()]
        return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()

    def __str__(self) -> str:
        name = "?" if self.model is None else self.model.name
        changed = "".join(f", {key}={value}" for key, value in self.parameters.items())
        span = f"{self.begin:g} to {self.end:g} s from {self.start}"
        return f"case of {name!r}: {span} by {self.solver} at {self.tolerance:g}{changed}"

    __repr__ = __str__


def _check_fields(where: str, given: Mapping[str, Any]) -> None:
    """Raises CaseError for what is no field of a case."""
    known = [each.name for each in fields(Case) if each.init]
    for name in given:
        if name not in known:
            raise CaseError(where, f"has no {name!r}", nearest(name, known))


_made = Case.__init__


@functools.wraps(_made)
def _make(self: Case, *args: Any, **given: Any) -> None:
    _check_fields("Case", given)
    _made(self, *args, **given)


Case.__init__ = _make  # type: ignore[method-assign]  # a misspelt field is one sentence with the nearest name


def _plain(value: Any) -> Any:
    """Numbers and sequences as JSON knows them; anything else by its text."""
    if isinstance(value, (str, bool, int, float)) or value is None:
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(entry) for entry in value]
    return repr(value)
