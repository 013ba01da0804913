"""Figures of what the natural frequencies depend on: sensitivities to the parameters, and the energy shares of the elements.

Draws ``SensitivityResult`` and the shares of a ``ModalResult`` of ``modelgen.analysis``, a panel per mode.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modelgen.analysis.linear.modal import ModalResult
from modelgen.analysis.linear.sensitivity import SensitivityResult
from modelgen.errors import CaseError
from modelgen.plots.dispatch import plot
from modelgen.plots.quantities import MINUS, words
from modelgen.plots.style import BLUE, INK, ORANGE, SKY, SMALL, TEXT, name_panel, panels, sheet, styled

COLUMNS = 2
ROW = 0.46  # cm
NEGLIGIBLE = 5e-4  # shares and slopes that would be printed as 0.0 %


@plot.register
@styled
def plot_sensitivities(result: SensitivityResult, /, *, modes: int = 6, count: int = 6) -> Figure:
    """Relative sensitivities of the first vibrating modes to the ``count`` parameters that each depends on most.

    Raises CaseError where no mode vibrates.
    """
    shown = _modes(f"sensitivities of {result.model!r}", result.rigid, result.frequencies, modes, count)
    shared = {mode for cluster in result.repeated for mode in cluster}
    largest = {mode: [each for each in result.largest(mode, count) if abs(each[1]) > NEGLIGIBLE] for mode in shown}
    methods = dict(zip(result.parameters, result.methods, strict=True))
    rough = {name for pairs in largest.values() for name, _ in pairs if methods[name] == "differences"}
    detail = (
        "Relative change of the natural frequency per relative change of the parameter: at 0.5, a parameter 10 % larger raises "
        f"the frequency by about 5 %.{' Hatched: by differences, where no derivative exists.' if rough else ''}"
    )
    figure, spots = _grid(result.model, "sensitivities of the natural frequencies", detail, len(shown), count)
    for mode, axes in zip(shown, spots, strict=False):
        for row, (name, slope) in enumerate(largest[mode]):
            axes.barh(row, slope, 0.62, color=BLUE if slope > 0 else ORANGE, hatch="/////" if name in rough else None,
                      edgecolor="white", linewidth=0, zorder=3)  # fmt: skip
            axes.annotate(
                f"{slope:+.2f}".replace("-", MINUS), (slope, row), xytext=(2 if slope > 0 else -2, 0), va="center",
                textcoords="offset points", ha="left" if slope > 0 else "right", fontsize=SMALL,
            )  # fmt: skip
        axes.axvline(0.0, color=INK, linewidth=0.6, zorder=4)
        slopes = [0.0, *(slope for _, slope in largest[mode])]
        least, most = min(slopes), max(slopes)
        room = 0.42 * (most - least) or 1.0  # for the numbers at the ends
        axes.set_xlim(least - room * (1.0 if least < 0 else 0.1), most + room * (1.0 if most > 0 else 0.1))
        _rows(axes, [words(name).replace(".", ", ") for name, _ in largest[mode]], count)
        name_panel(axes, f"{result.name(mode)}: {result.frequencies[mode]:.4g} Hz{' (repeated)' if mode in shared else ''}")
    _name_columns(spots, len(shown), "relative sensitivity [-]")
    return figure


@styled
def energy_shares(result: ModalResult, /, *, modes: int = 6, count: int = 6) -> Figure:
    """Shares of the kinetic and the potential energy of the first vibrating modes, of the ``count`` elements that hold most.

    Raises CaseError where no mode vibrates.
    """
    shown = _modes(f"energy shares of {result.model!r}", result.rigid, result.frequencies, modes, count)
    detail = "Shares of the kinetic and of the potential energy of each mode; over all elements each sums to 100 %."
    figure, spots = _grid(result.model, "energy shares of the modes", detail, len(shown), count)
    for mode, axes in zip(shown, spots, strict=False):
        kinetic, potential = 100 * result.kinetic[:, mode], 100 * result.potential[:, mode]
        size = np.maximum(kinetic, potential)
        order = [int(k) for k in np.argsort(-size, kind="stable")[:count] if size[k] > 100 * NEGLIGIBLE]
        for shares, color, hatch, name in ((kinetic, BLUE, None, "kinetic"), (potential, SKY, "/////", "potential")):
            filled = [row for row, k in enumerate(order) if shares[k] > 100 * NEGLIGIBLE]
            # An element with both kinds has two bars, one above the other.
            double = [min(kinetic[order[row]], potential[order[row]]) > 100 * NEGLIGIBLE for row in filled]
            shift = 0.16 if name == "potential" else -0.16
            places = [row + shift * both for row, both in zip(filled, double, strict=True)]
            values = [float(shares[order[row]]) for row in filled]
            axes.barh(places, values, [0.31 if both else 0.62 for both in double], color=color, hatch=hatch, edgecolor="white",
                      linewidth=0, label=name, zorder=3)  # fmt: skip
        for row, k in enumerate(order):
            axes.annotate(f"{size[k]:.3g} %", (size[k], row), xytext=(2, 0), textcoords="offset points", va="center",
                          fontsize=SMALL)  # fmt: skip
        axes.set_xlim(0, 1.3 * max(size.max(), 1e-9))
        _rows(axes, [words(result.elements[k]) for k in order], count)
        name_panel(axes, f"{result.name(mode)}: {result.frequencies[mode]:.4g} Hz")
    _name_columns(spots, len(shown), "share of the energy [%]")
    handles, labels = spots[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def _modes(where: str, rigid: int, frequencies: np.ndarray, modes: int, count: int) -> range:
    vibrating = len(frequencies) - rigid
    if vibrating < 1 or modes < 1 or count < 1:
        raise CaseError(where, f"{modes} of {vibrating} vibrating modes are to be drawn", "there must be at least one")
    return range(rigid, rigid + min(modes, vibrating))


def _grid(model: str, what: str, detail: str, shown: int, count: int) -> tuple[Figure, list[Axes]]:
    columns = min(COLUMNS, shown)
    rows = -(-shown // columns)
    figure = sheet(model, what, detail, height=1.4 + rows * (ROW * count + 1.0))
    return figure, [axes for row in panels(figure, rows, columns, share_x=False) for axes in row]


def _rows(axes: Axes, names: list[str], count: int) -> None:
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(count - 0.4, -0.6)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", labelsize=6.5)
    axes.locator_params(axis="x", nbins=5)


def _name_columns(spots: list[Axes], shown: int, text: str) -> None:
    for index, axes in enumerate(spots):
        if index >= shown:
            axes.set_axis_off()
        elif index + COLUMNS >= shown:
            axes.set_xlabel(text, fontsize=TEXT)
