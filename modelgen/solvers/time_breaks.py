"""Where no step may cross: the times of a run at which its laws jump or bend by the clock alone.

Part of ``solvers``, on ``lowering.time_switches``; read by ``march``, ``chunks`` and generated C. They are known before a run
begins. A step ends a few last digits of time before such a place, where the laws are still those of the left side, and the next
one begins as many after it. The state goes over this gap with the slope of the left side.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.lowering.time_switches import TimeSwitch, time_switches
from modelgen.solvers.problem import InitialValueProblem, Vector

SIDE = 16 * float(np.finfo(float).eps)  # how far the two sides of a break are from it, relative to its time
MOST = 4_000_000  # breaks of one run; where there are more, all are left to the error control
SCANS, HALVINGS = 4096, 60  # looks at a switch that is no straight line, and halvings of what they bracket
MOST_SCANS = 200_000


@dataclass(frozen=True, eq=False)
class TimeBreaks:
    """Times (n,) [s] just ``before`` and just ``after`` each break, increasing; ``times``: the breaks themselves.

    Where a run starts on a break, that is the time before it, and the run begins behind it.
    """

    times: Vector
    before: Vector
    after: Vector

    def start(self, t: float) -> tuple[float, int]:
        """Where a run from t begins, and how many breaks are behind it there."""
        at_once = len(self.times) > 0 and self.before[0] <= t
        return (float(self.after[0]), 1) if at_once else (t, 0)

    def until(self, t: float, first: float) -> Vector:
        """The breaks that a run from ``first`` has passed at t."""
        return self.times[(self.times > first) & (self.after <= t)]

    def __len__(self) -> int:
        return len(self.times)


def time_breaks(problem: InitialValueProblem) -> TimeBreaks:
    """The breaks from the start of a problem to its end, of its right-hand side and of its guards.

    >>> import casadi as ca
    >>> t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p")
    >>> stairs = ca.Function("stairs", [t, x, p], [ca.floor(p * t) - x])
    >>> time_breaks(InitialValueProblem(stairs, ("x",), [0.0], [4.0], [1.0], 0.0, [1.1])).times
    array([0.  , 0.25, 0.5 , 0.75, 1.  ])
    """
    first, last = problem.t0, float(problem.times[-1])
    functions = [problem.rhs] if problem.switching is None else [problem.rhs, problem.switching.guards]
    switches = [switch for function in functions for switch in time_switches(function)]
    found = _found(tuple(switches), first, last, problem.p.tobytes()) if switches and last > first else np.zeros(0)
    side = SIDE * np.maximum(np.abs(found), 1e-3 * problem.horizon)
    inside = (found + side > first) & (found - side < last)
    found, side = found[inside], side[inside]
    return TimeBreaks(found, np.maximum(found - side, first), found + side)


@functools.lru_cache(maxsize=64)
def _found(switches: tuple[TimeSwitch, ...], first: float, last: float, given: bytes) -> Vector:
    """All breaks from first to last, those of each switch between those of the ones before it."""
    p = np.frombuffer(given)
    found = np.zeros(0)
    for switch in switches:
        edges = np.concatenate([[first], found, [last]])
        search = _on_straight_lines if switch.affine else _by_scanning
        more = search(switch, edges, p)
        if len(found) + len(more) > MOST:
            return np.zeros(0)
        found = _distinct(np.concatenate([found, more]), last - first)
    return found


def _distinct(times: Vector, span: float) -> Vector:
    """Times in order, without those that differ from the one before by rounding only."""
    times = np.sort(times)
    close = 4 * SIDE * np.maximum(np.abs(times), 1e-3 * span)
    return times[np.diff(times, prepend=-np.inf) > close]


def _values(switch: TimeSwitch, times: Vector, p: Vector) -> Vector:
    values: Vector = np.asarray(switch.value.map(len(times))(times[None, :], p)).ravel()
    return values


def _on_straight_lines(switch: TimeSwitch, edges: Vector, p: Vector) -> Vector:
    """Places of a switch that is a straight line between the edges."""
    width = np.diff(edges)
    left, right = edges[:-1] + 0.25 * width, edges[1:] - 0.25 * width
    at_left, at_right = np.split(_values(switch, np.concatenate([left, right]), p), 2)
    with np.errstate(all="ignore"):  # nothing lies between edges at one time
        slope = (at_right - at_left) / (right - left)
    at_start, at_end = at_left - 0.25 * width * slope, at_right + 0.25 * width * slope
    usable = np.isfinite(slope) & (slope != 0)
    low, high = (np.where(usable, each(at_start, at_end), 0.0) for each in (np.minimum, np.maximum))
    slack = 1e-12 * (np.abs(low) + np.abs(high))  # a place on an edge may be found from either side
    if switch.whole:
        lowest, highest = np.ceil(low - slack), np.floor(high + slack)
        count = np.where(usable, np.maximum(highest - lowest + 1, 0), 0)
        if count.sum() > MOST:
            return np.zeros(int(MOST) + 1)
        count = count.astype(np.int64)
        which = np.repeat(np.arange(len(count)), count)
        wanted = lowest[which] + (np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count))
    else:
        which = np.flatnonzero(usable & (low <= slack) & (high >= -slack))
        wanted = np.zeros(len(which))
    times = left[which] + (wanted - at_left[which]) / slope[which]
    return np.clip(times, edges[which], edges[which + 1])


def _by_scanning(switch: TimeSwitch, edges: Vector, p: Vector) -> Vector:
    """Places of any other switch: by its signs (or whole parts) at many times, and halving between two that differ."""
    span = edges[-1] - edges[0]
    rate = np.abs(np.asarray(switch.rate.map(SCANS)(np.linspace(edges[0], edges[-1], SCANS)[None, :], p)).ravel())
    fastest = float(np.nanmax(np.where(np.isfinite(rate), rate, 0.0), initial=0.0))
    count = int(min(max(SCANS, 16 * fastest * span), MOST_SCANS))
    grid = np.unique(np.concatenate([edges, np.linspace(edges[0], edges[-1], count)]))

    def side(times: Vector) -> NDArray[np.float64]:
        values = _values(switch, times, p)
        return np.floor(values) if switch.whole else np.sign(values)

    left, right = grid[:-1].copy(), grid[1:].copy()
    here, there = side(left), side(right)
    on_it = edges[:1] if not switch.whole and here[0] == 0 != there[0] else edges[:0]  # the run starts on a place
    differ = (here != there) & (here != 0 if not switch.whole else True)
    left, right, here = left[differ], right[differ], here[differ]
    for _ in range(HALVINGS):
        middle = left + 0.5 * (right - left)
        same = side(middle) == here if len(middle) else np.zeros(0, dtype=bool)
        left, right = np.where(same, middle, left), np.where(same, right, middle)
    return np.concatenate([on_it, right])
