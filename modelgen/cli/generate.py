"""``modelgen generate``: a model as portable C with its equations, and whether such folders are still fresh. Part of ``cli``."""

from __future__ import annotations

from pathlib import Path

import click

from modelgen.cli.streams import tell

EXAMPLES = """
\b
Examples:
  modelgen generate fracturing-truck --out generated/fracturing-truck
  modelgen generate my_driveline.toml --out out/c --replace
  modelgen generate --check
  modelgen generate --check generated/fracturing-truck

\b
The folder gets equations.md, NAME.c and NAME.h (right-hand side, outputs, Jacobian, tables, solver), NAME_solver.c (a program
that prints a trajectory) and manifest.json. Build and run:
  cc -std=c99 -O2 generated/fracturing-truck/*.c -lm -o truck && ./truck --help
"""
FOLDER = Path("generated")


@click.command(epilog=EXAMPLES)
@click.argument("arguments", nargs=-1, metavar="MODEL | [DIR]...")
@click.option("--out", type=click.Path(path_type=Path), help="Folder to write.")
@click.option("--replace", is_flag=True, help="Replace the folder if modelgen wrote all of it.")
@click.option("--check", is_flag=True, help="Check folders instead; by default every one in generated/.")
def generate(arguments: tuple[str, ...], out: Path | None, replace: bool, check: bool) -> None:
    """Write MODEL as C that needs nothing but a compiler, or check what was written (exit code 1 if it is out of date)."""
    from modelgen.errors import CaseError

    if check:
        if out is not None or replace:
            raise CaseError("--check", "writes nothing, but --out or --replace is given", "leave one out")
        _check([Path(each) for each in arguments])
        return
    if len(arguments) != 1:
        raise CaseError("modelgen generate", f"got {len(arguments)} models", "name one MODEL, or take --check")
    if out is None:
        raise CaseError("modelgen generate", "has no --out", "name the folder to write")
    _write(arguments[0], out, replace)


def _write(model: str, out: Path, replace: bool) -> None:
    from modelgen.cli.generate_folder import MANIFEST, Subject, contents, default_case, probes, source_of
    from modelgen.drivelines import load
    from modelgen.reports.folder import output_folder

    subject = Subject.of(load(model), source_of(model, out))
    case = default_case(subject.model)
    files = contents(subject, case, probes(subject.model, case))
    with output_folder(out, replace, written=tuple(files)) as folder:
        for name, content in files.items():
            (folder / name).write_bytes(content)
    click.echo(f"{out}: {', '.join(name for name in files if name != MANIFEST)}, {MANIFEST}")


def _check(folders: list[Path]) -> None:
    from modelgen.cli.ending import FAILED, Ending
    from modelgen.cli.generate_check import check_folder
    from modelgen.errors import CaseError

    if not folders:
        folders = sorted(each for each in FOLDER.iterdir() if each.is_dir()) if FOLDER.is_dir() else []
        if not folders:
            raise CaseError("--check", "there is no folder in generated/", "name one, or go to where generated/ is")
    stale = []
    for folder in folders:
        found = check_folder(folder)
        for problem in found.problems:
            tell(f"{folder}: {problem}")
        if found.problems:
            stale.append(found.repair)
        else:
            click.echo(f"{folder}: fresh" + (f", {found.remark}" if found.remark else ""))
    if stale:
        raise Ending(f"out of date; repair with: {' && '.join(stale)}", FAILED)
