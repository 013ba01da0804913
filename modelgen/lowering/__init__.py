"""The compiler: SymPy equations become CasADi expressions, staged functions and C."""

from modelgen.lowering.compiled import Compiled
from modelgen.lowering.lower import lower
from modelgen.lowering.switching import Section

__all__ = ["Compiled", "Section", "lower"]
