"""``modelgen map``: angles, mesh forces and rattle over two parameters, such as speed and load.

Part of ``cli``; asks ``analysis.nonlinear.maps``.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from modelgen.cli.question import asks_a_model, fills_a_folder

if TYPE_CHECKING:
    from modelgen.analysis import MapResult

EXAMPLES = """
\b
Examples:
  modelgen map fracturing-truck-idle --out out/map --first speed "900 rpm" "1950 rpm" --second firing_mean "20 N*m" "600 N*m"

\b
Ends with 0 when done, 1 if a cell could not be run, 2 if it was refused. After Ctrl-C, 130: the cells that are done are kept.
"""
AXIS = "and its range, units allowed."


@click.command(name="map", epilog=EXAMPLES)
@asks_a_model
@fills_a_folder
@click.option("--first", nargs=3, required=True, metavar="NAME FIRST LAST", help=f"The parameter across {AXIS}")
@click.option("--second", nargs=3, required=True, metavar="NAME FIRST LAST", help=f"The parameter upward {AXIS}")
@click.option("--columns", type=click.IntRange(min=2), default=40, show_default=True, help="How many values of the first.")
@click.option("--rows", type=click.IntRange(min=2), default=20, show_default=True, help="How many values of the second.")
@click.option("--revolutions", type=click.IntRange(min=1), default=8, show_default=True, help="Of the slowest base, measured.")
@click.option("--limit", metavar="ANGLE", help='A limit of the vibration angle to draw, such as "0.5 deg".')
@click.option("--tolerance", type=float, default=1e-5, show_default=True, help="Of a step, per scale of each state.")
def operating_map(
    model: str,
    assignments: tuple[str, ...],
    speed: str | None,
    out: Path,
    replace: bool,
    first: tuple[str, str, str],
    second: tuple[str, str, str],
    columns: int,
    rows: int,
    revolutions: int,
    limit: str | None,
    tolerance: float,
) -> None:
    """Operating map of MODEL: peak angle, least mesh force, time without contact and rattle in every cell.

    The folder gets map.csv (a row per cell), map.json and a figure.
    """
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    with output_folder(out, replace, WRITTEN) as folder, Progress() as progress:
        progress.stage(f"read {model}")
        from modelgen.analysis import operating_map as map_of
        from modelgen.cli.bifurcation_case import stepped, strobed_case
        from modelgen.errors import Interrupted
        from modelgen.units import read_quantity

        bound = read_quantity(limit, "rad", "--limit") if limit is not None else None
        case = strobed_case(model, assignments, speed, None, tolerance)
        across, up = stepped(case.model, first, columns, "--first"), stepped(case.model, second, rows, "--second")
        progress.stage(f"run {columns * rows} cells", measured=True)
        try:
            result = map_of(case, across, up, revolutions=revolutions, progress=progress.fraction)
        except Interrupted as stopped:
            result = stopped.result
        progress.stage("write table and figure")
        _write(result, bound, folder)
    click.echo(str(result))
    click.echo(f"table, figure and map.json: {out}")
    if result.missing:
        from modelgen.cli.ending import INTERRUPTED, Ending

        raise Ending(f"interrupted; {result.missing} cells were not run, the others are kept in {out}", INTERRUPTED)
    if result.failures:
        from modelgen.cli.ending import FAILED, Ending

        raise Ending(f"{len(result.failures)} cells could not be run: {next(iter(result.failures.values()))}", FAILED)


WRITTEN = ("map.csv", "map.json", "map.png")


def _write(result: MapResult, limit: float | None, folder: Path) -> None:
    from modelgen.analysis.nonlinear.maps import RATTLE
    from modelgen.plots import plot, save
    from modelgen.reports.tables import write_data, write_table

    header = [f"{result.first} [{result.first_unit}]", f"{result.second} [{result.second_unit}]"]
    header += ["peak vibration angle [deg]", "of", "repeats after [common periods]"]
    for mesh in result.meshes:
        header += [f"{mesh} rattle", f"{mesh} least force [N]", f"{mesh} apart [1]", f"{mesh} on the back flank [1]"]
    header.append("failure")
    regions = {mesh: result.rattle(mesh) for mesh in result.meshes}
    table = []
    for row, up in enumerate(result.second_values.tolist()):
        for column, across in enumerate(result.first_values.tolist()):
            at = row, column
            cells = [across, up, math.degrees(result.peak_angle[at]), result.inertias[result.where[at]], int(result.repeats[at])]
            for mesh in result.meshes:
                said = RATTLE[regions[mesh][at]] if at not in result.failures else ""
                shares = (result.least_force[mesh][at], result.apart[mesh][at], result.back[mesh][at])
                cells += [said, *(float(each) for each in shares)]
            table.append([*cells, result.failures.get(at, "")])
    write_table(folder / "map.csv", header, table)
    worst = result.rattle()
    data = {
        "model": result.model,
        "first": result.first,
        "second": result.second,
        "cells": int(worst.size),
        "cells_by_rattle": {name: int((worst == k).sum()) for k, name in enumerate(RATTLE)},
        "largest_peak_angle_deg": max((math.degrees(each) for each in result.peak_angle.ravel() if each == each), default=0.0),
        "failures": [{"row": row, "column": column, "message": text} for (row, column), text in result.failures.items()],
    }
    write_data(folder / "map.json", data)
    save(plot(result, limit=limit), folder / "map.png")
