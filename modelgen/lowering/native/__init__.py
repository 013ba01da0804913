"""Native code: a right-hand side staged, printed as C with its solver around it, built, cached and loaded.

``graph`` -> ``collection`` -> ``stages`` (what depends on parameters, on time, on the state) -> ``emission`` (C text) ->
``library`` (with ``scalar.h``, ``lanes.h`` and ``solver.h``, through ``compiler`` and ``cache``).
"""

from modelgen.lowering.native.compiler import NoCompilerError
from modelgen.lowering.native.library import NativeSolver, native_solver

__all__ = ["NativeSolver", "NoCompilerError", "native_solver"]
