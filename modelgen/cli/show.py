"""``modelgen show``: the equations of motion of a model. Part of ``cli``."""

from __future__ import annotations

import click

EXAMPLES = """
\b
Examples:
  modelgen show fracturing-truck
  modelgen show my_driveline.toml --latex > equations.tex
"""


@click.command(epilog=EXAMPLES)
@click.argument("model")
@click.option("--latex", is_flag=True, help="Print LaTeX instead of Markdown.")
def show(model: str, latex: bool) -> None:
    """Print the equations of motion of MODEL, element by element and as a whole."""
    from modelgen.drivelines import load
    from modelgen.equations import assemble

    equations = assemble(load(model))
    click.echo(equations.latex() if latex else equations.markdown())
