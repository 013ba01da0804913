"""Figure of a sweep: what was collected over one parameter as curves, over two as maps, a panel per quantity.

Draws ``SweepResult`` of ``modelgen.analysis``. A point that failed is a cross at its place, never a gap without a word.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from numpy.typing import NDArray

from modelgen.analysis.sweeps.result import SweepResult
from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import display, words
from modelgen.plots.speed_axis import RPM
from modelgen.plots.style import BLUE, INK, VERMILION, name_panel, panels, sheet, styled

Array = NDArray[np.float64]
CURVE, MAP = 4.4, 7.6  # cm high
MOST = 6  # panels unless names are given
DOTS = 60  # points of a curve that are marked one by one
COLORS = "cividis"  # rises evenly in gray, the same for color-blind readers


@plot.register
@styled
def plot_sweep(result: SweepResult, /, *, names: Sequence[str] | None = None) -> Figure:
    """What was collected (``names``, by default the first six quantities) over the one or two parameters swept.

    Raises CaseError for an unknown name, for more than two parameters, and where there is nothing to show.
    """
    where = f"figure of the sweep of {result.model!r}"
    if len(result.names) > 2:
        problem = f"{len(result.names)} parameters were swept: {', '.join(result.names)}"
        raise CaseError(where, problem, "draw sweeps over one or two; to_xarray() cuts larger ones")
    shown = tuple(result.collected[:MOST] if names is None else names)
    if not shown or any(name in result.series for name in shown):
        raise CaseError(where, "shows statistics only, and there are none", "collect some, such as a channel's .highest")
    failed = int(np.count_nonzero(~result.succeeded))
    rest = "" if len(shown) == len(result.collected) else f" Shown: {len(shown)} of {len(result.collected)} quantities."
    crosses = f" {failed} failed (crosses)." if failed else ""
    detail = f"{len(result)} points ({result.sampling}).{crosses}{rest} {_engine(result)}"
    single = len(result.names) == 1
    title = f"sweep over {' and '.join(words(name) for name in result.names)}"
    figure = sheet(result.model, title, detail, height=1.0 + (CURVE if single else MAP) * len(shown))
    rows = [axes for (axes,) in panels(figure, len(shown))]
    for name, axes in zip(shown, rows, strict=True):
        (_curve if single else _map)(figure, axes, result, name)
    rows[-1].set_xlabel(_scale(result, 0)[1])
    return figure


def _engine(result: SweepResult) -> str:
    return ", ".join(f"{name} {value}" for name, value in result.engine.items())


def _scale(result: SweepResult, column: int) -> tuple[float, str]:
    """Factor and label of the axis of a swept parameter."""
    name, unit = result.names[column], result.units[column]
    if unit == "rad/s":
        return RPM, f"{words(name)} [rpm]"
    shown = display(unit, float(np.abs(result.values[:, column]).max()))
    return shown.factor, f"{words(name)} [{shown.unit}]"


def _shown(result: SweepResult, name: str) -> tuple[Array, str]:
    """The values (points,) of a quantity, and its unit, as they are drawn."""
    values = result[name].ravel()
    good = values[np.isfinite(values)]
    shown = display(result.unit(name), float(np.abs(good).max()) if good.size else 0.0)
    return shown(values), shown.unit


def _curve(figure: Figure, axes: Axes, result: SweepResult, name: str) -> None:
    places = result.values[:, 0] * _scale(result, 0)[0]
    values, unit = _shown(result, name)
    order = np.argsort(places, kind="stable")
    marker: dict[str, Any] = {"marker": "o", "markersize": 2.6} if len(places) <= DOTS else {}
    axes.plot(places[order], values[order], color=BLUE, linewidth=1.0, **marker)
    failed = ~np.isfinite(values)
    if failed.any():
        axes.plot(
            places[failed], np.zeros(failed.sum()), "x", color=VERMILION, markersize=4.5, transform=axes.get_xaxis_transform(),
            clip_on=False, zorder=6,
        )  # fmt: skip
    axes.set_ylabel(f"[{unit}]")
    name_panel(axes, words(name))


def _map(figure: Figure, axes: Axes, result: SweepResult, name: str) -> None:
    (across, _), (up, label) = _scale(result, 0), _scale(result, 1)
    x, y = result.values[:, 0] * across, result.values[:, 1] * up
    values, unit = _shown(result, name)
    failed = ~np.isfinite(values)
    colored: ScalarMappable | None = None
    if result.axes and min(result.shape) > 1 and all(np.all(np.diff(axis) > 0) for axis in result.axes):
        field = np.ma.masked_invalid(values.reshape(result.shape).T)
        colored = axes.pcolormesh(
            result.axes[0] * across, result.axes[1] * up, field, shading="nearest", cmap=COLORS, rasterized=True
        )  # fmt: skip
    else:
        colored = axes.scatter(x[~failed], y[~failed], c=values[~failed], s=16.0, cmap=COLORS, edgecolors=INK, linewidths=0.2)
    axes.plot(x[failed], y[failed], "x", color=VERMILION, markersize=4.0, zorder=6)
    figure.colorbar(colored, ax=axes, pad=0.015, label=f"[{unit}]")
    axes.set_ylabel(label)
    axes.grid(False)
    name_panel(axes, words(name))
