"""draw(driveline): the driveline as a picture, as an engineer sketches it. The paper's Fig. 5.

Seen from the side: disks on shaft lines, gear pairs as meshing wheels between the lines, torques as arrows, ground below.
"""

from __future__ import annotations

from matplotlib.figure import Figure

from modelgen.equations import Equations, assemble
from modelgen.errors import CaseError
from modelgen.model import Driveline
from modelgen.plots import glyphs
from modelgen.plots.layout import layout
from modelgen.plots.parts import Parts, parts
from modelgen.plots.scene import scene
from modelgen.plots.signs import BORDER
from modelgen.plots.style import WIDTH, page, sheet, styled


@styled
def draw(driveline: Driveline | Equations) -> Figure:
    """The driveline, drawn. Raises CaseError for something else, ModelError for a driveline that cannot exist.

    >>> from modelgen import Driveline, Inertia, Shaft
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])
    >>> draw(line).get_label()
    'two_disks: driveline'
    """
    if not isinstance(driveline, (Driveline, Equations)):
        raise CaseError("draw", f"there is no drawing of a {type(driveline).__name__}", "give a Driveline or its Equations")
    equations = assemble(driveline) if isinstance(driveline, Driveline) else driveline
    found = parts(equations)
    made = scene(layout(equations), found)
    width, height = max(WIDTH, made.size[0]), made.size[1]
    figure = sheet(equations.name, "driveline", _legend(found), height=height, width=width)
    left, bottom, right, top = made.room.bounds
    axes = page(figure)
    middle = (left + right) / 2
    axes.set(xlim=(middle - width / 2, middle + width / 2), ylim=(bottom - BORDER, top + BORDER))
    for ends in made.distant.values():
        glyphs.distant_gear(axes, *ends)
    for points in made.shafts:
        glyphs.shaft(axes, *points)
    for wheel in (wheel for pair in made.wheels.values() for wheel in pair):
        glyphs.wheel(axes, wheel.x, wheel.y, wheel.radius)
    for node, (x, y) in made.at.items():
        if made.disks[node]:
            glyphs.disk(axes, x, y, made.half_height[node], made.disks[node])
        else:
            glyphs.bare_node(axes, x, y)
    for x, y, arrow in made.arrows:
        glyphs.torque(axes, x, y, arrow.drives)
    for x, y, anchor, _ in made.anchors:
        glyphs.anchor(axes, x, y, anchor.springs)
    for block, box in made.room.labels:
        block.draw(axes, box)
    return figure


def _legend(found: Parts) -> str:
    """What the signs and numbers mean, those that are there."""
    said = ["Disks: inertias J [kg·m²], height by the fourth root of J"]
    if any(shaft.stiffness for shaft in found.shafts.values()):
        said.append(f"lines: shafts with stiffness k [{found.stiffness.unit}]")
    if any(wheels.teeth != (0, 0) for wheels in found.wheels.values()):
        said.append("wheels in mesh: gear pairs with tooth numbers z and ratio i, driven/driving")
    if found.arrows:
        said.append("arrows: torques, blue where the mean drives, red where it loads")
    if found.anchors:
        said.append("hatched: springs and dampers to ground")
    return "; ".join(said) + "."
