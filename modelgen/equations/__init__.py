"""The grammar: drivelines become equations of motion. It knows no element by name."""

from modelgen.equations.assembly import assemble
from modelgen.equations.plain import system
from modelgen.equations.records import Equations

__all__ = ["Equations", "assemble", "system"]
