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
FAST = 1e-9  # a state that has left its scale and e-folds within this part of the horizon grows without bound


@np.errstate(all="ignore")
def explain(
    scaled: ScaledProblem,
    t: float,
    y: Vector,
    step: float,
    fallback: Outcome,
    *,
    beyond: Vector | None = None,
    **facts: float | str,
) -> Ending:
    """Name the reason why no step from (t, y) succeeds; ``step`` [s] is the size that failed last.

    Looked for in this order: a state or rate that is not finite; a state outside the budget (``beyond``), or about to explode; a
    rate that is not finite a few steps ahead; a rate that jumps at every step. Where only a budget of steps or time is used up,
    fast growth and what lies ahead mean nothing. ``fallback`` is the outcome when nothing of that is found, ``facts`` what its
    sentence needs besides time, state, value, rate and step.
    """
    rates = scaled.rates(t, y)
    worst = int(np.argmax(np.abs(rates)))
    if (state := _first_non_finite(y)) is not None:
        return _ending(scaled, Outcome.NON_FINITE_STATE, t, y, rates, state)
    if (state := _first_non_finite(rates)) is not None:
        return _ending(scaled, Outcome.NON_FINITE_RATE, t, y, rates, state)
    if beyond is not None:
        return _ending(scaled, Outcome.DIVERGED, t, beyond, scaled.rates(t, beyond), int(np.argmax(np.abs(beyond))))
    if fallback not in (Outcome.MAX_STEPS, Outcome.MAX_TIME):
        exploding = np.flatnonzero(
            (rates * y > 0) & (np.abs(y) > 1) & (np.abs(rates) * FAST * scaled.problem.horizon > np.abs(y))
        )
        if exploding.size:
            return _ending(scaled, Outcome.DIVERGED, t, y, rates, int(exploding[np.argmax(np.abs(y[exploding]))]))
        for reach in (1, 8, 64):
            ahead, place = t + reach * step, y + reach * step * rates
            rates_ahead = scaled.rates(ahead, place)
            if (state := _first_non_finite(rates_ahead)) is not None:
                return _ending(scaled, Outcome.NON_FINITE_RATE, ahead, place, rates_ahead, state)
    if (found := chatter(scaled, t, y, step)) is not None:
        return found
    return _ending(scaled, fallback, t, y, rates, worst, step=step, **facts)


@np.errstate(all="ignore")
def chatter(scaled: ScaledProblem, t: float, y: Vector, step: float) -> Ending | None:
    """Whether a rate jumps back and forth at every step, however small the steps are.

    Three walks of short Euler steps, each from where the one before ended, with a quarter of its step: where a law switches, some
    rate changes sign all along, and between the last two places where it did, it jumps. (A stiff but smooth rate changes sign at
    large steps too, but does not jump.) Such a place can fool an error estimate: the slopes of a Runge-Kutta step may cancel in
    the whole step and in the halves alike.
    """
    switching = np.ones(scaled.size, dtype=bool)
    point = np.concatenate([[t], y])
    for h in (step / 4, step / 16, step / 64):
        points, rates = _walk(scaled, point, h)
        if not np.isfinite(rates).all():
            return None
        turns = rates[1:] * rates[:-1] < 0
        switching &= np.count_nonzero(turns, axis=0) >= FLIPS
        if not switching.any():
            return None
        point = points[-1]
    state = int(np.argmax(np.where(switching, np.ptp(rates, axis=0), -1)))
    last = int(np.flatnonzero(turns[:, state])[-1])
    low, high = float(rates[WALK // 2 :, state].min()), float(rates[WALK // 2 :, state].max())
    if (high - low) * scaled.problem.horizon < WEIGHTY or not _jumps(scaled, points[last], points[last + 1], state):
        return None
    scale = float(scaled.problem.scale[state])
    time, place = float(point[0]), point[1:]
    return _ending(scaled, Outcome.CHATTERING, time, place, scaled.rates(time, place), state, low=scale * low, high=scale * high)


def _walk(scaled: ScaledProblem, point: Vector, h: float) -> tuple[Vector, Vector]:
    """The points [t, y] (WALK + 1, 1 + nx) of explicit Euler steps, and the rates (WALK, nx) at all but the last."""
    points, rates = np.empty((WALK + 1, scaled.size + 1)), np.empty((WALK, scaled.size))
    points[0] = point
    for index in range(WALK):
        rates[index] = scaled.rates(points[index, 0], points[index, 1:])
        points[index + 1, 0] = points[index, 0] + h
        points[index + 1, 1:] = points[index, 1:] + h * rates[index]
    return points, rates


def _jumps(scaled: ScaledProblem, one: Vector, other: Vector, state: int) -> bool:
    """Whether a rate, which changes its sign between two points [t, y], does so by a jump: bisection to the last digit."""

    def rate(point: Vector) -> float:
        return float(scaled.rates(float(point[0]), point[1:])[state])

    first, second = rate(one), rate(other)
    whole = abs(second - first)
    for _ in range(200):
        middle = (one + other) / 2
        if np.array_equal(middle, one) or np.array_equal(middle, other):
            break
        value = rate(middle)
        if (value < 0) == (first < 0):
            one, first = middle, value
        else:
            other, second = middle, value
    return abs(second - first) > 0.4 * whole  # the sign function jumps twice by half


def _first_non_finite(values: Vector) -> int | None:
    bad = np.flatnonzero(~np.isfinite(values))
    return int(bad[0]) if bad.size else None


def _ending(
    scaled: ScaledProblem, outcome: Outcome, t: float, y: Vector, rates: Vector, state: int, **facts: float | str
) -> Ending:
    problem = scaled.problem
    value, rate = float(scaled.states(y)[state]), float(problem.scale[state] * rates[state])
    known: dict[str, float | str] = {"time": t, "state": problem.names[state], "value": value, "rate": rate}
    return Ending(outcome, outcome.sentence(**known, **facts))
