"""The diagram drawn by all solvers at once, one on the other, with their errors below."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
from report import color_of, machine

from modelgen.plots.style import GRAY, INK, SMALL, name_panel, sheet, style

MARKS: tuple[dict[str, Any], ...] = (
    {"marker": "o", "markersize": 2.4, "markeredgewidth": 0, "zorder": 5},
    {"marker": "+", "markersize": 5.0, "markeredgewidth": 0.8, "zorder": 4},
    {"marker": "o", "markersize": 6.0, "markerfacecolor": "none", "markeredgewidth": 0.8, "zorder": 3},
    {"marker": "s", "markersize": 8.0, "markerfacecolor": "none", "markeredgewidth": 0.8, "zorder": 2},
    {"marker": "D", "markersize": 10.0, "markerfacecolor": "none", "markeredgewidth": 0.8, "zorder": 1},
)
CLOUD: dict[str, Any] = {"marker": "o", "markersize": 1.8, "markeredgewidth": 0}
TICKS = (0.0, 0.001, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05)
HALF = 0.006  # of the band of a column that is not compared, in roots of the damping ratio


def diagram_figure(
    told: Mapping[str, Any], places: list[str], drawn: Mapping[str, np.ndarray], errors: Mapping[str, np.ndarray], path: Path
) -> None:
    """A panel for each place with the strobed angles (columns, strobes, places) [deg] of each solver; a panel of errors.

    Where solvers cannot be compared point by point their clouds stand side by side, elsewhere their points lie on each other.
    """
    values = np.array(told["values"])
    apart = np.isin(values, told["not_compared"])
    sides = np.linspace(-0.6, 0.6, len(drawn)) * HALF if len(drawn) > 1 else np.zeros(1)
    with style():
        figure = sheet("fracturing truck", "bifurcation diagram over the damping ratio", _detail(told), height=13.5)
        panels = figure.subplots(len(places) + 1, 1, sharex=True, height_ratios=[4.5] * len(places) + [3.2])
        for mark, side, (name, points) in zip(MARKS, sides, drawn.items(), strict=False):
            color = color_of(name)
            for k, axes in enumerate(panels[:-1]):
                for which, at, how in ((~apart, values, mark), (apart, _square(_root(values) + side), CLOUD)):
                    xs = np.repeat(at[which], points.shape[1])
                    axes.plot(xs, points[which, :, k].ravel(), linestyle="none", color=color, **how)
            panels[-1].semilogy(
                values[~apart], errors[name][~apart], linestyle="none", color=color, label=_label(name, told), **mark
            )
        for axes, place in zip(panels, places, strict=False):
            axes.set_ylabel("elastic angle [\u00b0]")
            name_panel(axes, f"{place}, once per turn of the pump")
        _errors(panels[-1], told, [errors[name][~apart] for name in drawn])
        for value in values[apart]:
            for axes in panels:
                axes.axvspan(*_square(_root(value) + np.array([-HALF, HALF])), color=GRAY, alpha=0.15, linewidth=0, zorder=0)
        figure.align_ylabels(list(panels))
        figure.legend(*panels[-1].get_legend_handles_labels(), loc="outside lower center", ncols=1, fontsize=SMALL)
        figure.savefig(path)


def _errors(axes: Any, told: Mapping[str, Any], found: list[np.ndarray]) -> None:
    """The lower panel's axes, with room around the aim."""
    finite = [each[np.isfinite(each) & (each > 0)] for each in found]
    every = np.concatenate([*finite, [told["level"]]])
    axes.axhline(told["level"], color=INK, linewidth=0.6, linestyle=(0, (4, 2)))
    axes.set_ylim(every.min() / 2, every.max() * 3)
    axes.set_ylabel("error [-]")
    name_panel(axes, "error of the strobes; dashed: what all are tuned to")
    axes.set_xscale("function", functions=(_root, _square))
    axes.set_xticks(TICKS, [f"{tick:g}" for tick in TICKS])
    axes.set_xlim(_square(np.array(-1.5 * HALF)), 0.0525)
    axes.set_xlabel("damping ratio \u03b6 of the shafts [-], on a root scale")


def _detail(told: Mapping[str, Any]) -> str:
    left_out = ", ".join(f"{value:g}" for value in told["not_compared"])
    shaded = f" Shaded (\u03b6 = {left_out}): too sensitive for that; clouds stand side by side." if left_out else ""
    return (
        f"{machine()}; {date.today().isoformat()}. {told['columns']} columns of {told['revolutions']} turns of the pump from the "
        f"static start, the last {told['strobes']} drawn; mesh damping in proportion. Error: largest difference of any channel "
        f"from a tight solution, per half its peak-to-peak; points of one column lie on each other.{shaded}"
    )


def _label(name: str, told: Mapping[str, Any]) -> str:
    row = next(row for row in told["rows"] if row["name"] == name)
    whole = f", all {told['columns']} columns {row['whole_s']:.3g} s" if told["not_compared"] else ""
    return f"{name}: {told['compared']} columns {row['seconds']:.3g} s{whole} (tolerance {row['tolerance']:.1e})"


def _root(values: np.ndarray) -> np.ndarray:
    """A root that goes on below zero, so that the axis has a margin."""
    return np.sign(values) * np.sqrt(np.abs(values))


def _square(values: np.ndarray) -> np.ndarray:
    return np.sign(values) * np.square(values)
