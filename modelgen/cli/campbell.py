"""``modelgen campbell``: natural frequencies over the speed, the orders that excite, and critical speeds with their margins.

Part of ``cli``; asks ``analysis.linear.campbell`` and puts its answer into tables, a figure and files.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from modelgen.cli.question import asks_a_model, fills_a_folder, speed_range, speed_steps

if TYPE_CHECKING:
    from modelgen.analysis import CampbellResult, OrderLine

EXAMPLES = """
\b
Examples:
  modelgen campbell fracturing-truck --out out/campbell
  modelgen campbell fracturing-truck --out out/campbell --replace --speeds "600 rpm" "2400 rpm" --highest-order 12
  modelgen campbell my_driveline.toml --out out/range --operating "1200 rpm" "1800 rpm"

\b
Ends with 0 when done, 2 if it was refused, 130 after Ctrl-C. Only what is done leaves a folder.
"""
SPEEDS = "Speeds of the diagram.  [default: a quarter to one and a half of the operating speed]"
OPERATING = "Range that margins count from.  [default: the operating speed]"


@click.command(epilog=EXAMPLES)
@asks_a_model
@fills_a_folder
@click.option("--speeds", nargs=2, metavar="FIRST LAST", help=SPEEDS)
@click.option("--count", type=click.IntRange(min=2), default=41, show_default=True, help="How many speeds, with --speeds.")
@click.option("--operating", nargs=2, metavar="LOW HIGH", help=OPERATING)
@click.option("--highest-order", type=click.FloatRange(min=0, min_open=True), help="Leave out orders above, per reference turn.")
def campbell(
    model: str,
    assignments: tuple[str, ...],
    speed: str | None,
    out: Path,
    replace: bool,
    speeds: tuple[str, str] | None,
    count: int,
    operating: tuple[str, str] | None,
    highest_order: float | None,
) -> None:
    """Campbell diagram of MODEL with the orders of engine, pump and meshes, and its critical speeds.

    The folder gets campbell.csv (natural frequencies by speed), critical_speeds.csv (every crossing with its margin),
    campbell.json and a figure.
    """
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    with output_folder(out, replace) as folder, Progress() as progress:
        wanted, target = speed_steps(speeds, count), speed_range(operating, "--operating")
        progress.stage(f"read {model}")
        from modelgen.analysis import campbell as diagram_of
        from modelgen.cli.question import opened

        _, compiled = opened(model, assignments, speed, turning=True)
        progress.stage("find natural frequencies and crossings")
        result = diagram_of(compiled, wanted, operating=target, highest_order=highest_order)
        progress.stage("write tables and figure")
        _write(result, folder)
    click.echo(str(result))
    click.echo(f"tables, figure and campbell.json: {out}")


def _write(result: CampbellResult, folder: Path) -> None:
    from modelgen.analysis.linear.mode_numbers import mode_name
    from modelgen.plots import plot, save
    from modelgen.reports.tables import RPM, write_data, write_table

    modes = [mode_name(mode, result.rigid) for mode in range(result.frequencies.shape[1])]
    rows = [[speed * RPM, *row] for speed, row in zip(result.speeds.tolist(), result.frequencies.tolist(), strict=True)]
    write_table(folder / "campbell.csv", ["speed [rpm]", *(f"{mode} [Hz]" for mode in modes)], rows)
    header = ["critical speed [rpm]", "margin [percent]", "mode", "frequency [Hz]"]
    header += ["order [1/turn]", "exact order", "sources", "harmonic torque [N*m]", "vector sum [N*m]"]
    write_table(folder / "critical_speeds.csv", header, [list(each.values()) for each in _critical(result)])
    write_data(folder / "campbell.json", campbell_data(result))
    save(plot(result), folder / "campbell.png")


def _critical(result: CampbellResult) -> list[dict[str, Any]]:
    """Critical speeds, in the order of the columns of their table."""
    from modelgen.reports.tables import RPM

    return [
        {
            "speed_rpm": each.speed * RPM,
            "margin_percent": 100 * each.margin,
            "mode": each.number,
            "frequency_hz": each.frequency,
            **_order(each.line),
        }
        for each in result.critical
    ]


def _order(line: OrderLine) -> dict[str, Any]:
    return {
        "order_per_turn": float(line.order),
        "exact_order": str(line.order),
        "sources": line.label,
        "torque_n_m": line.torque,
        "vector_sum_n_m": line.vector_sum,
    }


def campbell_data(result: CampbellResult) -> dict[str, Any]:
    """The diagram as plain data; vibrating modes count from 1, critical speeds by margin, the nearest first."""
    from modelgen.reports.tables import RPM

    return {
        "model": result.model,
        "operating_rpm": [each * RPM for each in result.operating],
        "speeds_rpm": (result.speeds * RPM).tolist(),
        "rigid_modes": result.rigid,
        "natural_frequencies_hz": result.frequencies.tolist(),
        "orders": [_order(line) for line in result.lines],
        "critical_speeds": _critical(result),
        "remarks": list(result.remarks),
    }
