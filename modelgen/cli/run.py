"""``modelgen run``: from a model to a folder with its equations, response, figures and report.

Part of ``cli``; the command line's main sentence.
"""

from __future__ import annotations

import dataclasses
import math
import shlex
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from modelgen.reports.response import Request, Response

EXAMPLES = """
\b
Examples:
  modelgen run fracturing-truck --out out/truck
  modelgen run fracturing-truck --out out/truck --replace --set zeta=0.02 --mesh-reading scaled
  modelgen run fracturing-truck --out out/slow --speed "1500 rpm" --damping modal
  modelgen run my_driveline.toml --out out/mine --start zero --window "0 s" "0.5 s"
  modelgen run my_driveline.toml --out out/stiff --set coupling.stiffness="400 kN*m/rad"

\b
Ends with 0 when done, 1 if the run failed, 2 if it was refused, 130 after Ctrl-C. Only a run that is done leaves a folder.
"""
SET = 'A parameter (zeta=0.02), or a value or switch of an element or kind (coupling.stiffness="4e5 N*m/rad"). Repeatable.'
WINDOW = 'When the response is measured, such as "0 s" "0.5 s".  [default: 8 periods of the slowest base frequency, once settled]'
START = "At rest under the mean torques, or with nothing twisted."
SOLVER = "One of those that modelgen solvers lists."
EVENTS = 'Locate changes of mode (contact, sticking) and restart there; "auto" where a law jumps or has memory.'
TOLERANCE = "Largest error of a step, relative to the scale of each state."


@click.command(epilog=EXAMPLES)
@click.argument("model")
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder for the results.")
@click.option("--replace", is_flag=True, help="Replace the folder if it holds the results of another run.")
@click.option("--set", "assignments", multiple=True, metavar="NAME=VALUE", help=SET)
@click.option("--speed", metavar="SPEED", help='Operating speed, such as "1900 rpm".')
@click.option("--damping", metavar="FORM", help="Damping of every shaft: per_shaft, modal, value or loss_factor.")
@click.option("--mesh-damping", metavar="FORM", help="Damping of every gear pair: corrected, literal or value.")
@click.option("--mesh-reading", type=click.Choice(["fixed", "scaled"]), help="Mesh damping ratio: of its own, or 0.1 zeta/0.035.")
@click.option("--start", type=click.Choice(["static", "zero"]), default="static", show_default=True, help=START)
@click.option("--solver", default="rk4", show_default=True, help=SOLVER)
@click.option("--events", type=click.Choice(["auto", "on", "off"]), default="auto", show_default=True, help=EVENTS)
@click.option("--tolerance", type=float, default=1e-6, show_default=True, help=TOLERANCE)
@click.option("--window", nargs=2, metavar="FIRST LAST", help=WINDOW)
@click.option("--crosscheck", default="rk4,cvodes,idas,erk,rosenbrock", show_default=True, metavar="SOLVERS", help='Or "none".')
@click.option("--max-seconds", type=float, default=600.0, show_default=True, help="Most computing time of one simulation.")
@click.pass_context
def run(ctx: click.Context, model: str, out: Path, replace: bool, **options: Any) -> None:
    """Simulate MODEL and write its report into a folder.

    The folder gets report.md, equations.md and .tex, model.toml (the model as run), responses.csv, summary.json and figures/.
    """
    begun = time.perf_counter()
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    with output_folder(out, replace) as folder, Progress() as progress:
        progress.stage(f"read {model}")
        from modelgen.drivelines import load
        from modelgen.reports.response import respond
        from modelgen.reports.results import write_results
        from modelgen.reports.settings import settle

        switches = {name: options.pop(name) for name in ("assignments", "speed", "damping", "mesh_damping", "mesh_reading")}
        request, given = _request(options), load(model)
        response = respond(settle(given, **switches), dataclasses.replace(request, rated=given.speed), progress)
        write_results(response, folder, _as_given(ctx), begun, progress)
    _say(response, out, time.perf_counter() - begun)


def _request(options: dict[str, Any]) -> Request:
    """What is asked of the run, checked before anything is computed."""
    from modelgen.errors import CaseError, nearest
    from modelgen.reports.response import Request
    from modelgen.solvers.problem import Budget, SolverOptions
    from modelgen.solvers.registry import every_solver, solver_named
    from modelgen.units import read_quantity

    solver_named(options["solver"])
    SolverOptions(tolerance=options["tolerance"], budget=Budget(max_seconds=options["max_seconds"]))
    named = options.pop("crosscheck")
    others = () if named == "none" else tuple(name.strip() for name in named.split(","))
    known = every_solver()
    for name in others:
        if name not in known:
            raise CaseError("--crosscheck", f"there is no solver {name!r}", nearest(name, [*known, "none"]))
    given = options.pop("window")
    window = None if given is None else tuple(read_quantity(text, "s", "--window") for text in given)
    return Request(crosscheck=others, window=window, **options)  # type: ignore[arg-type]  # two times, as click counts them


def _as_given(ctx: click.Context) -> str:
    """The command as a reader can repeat it, with every option that was given, apart from where its results went."""
    words = ["modelgen", "run", ctx.params["model"]]
    for option in ctx.command.params:
        name = option.name or ""
        if name in ("model", "out", "replace") or ctx.get_parameter_source(name) is not click.core.ParameterSource.COMMANDLINE:
            continue
        value, flag = ctx.params[name], option.opts[0]
        if option.multiple:
            words += [word for each in value for word in (flag, each)]
        else:
            words += [flag, *(value if isinstance(value, tuple) else (value,))]
    return shlex.join(str(word) for word in [*words, "--out", "DIR"])


def _say(response: Response, out: Path, wall: float) -> None:
    """The end of a run: its three main figures and where the rest stands."""
    from modelgen.reports import limit
    from modelgen.reports.report import digits

    limits, frequencies = limit.judged(response), response.modes.frequencies[response.modes.rigid :]
    found, inertias = limit.verdict(limits), response.angles.inertias
    rows = []
    if inertias:
        worst = max(inertias, key=lambda name: inertias[name].vibration.peak)
        side = f"; {'within' if found.ok else 'above'} {found.limit:g} deg" if found else ""
        angle = digits(math.degrees(inertias[worst].vibration.peak))
        rows.append(("largest vibration angle", f"{angle} deg at {worst} (0-peak, physical{side})"))
    if limits is not None:
        counts = ", ".join(f"{len(limits.with_verdict(each))} {each}" for each in ("pass", "fail", "not judged"))
        rows.append(("limits that it chooses", counts))
    if len(frequencies):
        rows.append(("lowest natural frequency", f"{digits(float(frequencies[0]), 6)} Hz"))
    meshes = response.angles.meshes
    if meshes:
        name = max(meshes, key=lambda pair: meshes[pair].largest)
        rows.append(("largest mesh force", f"{digits(meshes[name].largest / 1e3)} kN at {name}"))
    if (log := response.solution.events) is not None:
        rows.append(("events", str(int(log.counts.sum()))))
        rows += [(f"  {name}", str(count)) for name, count in log.counted().items()]
        rows += [(f"  time in {name}", f"{share:.2%}") for name, share in log.share().items()]
    for label, text in rows:
        click.echo(f"{label:25s} {text}")
    click.echo(f"{'report':25s} {out / 'report.md'} ({wall:.1f} s)")
