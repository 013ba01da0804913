"""Figure of what was located in a run: a channel with its events marked, over the modes that held.

Draws the event log of a ``Solution``; called by its name, because a solution's own figure is that of its channels.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelgen.errors import CaseError
from modelgen.plots.quantities import axis_label, definition, display, number
from modelgen.plots.style import INK, SERIES, SMALL, name_panel, sheet, styled
from modelgen.plots.time_axis import set_time
from modelgen.solvers import Solution
from modelgen.solvers.event_log import EventLog

MOST_MARKS = 500  # on a page; of more, only the modes are shown
MARKERS = ("o", "s", "^", "v", "D", "P", "X", "<", ">")


@styled
def plot_events(solution: Solution, channel: str, /) -> Figure:
    """A channel over time with every event of the log marked on it; below, which mode held when.

    Raises CaseError for an unknown channel, and for a solution without a log of events or without times.
    """
    where = f"plot of events of {solution.model_name!r}"
    log = solution.events
    if log is None:
        raise CaseError(where, "no events were located in this run", 'simulate with events "on", or give the case sections')
    if not len(solution.times):
        raise CaseError(where, "it holds no times", "see its message for how the run ended")
    values = solution[channel]
    shown = display(solution.unit(channel), float(np.abs(values).max()))
    variables = log.switching.modes
    shares = ", ".join(f"{name} {share:.1%}" for name, share in log.share().items())
    detail = f"{int(log.counts.sum())} events located by {solution.case.solver}, tolerance {number(solution.case.tolerance)}."
    strip = 0.55 * len(variables)
    detail += f"\nShare of the time in each mode: {shares}." if shares else ""
    figure = sheet(solution.model_name, f"{channel} and its events", detail, height=6.2 + (strip + 1.0 if variables else 0.0))
    if variables:
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[5.0, strip + 0.3])
    else:
        above = below = figure.subplots()
    above.plot(solution.times, shown(values), color=INK, linewidth=0.8)
    marked = _mark(above, solution, log, shown(values))
    name_panel(above, channel, definition(channel) if marked else f"{definition(channel)}; events are too many to be marked")
    above.set_ylabel(axis_label(channel, shown.unit))
    if variables:
        _modes(below, solution, log)
    set_time(below, solution)
    handles, labels = above.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 3))
    return figure


def _mark(axes: Axes, solution: Solution, log: EventLog, values: np.ndarray) -> bool:
    """A marker at each event, one kind for each guard; whether there was room for them."""
    inside = (log.times >= solution.times[0]) & (log.times <= solution.times[-1])
    if np.count_nonzero(inside) > MOST_MARKS:
        return False
    places = np.interp(log.times, solution.times, values)
    for index in np.unique(log.which[inside]).tolist():
        chosen = inside & (log.which == index)
        name = log.switching.crossings[index].name
        axes.plot(
            log.times[chosen], places[chosen], linestyle="none", marker=MARKERS[index % len(MARKERS)], markersize=4.5,
            color=SERIES[index % len(SERIES)], fillstyle="none", label=f"{name} ({np.count_nonzero(chosen)})",
        )  # fmt: skip
    return True


def _modes(axes: Axes, solution: Solution, log: EventLog) -> None:
    """One row per mode variable: a bar for each stretch of time that a mode held, lettered where there is room."""
    first, last = float(solution.times[0]), float(solution.times[-1])
    for row, mode in enumerate(log.switching.modes):
        changes = np.array([log.switching.crossings[index].variable == row for index in log.which.tolist()], dtype=bool)
        edges = np.concatenate([[first], np.clip(log.times[changes], first, last), [last]])
        after = [log.switching.crossings[index].enter or 0 for index in log.which[changes].tolist()]
        held = np.array([log.start[row], *after])
        for value, name in enumerate(mode.values):
            chosen = (held == value) & (np.diff(edges) > 0)
            bars = list(zip(edges[:-1][chosen], np.diff(edges)[chosen], strict=True))
            axes.broken_barh(bars, (-row - 0.4, 0.8), facecolors=SERIES[value % len(SERIES)], alpha=0.45, linewidth=0)
            for start, width in bars:
                if width > 0.014 * len(name) * (last - first):
                    axes.text(start + width / 2, -row, name, ha="center", va="center", fontsize=SMALL, color=INK)
    names = [mode.name for mode in log.switching.modes]
    axes.set_yticks([-row for row in range(len(names))], names, fontsize=SMALL)
    axes.set_ylim(-len(names) + 0.4, 0.6)
    axes.grid(False)
    name_panel(axes, "mode")
