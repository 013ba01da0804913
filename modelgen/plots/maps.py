"""Figure of an operating map: peak angle, rattle, share of time without contact and least mesh force over two parameters.

Draws ``MapResult`` of ``modelgen.analysis``. Cells that could not be run are crossed out; rattle regions have outlines, so that
they are told apart in gray as well.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from modelgen.analysis.nonlinear.maps import RATTLE, MapResult
from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import Display, display, words
from modelgen.plots.style import INK, PALE, SMALL, VERMILION, name_panel, panels, sheet, styled
from modelgen.units import read_quantity

PANEL = 5.2  # cm high
REGIONS = ("#F4F4F4", "#E9C46A", "#B5482A")


@plot.register
@styled
def plot_map(result: MapResult, /, *, limit: float | str | None = None) -> Figure:
    """Peak angle and, for every gear pair, rattle, time apart and least force, each as a panel over both parameters.

    ``limit``: a line where the peak angle passes it (rad, or a text such as "0.5 deg"). Raises CaseError for fewer than two
    values on an axis.
    """
    where = f"operating map of {result.model!r}"
    if len(result.first_values) < 2 or len(result.second_values) < 2:
        raise CaseError(where, "has an axis with one value", "give both axes two values or more")
    bound = read_quantity(limit, "rad", where) if isinstance(limit, str) else limit
    wanted: list[tuple[str, str]] = [("angle", "")]
    wanted += [(kind, mesh) for mesh in result.meshes for kind in ("rattle", "apart", "force")]
    columns = 2
    if len(wanted) % columns and result.meshes:
        wanted.insert(1, ("rattle", ""))
    rows = -(-len(wanted) // columns)
    title = f"operating map, {words(result.first)} x {words(result.second)}"
    figure = sheet(result.model, title, _detail(result, bound), height=PANEL * rows + 1.0)
    every = [axes for row in panels(figure, rows, columns) for axes in row]
    across, up = (
        _scale(result.first, result.first_unit, result.first_values),
        _scale(result.second, result.second_unit, result.second_values),
    )
    for axes, (kind, mesh) in zip(every, wanted, strict=False):
        _panel(figure, axes, result, kind, mesh, across(result.first_values), up(result.second_values), bound)
    for axes in every[len(wanted) :]:
        axes.set_axis_off()
    for k, axes in enumerate(every[: len(wanted)]):
        if k >= len(wanted) - columns:
            axes.set_xlabel(f"{words(result.first)} [{across.unit}]")
            axes.tick_params(labelbottom=True)
        if k % columns == 0:
            axes.set_ylabel(f"{words(result.second)} [{up.unit}]")
    if result.meshes:
        figure.legend(handles=_legend(), loc="outside lower center", ncols=3)
    return figure


def _scale(name: str, unit: str, values: np.ndarray) -> Display:
    if name == "speed" and unit == "rad/s":
        return Display(30 / np.pi, "rpm")
    return display(unit, float(np.abs(values).max()))


def _panel(
    figure: Figure, axes: Axes, result: MapResult, kind: str, mesh: str, x: np.ndarray, y: np.ndarray, limit: float | None
) -> None:
    axes.grid(visible=False)
    draw: dict[str, Any] = {"shading": "nearest", "rasterized": True, "zorder": 1}
    if kind == "angle":
        shown = display("rad", 1.0)
        mesh_of = axes.pcolormesh(x, y, shown(result.peak_angle), cmap=colormaps["viridis"], **draw)
        _bar(figure, axes, mesh_of, f"peak [{shown.unit}]")
        known = result.peak_angle[~np.isnan(result.peak_angle)]
        if limit is not None and known.size and known.min() < limit < known.max():
            axes.contour(x, y, result.peak_angle, levels=[limit], colors=[VERMILION], linewidths=1.2)
        name_panel(axes, "largest vibration angle, 0-peak")
    elif kind == "rattle":
        regions = result.rattle(mesh or None)
        axes.pcolormesh(x, y, np.maximum(regions, 0), cmap=ListedColormap(REGIONS), vmin=-0.5, vmax=2.5, **draw)
        for level in (1, 2):
            if np.any(regions == level) and not np.all(regions == level):
                axes.contour(x, y, (regions >= level).astype(float), levels=[0.5], colors=[INK], linewidths=0.7)
        name_panel(axes, f"{words(mesh)}: rattle" if mesh else "rattle of any gear pair")
    elif kind == "apart":
        mesh_of = axes.pcolormesh(
            x, y, 100 * (result.apart[mesh] + result.back[mesh]), cmap=colormaps["cividis"], vmin=0, vmax=100, **draw
        )
        _bar(figure, axes, mesh_of, "share of time [%]")
        name_panel(axes, f"{words(mesh)}: off the driving flank")
    else:
        force = result.least_force[mesh]
        known = force[~np.isnan(force)] if np.any(~np.isnan(force)) else np.zeros(1)
        shown = display("N", float(np.abs(known).max()))
        low, high = float(shown(known.min())), float(shown(known.max()))
        scale = TwoSlopeNorm(0.0, min(low, -1e-9), max(high, 1e-9))
        mesh_of = axes.pcolormesh(x, y, shown(force), cmap=colormaps["RdBu"], norm=scale, **draw)
        _bar(figure, axes, mesh_of, f"least force [{shown.unit}]")
        name_panel(axes, f"{words(mesh)}: least mesh force")
    for row, column in result.failures:
        axes.plot(x[column], y[row], marker="x", color=INK, markersize=3, zorder=5)
    axes.set_xlim(_edge(x))
    axes.set_ylim(_edge(y))


def _edge(values: np.ndarray) -> tuple[float, float]:
    return float(values[0] - (values[1] - values[0]) / 2), float(values[-1] + (values[-1] - values[-2]) / 2)


def _bar(figure: Figure, axes: Axes, drawn: Any, label: str) -> None:
    bar = figure.colorbar(drawn, ax=axes, pad=0.02, aspect=22)
    bar.set_label(label, fontsize=SMALL)
    bar.outline.set_visible(False)


def _legend() -> list[Patch]:
    names = ("no rattle", "one-sided: flanks part", "two-sided: the back flank is hit")
    assert len(names) == len(RATTLE)
    return [Patch(facecolor=color, edgecolor=PALE, label=name) for color, name in zip(REGIONS, names, strict=True)]


def _detail(result: MapResult, limit: float | None) -> str:
    cells = result.peak_angle.size
    said = ""
    if result.failures:
        first = next(iter(result.failures.values()))
        said = f" {len(result.failures)} cells could not be run (crossed out), the first: {first}."
    unsettled = int(np.sum(~result.settled)) - len(result.failures)
    if unsettled > 0:
        said += f" {unsettled} cells did not have the time to settle."
    line = f" Red line: {np.degrees(limit):.3g} degrees." if limit is not None else ""
    return (
        f"{cells} cells, each measured over {result.revolutions} periods of {words(result.base)} after the slowest mode has "
        f"decayed. Physical angles of any inertia, less their best straight line.{line}{said}"
    )
