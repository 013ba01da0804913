"""Answers: every result as a figure, ``plot(result)``, and the driveline itself, ``draw(driveline)``. Matplotlib lives here only.

Last stage of the flow before the command line: ``Solution -> <Question>Result -> Figure -> save``. ``style`` decides how figures
look; a file draws one kind of result and registers it with ``plot``. What needs more than a result, or draws another side of one,
has a name of its own: ``responses`` and ``mesh_forces`` of a solution over a window, ``energy_shares`` of modes, ``damper_power``
of a forced response, ``plot_events`` of a solution, and the figures of ``gear_meshes``.
"""

from modelgen.plots.angles import plot_angles
from modelgen.plots.bifurcation import plot_bifurcation
from modelgen.plots.campbell import plot_campbell
from modelgen.plots.channels import plot_solution
from modelgen.plots.comparison import plot_comparison
from modelgen.plots.crosscheck import plot_crosscheck
from modelgen.plots.damper_power import damper_power
from modelgen.plots.diagram_readings import diagram_readings
from modelgen.plots.dispatch import plot
from modelgen.plots.drawing import draw
from modelgen.plots.events import plot_events
from modelgen.plots.exponents import plot_exponents
from modelgen.plots.forced import plot_forced
from modelgen.plots.frequency_sweep import plot_frequency_sweep
from modelgen.plots.hammer import plot_hammer
from modelgen.plots.limits import plot_limits
from modelgen.plots.maps import plot_map
from modelgen.plots.mesh_curves import GearMeshes, MeshCurves, gear_meshes
from modelgen.plots.mesh_figures import backlash, fitting_errors, mesh_damping, mesh_stiffness
from modelgen.plots.mesh_forces import mesh_forces
from modelgen.plots.modes import plot_modes
from modelgen.plots.orbits import plot_orbits
from modelgen.plots.portraits import portraits
from modelgen.plots.referee import plot_referee
from modelgen.plots.responses import responses
from modelgen.plots.saving import save
from modelgen.plots.sections import plot_section
from modelgen.plots.sensitivity import energy_shares, plot_sensitivities
from modelgen.plots.sweep import plot_sweep

__all__ = [
    "GearMeshes",
    "MeshCurves",
    "backlash",
    "damper_power",
    "diagram_readings",
    "draw",
    "energy_shares",
    "fitting_errors",
    "gear_meshes",
    "mesh_damping",
    "mesh_forces",
    "mesh_stiffness",
    "plot",
    "plot_angles",
    "plot_bifurcation",
    "plot_campbell",
    "plot_comparison",
    "plot_crosscheck",
    "plot_events",
    "plot_exponents",
    "plot_forced",
    "plot_frequency_sweep",
    "plot_hammer",
    "plot_limits",
    "plot_map",
    "plot_modes",
    "plot_orbits",
    "plot_referee",
    "plot_section",
    "plot_sensitivities",
    "plot_solution",
    "plot_sweep",
    "portraits",
    "responses",
    "save",
]
