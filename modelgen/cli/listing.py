"""``modelgen list``: the catalogue of worked drivelines. Part of ``cli``."""

from __future__ import annotations

import click

EXAMPLES = """
\b
Examples:
  modelgen list
  modelgen run fracturing-truck --out out/truck
"""


@click.command("list", epilog=EXAMPLES)
def listing() -> None:
    """List the worked drivelines that can be run by name."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from modelgen.drivelines import catalogue, load

    table = Table(box=None, pad_edge=False)
    table.add_column("model", no_wrap=True)
    table.add_column("what it is")
    for name in sorted(catalogue()):
        line = load(name)
        table.add_row(Text(name), Text(f"{' '.join(line.description.split())}\n{str(line).partition(': ')[2]}"))
    Console(highlight=False).print(table)
