"""Answers: every result as a figure, ``plot(result)``, and the driveline itself, ``draw(driveline)``. Matplotlib lives here only.

Last stage of the flow before the command line: ``Solution -> <Question>Result -> Figure -> save``. ``style`` decides how figures
look; a file draws one kind of result and registers it with ``plot``. What needs more than a result has a name of its own:
``responses`` and ``mesh_forces`` of a solution over a window, and the figures of ``gear_meshes``.
"""

from modelgen.plots.angles import plot_angles
from modelgen.plots.channels import plot_solution
from modelgen.plots.crosscheck import plot_crosscheck
from modelgen.plots.dispatch import plot
from modelgen.plots.drawing import draw
from modelgen.plots.mesh_curves import GearMeshes, MeshCurves, gear_meshes
from modelgen.plots.mesh_figures import backlash, fitting_errors, mesh_damping, mesh_stiffness
from modelgen.plots.mesh_forces import mesh_forces
from modelgen.plots.modes import plot_modes
from modelgen.plots.responses import responses
from modelgen.plots.saving import save

__all__ = [
    "GearMeshes",
    "MeshCurves",
    "backlash",
    "draw",
    "fitting_errors",
    "gear_meshes",
    "mesh_damping",
    "mesh_forces",
    "mesh_stiffness",
    "plot",
    "plot_angles",
    "plot_crosscheck",
    "plot_modes",
    "plot_solution",
    "responses",
    "save",
]
