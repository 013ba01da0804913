"""``modelgen crosscheck``: the same run by several solvers at several tolerances, channel by channel.

Part of ``cli``; asks ``solvers.crosscheck`` and puts its answer into a table, a figure and files.
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from modelgen.solvers.crosscheck import CrosscheckResult

EXAMPLES = """
\b
Examples:
  modelgen crosscheck fracturing-truck --out out/crosscheck
  modelgen crosscheck fracturing-truck --solvers rk4,erk --tolerances 1e-5,1e-7 --end "0.2 s" --out out/two
  modelgen crosscheck my_driveline.toml --start zero --end "0.5 s" --out out/impacts
"""
SAMPLES = 20_001


@click.command(epilog=EXAMPLES)
@click.argument("model")
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder for the results.")
@click.option("--replace", is_flag=True, help="Replace the folder if it holds results of modelgen.")
@click.option("--solvers", default="rk4,cvodes,idas,erk,rosenbrock", show_default=True, help="Which, the reference's first.")
@click.option("--tolerances", help="Of every solver, such as 1e-6,1e-8.  [default: two for each, fit for comparing at 1e-6]")
@click.option("--end", default="1 s", show_default=True, help="Length of the comparison.")
@click.option("--start", type=click.Choice(["static", "zero"]), default="static", show_default=True, help="Rest, or untwisted.")
@click.option("--max-seconds", type=float, default=600.0, show_default=True, help="Most computing time of one run.")
def crosscheck(
    model: str, out: Path, replace: bool, solvers: str, tolerances: str | None, end: str, start: str, max_seconds: float
) -> None:
    """Compare solvers on MODEL: differences per channel, relative to half the peak-to-peak of its fluctuating part.

    The folder gets crosscheck.csv (every run and channel), crosscheck.json and a figure.
    """
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    with output_folder(out, replace) as folder, Progress() as progress:
        progress.stage(f"read {model}")
        from modelgen.drivelines import load
        from modelgen.solvers import Budget, Case
        from modelgen.solvers.crosscheck import crosscheck as compare
        from modelgen.units import read_quantity

        names, plan = _plan(solvers, tolerances)
        progress.stage("assemble and compile")
        length = read_quantity(end, "s", "--end")
        options = {"budget": Budget(max_seconds=max_seconds), "progress": progress.fraction}
        case = Case(load(model), end=length, samples=SAMPLES, start=start, solver=names[0], options=options)  # type: ignore[arg-type]  # a driveline is compiled by the case
        progress.stage(f"compare {', '.join(names)} over {length:g} s", measured=True)
        result = compare(case, names, plan)
        _write(result, folder)
    click.echo(str(result))


def _plan(solvers: str, tolerances: str | None) -> tuple[tuple[str, ...], Mapping[str, tuple[float, ...]]]:
    """Solvers and the tolerances of each. Raises CaseError for what is not there."""
    from modelgen.errors import CaseError
    from modelgen.solvers.registry import solver_named

    names = tuple(name.strip() for name in solvers.split(",") if name.strip())
    own = {name: solver_named(name).crosscheck_tolerance for name in names}
    if not names:
        raise CaseError("--solvers", "names none", "give some, such as rk4,cvodes")
    if tolerances is None:
        return names, {name: (100 * tolerance, tolerance) for name, tolerance in own.items()}
    try:
        given = tuple(float(text) for text in tolerances.split(","))
    except ValueError:
        raise CaseError("--tolerances", f"is {tolerances!r}", "give numbers such as 1e-6,1e-8") from None
    return names, dict.fromkeys(names, given)


def _write(result: CrosscheckResult, folder: Path) -> None:
    from modelgen.plots import plot, save

    with (folder / "crosscheck.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["solver", "tolerance", "channel", "relative difference"])
        for run in result.runs:
            writer.writerows([run.solver, run.tolerance, name, value] for name, value in run.differences.items())
    text = json.dumps(crosscheck_data(result), indent=2, allow_nan=False) + "\n"
    (folder / "crosscheck.json").write_text(text, encoding="utf-8")
    save(plot(result), folder / "crosscheck.png")


def crosscheck_data(result: CrosscheckResult) -> dict[str, Any]:
    """The comparison as plain data; a difference is null where a run did not reach its end."""
    return {
        "model": result.model,
        "horizon_s": result.horizon,
        "reference": {"solver": result.reference[0], "tolerance": result.reference[1]},
        "worst_relative_difference": _finite(result.worst_relative_difference),
        "growth_rate_per_s": result.growth_rate,
        "meaningful_until_s": _finite(result.meaningful_until),
        "sentence": result.sentence(),
        "runs": [
            {
                "solver": run.solver,
                "tolerance": run.tolerance,
                "outcome": run.outcome.name,
                "message": run.message,
                "worst_relative_difference": _finite(run.worst),
                "worst_channel": run.worst_channel,
                "steps": run.statistics.steps,
                "rejected": run.statistics.rejected,
                "evaluations": run.statistics.evaluations,
                "seconds": run.statistics.seconds,
            }
            for run in result.runs
        ],
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
