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
    {"marker": "o", "markersize": 2.6, "markeredgewidth": 0, "zorder": 5},
    {"marker": "o", "markersize": 6.5, "markerfacecolor": "none", "markeredgewidth": 0.7, "zorder": 3},
    {"marker": "s", "markersize": 9.0, "markerfacecolor": "none", "markeredgewidth": 0.6, "zorder": 2},
    {"marker": "D", "markersize": 11.5, "markerfacecolor": "none", "markeredgewidth": 0.5, "zorder": 1},
)
TICKS = (0.0, 0.001, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05)


def diagram_figure(
    told: Mapping[str, Any], places: list[str], drawn: Mapping[str, np.ndarray], errors: Mapping[str, np.ndarray], path: Path
) -> None:
    """A panel for each place with the strobed angles (columns, strobes, places) [deg] of each solver; a panel of errors."""
    values, apart = np.array(told["values"]), set(told["not_compared"])
    rows = {row["name"]: row for row in told["rows"]}
    with style():
        left_out = ", ".join(f"{value:g}" for value in told["not_compared"])
        figure = sheet(
            "fracturing truck", "bifurcation diagram over the damping ratio",
            f"{machine()}; {date.today().isoformat()}. {told['columns']} columns of {told['revolutions']} turns of the pump, the "
            f"last {told['strobes']} drawn; mesh damping in proportion. All solvers are tuned to an error of {told['level']:g}."
            + (f" Shaded (\u03b6 = {left_out}): too sensitive for a comparison point by point." if left_out else ""),
            height=14.0,
        )  # fmt: skip
        panels = figure.subplots(len(places) + 1, 1, sharex=True, height_ratios=[4.5] * len(places) + [3.0])
        for k, (axes, place) in enumerate(zip(panels, places, strict=False)):
            for mark, (name, points) in zip(MARKS, drawn.items(), strict=False):
                xs = np.repeat(values, points.shape[1])
                axes.plot(xs, points[:, :, k].ravel(), linestyle="none", color=color_of(name), **mark)
            axes.set_ylabel("elastic angle [\u00b0]")
            name_panel(axes, f"{place}: once per turn")
        below = panels[-1]
        for mark, (name, found) in zip(MARKS, errors.items(), strict=False):
            row = rows[name]
            shown = [e if v not in apart else np.nan for e, v in zip(found, values, strict=True)]
            said = f"{name}: {row['seconds']:.3g} s (tolerance {row['tolerance']:.1e})"
            below.semilogy(values, shown, linestyle="none", color=color_of(name), label=said, **mark)
        below.axhline(told["level"], color=INK, linewidth=0.6, linestyle=(0, (4, 2)))
        below.set_ylabel("error [-]")
        name_panel(below, "largest difference of any channel from a tight solution, per half its peak-to-peak; dashed: the aim")
        below.set_xscale("function", functions=(_root, _square))
        below.set_xticks(TICKS, [f"{tick:g}" for tick in TICKS])
        below.set_xlim(-2e-5, 0.052)
        below.set_xlabel("damping ratio \u03b6 of the shafts [-], on a root scale")
        for value in told["not_compared"]:
            low, high = (np.square(max(0.0, np.sqrt(value) + side)) for side in (-0.006, 0.006))
            for axes in panels:
                axes.axvspan(low if low > 0 else -2e-5, high, color=GRAY, alpha=0.15, linewidth=0, zorder=0)
        figure.align_ylabels(list(panels))
        figure.legend(*below.get_legend_handles_labels(), loc="outside lower center", ncols=1, fontsize=SMALL)
        figure.savefig(path)


def _root(values: np.ndarray) -> np.ndarray:
    """A root that goes on below zero, so that the axis has a margin."""
    return np.sign(values) * np.sqrt(np.abs(values))


def _square(values: np.ndarray) -> np.ndarray:
    return np.sign(values) * np.square(values)
