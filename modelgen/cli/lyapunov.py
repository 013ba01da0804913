"""``modelgen lyapunov``: Lyapunov exponents of the settled motion, with their intervals.

Part of ``cli``; asks ``analysis.stability.exponents`` and puts the answer into a table, a figure and data.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from modelgen.cli.question import asks_a_model, fills_a_folder

if TYPE_CHECKING:
    from modelgen.analysis import ExponentsResult

EXAMPLES = """
\b
Examples:
  modelgen lyapunov fracturing-truck-commensurate --out out/exponents
  modelgen lyapunov fracturing-truck-commensurate --out out/undamped --set zeta=0 --set xi=0 --transient 200
  modelgen lyapunov my_driveline.toml --out out/largest --largest --revolutions 500

\b
Ends with 0 when done, 2 if it was refused, 130 after Ctrl-C. Only what is done leaves a folder.
"""
REVOLUTIONS = "Periods of the slowest base frequency over which the exponents are means."
TRANSIENT = "Periods before that.  [default: until the slowest mode has decayed to a thousandth, 120 s at most]"
LARGEST = "The largest exponent only."
START = "Static equilibrium, or uniform rotation with nothing twisted."
TOLERANCE = "Largest error of a step, relative to the scale of each state."


@click.command(epilog=EXAMPLES)
@asks_a_model
@fills_a_folder
@click.option("--revolutions", type=click.IntRange(min=1), default=100, show_default=True, help=REVOLUTIONS)
@click.option("--transient", type=click.IntRange(min=0), help=TRANSIENT)
@click.option("--largest", is_flag=True, help=LARGEST)
@click.option("--start", type=click.Choice(["static", "zero"]), default="static", show_default=True, help=START)
@click.option("--tolerance", type=click.FloatRange(1e-13, 1e-2), default=1e-6, show_default=True, help=TOLERANCE)
def lyapunov(
    model: str,
    assignments: tuple[str, ...],
    speed: str | None,
    out: Path,
    replace: bool,
    revolutions: int,
    transient: int | None,
    largest: bool,
    start: str,
    tolerance: float,
) -> None:
    """Lyapunov exponents of MODEL: whether neighboring motions part (chaos) or meet, and how fast.

    The frame of deviations turns into its place during the transient; what it takes from the revolutions is said. A motion that
    is not stationary says so, with what it ends in. The rigid rotation, whose exponents are exactly 0, is listed apart. The
    folder gets exponents.csv, exponents.json and exponents.png.
    """
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    with output_folder(out, replace) as folder, Progress() as progress:
        progress.stage(f"read {model}")
        from modelgen.analysis import lyapunov_exponents, settled_window
        from modelgen.cli.question import opened
        from modelgen.solvers import Case, operating_point

        _, compiled = opened(model, assignments, speed, turning=True)
        window = settled_window(compiled, operating_point(compiled))
        first = window.first if transient is None else transient * window.period
        progress.stage(f"follow the motion for {revolutions} periods of {window.base}", measured=True)
        case = Case(
            *(compiled, first + revolutions * window.period),
            record_from=first,
            start=start,
            tolerance=tolerance,
            options={"progress": progress.fraction},
        )
        result = lyapunov_exponents(case, largest=largest)
        progress.stage("write tables and figure")
        _write(result, folder)
    click.echo(str(result))
    if transient is None and not window.settled:
        click.echo("the slowest mode had not decayed to a thousandth when the means began: a long --transient says more")
    click.echo(f"table, figure and exponents.json: {out}")


def _write(result: ExponentsResult, folder: Path) -> None:
    from modelgen.plots import plot, save
    from modelgen.reports.tables import write_data, write_table

    pairs = list(zip(result.exponents.tolist(), result.half_width.tolist(), strict=True))
    what = ["along the motion" if k == result.flow else "" for k in range(len(pairs))]
    rows = [[k + 1, value, half, what[k]] for k, (value, half) in enumerate(pairs)]
    rows += [["", 0.0, 0.0, f"rigid rotation: {name}"] for name in result.neutral]
    write_table(folder / "exponents.csv", ["number", "exponent [1/s]", "half 95 % interval [1/s]", "remark"], rows)
    write_data(
        folder / "exponents.json",
        {
            "model": result.model,
            "exponents_per_s": [value for value, _ in pairs],
            "half_95_percent_interval_per_s": [half for _, half in pairs],
            "sign_of_the_largest": result.sign,
            "stationary": result.stationary,
            "transient_s": result.transient,
            "transient_exponents_per_s": result.transient_exponents.tolist(),
            "transient_chaos": result.transient_chaos,
            "ends_in": result.ends_in or None,
            "beside": result.beside or None,
            "left_out_s": result.left_out,
            "remarks": list(result.remarks),
            "complete": result.complete,
            "along_the_motion": None if result.flow is None else result.flow + 1,
            "rigid_rotation_exactly_0": list(result.neutral),
            "mean_divergence_per_s": result.divergence,
            "sum_less_mean_divergence_per_s": result.trace_gap,
            "kaplan_yorke_dimension": result.dimension,
            "begin_s": result.begin,
            "duration_s": result.duration,
            "common_period_s": result.period or None,
            "stretch_s": result.stretch,
            "tolerance": result.tolerance,
        },
    )
    save(plot(result), folder / "exponents.png")
