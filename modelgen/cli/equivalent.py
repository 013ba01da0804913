"""``modelgen equivalent``: the driveline as inertias and stiffnesses referred to its reference shaft, as a table.

Part of ``cli``; asks ``drivelines.equivalent_system``. ``modelgen new`` reads the table back.
"""

from __future__ import annotations

from pathlib import Path

import click

from modelgen.cli.question import asks_a_model

EXAMPLES = """
\b
Examples:
  modelgen equivalent fracturing-truck --out truck.csv
  modelgen equivalent my_driveline.toml --out stiff.csv --set coupling.stiffness="400 kN*m/rad"
"""


@click.command(epilog=EXAMPLES)
@asks_a_model
@click.option("--out", required=True, type=click.Path(path_type=Path), metavar="FILE.csv", help="The table.")
@click.option("--replace", is_flag=True, help="Replace a file that exists.")
def equivalent(model: str, assignments: tuple[str, ...], speed: str | None, out: Path, replace: bool) -> None:
    """Write the equivalent system of MODEL about its operating point, and print it."""
    from modelgen.cli.new import refuse_unless_free
    from modelgen.cli.question import opened
    from modelgen.exchange.equivalent_system import equivalent_table
    from modelgen.reports.report import digits
    from modelgen.reports.tables import aligned
    from modelgen.solvers import operating_point

    refuse_unless_free(out, replace)
    _, compiled = opened(model, assignments, speed)
    table = equivalent_table(compiled, operating_point(compiled))
    table.write(out)
    click.echo(f"equivalent system of {table.model!r}, referred to {table.reference!r}")
    inertias = [[each.name, digits(each.inertia), digits(each.ratio, 6), digits(each.referred)] for each in table.inertias]
    click.echo(aligned(["inertia", "J [kg*m^2]", "ratio", "J referred [kg*m^2]"], inertias))
    shafts = [[f"{s.start} to {s.end}", digits(s.stiffness), digits(s.damping), " + ".join(s.elements)] for s in table.shafts]
    if shafts:
        click.echo(aligned(["shaft", "k referred [N*m/rad]", "c referred [N*m*s/rad]", "elements"], shafts))
    for remark in table.remarks:
        click.echo(remark)
    click.echo(f"table: {out}")
