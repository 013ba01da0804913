"""How a command says that it could not do what was asked: one line on stderr and an exit code.

Part of ``cli``.
"""

from __future__ import annotations

from typing import IO, Any

import click

from modelgen.cli.streams import tell

FAILED, REFUSED, INTERRUPTED = 1, 2, 130
"""Exit codes: a run that ended badly or a model that is wrong; a request that cannot be carried out; Ctrl-C."""


class Ending(click.ClickException):
    """The line ``modelgen: message`` and an exit code; a message with line breaks is put on one line."""

    def __init__(self, message: object, exit_code: int) -> None:
        super().__init__(" ".join(str(message).split()))
        self.exit_code = exit_code  # type: ignore[misc]  # click declares it on the class

    def show(self, file: IO[Any] | None = None) -> None:
        if file is None:
            tell(f"modelgen: {self.message}")
        else:
            click.echo(f"modelgen: {self.message}", file=file)
