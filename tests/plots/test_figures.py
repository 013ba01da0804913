"""Every figure of one small driveline: without warnings, readable, headed by model and subject, the same bytes every time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib
import pytest
from matplotlib.figure import Figure

from modelgen.plots import backlash, draw, fitting_errors, mesh_damping, mesh_forces, mesh_stiffness, plot, responses, save

MAKERS: dict[str, Callable[[Any], Figure]] = {
    "angles": lambda r: plot(r.angles),
    "angles_without_limit": lambda r: plot(r.angles, limit=None),
    "modes": lambda r: plot(r.modes, driveline=r.driveline, count=3),
    "modes_alone": lambda r: plot(r.modes, count=99),
    "crosscheck": lambda r: plot(r.crosscheck),
    "solution": lambda r: plot(r.solution, names=["coupling.torque", "engine.angle_deviation", "mesh.force", "mesh.error"]),
    "responses": lambda r: responses(r.solution, r.window, ["engine", "pump"]),
    "responses_whole": lambda r: responses(r.solution, r.window, ["fan"], last=None, limit=0.1),
    "mesh_forces": lambda r: mesh_forces(r.solution, r.window, last=2),
    "mesh_forces_with_impacts": lambda r: mesh_forces(r.impacts),
    "fitting_errors": lambda r: fitting_errors(r.meshes),
    "mesh_stiffness": lambda r: mesh_stiffness(r.meshes),
    "mesh_damping": lambda r: mesh_damping(r.meshes),
    "backlash": lambda r: backlash(r.meshes),
}


@pytest.mark.parametrize("name", MAKERS)
def test_figure_is_readable(name: str, results: Any, readable: Callable[..., None]) -> None:
    figure = MAKERS[name](results)
    readable(figure)
    assert figure.get_label().startswith("branched: ")
    assert figure.get_size_inches()[0] == pytest.approx(16 / 2.54)
    assert figure.get_label() in [text.get_text() for text in figure.texts]


@pytest.mark.parametrize("name", ["angles", "mesh_forces_with_impacts"])
def test_same_input_gives_the_same_bytes_whatever_the_settings(name: str, results: Any, tmp_path: Path) -> None:
    first = save(MAKERS[name](results), tmp_path / "first.png").read_bytes()
    foreign = {"font.size": 20.0, "axes.grid": False, "lines.linewidth": 9.0, "axes.facecolor": "red", "savefig.bbox": "tight"}
    with matplotlib.rc_context(foreign):
        second = save(MAKERS[name](results), tmp_path / "second.png").read_bytes()
        assert matplotlib.rcParams["font.size"] == 20.0
        assert matplotlib.rcParams["axes.facecolor"] == "red"
    assert first == second


def test_driveline_gives_the_same_bytes(results: Any, tmp_path: Path) -> None:
    files = [save(draw(results.driveline), tmp_path / f"{index}.svg").read_bytes() for index in range(2)]
    assert files[0] == files[1]
