"""The paper's thirteen figures, drawn from what was computed, each with a caption that says in which reading.

Part of ``cli``; the drawing is that of ``plots``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from modelgen.cli.progress import Progress
from modelgen.cli.reproduce_work import Reproduction

FILES = tuple(f"fig_{number:02d}.png" for number in range(1, 14))


@dataclass(frozen=True)
class PaperFigure:
    """A figure with the paper's number: its file, what it shows here, and under which definitions."""

    number: int
    title: str
    caption: str

    @property
    def file(self) -> str:
        """Name in the folder."""
        return FILES[self.number - 1]


Drawing = tuple[str, str, Callable[[], Any]]


def draw_all(work: Reproduction, folder: Path, progress: Progress) -> list[PaperFigure]:
    """Draws and saves the figures 1 to 13."""
    from modelgen.plots import save  # Matplotlib is slow to load, and the computing comes first

    drawings = [*_model(work), *_response(work), _diagrams(work), *_motions(work)]
    figures = []
    for number, (title, caption, draw) in enumerate(drawings, start=1):
        progress.fraction((number - 1) / len(drawings))
        figures.append(PaperFigure(number, title, caption))
        save(draw(), folder / figures[-1].file)
    return figures


def _model(work: Reproduction) -> Iterator[Drawing]:
    """Figures 1 to 5: the meshes and the driveline."""
    from modelgen import plots

    response, order = work.response, work.claims.series_order
    meshes = plots.gear_meshes(response.model, response.point)
    caption = (
        "Error of the mesh stiffness' Fourier series against its order, in percent of the mean. The rms falls with every order, "
        f"the largest error stays. Order {order}, the paper's choice, is no minimum."
    )
    yield "fitting error of the Fourier series", caption, partial(plots.fitting_errors, meshes)
    yield (
        "mesh stiffness and its series",
        "Mesh stiffness over two mesh periods: from the tooth geometry (Eq. 1 to 8), and as the model has it.",
        partial(plots.mesh_stiffness, meshes),
    )
    yield (
        "mesh damping",
        "Time-varying mesh damping over two mesh periods, in the corrected form that the model uses and as Eq. 10 is printed.",
        partial(plots.mesh_damping, meshes),
    )
    yield (
        "backlash function",
        "Backlash function of both pairs (Eq. 12) with the static state under the mean torques.",
        partial(plots.backlash, meshes),
    )
    yield (
        "dynamic model",
        "The whole driveline as it is modelled, with both gear pairs; the paper draws one gear pair.",
        partial(plots.draw, response.model.equations),
    )


def _response(work: Reproduction) -> Iterator[Drawing]:
    """Figures 6 to 8: angles of every inertia, responses at the places that the paper names."""
    from modelgen import plots

    response, claims = work.response, work.claims
    damping = f"Shaft damping {_switch(work, 'shaft')}, mesh damping {_switch(work, 'gear_pair')}."
    last = None if work.extent.window is not None else 2
    caption = (
        "Every inertia in every definition, because order and verdict depend on it: vibration and elastic angle, 0-peak and half "
        f"peak-to-peak, physical and referred. {damping}"
    )
    angles = partial(plots.plot, response.angles, limit=claims.limit_deg)
    yield "largest torsional angle of every inertia", caption, angles
    for role, element in claims.roles.items():
        caption = (
            f"Vibration angle of `{element}`, physical, over the last revolutions of the window, with the limit that the paper "
            f"quotes where it is near. {damping}"
        )
        draw = partial(plots.responses, response.solution, response.window, [element], last=last, limit=claims.limit_deg)
        yield f"response at the {_place(role)}", caption, draw


def _diagrams(work: Reproduction) -> Drawing:
    from modelgen.plots.diagram_readings import diagram_readings

    motion = work.claims.motion
    named = {f"mesh damping ratio {name}": each for name, each in work.diagrams.items()}
    caption = (
        f"Elastic angles at the strobes over the shafts' damping ratio, of the commensurate truck (`{motion.driveline}`), every "
        "column from the static start. Left: mesh damping ratio fixed; right: scaled with that of the shafts. Gray "
        "columns did not come to stand still; where nothing is damped there is nothing to settle to."
    )
    return f"bifurcation diagrams over {motion.parameter}", caption, partial(diagram_readings, named)


def _motions(work: Reproduction) -> Iterator[Drawing]:
    """Figures 10 to 13: by value, then by place."""
    from modelgen.plots.portraits import portraits

    motion = work.claims.motion
    for value in sorted({each.value for each in motion.claims}):
        for role, channel in work.channels.items():
            found = {name: work.motions[name, value] for name in work.diagrams}
            distinct = {id(each): name for name, each in reversed(found.items())}
            same = len(distinct) < len(found)
            rows = {f"mesh damping {name}" if not same else "both readings": found[name] for name in reversed(distinct.values())}
            notes = {name: f"{each.verdict.name}, ξ = {work.xi[_key(work, each)]:.3g}" for name, each in rows.items()}
            sections = {name: each.sections[0] for name, each in rows.items()}
            first = next(iter(rows.values()))
            readings = "Both readings coincide here." if same else "A row for each reading of the mesh damping."
            loose = ", ".join(name for name, each in rows.items() if each.undamped)
            undamped = (
                f" A mode without damping or next to none ({loose}): one motion from one start, no attractor." if loose else ""
            )
            caption = (
                f"Response, phase plane and section of the elastic angle of `{work.claims.roles[role]}`, physical, of the "
                f"commensurate truck, {first.starts[0]} start, strobed at the common period. {readings}{undamped}"
            )
            title = f"motion at the {_place(role)}, {motion.parameter} = {value:g}"
            yield title, caption, partial(portraits, sections, channel, first.period, notes=notes)


def _key(work: Reproduction, found: Any) -> tuple[str, float]:
    return next(key for key, each in work.motions.items() if each is found)


def _place(role: str) -> str:
    return role.replace("_", " ")


def _switch(work: Reproduction, kind: str) -> str:
    from modelgen.reports.settings import common_switch

    return common_switch(work.response.line, kind) or "as each element has it"
