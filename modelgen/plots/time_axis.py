"""Parts shared by the figures over time: the time axis, and the last periods of a window.

Used by ``channels``, ``responses`` and ``mesh_forces``.
"""

from __future__ import annotations

from matplotlib.axes import Axes

from modelgen.analysis import Window
from modelgen.errors import CaseError
from modelgen.solvers import Solution


def set_time(axes: Axes, solution: Solution) -> None:
    """The horizontal axis of the lowest panel."""
    axes.set_xlabel(r"time $t$ [s]")
    if len(solution.times) > 1:
        axes.set_xlim(float(solution.times[0]), float(solution.times[-1]))


def part_of(solution: Solution, window: Window | None, last: int | None, what: str) -> Solution:
    """The part of a solution in a window, or in its last so many periods. Raises CaseError where it does not cover that."""
    part, missing = solution, False
    if window is not None:
        first = window.first if last is None else max(window.first, window.last - last * window.period)
        slack = 1e-9 * max(1.0, abs(window.last))
        part = solution.between(first - slack, window.last + slack)
        allowed = window.period / 10
        missing = len(part.times) > 0 and (part.times[0] > first + allowed or part.times[-1] < window.last - allowed)
    if missing or len(part.times) < 3:
        covered = f"{solution.times[0]:.6g} to {solution.times[-1]:.6g} s" if len(solution.times) else "nothing"
        wanted = "" if window is None else f", the window is {window.first:.6g} to {window.last:.6g} s"
        raise CaseError(what, f"the solution covers {covered}{wanted}", "simulate to the end of the window")
    return part
