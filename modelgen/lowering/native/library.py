"""A native solver of one right-hand side: its source put together, built or found in the cache, loaded and called.

Last step of the compiler. The key of a build holds the function, this generator, the compiler and the processor, so nothing is
staged or printed for what was built before, and a new value of a parameter builds nothing.
"""

from __future__ import annotations

import _ctypes
import ctypes
import functools
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from modelgen.errors import LoweringError
from modelgen.lowering import instructions, step_control, tableau
from modelgen.lowering.methods import read_tableau
from modelgen.lowering.native.cache import library_for
from modelgen.lowering.native.compiler import NoCompilerError, find_compiler
from modelgen.lowering.native.functions import kinds_of, observer_functions, stage_functions
from modelgen.lowering.native.stages import Stages
from modelgen.lowering.native.steps import bundle, step_functions, step_sizes, with_error
from modelgen.lowering.native.task import Log, Observer, Task, c_records
from modelgen.lowering.step_control import c_macros
from modelgen.lowering.tableau import Tableau

_HERE = Path(__file__).parent
_HEADERS = ("scalar.h", "lanes.h", "task.h", "times.h", "dense.h", "guards.h", "roots.h", "events.h", "march.h", "solver.h")
_GENERATOR = (
    *("operations.py", "graph.py", "collection.py", "waves.py", "stages.py", "emission.py", "statements.py", "looped.py"),
    *("windows.py", "functions.py", "kinds.py", "explicit_step.py", "doubled_step.py", "steps.py", "task.py", "library.py"),
    *_HEADERS,
)
_ALIGNMENT = 64
SIZES = {"solver": "modelgen_sizes", "observer": "observer_sizes"}  # what a library of each kind answers first
_DOUBLES = ctypes.POINTER(ctypes.c_double)
_COUNTS = ctypes.POINTER(ctypes.c_int64)


class NativeSolver:
    """A loaded solver of one right-hand side; ``lanes`` trajectories run side by side in each worker.

    Calls release the interpreter's lock; any number of threads may work on one ``Task``, each with a workspace of its own.
    """

    def __init__(self, path: Path) -> None:
        self._library = library = _loaded(path)
        task, work, log = ctypes.POINTER(Task), ctypes.c_void_p, ctypes.POINTER(Log)
        for name, result, arguments in (
            ("sizes", ctypes.c_int64, [ctypes.c_int64]),
            ("bytes", ctypes.c_int64, [task]),
            ("start", None, [task, work]),
            ("run", ctypes.c_int64, [task, work, log, ctypes.c_int64]),
            ("job", ctypes.c_int64, [work, ctypes.c_int64]),
            ("rates", None, [work, ctypes.c_int64, ctypes.c_double, *[_DOUBLES] * 4]),
        ):
            function = getattr(library, f"modelgen_{name}")
            function.restype, function.argtypes = result, arguments
        sizes = [int(library.modelgen_sizes(index)) for index in range(7)]
        self.states, self.parameters, self.lanes, _, size, self.parameter_values, self.time_values = sizes
        if size != ctypes.sizeof(Task):
            raise LoweringError("native code", f"the library expects tasks of {size} bytes", "clear the cache of libraries")

    def workspace(self, task: Task) -> np.ndarray:
        """Memory for one worker on a task, ready to start."""
        count = int(self._library.modelgen_bytes(ctypes.byref(task)))
        raw = np.zeros(count + _ALIGNMENT, dtype=np.uint8)
        offset = -raw.ctypes.data % _ALIGNMENT
        work = raw[offset : offset + count]
        self._library.modelgen_start(ctypes.byref(task), work.ctypes.data)
        return work

    def run(self, task: Task, work: np.ndarray, log: Log, steps: int) -> bool:
        """Go on for at most so many steps, or until the log is nearly full; whether anything is left to do."""
        return bool(self._library.modelgen_run(ctypes.byref(task), work.ctypes.data, ctypes.byref(log), steps))

    def jobs(self, work: np.ndarray) -> list[int]:
        """The jobs that a worker is at, lane by lane; -1 where a lane is idle."""
        return [int(self._library.modelgen_job(work.ctypes.data, lane)) for lane in range(self.lanes)]

    def rates(self, t: Any, x: Any, p: Any, step: float = 0.0) -> np.ndarray:
        """dx/dt (nx) at one place, from the same stages that the solver uses; for times t (n) in order: (n, nx).

        ``step`` > 0: as at the start of steps so long, so that waves are read off polynomials where the solver would do so.
        """
        times = np.atleast_1d(np.ascontiguousarray(t, dtype=float))
        x, p = np.ascontiguousarray(x, dtype=float), np.ascontiguousarray(p, dtype=float)
        if x.shape != (self.states,) or p.shape != (self.parameters,):
            raise LoweringError(
                "native code", f"x and p have shapes {x.shape} and {p.shape}", f"wanted ({self.states},), ({self.parameters},)"
            )
        found, work = np.zeros((times.size, self.states)), self.workspace(Task())
        rows = (each.ctypes.data_as(_DOUBLES) for each in (times, x, p, found))
        self._library.modelgen_rates(work.ctypes.data, times.size, step, *rows)
        return found if np.ndim(t) else found[0]


