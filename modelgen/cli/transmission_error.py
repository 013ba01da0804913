"""``modelgen transmission-error``: how much a mesh vibrates over mesh frequency, swept up and down, with its jumps.

Part of ``cli``; asks ``analysis.nonlinear.frequency_sweep``.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from modelgen.cli.question import asks_a_model, fills_a_folder

if TYPE_CHECKING:
    from modelgen.analysis import FrequencySweepResult

EXAMPLES = """
\b
Examples:
  modelgen transmission-error two-disk-gear --out out/te --speeds "2500 rpm" "5000 rpm"
  modelgen transmission-error fracturing-truck-commensurate --out out/te --mesh pump_mesh --speeds "1500 rpm" "1900 rpm"

\b
Ends with 0 when done, 1 if a point could not be run, 2 if it was refused, 130 after Ctrl-C. Only what is done leaves a folder.
"""
SPEEDS = "Lowest and highest operating speed, units allowed."
MESH = "Gear pair whose transmission error is asked for.  [default: the only one]"
CHANNEL = "A further channel whose root mean square is kept. Repeatable."
TRANSIENT = "Most common periods that a speed is waited for until the motion stands still."
CLOSE = "How near a jump is closed in on, per mesh frequency; 0 leaves it between two speeds."


@click.command(name="transmission-error", epilog=EXAMPLES)
@asks_a_model
@fills_a_folder
@click.option("--speeds", nargs=2, required=True, metavar="LOWEST HIGHEST", help=SPEEDS)
@click.option("--count", type=click.IntRange(min=3), default=61, show_default=True, help="How many speeds.")
@click.option("--mesh", metavar="NAME", help=MESH)
@click.option("--channel", multiple=True, metavar="CHANNEL", help=CHANNEL)
@click.option("--transient", type=click.IntRange(min=0), default=400, show_default=True, help=TRANSIENT)
@click.option("--close", type=click.FloatRange(0, 0.1, max_open=True), default=1e-4, show_default=True, help=CLOSE)
@click.option("--tolerance", type=float, default=1e-5, show_default=True, help="Of a step, per scale of each state.")
def transmission_error(
    model: str,
    assignments: tuple[str, ...],
    speed: str | None,
    out: Path,
    replace: bool,
    speeds: tuple[str, str],
    count: int,
    mesh: str | None,
    channel: tuple[str, ...],
    transient: int,
    close: float,
    tolerance: float,
) -> None:
    """Dynamic transmission error of MODEL over mesh frequency: its rms about the mean, swept up and down.

    Every speed starts from the last state of its neighbor, so branches of a nonlinear resonance part, and jumps are found. The
    folder gets transmission_error.csv (a row per speed and direction), transmission_error.json (jumps; where flanks begin to
    part) and a figure.
    """
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    with output_folder(out, replace, WRITTEN) as folder, Progress() as progress:
        progress.stage(f"read {model}")
        from modelgen.analysis import frequency_sweep
        from modelgen.cli.bifurcation_case import strobed_case
        from modelgen.cli.question import speed_steps

        case = strobed_case(model, assignments, speed, None, tolerance)
        listed = speed_steps(speeds, count)
        assert listed is not None
        progress.stage(f"sweep {count} speeds up and down", measured=True)
        swept = {"transient": transient, "close": close, "progress": progress.fraction}
        result = frequency_sweep(case, listed, mesh, channel, **swept)  # type: ignore[arg-type]
        progress.stage("write table and figure")
        _write(result, folder)
    click.echo(str(result))
    click.echo(f"table, figure and transmission_error.json: {out}")
    if result.failed:
        from modelgen.cli.ending import FAILED, Ending

        raise Ending(f"{len(result.failed)} points could not be run: {result.failed[0].failure}", FAILED)


WRITTEN = ("transmission_error.csv", "transmission_error.json", "transmission_error.png")


def _write(result: FrequencySweepResult, folder: Path) -> None:
    from modelgen.plots import plot, save
    from modelgen.reports.tables import write_data, write_table

    header = ["direction", "speed [rad/s]", "mesh frequency [Hz]"]
    for name, unit in zip(result.channels, result.units, strict=True):
        header += [f"{name} {kind} [{unit}]" for kind in ("rms about its mean", "least", "largest")]
    header += ["share apart [1]", "share on the back flank [1]", "period [common periods]", "settled", "residual [scales]"]
    header.append("ending")
    rows: list[list[Any]] = []
    for way in ("forward", "backward"):
        for point in getattr(result, way):
            sizes = [size for sizes in zip(point.rms, point.least, point.largest, strict=True) for size in sizes]
            ending = [point.separated, point.back, point.period, "yes" if point.settled else "no", point.residual]
            ending.append(point.failure)
            rows.append([WAYS[way], point.speed, point.frequency, *sizes, *ending])
    write_table(folder / "transmission_error.csv", header, rows)
    write_data(folder / "transmission_error.json", transmission_error_data(result))
    save(plot(result), folder / "transmission_error.png")


WAYS = {"forward": "upward", "backward": "downward"}


def transmission_error_data(result: FrequencySweepResult) -> dict[str, Any]:
    """The jumps and other changes as plain data; the branches themselves are in the table."""
    points = (*result.forward, *result.backward)
    return {
        "model": result.model,
        "mesh": result.mesh,
        "speeds": len(result.forward),
        "failed_points": [{"speed_rad_per_s": each.speed, "message": each.failure} for each in result.failed],
        "unsettled_points": sum(not point.settled for point in points),
        "largest_rms": max((point.rms[0] for point in points if not point.failure), default=None),
        "unit": result.units[0],
        "changes": [
            {
                "direction": WAYS[each.direction],
                "kind": each.kind,
                "mesh_frequency_hz": each.frequency,
                "last_before_hz": each.stays,
                "first_after_hz": each.changes,
                "rms_before": each.before,
                "rms_after": each.after,
            }
            for each in result.changes
        ],
    }
