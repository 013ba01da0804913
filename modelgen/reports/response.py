"""From a driveline to its settled response: modes, window, simulation, angles, cross-check. The work behind ``modelgen run``.

Part of ``reports``; every step is a question to a package above, asked in the order that a report needs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from modelgen.analysis import AnglesResult, ModalResult, Window
from modelgen.analysis.limits.rulebook import chosen_rules
from modelgen.analysis.time_domain.settled import settled
from modelgen.errors import CaseError
from modelgen.lowering import Compiled
from modelgen.model import Driveline
from modelgen.reports.progress import Progress
from modelgen.solvers import Case, OperatingPoint, Solution
from modelgen.solvers.crosscheck import CrosscheckResult, crosscheck
from modelgen.solvers.registry import solver_named

CROSSCHECKED = ("rk4", "cvodes", "idas", "erk", "rosenbrock")  # by default
CROSSCHECK_HORIZON = 1.0  # s
CROSSCHECK_SAMPLES = 20_001


@dataclass(frozen=True)
class Request:
    """What the command line asks of a run, apart from the model.

    ``rated`` [rad/s]: the maximum continuous speed, by default the operating speed.
    """

    start: str = "static"
    solver: str = "rk4"
    events: str = "auto"
    tolerance: float = 1e-6
    window: tuple[float, float] | None = None
    crosscheck: tuple[str, ...] = ()
    max_seconds: float = 600.0
    rated: float | None = None


@dataclass(frozen=True, eq=False)
class Response:
    """A driveline, its operating point and modes, its solution over a window, and what was read from it.

    ``rate`` [1/s] is that of the samples; ``thinned`` where memory did not allow the rate wanted. ``crosscheck`` is None where
    none was asked for or its reference run failed; ``crosscheck_failed`` then says why.
    """

    line: Driveline
    request: Request
    model: Compiled
    point: OperatingPoint
    modes: ModalResult
    window: Window
    solution: Solution
    angles: AnglesResult
    rate: float
    thinned: bool
    crosscheck: CrosscheckResult | None
    crosscheck_failed: str


def respond(line: Driveline, request: Request, progress: Progress) -> Response:
    """Runs a driveline as requested. Raises RunFailedError for a run that fails, and the refusals of each step."""
    chosen_rules(line.limits)  # says what is wrong with them before anything is computed
    progress.stage("assemble and compile")
    found = settled(
        line,
        request.window,
        start=request.start,
        solver=request.solver,
        events=request.events,
        tolerance=request.tolerance,
        max_seconds=request.max_seconds,
        stage=progress.stage,
        progress=progress.fraction,
    )
    checked, failed = _cross_check(found.solution.case, found.window, request, progress)
    bound = found.bound
    return Response(
        *(line, request, bound.model, bound.operating_point, found.modes, found.window, found.solution, found.angles),
        *(found.rate, found.thinned, checked, failed),
    )


def _cross_check(case: Case, window: Window, request: Request, progress: Progress) -> tuple[CrosscheckResult | None, str]:
    """The case by other solvers from the same start, over a horizon that all can afford; or why it could not be done."""
    others = [name for name in request.crosscheck if name != request.solver]
    if not others:
        return None, ""
    plan = {request.solver: (request.tolerance,), **{name: (solver_named(name).crosscheck_tolerance,) for name in others}}
    end = min(window.last, max(CROSSCHECK_HORIZON, window.period))
    done, last = 0, 0.0

    def advance(fraction: float) -> None:
        nonlocal done, last
        done, last = done + (fraction < last), fraction
        progress.fraction((done + fraction) / (len(plan) + 1))

    options: dict[str, Any] = {**case.options, "progress": advance}
    short = case.change(end=end, record_from=None, samples=CROSSCHECK_SAMPLES, channels=None, options=options)
    progress.stage(f"cross-check by {', '.join(plan)} over {end:.3g} s", measured=True)
    try:
        return crosscheck(short, tuple(plan), plan, reference=(request.solver, request.tolerance / 10)), ""
    except CaseError as error:
        return None, str(error)
