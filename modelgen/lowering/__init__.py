"""The compiler: SymPy equations become CasADi expressions, staged functions and C."""

from modelgen.lowering.compiled import Compiled
from modelgen.lowering.lower import lower

__all__ = ["Compiled", "lower"]
