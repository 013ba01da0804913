"""Figure of mode shapes along the real train: referred angles, with the shaft lines, gear pairs and branches as they are.

Draws ``ModalResult`` of ``modelgen.analysis``. Referred to the reference shaft, a rigid gear pair would join its two wheels by a
level line: what slopes between two lines is the deflection of the mesh.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from modelgen.analysis import ModalResult
from modelgen.equations import Equations, assemble
from modelgen.errors import CaseError
from modelgen.model import Driveline
from modelgen.plots.dispatch import plot
from modelgen.plots.glyphs import BRONZE
from modelgen.plots.layout import layout
from modelgen.plots.quantities import number, words
from modelgen.plots.style import BLUE, FAINT, GRAY, SMALL, name_panel, panels, sheet, styled

Array = NDArray[np.float64]
COLUMNS = 2


@dataclass(frozen=True)
class _Train:
    """Stations from left to right: name of each, its row in the result, and the pairs of stations that shafts and gears join."""

    names: tuple[str, ...]
    nodes: tuple[int, ...]
    shafts: tuple[tuple[int, int], ...]
    gears: tuple[tuple[int, int], ...]


@plot.register
@styled
def plot_modes(result: ModalResult, /, *, driveline: Driveline | Equations | None = None, count: int = 6) -> Figure:
    """Shapes of the first vibrating modes in referred angles, largest 1, with frequency and damping ratio.

    With the ``driveline`` its shafts, gears and branches are drawn as they are; without, its parts in the order of the result,
    joined where their speeds are the same. Raises CaseError where no mode vibrates, or for another driveline than the result's.
    """
    where = f"modes of {result.model!r}"
    vibrating = len(result.frequencies) - result.rigid
    if vibrating < 1 or count < 1:
        raise CaseError(where, f"{count} of {vibrating} vibrating modes are to be drawn", "there must be at least one")
    train = _plain_train(result) if driveline is None else _train(driveline)
    if tuple(name for _, name in sorted(zip(train.nodes, train.names, strict=True))) != result.names:
        raise CaseError(where, "the driveline given has other parts", "give the driveline whose modes these are")
    shown = range(result.rigid, result.rigid + min(count, vibrating))
    detail = (
        "Angles referred to the reference shaft (physical / r), largest 1; about the operating point with mean mesh stiffness. "
        "f: undamped natural frequency, ζ: damping ratio; overdamped: its two rates of decay. "
        "Solid: shafts; dashed: gear pairs; bands: lines of one speed ratio r."
    )
    rows = -(-len(shown) // COLUMNS)
    columns = min(COLUMNS, len(shown))
    figure = sheet(result.model, "mode shapes", detail, height=2.2 + 3.5 * rows)
    grid = panels(figure, rows, columns, share_y=True)
    spots = [axes for row in grid for axes in row]
    for place, (mode, axes) in enumerate(zip(shown, spots, strict=False), 1):
        shape = result.referred[:, mode]
        _shape(axes, train, shape / shape[np.abs(shape).argmax()])
        _bands(axes, train, result.ratio, with_text=place <= columns)
        title = f"{result.name(mode)}: f = {result.frequencies[mode]:.4g} Hz, {_damping(result, mode)}"
        name_panel(axes, title, " " if place <= columns else "")
        axes.set(ylim=(-1.15, 1.15), xlim=(-0.7, len(train.names) - 0.3))
    for axes in spots[len(shown) :]:
        axes.set_axis_off()
    for row in grid:
        row[0].set_ylabel("referred angle [-]")
    _name_stations(grid, len(shown), train)
    return figure


def _train(driveline: Driveline | Equations) -> _Train:
    equations = assemble(driveline) if isinstance(driveline, Driveline) else driveline
    places = layout(equations)
    order = [node for row in places.rows for node in row.nodes]
    station = {node: index for index, node in enumerate(order)}
    joined: dict[str, list[tuple[int, int]]] = {"shaft": [], "gear": []}
    for joint in places.joints:
        joined[joint.kind].append((station[joint.first], station[joint.second]))
    names = tuple(equations.nodes[node].name for node in order)
    return _Train(names, tuple(order), tuple(joined["shaft"]), tuple(joined["gear"]))


def _plain_train(result: ModalResult) -> _Train:
    pairs = list(pairwise(range(len(result.names))))
    alike = [bool(np.isclose(result.ratio[a], result.ratio[b], rtol=1e-12)) for a, b in pairs]
    shafts = tuple(pair for pair, same in zip(pairs, alike, strict=True) if same)
    gears = tuple(pair for pair, same in zip(pairs, alike, strict=True) if not same)
    return _Train(result.names, tuple(range(len(result.names))), shafts, gears)


def _shape(axes: Axes, train: _Train, shape: Array) -> None:
    height = shape[list(train.nodes)]
    axes.axhline(0.0, color=GRAY, linewidth=0.6, zorder=1)
    for a, b in train.gears:
        axes.plot([a, b], height[[a, b]], color=BRONZE, linewidth=0.9, linestyle=(0, (3, 2)), zorder=2)
    for a, b in train.shafts:
        axes.plot([a, b], height[[a, b]], color=BLUE, linewidth=1.2, zorder=3)
    axes.plot(np.arange(len(height)), height, linestyle="none", marker="o", markersize=3, color=BLUE, zorder=4)
    axes.grid(axis="x", visible=False)


def _bands(axes: Axes, train: _Train, ratio: Array, with_text: bool) -> None:
    start = 0
    for index, (value, group) in enumerate(groupby(round(float(ratio[each]), 9) for each in train.nodes)):
        end = start + len(list(group))
        if index % 2:
            axes.axvspan(start - 0.5, end - 0.5, color=FAINT, zorder=0, linewidth=0)
        if with_text:
            axes.annotate(
                f"r = {value:.3g}", ((start + end - 1) / 2, 1), xycoords=("data", "axes fraction"), xytext=(0, 2),
                textcoords="offset points", ha="center", va="bottom", fontsize=SMALL, color=GRAY,
            )  # fmt: skip
        start = end


def _name_stations(grid: list[list[Axes]], shown: int, train: _Train) -> None:
    """Names below the lowest panel of each column."""
    for column in range(len(grid[0])):
        used = [row[column] for index, row in enumerate(grid) if index * len(row) + column < shown]
        used[-1].set_xticks(range(len(train.names)), [words(name) for name in train.names], rotation=90, fontsize=6.5)
        used[-1].tick_params(axis="x", labelbottom=True)


def _damping(result: ModalResult, mode: int) -> str:
    own = result.damped(mode)
    if own is None or own.ratio is None:
        slow, fast = (number(rate, 3) for rate in (own.rates if own and own.rates else (0.0, 0.0)))
        return f"{'unstable' if own and own.growth else 'overdamped'}, {slow} and {fast} 1/s"
    return f"ζ = {100 * own.ratio:.2g} %"
