"""``modelgen elements``: the vocabulary of model files. Part of ``cli``."""

from __future__ import annotations

import click

EXAMPLES = """
\b
Examples:
  modelgen elements
  modelgen elements gear_pair
"""


@click.command(epilog=EXAMPLES)
@click.argument("kind", required=False)
def elements(kind: str | None) -> None:
    """List the kinds of elements, or say what one KIND is and asks for."""
    import modelgen.elements  # noqa: F401 - defining the elements makes their kinds known
    from modelgen.errors import CaseError, nearest
    from modelgen.model import Element

    known = Element.vocabulary
    if kind is None:
        for name, element in known.items():
            first, *_ = (element.__doc__ or "").strip().splitlines() or [""]
            click.echo(f"{name:16s} {first}".rstrip())
    elif kind in known:
        click.echo(known[kind].describe())
    else:
        raise CaseError("elements", f"there is no kind {kind!r}", nearest(kind, known))
