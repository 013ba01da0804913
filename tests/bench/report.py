"""What is written: the summary as JSON, ratios as Markdown, a figure of each question in modelgen's own style."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Mapping
from datetime import date
from pathlib import Path
from typing import Any

from curves import Curve

from modelgen.plots.style import BLUE, GRAY, GREEN, INK, ORANGE, PURPLE, SKY, SMALL, VERMILION, sheet, style

COLORS = {
    "modelgen": BLUE, "heyoka": VERMILION, "numba": GREEN, "CasADi": ORANGE, "JiTCODE": PURPLE, "SciPy": SKY, "diffrax": INK,
}  # fmt: skip
MARKERS = "os^DvPX*"
COLUMNS = {
    "ours [s]": "ours_s", "by": "ours", "fastest peer": "fastest_peer", "[s]": "fastest_peer_s", "ratio": "ratio",
    "peers that reach it": "reached_by", "cvodes": "ratio_cvodes_vm", "SciPy": "ratio_scipy",
}  # fmt: skip


def machine() -> str:
    """Processor and number of cores."""
    name = platform.processor()
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
        name = next(line.partition(":")[2].strip() for line in text.splitlines() if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return f"{name}, {len(os.sched_getaffinity(0))} cores"


def color_of(name: str) -> str:
    """The color of a package by the first word of a solver's name."""
    return COLORS[name.split()[0].rstrip(",")]


def figure(curves: list[Curve], which: str, title: str, shown: str, path: Path) -> None:
    """Seconds per trajectory over the error: a color for each package, a marker for each of its solvers."""
    absent = [curve.name for curve in curves if not curve.points(which)]
    drawn_curves = [curve for curve in curves if curve.points(which)]
    with style():
        drawn = sheet(
            title, "error against cost",
            f"{machine()}; {date.today().isoformat()}. Lower left is better. Every solver at several tolerances; those of "
            f"modelgen are bold. Solid: events are located.{' Without a result: ' + '; '.join(absent) + '.' if absent else ''}",
            height=10.5,
        )  # fmt: skip
        axes = drawn.subplots()
        packages: dict[str, int] = {}
        for curve in drawn_curves:
            color, own = color_of(curve.name), curve.name.startswith("modelgen")
            k = packages[color] = packages.get(color, -1) + 1
            errors, seconds = zip(*curve.points(which), strict=True)
            located = "events" in curve.name and "without" not in curve.name
            axes.loglog(
                errors, seconds, marker=MARKERS[k], color=color, label=curve.name, zorder=4 if own else 3,
                linewidth=1.6 if own else 0.8, linestyle="-" if located else "--", markersize=4.5 if own else 4,
                markerfacecolor=color if own else "white", markeredgewidth=0.9,
            )  # fmt: skip
        axes.axvline(1e-5, color=GRAY, linewidth=0.6, linestyle=(0, (4, 2)), zorder=1)
        axes.annotate(
            "better", (0.91, 0.88), (0.97, 0.96), xycoords="axes fraction", textcoords="axes fraction", ha="right", va="top",
            fontsize=SMALL, color=GRAY, arrowprops={"arrowstyle": "->", "color": GRAY, "linewidth": 0.8},
        )  # fmt: skip
        axes.set_xlabel(f"largest error of any channel per half its peak-to-peak{shown} [-]")
        axes.set_ylabel("seconds per trajectory [s]")
        drawn.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=6.5, handlelength=3.6)
        drawn.savefig(path)


def _cell(value: Any) -> str:
    return "-" if value is None else f"{value:.3g}" if isinstance(value, float) else str(value)


def _rows(heads: list[str], rows: list[list[Any]]) -> list[str]:
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return [*lines, *("| " + " | ".join(map(_cell, row)) + " |" for row in rows), ""]


def table(summary: Mapping[str, Any]) -> str:
    """The ratios as Markdown: seconds of the fastest peer, of cvodes and of SciPy per ours, at one error."""
    head = (
        f"{summary['machine']}, {summary['date']}. Seconds per trajectory at an error. Ratios: seconds per ours, of the fastest "
        "peer, of CasADi's cvodes on its virtual machine, of SciPy's DOP853 called from Python."
    )
    lines = [head, ""]
    names = ("single", "sweep_median", "sweep_worst", "smooth_single", "gear_pair_single")
    rows = [
        [name, level, *(row.get(key) for key in COLUMNS.values())]
        for name in names
        for level, row in summary.get(name, {}).items()
    ]
    lines += _rows(["question", "error", *COLUMNS], rows) if rows else []
    if found := summary.get("diagram"):
        said = (
            f"Bifurcation diagram: {found['columns']} columns of {found['revolutions']} revolutions. "
            f"The {found['compared']} that can be compared point by point (seconds): fastest peer {found['fastest_peer']}, "
            f"ratio {_cell(found['ratio'])}; all of them (whole_s): {found['fastest_peer_whole']}, "
            f"ratio {_cell(found['ratio_whole'])} to {found['ours_whole']}."
        )
        heads = ["name", "tolerance", "error", "seconds", "whole_s"]
        lines += [said, "", *_rows(heads, [[row[key] for key in heads] for row in found["rows"]])]
    if found := summary.get("scaling"):
        heads = list(dict.fromkeys(key for row in found.values() for key in row))
        lines += _rows(["inertias", *heads], [[count, *(row.get(key) for key in heads)] for count, row in found.items()])
    silent = {
        key: [f"{curve['name']} {each}" for curve in curves for each in curve["failures"]]
        for key, curves in summary.get("curves", {}).items()
    }
    said = [f"- {key}: {each}" for key, each in summary["failures"].items()]
    said += [f"- {key}: {each}" for key, every in silent.items() for each in every]
    return "\n".join([*lines, *(["What failed:", "", *said, ""] if said else [])])


def written(summary: Mapping[str, Any], out: Path) -> None:
    """Writes summary.json and table.md, each whole or not at all."""
    texts = {"summary.json": json.dumps(summary, indent=2, default=float) + "\n", "table.md": table(summary)}
    for name, text in texts.items():
        part = out / f"{name}.part"
        part.write_text(text, encoding="utf-8")
        part.replace(out / name)
