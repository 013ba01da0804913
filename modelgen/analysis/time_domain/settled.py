"""Question: how does a driveline vibrate once its transient is over?

On ``window`` and ``angles``: a run from a start to the end of the settled window, with as many samples as its fastest motion
needs. ``modelgen run`` reports what is found here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np

from modelgen.analysis.linear.modal import ModalResult, modal
from modelgen.analysis.time_domain.angles import AnglesResult, angles
from modelgen.analysis.time_domain.window import Window, settled_window
from modelgen.errors import CaseError, RunFailedError
from modelgen.lowering import Compiled
from modelgen.solvers.bound_model import BoundModel, bind
from modelgen.solvers.case import Case
from modelgen.solvers.case_values import read_number
from modelgen.solvers.operating_point import OperatingPoint
from modelgen.solvers.problem import Budget
from modelgen.solvers.simulate import simulate
from modelgen.solvers.solution import Solution

SAMPLES_PER_PERIOD = 40  # of the highest natural frequency, or of the fastest base frequency if that is higher
FEWEST_SAMPLES = 2001
MOST_NUMBERS = 25_000_000  # 200 MB of channels and states
GIVEN, LOWEST_MODE = "the given window", "the lowest mode"  # what a window counts where it counts no base frequency
FREE_PERIODS = 20  # of the lowest mode, for a driveline without base frequencies
CHANNELS = (".angle_deviation", ".elastic_angle", ".twist", ".force", ".penetration", ".deflection")


@dataclass(frozen=True, eq=False)
class SettledResult:
    """The motion of a bound model over a window: ``solution`` and the ``angles`` and forces read from it.

    ``modes``: those about the operating point. ``thinned``: whether memory did not allow as many samples as were wanted.
    """

    bound: BoundModel
    modes: ModalResult
    window: Window
    solution: Solution
    angles: AnglesResult
    thinned: bool

    @property
    def rate(self) -> float:
        """Samples per second [1/s]."""
        return (self.solution.case.samples - 1) / (self.window.last - self.window.first)

    def __str__(self) -> str:
        w = self.window
        return f"settled motion of {self.bound.name!r} from {w.first:.6g} to {w.last:.6g} s ({w.revolutions} periods of {w.base})"

    __repr__ = __str__


def settled(
    x: Any,
    window: Window | tuple[Any, Any] | None = None,
    *,
    start: Any = "static",
    solver: str = "rk4",
    events: str = "auto",
    tolerance: float = 1e-6,
    max_seconds: float = 600.0,
    stage: Callable[..., None] | None = None,
    progress: Callable[[float], None] | None = None,
) -> SettledResult:
    """The settled motion of a driveline, a model, or a catalogue name; angles as ``modelgen run`` gives them.

    ``window``: two times [s, or texts such as "0.5 s"], by default the settled window; a driveline without base frequencies is
    observed over the first periods of its lowest mode. ``start``, ``solver``, ``events``, ``tolerance`` as in ``Case``;
    ``max_seconds`` of computing time. ``stage(words, measured)`` and ``progress(share)`` are told how far it is.
    Raises RunFailedError for a run that does not reach its end, and what ``bind`` and ``operating_point`` raise.

    >>> found = settled("two-disk-gear", ("0 s", "0.01 s"))
    >>> found.window.last, found.solution.outcome.name
    (0.01, 'SUCCESS')
    """
    bound = bind(x, question="settled")
    model, modes = bound.model, modal(bound)
    chosen = window if isinstance(window, Window) else choose_window(bound, modes, window)
    channels = wanted_channels(model)
    wanted = SAMPLES_PER_PERIOD * max(modes.frequencies[-1], *base_frequencies(model, bound.operating_point).values(), 0.0)
    samples = max(FEWEST_SAMPLES, ceil((chosen.last - chosen.first) * wanted) + 1)
    most = MOST_NUMBERS // (len(channels) + len(model.states))
    case = Case(
        model,
        end=chosen.last,
        record_from=chosen.first,
        samples=min(samples, most),
        start=start,
        channels=channels,
        solver=solver,
        tolerance=tolerance,
        options={"progress": progress, "budget": Budget(max_seconds=max_seconds), "events": events},
    )
    if stage is not None:
        stage(f"simulate {chosen.last:.4g} s", True)
    solution = simulate(case)
    if not solution.succeeded:
        raise RunFailedError(f"run of {solution.model_name!r}", solution.message)
    found = angles(solution, chosen, bound.operating_point)
    return SettledResult(bound, modes, chosen, solution, found, samples > most)


def choose_window(bound: BoundModel, modes: ModalResult, given: tuple[Any, Any] | None = None) -> Window:
    """The given window, or the settled one; without base frequencies the first periods of the lowest mode, from the start on.

    Raises CaseError for a given window that ends before it begins.
    """
    if given is not None:
        first, last = read_window(given)
        return Window(first, last, revolutions=1, base=GIVEN, period=last - first, settled=False)
    if any(frequency > 0 for frequency in base_frequencies(bound.model, bound.operating_point).values()):
        return settled_window(bound)
    vibrating = modes.frequencies[modes.rigid :]
    period = 1 / float(vibrating[0]) if len(vibrating) and vibrating[0] > 0 else 1 / FREE_PERIODS
    return Window(0.0, FREE_PERIODS * period, FREE_PERIODS, LOWEST_MODE, period, settled=False)


def read_window(given: tuple[Any, Any]) -> tuple[float, float]:
    """Two times [s] that follow each other, from numbers or texts. Raises CaseError."""
    first, last = (read_number("window", each, "s") for each in given)
    if not 0 <= first < last:
        raise CaseError("window", f"goes from {first:g} to {last:g} s", "give two times that follow each other, from 0 s up")
    return first, last


def base_frequencies(model: Compiled, point: OperatingPoint) -> dict[str, float]:
    """Base frequencies [Hz] by name."""
    values = model.mean_model.frequencies_at(point.p) / (2 * np.pi)
    return dict(zip((clock.name for clock in model.equations.clocks), values.tolist(), strict=True))


def wanted_channels(model: Compiled) -> tuple[str, ...]:
    """Channels to keep: those that angles, figures and tables read, and the torque of whatever is twisted."""
    twisted = {name.removesuffix(".twist") for name in model.outputs if name.endswith(".twist")}
    torques = {f"{name}.torque" for name in twisted}
    return tuple(name for name in model.outputs if name.endswith(CHANNELS) or name in torques)
