"""Which figures a run draws, where they stand in the report, and what is written below them.

Part of ``reports``; the drawing is that of ``plots``. Nine or ten figures for a geared driveline, the paper's Fig. 1 to 8 among
them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from modelgen.analysis.time_domain.settled import GIVEN, LOWEST_MODE
from modelgen.errors import CaseError
from modelgen.reports import limit
from modelgen.reports.progress import Progress
from modelgen.reports.response import Response

FOLDER = "figures"


@dataclass(frozen=True)
class Figure:
    """A figure in the report: file path relative to it, section, title and caption."""

    path: str
    place: str
    title: str
    caption: str


@dataclass(frozen=True)
class Drawing:
    """A figure that is still to be drawn."""

    name: str
    place: str
    title: str
    caption: str
    draw: Callable[[], Any]


def draw_figures(response: Response, folder: Path, progress: Progress) -> list[Figure]:
    """Draws and saves every figure that the driveline has something to show for, as PNG."""
    from modelgen.plots import save  # Matplotlib is slow to load, and the simulation comes first

    (folder / FOLDER).mkdir()
    figures, drawings = [], list(_drawings(response))
    for done, each in enumerate(drawings):
        progress.fraction(done / len(drawings))
        path = f"{FOLDER}/{each.name}.png"
        save(each.draw(), folder / path)
        figures.append(Figure(path, each.place, each.title, each.caption))
    return figures


def _drawings(response: Response) -> Iterator[Drawing]:
    from modelgen import plots

    line, modes, solution, window = response.line, response.modes, response.solution, response.window
    found, inertias = response.angles, response.angles.inertias
    verdict = limit.verdict(limit.judged(response))
    bound = verdict.limit if verdict else None
    equations = response.model.equations
    whole = window.base in (GIVEN, LOWEST_MODE)
    yield Drawing("driveline", "model", "driveline", "The driveline as it was run.", partial(plots.draw, equations))
    if len(modes.frequencies) > modes.rigid:
        caption = "Shapes of the lowest vibrating modes in referred angles: an ideal gear pair would make no step."
        yield Drawing("modes", "modes", "mode shapes", caption, partial(plots.plot, modes, driveline=equations))
    if inertias:
        caption = "Vibration and elastic angle of every inertia, 0-peak and half p-p, physical and referred."
        yield Drawing("angles", "angles", "angles", caption, partial(plots.plot, found, limit=bound))
        worst = max(inertias, key=lambda name: inertias[name].vibration.peak)
        wanted = dict.fromkeys([line.reference or "", worst, list(inertias)[-1]])
        shown = [name for name in wanted if name in inertias]
        caption = "Vibration angle at the reference shaft, where it is largest, and at the last inertia, physical."
        chosen = partial(plots.responses, solution, window, shown, last=None if whole else 2, limit=bound)
        yield Drawing("responses", "angles", "responses", caption, chosen)
    if found.meshes:
        caption = (
            "Mesh forces over the window, and forces and deflections about the largest one; gray where the teeth are apart, red "
            "where the back flank carries."
        )
        forces = partial(plots.mesh_forces, solution, window)
        yield Drawing("mesh_forces", "meshes", "mesh forces", caption, forces)
    yield from _mesh_drawings(response)
    if response.crosscheck is not None and any(run.differences for run in response.crosscheck.runs):
        caption = "Differences between the solvers, by tolerance and by channel."
        yield Drawing("crosscheck", "crosscheck", "cross-check", caption, partial(plots.plot, response.crosscheck))


def _mesh_drawings(response: Response) -> Iterator[Drawing]:
    """Stiffness, damping and backlash of the gear pairs."""
    from modelgen import plots

    try:
        meshes = plots.gear_meshes(response.model, response.point)
    except CaseError:  # a driveline without elastic gear pairs
        return
    caption = "Mesh stiffness over two mesh periods: from the teeth where it follows from them, and as the model has it."
    yield Drawing("mesh_stiffness", "meshes", "mesh stiffness", caption, partial(plots.mesh_stiffness, meshes))
    if any(pair.errors is not None for pair in meshes.pairs):
        caption = "Error of the Fourier series of the mesh stiffness against its order: the rms falls, the largest error stays."
        yield Drawing("fitting_errors", "meshes", "fitting errors", caption, partial(plots.fitting_errors, meshes))
    caption = "Mesh damping over two mesh periods: corrected, and as printed in the paper."
    yield Drawing("mesh_damping", "meshes", "mesh damping", caption, partial(plots.mesh_damping, meshes))
    caption = "Backlash function of every pair, with the static state under the mean torques."
    yield Drawing("backlash", "meshes", "backlash", caption, partial(plots.backlash, meshes))
