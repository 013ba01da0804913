"""The files of a run, written into one folder: model, equations, figures, channels, report, summary.

Part of ``reports``. The summary comes last, because it holds the time that everything took.
"""

from __future__ import annotations

import time
from pathlib import Path

from modelgen.drivelines.claims import claims_of
from modelgen.model.files import write_model
from modelgen.reports.figures import draw_figures
from modelgen.reports.paper import paper_text, readings
from modelgen.reports.progress import Progress
from modelgen.reports.report import report_text
from modelgen.reports.response import Response
from modelgen.reports.responses import write_responses
from modelgen.reports.summary import summary_text


def write_results(response: Response, folder: Path, command: str, begun: float, progress: Progress) -> None:
    """Writes everything; ``begun`` is when the run began, by ``time.perf_counter``."""
    progress.stage("write equations and channels")
    write_model(response.line, folder / "model.toml")
    equations = response.model.equations
    (folder / "equations.md").write_text(equations.markdown(), encoding="utf-8")
    (folder / "equations.tex").write_text(equations.latex(), encoding="utf-8")
    write_responses(response, folder / "responses.csv")
    progress.stage("draw figures", measured=True)
    figures = draw_figures(response, folder, progress)
    _write_paper(response, folder, command, progress)
    progress.stage("write report")
    wall = time.perf_counter() - begun
    (folder / "report.md").write_text(report_text(response, figures, command), encoding="utf-8")
    (folder / "summary.json").write_text(summary_text(response, wall), encoding="utf-8")


def _write_paper(response: Response, folder: Path, command: str, progress: Progress) -> None:
    """``paper.md``, for a driveline that a paper makes claims about."""
    claims = claims_of(response.line.name)
    if claims is not None:
        progress.stage("compare with the paper: other readings of the damping")
        (folder / "paper.md").write_text(paper_text(response, claims, readings(response, progress), command), encoding="utf-8")
