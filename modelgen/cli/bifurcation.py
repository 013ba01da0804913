"""``modelgen bifurcation``: the settled motion over a parameter, strobed at the common period.

Part of ``cli``; asks ``analysis.nonlinear.bifurcation``.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from modelgen.cli.question import asks_a_model, fills_a_folder

if TYPE_CHECKING:
    from modelgen.analysis import BifurcationResult

EXAMPLES = """
\b
Examples:
  modelgen bifurcation fracturing-truck-commensurate --out out/zeta --over zeta 0 0.05 --count 201
  modelgen bifurcation fracturing-truck-commensurate --out out/scaled --over zeta 0 0.05 --mesh-reading scaled
  modelgen bifurcation my_driveline.toml --out out/hysteresis --over speed "900 rpm" "1500 rpm" --direction both

\b
Ends with 0 when done, 1 if a column could not be run, 2 if it was refused. After Ctrl-C, 130: the columns that are done are kept.
"""
CHANNEL = "A channel to show, such as coupling.twist. Repeatable.  [default: elastic angles of reference shaft and last inertia]"
DIRECTION = "Columns by themselves, or each from the last state of its neighbor, upward, downward or both."
STARTS = 'Starts of independent columns: "static" or "zero". Repeatable; finds motions that coexist.'
TRANSIENT = "Most strobes that a column is waited for until it stands still."
STILL = "How near strobes come back, per scale of the states.  [default: 1e-6, or ten tolerances if that is more]"
BASE = "Strobe at the period of this base frequency, where there is no short common period."
READING = "Mesh damping ratio: of its own, or 0.1 zeta/0.035."


@click.command(epilog=EXAMPLES)
@asks_a_model
@fills_a_folder
@click.option("--over", nargs=3, required=True, metavar="NAME FIRST LAST", help="The parameter and its range, units allowed.")
@click.option("--count", type=click.IntRange(min=2), default=101, show_default=True, help="How many values.")
@click.option("--channel", multiple=True, metavar="CHANNEL", help=CHANNEL)
@click.option(
    "--direction",
    type=click.Choice(["independent", "forward", "backward", "both"]),
    default="independent",
    show_default=True,
    help=DIRECTION,
)
@click.option("--start", "starts", multiple=True, type=click.Choice(["static", "zero"]), help=STARTS)
@click.option("--strobes", type=click.IntRange(min=16), default=150, show_default=True, help="Strobes that are kept.")
@click.option("--transient", type=click.IntRange(min=0), default=200, show_default=True, help=TRANSIENT)
@click.option("--still", type=click.FloatRange(min=0, max=1, min_open=True, max_open=True), help=STILL)
@click.option("--base", metavar="NAME", help=BASE)
@click.option("--mesh-reading", type=click.Choice(["fixed", "scaled"]), help=READING)
@click.option("--tolerance", type=float, default=1e-5, show_default=True, help="Of a step, per scale of each state.")
def bifurcation(
    model: str,
    assignments: tuple[str, ...],
    speed: str | None,
    out: Path,
    replace: bool,
    over: tuple[str, str, str],
    count: int,
    channel: tuple[str, ...],
    direction: str,
    starts: tuple[str, ...],
    strobes: int,
    transient: int,
    still: float | None,
    base: str | None,
    mesh_reading: str | None,
    tolerance: float,
) -> None:
    """Bifurcation diagram of MODEL over a parameter: strobes at the common period of all that shakes, after the transient.

    The folder gets bifurcation.csv (every strobe), columns.csv (period, residual and transient of every column),
    bifurcation.json and a figure. A column that did not come to stand still says so.
    """
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    with output_folder(out, replace, WRITTEN) as folder, Progress() as progress:
        progress.stage(f"read {model}")
        from modelgen.analysis import bifurcation as diagram_of
        from modelgen.cli.bifurcation_case import stepped, strobed_case
        from modelgen.errors import Interrupted

        case = strobed_case(model, assignments, speed, mesh_reading, tolerance)
        name, values = stepped(case.model, over, count, "--over")
        progress.stage(f"strobe {count} values", measured=True)
        try:
            result = diagram_of(
                *(case, name, values, channel or None),
                direction=direction,
                starts=starts or None,
                count=strobes,
                transient=transient,
                still=still,
                base=base,
                progress=progress.fraction,
            )
        except Interrupted as stopped:
            result = stopped.result
        progress.stage("write tables and figure")
        _write(result, folder)
    click.echo(str(result))
    click.echo(f"tables, figure and bifurcation.json: {out}")
    if result.missing:
        from modelgen.cli.ending import INTERRUPTED, Ending

        raise Ending(f"interrupted; {result.missing} columns were not run, the others are kept in {out}", INTERRUPTED)
    if result.failed:
        from modelgen.cli.ending import FAILED, Ending

        raise Ending(f"{len(result.failed)} columns could not be run: {result.failed[0].failure}", FAILED)


WRITTEN = ("bifurcation.csv", "columns.csv", "bifurcation.json", "bifurcation.png")


def _write(result: BifurcationResult, folder: Path) -> None:
    from modelgen.plots import plot, save
    from modelgen.reports.tables import write_data, write_table

    value = f"{result.parameter} [{result.unit}]"
    header = [value, "branch", *(f"{name} [{unit}]" for name, unit in zip(result.channels, result.units, strict=True))]
    header.append("ending")
    rows = (
        [column.value, column.branch, *point, column.failure] for column in result.columns for point in column.points.tolist()
    )
    write_table(folder / "bifurcation.csv", header, rows)
    header = [value, "branch", "period [strobes]", "settled", "residual [scales]", "transient [strobes]", "ending"]
    write_table(folder / "columns.csv", header, [list(each.values()) for each in _columns(result)])
    write_data(folder / "bifurcation.json", bifurcation_data(result))
    if len(result.values) > 1:  # Ctrl-C may leave one, which is no diagram
        save(plot(result), folder / "bifurcation.png")


def _columns(result: BifurcationResult) -> list[dict[str, Any]]:
    return [
        {
            "value": column.value,
            "branch": column.branch,
            "period": column.period,
            "settled": "yes" if column.settled else "no",
            "residual": column.residual,
            "transient": column.transient,
            "ending": column.failure,
        }
        for column in result.columns
    ]


def bifurcation_data(result: BifurcationResult) -> dict[str, Any]:
    """The diagram as plain data; strobes themselves are in the table."""
    return {
        "model": result.model,
        "parameter": result.parameter,
        "unit": result.unit,
        "strobe": result.strobe,
        "standing_still_within_scales": result.still,
        "branches": list(result.branches),
        "failed_columns": len(result.failed),
        "missing_columns": result.missing,
        "unsettled_columns": sum(not column.settled for column in result.columns),
        "coexisting_at": result.coexisting().tolist(),
        "columns": _columns(result),
    }
