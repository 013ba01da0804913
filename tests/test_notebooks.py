"""The notebooks run from top to bottom, and are committed with their figures."""

from __future__ import annotations

from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

FOLDER = Path(__file__).parent.parent / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
LONG = {"02_fracturing_truck", "03_nonlinear_dynamics"}


def pictures(notebook: object) -> list[int]:
    """Number of pictures that each code cell shows."""
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]  # type: ignore[attr-defined]
    return [sum("image/png" in output.get("data", {}) for output in cell.outputs) for cell in cells]


def test_there_are_notebooks() -> None:
    assert [path.name[:3] for path in NOTEBOOKS] == [f"{number:02d}_" for number in range(1, len(NOTEBOOKS) + 1)]
    assert len(NOTEBOOKS) >= 2


@pytest.mark.parametrize(
    "path", [pytest.param(path, id=path.stem, marks=[pytest.mark.slow] * (path.stem in LONG)) for path in NOTEBOOKS]
)
@pytest.mark.filterwarnings("ignore:.*[Zz]mq.*:RuntimeWarning", "ignore::DeprecationWarning")
def test_a_notebook_runs_and_shows_what_is_committed(path: Path) -> None:
    committed = nbformat.read(path, as_version=4)
    run = nbformat.read(path, as_version=4)
    for cell in run.cells:
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
    nbclient.NotebookClient(run, timeout=300, kernel_name="python3").execute()
    assert pictures(run) == pictures(committed)
    assert sum(pictures(run)) >= 3
