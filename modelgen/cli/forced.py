"""``modelgen forced``: steady vibration under the harmonic torques, by order and over the cycle, at one or many speeds.

Part of ``cli``; asks ``forced`` and ``gear_hammer`` of ``analysis.linear``, ``forced_tables`` puts their answers into files.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from modelgen.cli.question import asks_a_model, fills_a_folder, speed_steps
from modelgen.reports.assignments import pair
from modelgen.reports.diameters import DIAMETER

if TYPE_CHECKING:
    from modelgen.lowering import Compiled
    from modelgen.model import Driveline

EXAMPLES = """
\b
Examples:
  modelgen forced fracturing-truck --out out/forced
  modelgen forced fracturing-truck --out out/range --speeds "1200 rpm" "2000 rpm" --count 81
  modelgen forced fracturing-truck --out out/misfire --misfire firing_3=0
  modelgen forced my_driveline.toml --out out/stress --diameter coupling="80 mm" --limit coupling.shear_stress="40 MPa"

\b
Ends with 0 when done, 2 if it was refused, 130 after Ctrl-C. Only what is done leaves a folder.
"""
LIMITED = 'CHANNEL=VALUE, such as coupling.torque="12 kN*m"'
SHOW = "A channel that the figure shows, such as coupling.torque. Repeatable.  [default: those that swing most]"
LIMIT = 'A limit to draw, such as flywheel.angle_deviation="0.5 deg". Repeatable.'
MISFIRE = "A source and the factor on its torque: firing_3=0 fires not at all, firing_3=0.5 half. Repeatable."


REFINE = "Add speeds at resonances between those of --speeds.  [default: with 10 speeds or more]"


@click.command(epilog=EXAMPLES)
@asks_a_model
@fills_a_folder
@click.option("--speeds", nargs=2, metavar="FIRST LAST", help="Range of speeds.  [default: the operating speed only]")
@click.option("--count", type=click.IntRange(min=2), default=41, show_default=True, help="How many speeds, with --speeds.")
@click.option("--misfire", multiple=True, metavar="ELEMENT=FACTOR", help=MISFIRE)
@click.option("--diameter", multiple=True, metavar="SHAFT=DIAMETER", help=DIAMETER)
@click.option("--show", multiple=True, metavar="CHANNEL", help=SHOW)
@click.option("--limit", multiple=True, metavar="CHANNEL=VALUE", help=LIMIT)
@click.option("--highest-order", type=click.FloatRange(min=0, min_open=True), help="Leave out orders above, per reference turn.")
@click.option("--refine/--no-refine", default=None, help=REFINE)
def forced(
    model: str,
    assignments: tuple[str, ...],
    speed: str | None,
    out: Path,
    replace: bool,
    speeds: tuple[str, str] | None,
    count: int,
    misfire: tuple[str, ...],
    diameter: tuple[str, ...],
    show: tuple[str, ...],
    limit: tuple[str, ...],
    highest_order: float | None,
    refine: bool | None,
) -> None:
    """Forced response of MODEL, linear about its operating point: every order with its phase, and their sum over the cycle.

    The folder gets forced.csv (mean, 0-peak and half peak to peak of every channel by speed), orders.csv (amplitude and phase by
    order; below 1e-4 of a channel's largest left out), power.csv (power lost in each damper), gears.csv (gear load and hammer),
    forced.json and figures.
    """
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    with output_folder(out, replace) as folder, Progress() as progress:
        wanted, bounds = speed_steps(speeds, count), dict(pair(text, "--limit", LIMITED) for text in limit)
        progress.stage(f"read {model}")
        from modelgen.analysis import forced as response_of
        from modelgen.cli.forced_tables import write_forced
        from modelgen.cli.question import opened
        from modelgen.reports.diameters import diameters

        line, compiled = opened(model, assignments, speed, turning=True)
        factors = misfires(line, compiled, misfire)
        progress.stage("find the response of every order")
        result = response_of(
            compiled,
            wanted,
            factors,
            diameters=diameters(line, compiled, diameter),
            highest_order=highest_order,
            refine=refine,
        )
        progress.stage("write tables and figure")
        text = write_forced(result, factors, folder, show, bounds)
    click.echo(text)
    click.echo(f"tables, figures and forced.json: {out}")


def misfires(line: Driveline, model: Compiled, given: Iterable[str]) -> dict[str, float]:
    """Values of the parameters ``ELEMENT.scale``. Raises CaseError for what is no assignment, NamingError for no source."""
    from modelgen.errors import CaseError, NamingError, nearest

    sources = [name.removesuffix(".scale") for name in model.parameters.parameters if name.endswith(".scale")]
    found = {}
    for text in given:
        name, factor = pair(text, "--misfire", "ELEMENT=FACTOR, such as firing_3=0")
        if name not in sources:
            problem = f"driveline {line.name!r} has no source {name!r} with a factor of its own"
            raise NamingError(f"--misfire {name}", problem, nearest(name, sources))
        try:
            found[f"{name}.scale"] = float(factor)
        except ValueError:
            raise CaseError(f"--misfire {name}", f"{factor!r} is not a number", "write a factor such as 0 or 0.5") from None
        if not math.isfinite(found[f"{name}.scale"]):
            raise CaseError(f"--misfire {name}", f"is {factor}", "give a finite factor")
    return found
