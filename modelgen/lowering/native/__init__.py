"""Native code: a right-hand side staged, printed as C with its solver around it, built, cached and loaded.

``graph`` -> ``collection`` -> ``stages`` (what depends on parameters, on time, on the state) -> ``emission`` and ``functions``
(C text) -> ``library`` (through ``compiler`` and ``cache``). Around the stages stand a step printed from a tableau (``steps``)
and, as they are, ``scalar.h`` and ``lanes.h`` (values), ``task.h`` (memory, shared with ``task``), ``dense.h`` (between steps),
``guards.h`` and ``events.h`` (where a guard passes zero, and what follows), ``march.h`` (sizes of steps) and ``solver.h`` (the
loop). The guards that every step watches share the stages of the right-hand side; resets, channels, and guards asked for at other
times are small libraries of their own, so that asking for others does not build the solver anew.
"""

from modelgen.lowering.native.compiler import NoCompilerError
from modelgen.lowering.native.library import NativeObserver, NativeSolver, native_observer, native_solver

__all__ = ["NativeObserver", "NativeSolver", "NoCompilerError", "native_observer", "native_solver"]
