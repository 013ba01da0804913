"""``modelgen compare``: a measured recording laid over the computed response, with peaks and orders beside each other.

Part of ``cli``; asks ``analysis.measurements.compare``.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from modelgen.cli.question import asks_a_model, fills_a_folder
from modelgen.reports.assignments import pair

if TYPE_CHECKING:
    from modelgen.analysis.measurements.compare import ComparisonResult
    from modelgen.analysis.measurements.measurement import Measurement
    from modelgen.solvers import Solution

EXAMPLES = """
\b
Examples:
  modelgen compare my_driveline.toml recording.csv --out out/compare
  modelgen compare my_driveline.toml recording.csv --out out/compare --replace --channel coupling.torque=MD1 --align
  modelgen compare my_driveline.toml recording.csv --out out/late --start "0.25 s" --base engine_half_order

\b
The recording has the time or the crank angle in its first column, and units in its header:
  t [ms]; flywheel.angle_deviation [deg]; coupling.torque [kN*m]

\b
Ends with 0 when done, 1 if the run failed, 2 if it was refused, 130 after Ctrl-C. Only what is done leaves a folder.
"""
CHANNEL = "A channel and the column that measured it. Repeatable.  [default: columns named like channels]"
BASE = "Base frequency of the orders.  [default: the slowest one]"
SHAFT = "Whose angle a recording over crank angle counts.  [default: the reference shaft]"
START = 'Time of the run at which the clock of the recording stands at zero, such as "0.25 s".'
WINDOW = 'When the response is computed, such as "0 s" "0.5 s".  [default: 8 periods of the slowest base frequency, once settled]'


@click.command(epilog=EXAMPLES)
@asks_a_model
@click.argument("measurement", type=click.Path(path_type=Path))
@fills_a_folder
@click.option("--channel", "channels", multiple=True, metavar="CHANNEL=COLUMN", help=CHANNEL)
@click.option("--base", metavar="NAME", help=BASE)
@click.option("--start", metavar="TIME", help=START)
@click.option("--align", is_flag=True, help="Look for the shift that lays one best over the other.")
@click.option("--shaft", metavar="INERTIA", help=SHAFT)
@click.option("--window", nargs=2, metavar="FIRST LAST", help=WINDOW)
def compare(
    model: str, measurement: Path, assignments: tuple[str, ...], speed: str | None, out: Path, replace: bool, **options: Any
) -> None:
    """Run MODEL and lay the recording MEASUREMENT over it.

    The folder gets comparison.csv (peaks and orders, measured and simulated), comparison.json and a figure.
    """
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    with output_folder(out, replace) as folder, Progress() as progress:
        from modelgen.units import read_quantity

        form = "CHANNEL=COLUMN, such as coupling.torque=MD1"
        pairs = dict(pair(text, "--channel", form) for text in options.pop("channels"))
        window, start = options.pop("window"), options.pop("start")
        times = None if window is None else tuple(read_quantity(text, "s", "--window") for text in window)
        zero = None if start is None else read_quantity(start, "s", "--start")
        progress.stage(f"read {measurement}")
        from modelgen.analysis.measurements.compare import compare as laid_over
        from modelgen.analysis.measurements.measurement import read_measurement
        from modelgen.drivelines import load
        from modelgen.reports.response import Request, respond
        from modelgen.reports.settings import settle

        data = read_measurement(measurement)
        line = settle(load(model), assignments, speed)
        response = respond(line, Request(window=times), progress)  # type: ignore[arg-type]  # two times, as click counts them
        progress.stage("compare")
        _check_columns(pairs, data, response.solution)
        result = laid_over(response.solution, data, pairs or None, start=zero, **options)
        _write(result, folder)
    click.echo(str(result))
    click.echo(f"table, figure and comparison.json: {out}")


def _check_columns(pairs: dict[str, str], data: Measurement, solution: Solution) -> None:
    """Raises CaseError for a column that is named like no channel and is not paired with one."""
    from modelgen.errors import CaseError, nearest

    for column in data.channels:
        if not pairs and column not in solution.channels:
            remedy = f"{nearest(column, solution.channels)}; pair them with --channel CHANNEL={column}"
            raise CaseError(f"{data.source}, column {column!r}", "is no channel of the run", remedy)


def _write(result: ComparisonResult, folder: Path) -> None:
    from modelgen.plots import plot, save
    from modelgen.reports.tables import write_data, write_table

    rows: list[list[Any]] = []
    for each in result.channels:
        both = zip(asdict(each.measured_extent).items(), asdict(each.simulated_extent).values(), strict=True)
        rows += [[each.channel, each.column, name, None, each.unit, own, other, None] for (name, own), other in both]
        for order in each.orders:
            turn = None if order.phase_difference is None else math.degrees(order.phase_difference)
            rows.append(
                [each.channel, each.column, order.name, order.frequency, each.unit, order.measured, order.simulated, turn]
            )
    header = ["channel", "column", "what", "frequency [Hz]", "unit", "measured [unit]", "simulated [unit]"]
    write_table(folder / "comparison.csv", [*header, "phase difference [deg]"], rows)
    write_data(folder / "comparison.json", comparison_data(result))
    save(plot(result), folder / "comparison.png")


def comparison_data(result: ComparisonResult) -> dict[str, Any]:
    """The comparison as plain data; amplitudes in the unit that their channel names, differences are simulated less measured."""
    return {
        "model": result.model,
        "measurement": result.source,
        "base": result.base,
        "base_frequency_hz": result.frequency,
        "window_s": result.window,
        "shift_s": result.shift,
        "aligned": result.aligned,
        "channels": {
            f"{each.channel} [{each.unit}]": {
                "column": each.column,
                "treatment": each.treatment,
                "measured": asdict(each.measured_extent),
                "simulated": asdict(each.simulated_extent),
                "peak_difference": each.peak_difference,
                "half_pp_difference": each.half_pp_difference,
                "rms_difference": each.rms_difference,
                "correlation_coefficient": each.correlation,
                "orders": [
                    {
                        "order": order.order,
                        "order_per_turn": order.per_turn,
                        "name": order.name,
                        "frequency_hz": order.frequency,
                        "measured": order.measured,
                        "simulated": order.simulated,
                        "difference": order.difference,
                        "phase_difference_rad": order.phase_difference,
                    }
                    for order in each.orders
                ],
            }
            for each in result.channels
        },
        "remarks": result.remarks,
    }
