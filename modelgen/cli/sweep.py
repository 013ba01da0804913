"""``modelgen sweep``: one model at many points, on every core or a cluster; what is finished is kept, whatever is killed.

Part of ``cli``; asks ``analysis.sweeps``. Unlike the folders of other commands, that of a sweep fills on the way, and the same
command goes on in it.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from modelgen.cli.question import asks_a_model
from modelgen.reports.assignments import pair

if TYPE_CHECKING:
    from modelgen.lowering import Compiled
    from modelgen.solvers import Case

EXAMPLES = """
\b
Examples:
  modelgen sweep fracturing-truck --over zeta=0:0.05:201 --out out/zeta
  modelgen sweep fracturing-truck --over speed="1500 rpm:2100 rpm:61" --over coupling.stiffness="300:500:21 kN*m/rad" \\
      --collect coupling.torque.amplitude --out out/map
  modelgen sweep my_driveline.toml --over zeta=0.01,0.02,0.05 --window "2 s" "3 s" --out out/three
  modelgen sweep my_driveline.toml --over zeta=0.01:0.05 --over speed="900:1500 rpm" --sampling sobol --count 256 --out out/random
  modelgen sweep my_driveline.toml --over zeta=0:0.05:2001 --dask tcp://10.0.0.1:8786 --out out/many

