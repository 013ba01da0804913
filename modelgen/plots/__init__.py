"""Answers: every result as a figure, ``plot(result)``, and the driveline itself, ``draw(driveline)``. Matplotlib lives here only.

Last stage of the flow before the command line: ``Solution -> <Question>Result -> Figure -> save``. ``style`` decides how figures
look; a file draws one kind of result and registers it with ``plot``. What needs more than a result, or draws another side of one,
has a name of its own: ``responses`` and ``mesh_forces`` of a solution over a window, ``energy_shares`` of modes, ``damper_power``
of a forced response, and the figures of ``gear_meshes``.
"""

from modelgen.plots.angles import plot_angles
from modelgen.plots.campbell import plot_campbell
from modelgen.plots.channels import plot_solution
from modelgen.plots.comparison import plot_comparison
from modelgen.plots.crosscheck import plot_crosscheck
from modelgen.plots.damper_power import damper_power
from modelgen.plots.dispatch import plot
from modelgen.plots.drawing import draw
from modelgen.plots.forced import plot_forced
from modelgen.plots.hammer import plot_hammer
from modelgen.plots.limits import plot_limits
from modelgen.plots.mesh_curves import GearMeshes, MeshCurves, gear_meshes
from modelgen.plots.mesh_figures import backlash, fitting_errors, mesh_damping, mesh_stiffness
from modelgen.plots.mesh_forces import mesh_forces
from modelgen.plots.modes import plot_modes
from modelgen.plots.referee import plot_referee
from modelgen.plots.responses import responses
from modelgen.plots.saving import save
from modelgen.plots.sensitivity import energy_shares, plot_sensitivities

__all__ = [
    "GearMeshes",
    "MeshCurves",
    "backlash",
    "damper_power",
    "draw",
    "energy_shares",
    "fitting_errors",
    "gear_meshes",
    "mesh_damping",
    "mesh_forces",
    "mesh_stiffness",
    "plot",
    "plot_angles",
    "plot_campbell",
    "plot_comparison",
    "plot_crosscheck",
    "plot_forced",
    "plot_hammer",
    "plot_limits",
    "plot_modes",
    "plot_referee",
    "plot_sensitivities",
    "plot_solution",
    "responses",
    "save",
]
