"""Diameters of shafts, from the command line or from the model: with them a torque becomes a shear stress.

Part of ``reports``, shared by ``forced`` and ``limits``. A mass-elastic table leaves diameters as parameters named
SHAFT_diameter.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from modelgen.reports.assignments import pair

if TYPE_CHECKING:
    from modelgen.analysis.linear.shear_stress import Diameter
    from modelgen.lowering import Compiled
    from modelgen.model import Driveline

NAMED = "_diameter"
DIAMETER = 'Diameter for the stress of a shaft: SHAFT="80 mm", or outer and inner SHAFT="80 mm/40 mm". Repeatable.'


def diameters(line: Driveline, model: Compiled, given: Iterable[str] = ()) -> dict[str, Diameter]:
    """Diameters by shaft: parameters SHAFT_diameter of the driveline, and ``SHAFT=OUTER`` or ``SHAFT=OUTER/INNER`` as given.

    Raises CaseError for what is no assignment, NamingError for a shaft that is not there.
    """
    from modelgen.errors import NamingError, nearest

    twisted = [name.removesuffix(".torque") for name in model.outputs if name.endswith(".torque")]
    found: dict[str, Diameter] = {}
    for name, named in line.parameters.items():
        shaft = name.removesuffix(NAMED)
        if shaft != name and shaft in twisted and isinstance(named.value, float):
            found[shaft] = f"{named.value!r} {named.unit}"
    for text in given:
        shaft, size = pair(text, "--diameter", 'SHAFT=DIAMETER, such as coupling="80 mm"')
        if shaft not in twisted:
            raise NamingError(f"--diameter {shaft}", f"driveline {line.name!r} has no such shaft", nearest(shaft, twisted))
        outer, bored, inner = (part.strip() for part in size.partition("/"))
        found[shaft] = (outer, inner) if bored else outer
    return found
