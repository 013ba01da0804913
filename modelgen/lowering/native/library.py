"""A native solver of one right-hand side: its source put together, built or found in the cache, loaded and called.

Last step of the compiler. The key of a build holds the function, this generator, the compiler and the processor, so nothing is
staged or printed for what was built before, and a new value of a parameter builds nothing.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from modelgen.errors import LoweringError
from modelgen.lowering.native.cache import library_for
from modelgen.lowering.native.compiler import find_compiler
from modelgen.lowering.native.emission import stage_functions
from modelgen.lowering.native.stages import Stages

_HERE = Path(__file__).parent
_GENERATOR = (
    "operations.py",
    "graph.py",
    "collection.py",
    "stages.py",
    "emission.py",
    "library.py",
    "scalar.h",
    "lanes.h",
    "solver.h",
)
_ALIGNMENT = 64
_DOUBLES = ctypes.POINTER(ctypes.c_double)
_COUNTS = ctypes.POINTER(ctypes.c_int64)

OUTCOMES = ("RUNNING", "SUCCESS", "MAX_STEPS", "STEP_TOO_SMALL", "NON_FINITE_RATE", "DIVERGED")  # as in solver.h
COUNTS = ("outcome", "steps", "rejected", "evaluations", "reached", "stop")
FACTS = ("time", "size", "smallest", "largest")


class Task(ctypes.Structure):
    """What all workers of a run share; the fields are described in solver.h."""

    _fields_ = (
        *((name, ctypes.c_int64) for name in ("jobs", "samples", "times_stride")),
        ("next", _COUNTS),
        *((name, _DOUBLES) for name in ("p", "x0", "scale", "times", "states", "last", "extrema")),
        ("counts", _COUNTS),
        ("facts", _DOUBLES),
        *(
            (name, ctypes.c_double)
            for name in ("begin", "tolerance", "first_step", "largest_step", "smallest_step", "bound", "correction")
        ),
        ("max_steps", ctypes.c_int64),
    )


class NativeSolver:
    """A loaded solver of one right-hand side; ``lanes`` trajectories run side by side in each worker.

    Calls release the interpreter's lock; any number of threads may work on one ``Task``, each with a workspace of its own.
    """

    def __init__(self, path: Path) -> None:
        self._library = ctypes.CDLL(str(path))
        self._library.modelgen_sizes.restype = ctypes.c_int64
        self._library.modelgen_sizes.argtypes = [ctypes.c_int64]
        self._library.modelgen_run.restype = ctypes.c_int64
        self._library.modelgen_run.argtypes = [ctypes.POINTER(Task), ctypes.c_void_p, ctypes.c_int64]
        self._library.modelgen_start.restype = None
        self._library.modelgen_start.argtypes = [ctypes.c_void_p]
        self._library.modelgen_job.restype = ctypes.c_int64
        self._library.modelgen_job.argtypes = [ctypes.c_void_p, ctypes.c_int64]
        self._library.modelgen_rates.restype = None
        self._library.modelgen_rates.argtypes = [ctypes.c_void_p, ctypes.c_double, _DOUBLES, _DOUBLES, _DOUBLES]
        sizes = [int(self._library.modelgen_sizes(index)) for index in range(7)]
        self.states, self.parameters, self.lanes, self._bytes, task, self.parameter_values, self.time_values = sizes
        if task != ctypes.sizeof(Task):
            raise LoweringError("native code", f"the library expects tasks of {task} bytes", "clear the cache of libraries")

    def workspace(self) -> np.ndarray:
        """Memory for one worker, ready to start."""
        raw = np.zeros(self._bytes + _ALIGNMENT, dtype=np.uint8)
        offset = -raw.ctypes.data % _ALIGNMENT
        work = raw[offset : offset + self._bytes]
        self._library.modelgen_start(work.ctypes.data)
        return work

    def run(self, task: Task, work: np.ndarray, steps: int) -> bool:
        """Go on for at most so many steps; whether anything is left to do."""
        return bool(self._library.modelgen_run(ctypes.byref(task), work.ctypes.data, steps))

    def jobs(self, work: np.ndarray) -> list[int]:
        """The jobs that a worker is at, lane by lane; -1 where a lane is idle."""
        return [int(self._library.modelgen_job(work.ctypes.data, lane)) for lane in range(self.lanes)]

    def rates(self, t: float, x: Any, p: Any) -> np.ndarray:
        """dx/dt at one place, from the same stages that the solver uses."""
        x, p = np.ascontiguousarray(x, dtype=float), np.ascontiguousarray(p, dtype=float)
        if x.shape != (self.states,) or p.shape != (self.parameters,):
            raise LoweringError(
                "native code", f"x and p have shapes {x.shape} and {p.shape}", f"wanted ({self.states},), ({self.parameters},)"
            )
        found, work = np.zeros(self.states), self.workspace()
        self._library.modelgen_rates(work.ctypes.data, t, *(each.ctypes.data_as(_DOUBLES) for each in (x, p, found)))
        return found


def source(function: ca.Function, lanes: bool) -> str:
    """The whole C text of a native solver: for one trajectory, or for lanes. Raises LoweringError for an operation without C."""
    stages = Stages.of(function)
    printed = stage_functions(stages, "v_" if lanes else "s_")
    head = "" if lanes else "#define SINGLE\n"
    return head + _text("scalar.h") + _text("lanes.h") + _text("solver.h").replace('#include "stages.h"\n', printed)


def _text(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")


@functools.lru_cache(maxsize=32)
def native_solver(function: ca.Function, lanes: bool = False) -> NativeSolver:
    """The native solver of an SX function (t, x, p) -> dx/dt, built or from the cache.

    Raises NoCompilerError without a compiler, LoweringError for an operation that has no C.
    """
    compiler = find_compiler()

    def build(folder: Path, library: Path) -> None:
        text = folder / "solver.c"
        text.write_text(source(function, lanes), encoding="utf-8")
        compiler.build(text, library)

    parts = (function.serialize().encode(), _generator(), compiler.identity().encode(), b"lanes" if lanes else b"single")
    key = hashlib.sha256(b"\0".join(hashlib.sha256(part).digest() for part in parts)).hexdigest()
    return NativeSolver(library_for(key, build))


@functools.cache
def _generator() -> bytes:
    """The files that decide what is printed."""
    return b"\0".join((_HERE / name).read_bytes() for name in _GENERATOR)
