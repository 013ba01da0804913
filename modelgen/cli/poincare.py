"""``modelgen poincare``: the section of one motion, its phase portrait, and the verdict on it.

Part of ``cli``; asks ``nonlinear.sections`` and ``classification`` of ``analysis`` and, for a proof, ``stability.orbits``.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from modelgen.cli.bifurcation import BASE, CHANNEL, READING, STILL, TRANSIENT
from modelgen.cli.question import asks_a_model, fills_a_folder
from modelgen.reports.assignments import pair

if TYPE_CHECKING:
    from modelgen.analysis import PeriodicOrbit, SectionResult, Verdict
    from modelgen.solvers import Case

EXAMPLES = """
\b
Examples:
  modelgen poincare fracturing-truck-commensurate --out out/section --prove
  modelgen poincare fracturing-truck-commensurate --out out/undamped --set zeta=0 --strobes 1000
  modelgen poincare my_driveline.toml --out out/surface --surface coupling.twist="0.2 deg" --end 20

\b
Ends with 0 when done, 1 if the run failed, 2 if it was refused, 130 after Ctrl-C. Only what is done leaves a folder.
"""
SURFACE = "Cut where this channel passes a value upward, instead of a strobe."
PROVE = "Look for the periodic motion by shooting as well: closed to 1e-10, and every multiplier."
END = "With --surface: look for crossings up to this time [s]."


@click.command(epilog=EXAMPLES)
@asks_a_model
@fills_a_folder
@click.option("--channel", multiple=True, metavar="CHANNEL", help=CHANNEL)
@click.option("--strobes", type=click.IntRange(min=16), default=150, show_default=True, help="Points that are kept.")
@click.option("--transient", type=click.IntRange(min=0), default=200, show_default=True, help=TRANSIENT)
@click.option("--still", type=click.FloatRange(min=0, max=1, min_open=True, max_open=True), help=STILL)
@click.option("--base", metavar="NAME", help=BASE)
@click.option("--surface", metavar="CHANNEL=VALUE", help=SURFACE)
@click.option("--end", type=click.FloatRange(min=0, min_open=True), default=10.0, show_default=True, help=END)
@click.option("--prove", is_flag=True, help=PROVE)
@click.option("--mesh-reading", type=click.Choice(["fixed", "scaled"]), help=READING)
@click.option("--tolerance", type=float, default=1e-6, show_default=True, help="Of a step, per scale of each state.")
def poincare(
    model: str,
    assignments: tuple[str, ...],
    speed: str | None,
    out: Path,
    replace: bool,
    channel: tuple[str, ...],
    strobes: int,
    transient: int,
    still: float | None,
    base: str | None,
    surface: str | None,
    end: float,
    prove: bool,
    mesh_reading: str | None,
    tolerance: float,
) -> None:
    """Poincaré section and phase portrait of MODEL, with a verdict: period n, quasi-periodic, chaotic or undecided.

    The folder gets section.csv (the points), section.json (the verdict with its evidence) and a figure.
    """
    from modelgen.cli.ending import FAILED, Ending
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    with output_folder(out, replace, WRITTEN) as folder, Progress() as progress:
        progress.stage(f"read {model}")
        from modelgen.analysis import classify, periodic_orbit
        from modelgen.analysis import poincare as section_of
        from modelgen.analysis.classification.damping import undamped
        from modelgen.analysis.classification.motion_evidence import REACHED
        from modelgen.analysis.nonlinear.recurrence import FEWEST
        from modelgen.cli.bifurcation_case import strobed_case

        case = strobed_case(model, assignments, speed, mesh_reading, tolerance)
        progress.stage("find the points of the section", measured=True)
        if surface is None:
            kept = {"count": strobes, "transient": transient, "still": still, "base": base}
            result = section_of(case, channel or None, progress=progress.fraction, **kept)  # type: ignore[arg-type]
        else:
            result = _cut(case, surface, channel, strobes, end)
        if result.failure and len(result.times) < FEWEST:
            raise Ending(result, FAILED)
        orbit, away = None, float("nan")
        if prove:
            progress.stage("look for the periodic motion by shooting")
            orbit = periodic_orbit(case, order=max(1, result.period))
            away = _away(case, orbit, result) if surface is None else away
        reached = orbit if away < REACHED else None
        verdict = classify(result.sequence, result.still, orbit=reached, complete=result.complete, conservative=undamped(case))
        progress.stage("write table and figure")
        _write(result, verdict, folder)
    click.echo(str(result))
    click.echo(f"verdict: {verdict}")
    if orbit is not None and reached is None:
        far = f"the points stay away from it by {away:.2g} of the scales" if away == away else "these points do not show it"
        click.echo(f"beside that, shooting: {orbit.verdict}; {far}")
    click.echo(f"table, figure and section.json: {out}")
    if result.failure:
        raise Ending(f"the run of the section failed: {result.failure}", FAILED)


WRITTEN = ("section.csv", "section.json", "section.png")


def _cut(case: Case, surface: str, channels: tuple[str, ...], count: int, end: float) -> SectionResult:
    from modelgen.analysis.nonlinear.surface import surface_section
    from modelgen.units import read_quantity

    name, text = pair(surface, "--surface", 'CHANNEL=VALUE, such as coupling.twist="0.2 deg"')
    level = read_quantity(text, case.model.unit(name), f"--surface {name}")
    return surface_section(case.change(end=end), (name, level), channels or None, count=count)


def _away(case: Case, orbit: PeriodicOrbit, result: SectionResult) -> float:
    """How far the last points are from an orbit: proof of an orbit is evidence only on a motion that has come to it."""
    from modelgen.analysis.classification.motion_evidence import distance_from
    from modelgen.analysis.nonlinear.motion import vibrating_states
    from modelgen.analysis.nonlinear.runs import setting

    made = setting(case)
    return distance_from(orbit, result.sequence, vibrating_states(case.model, made.point), made.problem.scale)


def _write(result: SectionResult, verdict: Verdict, folder: Path) -> None:
    from modelgen.plots import plot, save
    from modelgen.reports.tables import write_data, write_table

    header = ["time [s]"]
    for name, unit in zip(result.channels, result.units, strict=True):
        header += [f"{name} [{unit}]", f"rate of {name} [{unit}/s]"]
    rows = [
        [time, *(each for both in zip(values, rates, strict=True) for each in both)]
        for time, values, rates in zip(result.times.tolist(), result.values.tolist(), result.rates.tolist(), strict=True)
    ]
    header.append("ending")
    rows = [[*row, ""] for row in rows]
    if result.failure:
        rows.append([*[None] * (len(header) - 1), result.failure])
    write_table(folder / "section.csv", header, rows)
    write_data(folder / "section.json", section_data(result, verdict))
    save(plot(result, verdict=verdict), folder / "section.png")


def section_data(result: SectionResult, verdict: Verdict) -> dict[str, Any]:
    """The section and the verdict as plain data."""
    return {
        "model": result.model,
        "changed_parameters": dict(result.parameters),
        "section": result.section,
        "points": len(result.times),
        "transient": result.transient,
        "settled": result.settled,
        "outcome": result.outcome.name,
        "failure": result.failure or None,
        "residual_scales": result.residual,
        "verdict": verdict.name,
        "kind": verdict.kind,
        "period": verdict.period,
        "undamped": verdict.conservative,
        "evidence": [
            {"source": each.source, "finding": each.finding, "speaks_for": each.speaks_for, "decided": each.decided}
            for each in verdict.evidence
        ],
    }
