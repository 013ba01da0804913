"""Why a run cannot go on: the right-hand side is probed at the last good state.

Part of ``solvers``; used by all of them, because an integrator that gives up says little: CasADi's report NaN, blow-up and
chatter as the same code, and a step that became too small may mean any of them.
"""

from __future__ import annotations

import numpy as np

from modelgen.solvers.coordinates import ScaledProblem
from modelgen.solvers.outcome import Ending, Outcome
from modelgen.solvers.problem import Vector

WALK = 32  # steps of a walk that looks for chatter
FLIPS = WALK // 4  # changes of sign on it that count as chatter
WEIGHTY = 1e-2  # a jump that could not move a state by this part of its scale within the horizon is rounding, not chatter
FAST = 1e-6  # a state that e-folds within this fraction of the horizon, and has left its scale, blows up


@np.errstate(all="ignore")
def explain(
    scaled: ScaledProblem, t: float, y: Vector, step: float, fallback: Outcome, *, beyond: Vector | None = None, **facts: float | str
) -> Ending:
    """Name the reason why no step from (t, y) succeeds; ``step`` [s] is the size that failed last.

    Looked for in this order: a state or rate that is not finite (here, or a few steps ahead), growth without bound (at
    ``beyond``, a state outside the budget, if there is one), a rate that jumps at every step. ``fallback`` is the outcome when
    nothing of that is found, ``facts`` what its sentence needs besides time, state, value, rate and step.
    """
    horizon = scaled.problem.horizon
    rates = scaled.rates(t, y)
    worst = int(np.argmax(np.abs(rates)))
    if (state := _first_non_finite(y)) is not None:
        return _ending(scaled, Outcome.NON_FINITE_STATE, t, y, rates, state)
    if (state := _first_non_finite(rates)) is not None:
        return _ending(scaled, Outcome.NON_FINITE_RATE, t, y, rates, state)
    if beyond is not None:
        return _ending(scaled, Outcome.DIVERGED, t, beyond, scaled.rates(t, beyond), int(np.argmax(np.abs(beyond))))
    growing = np.flatnonzero((rates * y > 0) & (np.abs(y) > 1) & (np.abs(rates) * FAST * horizon > np.abs(y)))
    if growing.size:
        return _ending(scaled, Outcome.DIVERGED, t, y, rates, int(growing[np.argmax(np.abs(y[growing]))]))
    for reach in (1, 8, 64):
        ahead, place = t + reach * step, y + reach * step * rates
        beyond_rates = scaled.rates(ahead, place)
        if (state := _first_non_finite(beyond_rates)) is not None:
            return _ending(scaled, Outcome.NON_FINITE_RATE, ahead, place, beyond_rates, state)
    if (found := chatter(scaled, t, y, step)) is not None:
        return found
    return _ending(scaled, fallback, t, y, rates, worst, step=step, **facts)


@np.errstate(all="ignore")
def chatter(scaled: ScaledProblem, t: float, y: Vector, step: float) -> Ending | None:
    """Whether a rate jumps back and forth at every step, by the same amount however small the steps are.

    Three walks of short Euler steps, each from where the one before ended, with a quarter of its step: where a law switches, the
    rate changes sign all along, and its jump does not shrink with the step. (A stiff but smooth rate oscillates only while the
    step is large.) Such a place can fool an error estimate: the slopes of a Runge-Kutta step may cancel in the whole step and in
    the halves alike.
    """
    lows, highs, switching = [], [], np.ones(scaled.size, dtype=bool)
    time, place = t, y.copy()
    for h in (step / 4, step / 16, step / 64):
        seen = np.empty((WALK, scaled.size))
        for index in range(WALK):
            seen[index] = scaled.rates(time, place)
            time, place = time + h, place + h * seen[index]
        if not np.isfinite(seen).all():
            return None
        switching &= np.count_nonzero(seen[1:] * seen[:-1] < 0, axis=0) >= FLIPS
        if not switching.any():
            return None
        settled = seen[WALK // 2 :]
        lows.append(settled.min(axis=0))
        highs.append(settled.max(axis=0))
    jump = np.array(highs) - np.array(lows)
    switching &= (jump.max(axis=0) < 2 * jump.min(axis=0)) & (jump.min(axis=0) * scaled.problem.horizon > WEIGHTY)
    if not switching.any():
        return None
    state = int(np.argmax(np.where(switching, jump[-1], -1)))
    scale = scaled.problem.scale[state]
    facts = {"low": scale * float(lows[-1][state]), "high": scale * float(highs[-1][state])}
    return _ending(scaled, Outcome.CHATTERING, time, place, scaled.rates(time, place), state, **facts)


def _first_non_finite(values: Vector) -> int | None:
    bad = np.flatnonzero(~np.isfinite(values))
    return int(bad[0]) if bad.size else None


def _ending(
    scaled: ScaledProblem, outcome: Outcome, t: float, y: Vector, rates: Vector, state: int, **facts: float | str
) -> Ending:
    problem = scaled.problem
    value, rate = float(scaled.states(y)[state]), float(problem.scale[state] * rates[state])
    known = {"time": t, "state": problem.names[state], "value": value, "rate": rate}
    return Ending(outcome, outcome.sentence(**known, **facts))