\b
The folder gets sweep-plan.json, shards/ (points as they are finished), and at the end table.csv and sweep.png. Stop it at any
time: the same command goes on. Ends with 0 when every point has its outcome, 2 if it was refused, 130 after Ctrl-C.
"""
OVER = "START:STOP:COUNT, values with commas, or LOW:HIGH of random points. Repeatable: all combinations."
COLLECT = (
    "A channel with .highest, .lowest, .mean, .rms, .amplitude or .final; a mode with .share; steps, rejected, events. "
    "[default: highest and amplitude of every shaft's torque and gear pair's force]"
)
SAMPLING = "Points: all combinations, values side by side, or --count random or Sobol' points."
WINDOW = "What is recorded.  [default: 8 periods of the slowest base frequency, once settled at the model's own values]"
DASK = "Address of a Dask scheduler, whose workers compute."
WORKERS = "Processes on this machine; 0 computes in this one.  [default: one per core]"
BACKEND = "Generated C where there is a compiler (auto), C or nothing, or CasADi's virtual machine."
NETCDF = "Also write sweep.nc (needs the extra xarray)."
SAMPLINGS = ("grid", "list", "random", "sobol")
MOST = 10_000_000  # points of one range
UNITED = re.compile(r"(.*?[\d.])\s+(\S.*)")


@click.command(epilog=EXAMPLES)
@asks_a_model
@click.option("--over", "ranges", multiple=True, required=True, metavar="NAME=VALUES", help=OVER)
@click.option("--collect", multiple=True, metavar="NAME", help=COLLECT)
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder that keeps the results.")
@click.option("--fresh", is_flag=True, help="Start over: delete what a sweep left in the folder.")
@click.option("--sampling", type=click.Choice(SAMPLINGS), default="grid", show_default=True, help=SAMPLING)
@click.option("--count", type=click.IntRange(min=1), help="How many random or Sobol' points.")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of random and Sobol' points.")
@click.option("--window", nargs=2, metavar="FIRST LAST", help=WINDOW)
@click.option("--samples", type=click.IntRange(min=2), default=2001, show_default=True, help="Output times in the window.")
@click.option("--start", type=click.Choice(["static", "zero"]), default="static", show_default=True, help="Where runs start.")
@click.option("--solver", default="rk4", show_default=True, help="As of modelgen run.")
@click.option("--tolerance", type=float, default=1e-6, show_default=True, help="Largest error of a step, per scale of a state.")
@click.option("--backend", type=click.Choice(["auto", "c", "vm"]), default="auto", show_default=True, help=BACKEND)
@click.option("--max-seconds", type=float, default=600.0, show_default=True, help="Most computing time of one point.")
@click.option("--workers", type=click.IntRange(min=0), help=WORKERS)
@click.option("--dask", metavar="ADDRESS", help=DASK)
@click.option("--netcdf", is_flag=True, help=NETCDF)
def sweep(
    model: str, assignments: tuple[str, ...], speed: str | None, ranges: tuple[str, ...], out: Path, **options: Any
) -> None:
    """Run MODEL at many points and keep what is collected in a folder that survives anything."""
    from modelgen.cli.ending import INTERRUPTED, Ending
    from modelgen.cli.progress import Progress

    done = [0, 0]
    with Progress() as progress:
        progress.stage(f"read {model}")
        from modelgen.analysis.sweeps.cluster import connect
        from modelgen.analysis.sweeps.store import refuse_foreign
        from modelgen.analysis.sweeps.sweep import sweep as swept
        from modelgen.cli.question import opened

        refuse_foreign(out, f"sweep folder {str(out)!r}")
        _, compiled = opened(model, assignments, speed)
        over = _over(compiled, ranges, options["sampling"])
        collect = options["collect"] or _usual(compiled)
        case = _case(compiled, options)
        client = None if options["dask"] is None else connect(options["dask"])

        def say(finished: int, points: int) -> None:
            if not done[1]:
                progress.stage(f"compute {points} points, {finished} of them finished before", measured=True)
            done[:] = finished, points
            progress.fraction(finished / points)

        kinds = {name: options[name] for name in ("sampling", "count", "fresh", "workers")}
        try:
            result = swept(case, over, collect, out=out, client=client, progress=say, **kinds)
        except KeyboardInterrupt:
            kept = f"at least {done[0]} of {done[1]} points are kept in {click.format_filename(out)}"
            raise Ending(f"interrupted; {kept}, and the same command goes on", INTERRUPTED) from None
        finally:
            if client is not None:
                client.close()
        progress.stage("draw")
        written = _write(result, out, options["netcdf"])
    click.echo(str(result))
    click.echo(f"{', '.join(written)} in {click.format_filename(out)}")


def _over(model: Compiled, ranges: tuple[str, ...], sampling: str) -> dict[str, Any]:
    """The values by name. Raises CaseError for a name given twice."""
    from modelgen.errors import CaseError

    over: dict[str, Any] = {}
    for each in ranges:
        name, values = _values(model, *pair(each, "--over", "NAME=START:STOP:COUNT"), sampling)
        if name in over:
            raise CaseError(f"--over {name}", "is given twice", "give all its values at once")
        over[name] = values
    return over


def _values(model: Compiled, name: str, text: str, sampling: str) -> tuple[str, list[float]]:
    """The values of one name: START:STOP:COUNT, LOW:HIGH of random points, or values with commas; one unit may serve all."""
    import numpy as np

    from modelgen.errors import CaseError
    from modelgen.units import read_quantity

    where = f"--over {name}"
    known = model.parameters.parameters.get(name.partition("[")[0])
    if known is None:
        model.parameters.unbalanced({name: 1.0})  # its refusal names the nearest
    unit = "1" if known is None else known.unit
    parts = [part.strip() for part in re.split("[:,]", text)]
    last = UNITED.fullmatch(text.strip())
    shared = last[2] if last and "," not in last[2] and ":" not in last[2] else ""

    def number(part: str) -> float:
        return read_quantity(part if UNITED.fullmatch(part) or not shared else f"{part} {shared}", unit, where)

    if ":" not in text:
        return name, [number(part) for part in parts]
    if sampling in ("random", "sobol"):
        if len(parts) != 2:
            raise CaseError(where, f"is {text!r}", "random points lie between LOW:HIGH")
        return name, [number(part) for part in parts]
    count = parts[2].removesuffix(shared).strip() if len(parts) == 3 else ""
    if not re.fullmatch(r"[0-9]{1,18}", count) or int(count) < 1 or "," in text:
        raise CaseError(where, f"is {text!r}", "write START:STOP:COUNT, such as 0:0.05:201, or values with commas")
    if int(count) > MOST:
        raise CaseError(where, f"has {int(count)} points", f"take at most {MOST}")
    return name, np.linspace(number(parts[0]), number(parts[1]), int(count)).tolist()


def _usual(model: Compiled) -> list[str]:
    """Highest and amplitude of the torque of every shaft and the force of every gear pair, else of every output."""
    torques = [name for name in model.outputs if name.endswith(".twist")]
    names = [name.removesuffix(".twist") + ".torque" for name in torques]
    names += [name for name in model.outputs if name.endswith(".force")]
    chosen = [name for name in names if name in model.outputs] or list(model.outputs)
    return [f"{name}.{statistic}" for name in chosen for statistic in ("highest", "amplitude")]


def _case(model: Compiled, options: dict[str, Any]) -> Case:
    """The case of the sweep, before its parameters change."""
    from modelgen.analysis import settled_window
    from modelgen.solvers import Budget, Case, operating_point
    from modelgen.units import read_quantity

    if options["window"] is None:
        window = settled_window(model, operating_point(model))
        first, last = window.first, window.last
    else:
        first, last = (read_quantity(text, "s", "--window") for text in options["window"])
    backend = {} if options["backend"] == "auto" else {"backend": options["backend"]}
    return Case(
        model,
        end=last,
        record_from=first,
        samples=options["samples"],
        start=options["start"],
        solver=options["solver"],
        tolerance=options["tolerance"],
        seed=options["seed"],
        options={**backend, "budget": Budget(max_seconds=options["max_seconds"])},
    )


def _write(result: Any, out: Path, netcdf: bool) -> list[str]:
    """Figure and NetCDF beside the table; returns the names of all that is there."""
    from modelgen.plots import plot, save

    written = ["table.csv"]
    if len(result.names) <= 2 and result.collected and len(result) > 1:
        written.append(save(plot(result), out / "sweep.png").name)
    if netcdf:
        written.append(result.to_netcdf(out / "sweep.nc").name)
    return written
