"""``modelgen solvers``: what integrates in time, from the package and from the user's tables. Part of ``cli``."""

from __future__ import annotations

import click

EXAMPLES = """
\b
Examples:
  modelgen solvers
  MODELGEN_METHODS=my_methods modelgen run two-disk-gear --solver bogacki_shampine --out out/gear

\b
A file NAME.toml in a folder of $MODELGEN_METHODS is an explicit method: its order and its table, numbers only.
"""


@click.command(epilog=EXAMPLES)
def solvers() -> None:
    """List the solvers: their order, whether they locate events, and their tolerance in cross-checks."""
    from modelgen.reports.tables import aligned
    from modelgen.solvers.registry import every_solver

    header = ["solver", "order", "events", "cross-check", "what it is"]
    rows = [
        [name, str(each.order), "located" if each.locates_events else "-", f"{each.crosscheck_tolerance:g}", each.description]
        for name, each in every_solver().items()
    ]
    wide = max(len(row[-1]) for row in rows)
    header, *rows = ([*row[:-1], row[-1].ljust(wide)] for row in (header, *rows))
    click.echo(aligned(header, rows))
