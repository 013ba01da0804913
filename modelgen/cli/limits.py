"""``modelgen limits``: what the driveline does, held against rules, with formula, margin and source of each.

Part of ``cli``; ``limit_values`` gathers the values, ``analysis.limits.check`` judges them.
"""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from modelgen.cli.question import asks_a_model, fills_a_folder, speed_range
from modelgen.reports.diameters import DIAMETER

if TYPE_CHECKING:
    from modelgen.analysis.limits.bound_rule import Rule
    from modelgen.analysis.limits.check import LimitRow, LimitsResult
    from modelgen.model import Driveline

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
RULE = (
    "A rule or a file of rules, the elements it is for (all, if none), its inputs NAME=VALUE. Repeatable.  "
    "[default: those that the model chooses]"
)
LIST = "Print the rules and what they ask for."
RESPONSE = "Angles and torques once settled, as modelgen run has them, or of the linear forced response."
OPERATING = (
    "Range of speeds that natural frequencies keep off; its end is the maximum continuous speed.  "
    "[default: the operating speed; the model's own is the maximum]"
)
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
    from modelgen.cli.progress import Progress
    from modelgen.reports.folder import output_folder

    with output_folder(out, replace) as folder, Progress() as progress:
        target = speed_range(operating, "--operating")
        from modelgen.analysis.limits.check import check_limits
        from modelgen.cli.question import opened
        from modelgen.drivelines import load
        from modelgen.reports.diameters import diameters
        from modelgen.reports.limit_values import SEPARATION, forced_values, separation_values, settled_values

        chosen = read_rules(given)
        progress.stage(f"read {model}")
        line, compiled = opened(model, assignments, speed)
        chosen = chosen or _own_rules(line)
        sizes = diameters(line, compiled, diameter)
        rated = target[1] if target else load(model).speed
        remarks: tuple[str, ...] = ()
        values: dict[str, Any] = {}
        if any(each.quantity not in SEPARATION for each in chosen):
            if response == "settled":
                values, remarks = settled_values(line, sizes, progress, rated)
            else:
                progress.stage("find the response of every order")
                values, remarks = forced_values(compiled, sizes, rated)
        progress.stage("find how far natural frequencies keep off")
        orders = [order for each in chosen for order in each.orders_meant()]
        values |= separation_values(compiled, target, share, rated, orders)
        progress.stage("judge")
        judged = check_limits(values, chosen, line.name)
        result = dataclasses.replace(judged, remarks=(*remarks, *judged.remarks))
        _write(result, folder)
    click.echo(str(result))
    click.echo(f"table, figure and limits.json: {out}")


def read_rules(given: Iterable[str]) -> list[Rule]:
    """Rules from texts such as ``NAME ELEMENT input='600 MPa'``. Raises CaseError or UnitError for what they do not know."""
    from modelgen.analysis.limits.rulebook import chosen_rules
    from modelgen.errors import CaseError
    from modelgen.model.chosen_limits import ChosenLimit

    found: list[Rule] = []
    for text in given:
        try:
            words = shlex.split(text)
        except ValueError:
            raise CaseError(f"--rule {text!r}", "has a quotation mark without its partner", "close it") from None
        if not words:
            raise CaseError("--rule", "is empty", "name a rule; modelgen limits --list names them")
        name, *rest = words
        inputs = dict(word.split("=", 1) for word in rest if "=" in word)
        elements = tuple(word for word in rest if "=" not in word)
        found += chosen_rules([ChosenLimit(name, elements, inputs)])  # says what is missing before anything is computed
    return found


def _own_rules(line: Driveline) -> list[Rule]:
    """The rules that the model chooses. Raises CaseError where it chooses none: nobody else chooses for it."""
    from modelgen.analysis.limits.rulebook import chosen_rules
    from modelgen.errors import CaseError

    found = chosen_rules(line.limits)
    if not found:
        remedy = "name one with --rule (modelgen limits --list names them), or write [[limits]] into the model file"
        raise CaseError(f"driveline {line.name!r}", "chooses no rule to be held against", remedy)
    return found


def _write(result: LimitsResult, folder: Path) -> None:
    from modelgen.plots import plot, save
    from modelgen.reports.tables import write_data, write_table

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
