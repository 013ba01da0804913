"""``modelgen check``: whether a model file is right, without simulating it.

Part of ``cli``. Reads and assembles (names, units, topology, dimensions), compiles, and finds the static state (balance).
"""

from __future__ import annotations

import click

from modelgen.cli.ending import FAILED, Ending
from modelgen.errors import ModelgenError

EXAMPLES = """
\b
Examples:
  modelgen check my_driveline.toml
  modelgen check fracturing-truck

\b
Ends with 0 if the model is right, and with 1 and one line that says what is wrong if it is not.
"""
SHOWN = 6


@click.command(epilog=EXAMPLES)
@click.argument("model")
def check(model: str) -> None:
    """Read MODEL, assemble and balance it, and print a summary, or the one thing that is wrong."""
    from modelgen.analysis.limits.rulebook import chosen_rules
    from modelgen.drivelines import load
    from modelgen.equations import assemble
    from modelgen.lowering import lower
    from modelgen.reports.report import digits
    from modelgen.solvers import operating_point

    try:
        line = load(model)
        equations = assemble(line)
        chosen_rules(line.limits)
        compiled = lower(equations)
        point = operating_point(compiled)
    except ModelgenError as wrong:
        raise Ending(wrong, FAILED) from None
    click.echo(line)
    click.echo(equations)
    for name in equations.balanced:
        click.echo(f"  {name} = {digits(compiled.parameters.value(point.p, name), 9)} balances the mean power")
    for name, net, parts in point.remaining(compiled):
        click.echo(f"  along the rotation of {name!r}: mean torques leave {digits(net, 3)} of {digits(parts, 6)} N*m")
    for name, torque in point.holding.items():
        click.echo(f"  {name} holds {digits(torque, 6)} N*m at rest")
    for remark in point.remarks:
        click.echo(f"  static state: {remark}")
    if equations.drifts:
        click.echo(f"  declared to drift: the reference shaft gains {point.drift:.4g} rad/s every second")
    frequencies = [digits(float(f), 6) for f in point.frequencies()]
    more = f", ... ({len(frequencies)} in all)" if len(frequencies) > SHOWN else ""
    click.echo(f"  natural frequencies [Hz]: {', '.join(frequencies[:SHOWN])}{more}")
    click.echo("the model is right")
