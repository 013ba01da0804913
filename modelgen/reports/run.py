"""What ``modelgen run`` does, in Python: the settled response of a driveline and its report, in a folder.

Part of ``reports``, on ``response`` and ``results``.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from modelgen.analysis.time_domain.settled import read_window
from modelgen.drivelines import load
from modelgen.errors import CaseError
from modelgen.model import Driveline
from modelgen.reports.folder import output_folder
from modelgen.reports.progress import Progress, Silence
from modelgen.reports.response import CROSSCHECKED, Request, Response, respond
from modelgen.reports.results import write_results
from modelgen.solvers.registry import solver_named


def run(
    x: Driveline | str | Path,
    out: str | Path,
    *,
    replace: bool = False,
    start: str = "static",
    solver: str = "rk4",
    events: str = "auto",
    tolerance: float = 1e-6,
    window: tuple[Any, Any] | None = None,
    crosscheck: Sequence[str] = CROSSCHECKED,
    max_seconds: float = 600.0,
    progress: Progress | None = None,
) -> Response:
    """Simulates a driveline, or one by its catalogue name or path, and writes its report into the folder ``out``.

    The folder gets ``report.md``, ``equations.md`` and ``.tex``, ``model.toml`` (the model as run), ``responses.csv``,
    ``summary.json`` and ``figures/``; with ``replace`` it may hold the results of another run. ``window``: two times [s, or
    texts], by default the settled window. ``crosscheck``: solvers that run the case too; none for an empty sequence. The others
    as in ``settled``; ``progress`` is told how far it is. Raises CaseError for a folder that may not be written or a model
    without its driveline, RunFailedError for a run that fails.
    """
    begun, telling = time.perf_counter(), progress or Silence()
    for name in (solver, *crosscheck):
        solver_named(name)
    times = None if window is None else read_window(window)
    with output_folder(Path(out), replace) as folder:
        line = x if isinstance(x, Driveline) else _loaded(x)
        request = Request(start, solver, events, tolerance, times, tuple(crosscheck), max_seconds, line.speed)
        response = respond(line, request, telling)
        named = x if isinstance(x, (str, Path)) else "model.toml"
        write_results(response, folder, f"modelgen run {named} --out DIR", begun, telling)
    return response


def _loaded(x: Any) -> Driveline:
    if not isinstance(x, (str, Path)):
        remedy = "give the driveline itself, its catalogue name, or the path of its model file"
        raise CaseError("run", f"is asked of {type(x).__name__}, which does not hold its driveline", remedy)
    return load(x)
