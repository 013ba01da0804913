"""``modelgen reproduce paper``: the paper's thirteen figures, and every one of its claims beside what the model gives.

Part of ``cli``. Computing, figures, claims and texts stand in ``reproduce_*``.
"""

from __future__ import annotations

import time
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import click

from modelgen.cli.question import fills_a_folder

if TYPE_CHECKING:
    from modelgen.cli.progress import Progress
    from modelgen.cli.reproduce_work import Extent
    from modelgen.drivelines.claims import Claims
    from modelgen.model import Driveline
    from modelgen.reports.paper import ClaimRow

DRIVELINE = "fracturing-truck"
WRITTEN = ("reproduction.md", "reproduction.json", *(f"fig_{number:02d}.png" for number in range(1, 14)))
EXAMPLES = """
\b
Examples:
  modelgen reproduce paper --out out/paper
  modelgen reproduce paper --out out/look --quick

\b
Ends with 0 when done, 1 if a run failed, 2 if it was refused, 130 after Ctrl-C. Only what is done leaves a folder.
"""
QUICK = "A coarse version, in seconds: everything is there, nothing is decided."


@click.command(epilog=EXAMPLES)
@click.argument("what", type=click.Choice(["paper"]))
@fills_a_folder
@click.option("--quick", is_flag=True, help=QUICK)
def reproduce(what: str, out: Path, replace: bool, quick: bool) -> None:
    """Everything that the paper shows, computed from the catalogued truck: figures 1 to 13 and its claims.

    The folder gets fig_01.png to fig_13.png, reproduction.md (every claim: holds, does not hold, or cannot be decided, with the
    evidence) and reproduction.json. Kinds of motion are those of the commensurate truck under both readings of the mesh damping.
    The full version takes some minutes on two cores.
    """
    begun = time.perf_counter()
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    command = f"modelgen reproduce {what} --out DIR{' --quick' * quick}"
    with output_folder(out, replace, WRITTEN) as folder, Progress() as progress:
        progress.stage(f"read {DRIVELINE}")
        from modelgen.cli.reproduce_work import FULL
        from modelgen.cli.reproduce_work import QUICK as COARSE
        from modelgen.drivelines import load
        from modelgen.drivelines.claims import claims_of

        claims = claims_of(DRIVELINE)
        assert claims is not None  # they come with it
        rows = fill(folder, load(DRIVELINE), claims, COARSE if quick else FULL, command, begun, progress)
    counted = Counter(row.verdict for row in rows)
    for verdict, count in counted.most_common():
        click.echo(f"{count:3d} claims: {verdict}")
    click.echo(f"report and 13 figures: {out / 'reproduction.md'} ({time.perf_counter() - begun:.1f} s)")


def fill(
    folder: Path, line: Driveline, claims: Claims, extent: Extent, command: str, begun: float, progress: Progress
) -> list[ClaimRow]:
    """Computes everything and writes it into a folder; the claims with their verdicts."""
    from modelgen.cli.reproduce_work import reproduce_all

    work = reproduce_all(line, claims, extent, progress)
    progress.stage("draw figures", measured=True)
    from modelgen.cli.reproduce_claims import claim_rows
    from modelgen.cli.reproduce_figures import draw_all
    from modelgen.cli.reproduce_report import reproduction_data, reproduction_text
    from modelgen.reports.tables import write_data

    figures, rows = draw_all(work, folder, progress), claim_rows(work)
    progress.stage("write report")
    wall = time.perf_counter() - begun
    write_data(folder / "reproduction.json", reproduction_data(work, rows, figures, wall))
    text = reproduction_text(work, rows, figures, command, wall)
    (folder / "reproduction.md").write_text(text, encoding="utf-8")
    return rows