class NativeObserver:
    """A loaded function (t, x, p) or (t, x, v, p) -> column that a solver asks for within its run: guards, resets, channels."""

    def __init__(self, path: Path) -> None:
        self._library = _loaded(path)  # holds the code as long as it is pointed to
        self._library.observer_sizes.restype = ctypes.c_int64
        self._library.observer_sizes.argtypes = [ctypes.c_int64]
        sizes = [int(self._library.observer_sizes(index)) for index in range(5)]
        self.values, self.outputs, self.states, self.parameters, self.lanes = sizes

    def entry(self) -> Observer:
        """What a task needs to know of it."""
        places = (ctypes.cast(getattr(self._library, f"observer_{name}"), ctypes.c_void_p) for name in ("parameters", "at"))
        return Observer(self.values, self.outputs, *places)


def source(function: ca.Function, lanes: bool, tableau: Tableau, guards: ca.Function | None = None) -> str:
    """The whole C text of a native solver: for one trajectory, or for lanes. Raises LoweringError for an operation without C."""
    surfaces = 0 if guards is None else int(guards.numel_out(0)) // 2
    chosen, middle = with_error(tableau)
    stages = Stages.of(function if guards is None else _together(function, guards), with_waves=True)
    printed = stage_functions(stages, "v_" if lanes else "s_", times=bundle(chosen, surfaces > 0))
    records = _text("task.h").replace('#include "stages.h"\n', printed).replace('#include "records.h"\n', c_records())
    texts = [_head(lanes), c_macros(), step_sizes(chosen, middle, surfaces), records]
    texts += [_text("times.h"), step_functions(chosen, middle, kinds_of(stages), surfaces > 0)]
    texts += [_text(name) for name in _HEADERS[4:]]
    return "\n".join(texts)


def _together(function: ca.Function, guards: ca.Function) -> ca.Function:
    """Rates, guards and rates of the guards as one function (t, x, v, p), so that they share what parameters and time fix."""
    t, x, v, p = (ca.SX.sym(name, guards.sparsity_in(index)) for index, name in enumerate(("t", "x", "v", "p")))
    return ca.Function("step", [t, x, v, p], [ca.densify(ca.vertcat(function(t, x, p), guards(t, x, v, p)))])


def observer_source(function: ca.Function, lanes: bool) -> str:
    """The whole C text of an observer for a solver of one trajectory, or of lanes."""
    return _head(lanes) + observer_functions(Stages.of(function))


def _head(lanes: bool) -> str:
    return ("" if lanes else "#define SINGLE\n") + _text("scalar.h") + _text("lanes.h")


def _text(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")


def native_solver(
    function: ca.Function, lanes: bool = False, method: str = "rk4", guards: ca.Function | None = None
) -> NativeSolver:
    """The native solver of an SX function (t, x, p) -> dx/dt by an explicit method of a name, built or found.

    ``guards``: (t, x, v, p) -> the guards that every step watches, then their rates. Raises NoCompilerError without a compiler,
    LoweringError for an operation that has no C or an unknown method.
    """
    return solver_of(function, lanes, read_tableau(method), guards)


@functools.lru_cache(maxsize=32)
def solver_of(function: ca.Function, lanes: bool, tableau: Tableau, guards: ca.Function | None) -> NativeSolver:
    """The same by the table of the method; a method is known by its numbers."""
    functions = (function,) if guards is None else (function, guards)
    return NativeSolver(_built(functions, ("solver", tableau, lanes), lambda: source(function, lanes, tableau, guards)))


@functools.lru_cache(maxsize=64)
def native_observer(function: ca.Function, lanes: bool = False) -> NativeObserver:
    """The observer of an SX function (t, x, p) or (t, x, v, p) -> one dense column, built or from the cache."""
    return NativeObserver(_built((function,), ("observer", lanes), lambda: observer_source(function, lanes)))


def _loaded(path: Path) -> ctypes.CDLL:
    """A library of ours. Raises NoCompilerError where the machine does not let it be loaded."""
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        remedy = "set $MODELGEN_CACHE to a folder on a file system that is not mounted noexec, or run on CasADi's virtual machine"
        raise NoCompilerError("native code", f"a built library cannot be loaded: {error!s:.160}", remedy) from None


def _probe(path: Path, function: str) -> None:
    """Loads what was just built and asks it for its sizes, before it is kept: a compiler may end well and write rubbish."""
    library = _loaded(path)
    try:
        sizes = getattr(library, function)
    except AttributeError:
        problem = f"the compiler wrote a library without {function}"
        raise NoCompilerError("native code", problem, "correct $CC, or run on CasADi's virtual machine") from None
    sizes.restype, sizes.argtypes = ctypes.c_int64, [ctypes.c_int64]
    if sizes(0) < 0:
        raise NoCompilerError("native code", "a library that was just built does not answer", "correct $CC")
    if hasattr(_ctypes, "dlclose"):
        _ctypes.dlclose(library._handle)


def _built(functions: tuple[ca.Function, ...], kind: tuple[object, ...], text_of: Callable[[], str]) -> Path:
    compiler = find_compiler()

    def build(folder: Path, library: Path) -> None:
        text = folder / "solver.c"
        text.write_text(text_of(), encoding="utf-8")
        compiler.build(text, library)
        _probe(library, SIZES[str(kind[0])])

    parts = (
        *(function.serialize().encode() for function in functions),
        _generator(),
        compiler.identity().encode(),
        repr(kind).encode(),
    )
    key = hashlib.sha256(b"\0".join(hashlib.sha256(part).digest() for part in parts)).hexdigest()
    return library_for(key, build)


@functools.cache
def _generator() -> bytes:
    """The files that decide what is printed."""
    others = (tableau, step_control, instructions)
    paths = [*(_HERE / name for name in _GENERATOR), *(Path(str(each.__file__)) for each in others)]
    return b"\0".join(path.read_bytes() for path in paths)
