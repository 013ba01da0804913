"""``modelgen limits``: what the driveline does, held against rules, with formula, margin and source of each.

Part of ``cli``; ``limit_values`` gathers the values, ``analysis.limits.check`` judges them.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from modelgen.cli.diameters import DIAMETER
from modelgen.cli.question import asks_a_model, fills_a_folder, speed_range

if TYPE_CHECKING:
    from modelgen.analysis.limits.check import LimitRow, LimitsResult
    from modelgen.analysis.limits.rulebook import Rule

EXAMPLES = """
\b
Examples:
  modelgen limits fracturing-truck --out out/limits
  modelgen limits fracturing-truck --out out/linear --response forced --operating "1500 rpm" "1900 rpm"
  modelgen limits my_driveline.toml --out out/coupling \\
      --rule "coupling_vibratory_torque coupling continuous_vibratory_torque='1.5 kN*m'"
  modelgen limits my_driveline.toml --out out/stress --diameter shaft="80 mm" \\
      --rule "mil_std_167_2_steel shaft tensile_strength='600 MPa'"
  modelgen limits --list

\b
Ends with 0 when done, whatever the verdicts; 1 if the run failed, 2 if it was refused, 130 after Ctrl-C.
"""
USUAL = ("syt_5211_angle", "api_617_separation")
RULE = f"A rule, the elements it is for (all, if none), its inputs NAME=VALUE. Repeatable.  [default: {', '.join(USUAL)}]"
LIST = "Print the rules and what they ask for."
RESPONSE = "Angles and torques once settled, as modelgen run has them, or of the linear forced response."
OPERATING = "Range of speeds that natural frequencies keep off.  [default: the operating speed]"
SHARE = "Orders whose torque is below this share of the largest one are not kept off from."


def _list(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    """Prints the rules and ends."""
    if not wanted:
        return
    from modelgen.analysis.limits.rulebook import rules

    for name, rule in rules().items():
        click.echo(f"{name}: {rule.title}; judges {rule.quantity} [{rule.unit}]")
        click.echo(f"  {rule.citation}; {rule.provenance}")
        for each in rule.inputs.values():
            choices = f"; or {', '.join(each.choices)}" if each.choices else ""
            default = "" if each.default is None else f" (default {each.default:g})"
            click.echo(f"  {each.name} [{each.unit}]{default}: {each.doc}{choices}")
    ctx.exit()


@click.command(epilog=EXAMPLES)
@asks_a_model
@fills_a_folder
@click.option("--rule", "given", multiple=True, metavar="RULE", help=RULE)
@click.option("--response", type=click.Choice(["settled", "forced"]), default="settled", show_default=True, help=RESPONSE)
@click.option("--operating", nargs=2, metavar="LOW HIGH", help=OPERATING)
@click.option("--share", type=click.FloatRange(0, 1), default=0.01, show_default=True, help=SHARE)
@click.option("--diameter", multiple=True, metavar="SHAFT=DIAMETER", help=DIAMETER)
@click.option("--list", is_flag=True, is_eager=True, expose_value=False, callback=_list, help=LIST)
def limits(
    model: str,
    assignments: tuple[str, ...],
    speed: str | None,
    out: Path,
    replace: bool,
    given: tuple[str, ...],
    response: str,
    operating: tuple[str, str] | None,
    share: float,
    diameter: tuple[str, ...],
) -> None:
    """Hold MODEL against limits: angles, torques, stresses, separation of natural frequencies from what excites them.

    The folder gets limits.csv (every value against every rule, with formula, margin and source), limits.json and a figure. A
    rule whose own text was not seen says so.
    """
    from modelgen.cli.folder import output_folder
    from modelgen.cli.progress import Progress

    with output_folder(out, replace) as folder, Progress() as progress:
        target = speed_range(operating, "--operating")
        from modelgen.cli.diameters import diameters
        from modelgen.cli.limit_values import forced_values, separation_values, settled_values
        from modelgen.cli.question import opened

        chosen = read_rules(given)
        progress.stage(f"read {model}")
        line, compiled = opened(model, assignments, speed)
        sizes = diameters(line, compiled, diameter)
        remarks: tuple[str, ...] = ()
        values: dict[str, Any] = {}
        if not chosen or any(each.quantity not in ("separation_margin", "critical_speed_ratio") for each in chosen):
            if response == "settled":
                values, remarks = settled_values(line, sizes, progress)
            else:
                progress.stage("find the response of every order")
                values, remarks = forced_values(compiled, sizes)
        progress.stage("find how far natural frequencies keep off")
        values |= separation_values(compiled, target, share)
        progress.stage("judge")
        result = _judge(values, chosen, line.name, remarks)
        _write(result, folder)
    click.echo(str(result))
    click.echo(f"table, figure and limits.json: {out}")


def read_rules(given: Iterable[str]) -> list[Rule]:
    """Rules from texts such as ``NAME ELEMENT input='600 MPa'``. Raises CaseError or UnitError for what they do not know."""
    from modelgen.analysis.limits.rulebook import rule
    from modelgen.errors import CaseError

    found = []
    for text in given:
        try:
            words = shlex.split(text)
        except ValueError:
            raise CaseError(f"--rule {text!r}", "has a quotation mark without its partner", "close it") from None
        if not words:
            raise CaseError("--rule", "is empty", "name a rule; modelgen limits --list names them")
        name, *rest = words
        inputs = dict(word.split("=", 1) for word in rest if "=" in word)
        chosen = rule(name).given(*(word for word in rest if "=" not in word), **inputs)
        chosen.limit()  # says what is missing before anything is computed
        found.append(chosen)
    return found


def _judge(values: Mapping[str, Any], chosen: list[Rule], model: str, remarks: tuple[str, ...]) -> LimitsResult:
    """The rules asked for, or those of the usual ones that there is something to judge for."""
    from dataclasses import replace

    from modelgen.analysis.limits.check import check_limits
    from modelgen.analysis.limits.rulebook import rule
    from modelgen.errors import CaseError

    if not chosen:
        held = {name.rpartition(".")[2] for name in values}
        chosen = [each for each in map(rule, USUAL) if each.quantity in held]
        if not chosen:
            problem = "has neither angles nor natural frequencies to judge"
            raise CaseError(f"driveline {model!r}", problem, "name a rule with --rule")
    return replace(check_limits(values, chosen, model), remarks=remarks)


def _write(result: LimitsResult, folder: Path) -> None:
    from modelgen.cli.tables import write_data, write_table
    from modelgen.plots import plot, save

    rows = [_columns(row) for row in result.rows]
    write_table(folder / "limits.csv", list(rows[0]), [list(row.values()) for row in rows])
    write_data(folder / "limits.json", limits_data(result))
    save(plot(result), folder / "limits.png")


def _columns(row: LimitRow) -> dict[str, Any]:
    """A row of the table, by its columns."""
    return {
        "verdict": row.verdict,
        "element": row.element,
        "quantity": row.quantity,
        "value [unit]": row.value,
        "comparison": row.comparison,
        "limit [unit]": " and ".join(f"{each:.9g}" for each in row.limits),
        "unit": row.unit,
        "margin [percent]": None if row.margin is None else 100 * row.margin,
        "half p-p [unit]": row.beside,
        "formula": row.formula,
        "formula with numbers": row.inserted,
        "rule": row.rule,
        "title": row.title,
        "measure": row.measure,
        "applies to": row.applies,
        "citation": row.citation,
        "verified": "yes" if row.verified else "no",
        "text seen": row.provenance,
        "remark": row.remark,
    }


def limits_data(result: LimitsResult) -> dict[str, Any]:
    """The verdicts as plain data: values and limits in the ``unit`` of their row, margins as share of the limit."""
    from dataclasses import asdict

    counts = {verdict.replace(" ", "_"): len(result.with_verdict(verdict)) for verdict in ("pass", "fail", "not judged")}
    told = {"ok": result.ok, **counts, "unverified": result.unverified, "remarks": result.remarks}
    return {"model": result.model, **told, "rows": [asdict(row) for row in result.rows]}
