"""``modelgen orbit``: a periodic motion by shooting, and whether it attracts.

Part of ``cli``; asks ``analysis.stability.orbits`` and puts the answer into tables, a figure and data.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from modelgen.cli.question import asks_a_model, fills_a_folder

if TYPE_CHECKING:
    from modelgen.analysis import PeriodicOrbit

EXAMPLES = """
\b
Examples:
  modelgen orbit fracturing-truck-commensurate --out out/orbit
  modelgen orbit my_driveline.toml --out out/doubled --order 2 --settle 200

\b
Ends with 0 when done (also where no orbit is found, which orbit.json then says), 2 if it was refused, 130 after Ctrl-C. Only what
is done leaves a folder.
"""
ORDER = "Common periods of the excitation after which the motion is to repeat."
SETTLE = "Common periods that the motion may take to settle, before Newton's method takes over."
START = "Static equilibrium, or uniform rotation with nothing twisted."
TOLERANCE = "Of the shooting: largest error of a step, relative to the scale of each state."


@click.command(epilog=EXAMPLES)
@asks_a_model
@fills_a_folder
@click.option("--order", type=click.IntRange(min=1), default=1, show_default=True, help=ORDER)
@click.option("--settle", type=click.IntRange(min=0), default=20, show_default=True, help=SETTLE)
@click.option("--start", type=click.Choice(["static", "zero"]), default="static", show_default=True, help=START)
@click.option("--tolerance", type=click.FloatRange(1e-13, 1e-6), default=1e-12, show_default=True, help=TOLERANCE)
def orbit(
    model: str,
    assignments: tuple[str, ...],
    speed: str | None,
    out: Path,
    replace: bool,
    order: int,
    settle: int,
    start: str,
    tolerance: float,
) -> None:
    """The periodic motion of MODEL under its excitation, with its Floquet multipliers.

    "Period n proven" means: it misses its start by less than 1e-10 of each state's scale, and every multiplier lies inside the
    unit circle; the rigid rotation, whose multipliers are exactly 1, is listed apart. The folder gets multipliers.csv,
    orbit_start.csv (the state that it starts from), orbit.json and multipliers.png.
    """
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    with output_folder(out, replace) as folder, Progress() as progress:
        progress.stage(f"read {model}")
        from modelgen.analysis import periodic_orbit
        from modelgen.cli.question import opened
        from modelgen.solvers import Case

        _, compiled = opened(model, assignments, speed, turning=True)
        case = Case(compiled, end=1.0, start=start)
        result = periodic_orbit(case, order=order, settle=settle, tolerance=tolerance, report=progress.stage)
        progress.stage("write tables and figure")
        _write(result, {state.name: state.unit for state in compiled.equations.states}, folder)
    click.echo(str(result))
    click.echo(f"tables, figure and orbit.json: {out}")


def _write(result: PeriodicOrbit, units: dict[str, str], folder: Path) -> None:
    from modelgen.analysis.stability.multipliers import kind_of_loss
    from modelgen.plots import plot, save
    from modelgen.reports.tables import write_data, write_table

    numbers = [complex(each) for each in result.multipliers]
    outside = [kind_of_loss(each) if abs(each) > 1 else "" for each in numbers]
    rows = [[k + 1, each.real, each.imag, abs(each), outside[k]] for k, each in enumerate(numbers)]
    rows += [["", 1.0, 0.0, 1.0, f"rigid rotation: {name}"] for name in result.neutral]
    write_table(folder / "multipliers.csv", ["number", "real part [1]", "imaginary part [1]", "size [1]", "remark"], rows)
    start = result.start
    write_table(folder / "orbit_start.csv", ["state", "value [unit]", "unit"], [[k, start[k], units.get(k, "1")] for k in start])
    write_data(
        folder / "orbit.json",
        {
            "model": result.model,
            "verdict": result.verdict,
            "found": result.found,
            "proven": result.proven,
            "stability": result.stability,
            "lost_by": list(result.losses),
            "order": result.order,
            "period_s": result.period,
            "common_period_s": result.base_period,
            "residual_in_scales": result.residual,
            "multipliers": [{"real": each.real, "imaginary": each.imag, "size": abs(each)} for each in numbers],
            "rigid_rotation_exactly_1": list(result.neutral),
            "begin_s": result.begin,
            "start": dict(start),
            "newton_rounds": result.rounds,
            "tolerance": result.tolerance,
        },
    )
    save(plot(result), folder / "multipliers.png")
