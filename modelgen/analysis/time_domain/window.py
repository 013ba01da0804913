"""Question: from when on is a run settled, and over which window is it measured?

A window is a whole number of revolutions of the slowest base frequency, at least eight, after the slowest vibrating mode of the
linear model has decayed to a thousandth.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log
from typing import Any

import numpy as np

from modelgen.analysis.linear.modal import damped_pairs
from modelgen.errors import CaseError, refuse_unless
from modelgen.solvers.bound_model import bind
from modelgen.solvers.operating_point import OperatingPoint

DECAY = 1e-3
REVOLUTIONS = 8


@dataclass(frozen=True)
class Window:
    """From ``first`` to ``last`` [s]: ``revolutions`` periods of the base frequency named ``base`` [period in s].

    ``settled``: whether the slowest mode has decayed to a thousandth by then (it has not where the budget ended first).
    """

    first: float
    last: float
    revolutions: int
    base: str
    period: float
    settled: bool


def settled_window(
    model: Any, point: OperatingPoint | None = None, revolutions: int = REVOLUTIONS, longest: float = 120.0, decay: float = DECAY
) -> Window:
    """The window in which a run from any start is measured; it ends by ``longest`` [s] even if not settled.

    Raises CaseError for a driveline without base frequencies, whose window must be given.
    """
    bound = bind(model, question="settled_window")
    model, point = bound.model, point or bound.operating_point
    refuse_unless(point, OperatingPoint, "settled_window, point")
    frequencies = model.mean_model.frequencies_at(point.p)
    named = [(f, clock.name) for f, clock in zip(frequencies, model.equations.clocks, strict=True) if f > 0]
    if not named:
        raise CaseError(f"driveline {model.name!r}", "has no base frequency to count revolutions of", "give a window in seconds")
    slowest, name = min(named)
    period = float(2 * np.pi / slowest)
    pairs = damped_pairs(point)
    rates = np.concatenate([pairs.decay_rates, pairs.rates[~np.isnan(pairs.rates)]])  # overdamped modes creep
    vibrating = rates[rates > 0]
    needed = log(1 / decay) / vibrating.min() if len(vibrating) == len(rates) and len(rates) else np.inf
    available = max(0, int(longest / period) - revolutions)
    wanted = ceil(needed / period) if np.isfinite(needed) else available + 1
    turns = min(wanted, available)
    return Window(turns * period, (turns + revolutions) * period, revolutions, name, period, wanted <= available)
