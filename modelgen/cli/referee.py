"""``modelgen referee``: the same run by modelgen and by an independent multibody engine, laid over each other.

Part of ``cli``; asks ``analysis.referee`` and puts its answer into a table, a figure and files.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from modelgen.cli.question import asks_a_model, fills_a_folder

if TYPE_CHECKING:
    from modelgen.analysis.referee.comparison import RefereeResult

EXAMPLES = """
\b
Examples:
  modelgen referee fracturing-truck --out out/referee
  modelgen referee fracturing-truck --mean-stiffness --step "0.4 us" --out out/referee-mean
  modelgen referee my_driveline.toml --end "1 s" --out out/mine

\b
Needs the extra "referee" (the package mujoco). Ends with 0 when done, 2 if it was refused, 130 after Ctrl-C.
"""
CHANNELS_OF_FIGURE = "A channel to be drawn, up to four times.  [default: mesh forces, largest twist and angle]"


@click.command(epilog=EXAMPLES)
@asks_a_model
@fills_a_folder
@click.option("--end", default="0.1 s", show_default=True, help="Length of the run.")
@click.option("--step", default="5 us", show_default=True, help="Fixed step of the referee.")
@click.option("--start", type=click.Choice(["static", "zero"]), default="static", show_default=True, help="Rest, or untwisted.")
@click.option("--mean-stiffness", is_flag=True, help="Every mesh at its mean stiffness, on both sides.")
@click.option("--samples", type=click.IntRange(2, 1_000_001), default=2001, show_default=True, help="Instants compared.")
@click.option("--channel", "channels", multiple=True, metavar="CHANNEL", help=CHANNELS_OF_FIGURE)
def referee(
    model: str, assignments: tuple[str, ...], speed: str | None, out: Path, replace: bool, end: str, step: str, **options: Any
) -> None:
    """Let MuJoCo run MODEL from its own primitives, and compare every angle, twist, deflection and force.

    The folder gets referee.csv (both sides of every channel, sampled), referee.json (differences, and what differs in
    modelling) and an overlay figure.
    """
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    with output_folder(out, replace) as folder, Progress() as progress:
        progress.stage(f"read {model}")
        from modelgen.analysis.referee.comparison import referee as ask
        from modelgen.drivelines import load
        from modelgen.reports.settings import settle
        from modelgen.units import read_quantity

        channels = options.pop("channels")
        line = settle(load(model), assignments, speed)
        times = read_quantity(end, "s", "--end"), read_quantity(step, "s", "--step")
        progress.stage("run both engines", measured=True)
        result = ask(line, times[0], step=times[1], progress=progress.fraction, **options)
        _write(result, channels, folder)
    click.echo(str(result))
    click.echo(f"table, figure and referee.json: {out}")


def _write(result: RefereeResult, channels: tuple[str, ...], folder: Path) -> None:
    from modelgen.plots import plot, save
    from modelgen.reports.tables import write_data, write_table

    save(plot(result, channels=channels or None), folder / "referee.png")
    header = ["time [s]"]
    for name in result.ours:
        header += [f"{name}, modelgen [{result.units[name]}]", f"{name}, referee [{result.units[name]}]"]
    columns = [result.times, *(side[name] for name in result.ours for side in (result.ours, result.theirs))]
    write_table(folder / "referee.csv", header, [list(row) for row in zip(*(each.tolist() for each in columns), strict=True)])
    write_data(folder / "referee.json", referee_data(result))


def referee_data(result: RefereeResult) -> dict[str, Any]:
    """The comparison as plain data; differences are relative to half the peak-to-peak of each channel's fluctuating part."""
    return {
        "model": result.model,
        "engine": result.engine,
        "horizon_s": float(result.times[-1]),
        "referee_step_s": result.step,
        "referee_seconds": result.seconds,
        "worst_relative_difference": result.worst[1],
        "worst_channel": result.worst[0],
        "worst_peak_to_peak_difference": result.worst_peak[1],
        "differences": dict(result.difference),
        "peak_to_peak_differences": dict(result.peak_difference),
        "differences_in_modelling": list(result.notes),
    }
