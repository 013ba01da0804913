"""``modelgen new``: a model file from a mass-elastic table, as engine and coupling makers hand them over.

Part of ``cli``; asks ``drivelines.mass_elastic``.
"""

from __future__ import annotations

import os
from pathlib import Path

import click

EXAMPLES = """
\b
Examples:
  modelgen new my-train --from maker.csv
  modelgen new my-train --from maker.csv --out models/my_train.toml --replace

\b
The table has a row for each inertia, with the stiffness to the next row:
  name, J [kg*m^2], k [kN*m/rad], ratio, diameter [mm]
  engine, 12.5, 850, 1, 120
  pinion, 0.8, , 1,
  wheel, 4.1, 2300, 20/61, 150
  propeller, 60, , 20/61,
Columns that may be there too: damping, shaft, to; J_referred and k_referred in place of J and k.
"""


@click.command(epilog=EXAMPLES)
@click.argument("name")
@click.option("--from", "table", type=click.Path(path_type=Path), metavar="TABLE.csv", help="The mass-elastic table.")
@click.option("--out", type=click.Path(path_type=Path), metavar="FILE.toml", help="The model file.  [default: NAME.toml]")
@click.option("--replace", is_flag=True, help="Replace a file that exists.")
def new(name: str, table: Path | None, out: Path | None, replace: bool) -> None:
    """Write the model file of the driveline NAME from a mass-elastic table, and print its natural frequencies."""
    from modelgen.errors import CaseError

    if table is None:
        raise CaseError(f"new {name!r}", "is given no table", "name it with --from TABLE.csv (modelgen new --help shows one)")
    from modelgen.equations import assemble
    from modelgen.exchange.mass_elastic import read_mass_elastic
    from modelgen.lowering import lower
    from modelgen.model.files import write_model
    from modelgen.model.names import model_name
    from modelgen.reports.report import digits
    from modelgen.solvers import operating_point

    path = out or Path(f"{model_name(name, 'new')}.toml")
    where = f"file {str(path)!r}"
    if path.suffix != ".toml":
        raise CaseError(where, f"has the ending {path.suffix!r}", "model files end in .toml")
    refuse_unless_free(path, replace)
    line = read_mass_elastic(table, name)
    frequencies = operating_point(lower(assemble(line))).frequencies()
    try:
        write_model(line, path)
    except OSError as error:
        raise CaseError(where, f"cannot be written: {error.strerror}", "check the path and its permissions") from None
    click.echo(line)
    if "not read" in line.description:
        click.echo(line.description.partition(". ")[2])
    click.echo(f"natural frequencies [Hz]: {', '.join(digits(float(each), 6) for each in frequencies)}")
    click.echo(f"model file: {path}")


def refuse_unless_free(path: Path, replace: bool) -> None:
    """Raises CaseError for a file that exists, unless it may be replaced, and for a folder."""
    from modelgen.errors import CaseError

    if os.path.isdir(path):
        raise CaseError(f"file {str(path)!r}", "is a folder", "name a file")
    if os.path.exists(path) and not replace:
        raise CaseError(f"file {str(path)!r}", "exists", "take --replace, or name another file with --out")
