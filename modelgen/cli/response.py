"""From a driveline to its settled response: modes, window, simulation, angles, cross-check. The work behind ``modelgen run``.

Part of ``cli``; every step is a question to a package above, asked in the order that a report needs.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np

from modelgen.analysis import AnglesResult, ModalResult, Window, angles, modal, settled_window
from modelgen.analysis.limits.rulebook import chosen_rules
from modelgen.cli.ending import FAILED, Ending
from modelgen.cli.progress import Progress
from modelgen.equations import assemble
from modelgen.errors import CaseError
from modelgen.lowering import Compiled, lower
from modelgen.model import Driveline
from modelgen.solvers import Budget, Case, OperatingPoint, Solution, operating_point, simulate
from modelgen.solvers.crosscheck import CrosscheckResult, crosscheck
from modelgen.solvers.registry import solver_named

SAMPLES_PER_PERIOD = 40  # of the highest natural frequency, or of the fastest base frequency if that is higher
FEWEST_SAMPLES = 2001
MOST_NUMBERS = 25_000_000  # 200 MB of channels and states
GIVEN, LOWEST_MODE = "the given window", "the lowest mode"  # what a window counts where it counts no base frequency
FREE_PERIODS = 20  # of the lowest mode, for a driveline without base frequencies
CROSSCHECK_HORIZON = 1.0  # s
CROSSCHECK_SAMPLES = 20_001
CHANNELS = (".angle_deviation", ".elastic_angle", ".twist", ".force", ".penetration", ".deflection")


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
    """Runs a driveline as requested. Raises Ending for a run that fails, and the refusals of each step."""
    chosen_rules(line.limits)  # says what is wrong with them before anything is computed
    progress.stage("assemble and compile")
    model = lower(assemble(line))
    point = operating_point(model)
    modes = modal(model, point=point)
    window = choose_window(model, point, modes, request.window)
    channels = wanted_channels(model)
    wanted = SAMPLES_PER_PERIOD * max(modes.frequencies[-1], *_base_frequencies(model, point), 0.0)
    samples = max(FEWEST_SAMPLES, ceil((window.last - window.first) * wanted) + 1)
    most = MOST_NUMBERS // (len(channels) + len(model.states))
    case = Case(
        model,
        end=window.last,
        record_from=window.first,
        samples=min(samples, most),
        start=request.start,
        channels=channels,
        solver=request.solver,
        tolerance=request.tolerance,
        options={
            "progress": progress.fraction,
            "budget": Budget(max_seconds=request.max_seconds),
            "events": request.events,
        },
    )
    progress.stage(f"simulate {window.last:.4g} s", measured=True)
    solution = simulate(case)
    if not solution.succeeded:
        raise Ending(f"run of {line.name!r}: {solution.message}", FAILED)
    found = angles(solution, window, point)
    checked, failed = _cross_check(case, window, request, progress)
    rate = (case.samples - 1) / (window.last - window.first)
    return Response(line, request, model, point, modes, window, solution, found, rate, samples > most, checked, failed)


def choose_window(model: Compiled, point: OperatingPoint, modes: ModalResult, given: tuple[float, float] | None) -> Window:
    """The given window, or the settled one; without base frequencies the first periods of the lowest mode, from the start on.

    Raises CaseError for a given window that ends before it begins.
    """
    if given is not None:
        if not 0 <= given[0] < given[1]:
            times = f"goes from {given[0]:g} to {given[1]:g} s"
            raise CaseError("--window", times, "give two times that follow each other, from 0 s up")
        return Window(*given, revolutions=1, base=GIVEN, period=given[1] - given[0], settled=False)
    if any(frequency > 0 for frequency in _base_frequencies(model, point)):
        return settled_window(model, point)
    vibrating = modes.frequencies[modes.rigid :]
    period = 1 / float(vibrating[0]) if len(vibrating) and vibrating[0] > 0 else 1 / FREE_PERIODS
    return Window(0.0, FREE_PERIODS * period, FREE_PERIODS, LOWEST_MODE, period, settled=False)


def _base_frequencies(model: Compiled, point: OperatingPoint) -> list[float]:
    """Base frequencies [Hz], in the order of the clocks."""
    return (np.asarray(model.mean_model["frequencies"](point.p)).ravel() / (2 * np.pi)).tolist()


def base_frequencies(response: Response) -> dict[str, float]:
    """Base frequencies [Hz] by name."""
    names = [clock.name for clock in response.model.equations.clocks]
    return dict(zip(names, _base_frequencies(response.model, response.point), strict=True))


def wanted_channels(model: Compiled) -> tuple[str, ...]:
    """Channels to keep: those that angles, figures and tables read, and the torque of whatever is twisted."""
    twisted = {name.removesuffix(".twist") for name in model.outputs if name.endswith(".twist")}
    torques = {f"{name}.torque" for name in twisted}
    return tuple(name for name in model.outputs if name.endswith(CHANNELS) or name in torques)


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
