"""The command line: ``modelgen run``, ``modal``, ``limits`` and the others of ``commands``. Only ``__main__`` stands below it.

A command asks the packages above and puts their answers into files or lines. What is heavy is imported inside the commands, so
that ``modelgen --help`` answers at once.
"""

from __future__ import annotations

import sys
from typing import NoReturn


def main() -> NoReturn:
    """The script ``modelgen``; ends the process with its exit code."""
    from modelgen.cli.commands import commands
    from modelgen.cli.signals import end_by_signals

    for stream in (sys.stdout, sys.stderr):
        # A description may hold characters that the terminal cannot show.
        stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]  # both are text files here
    end_by_signals()
    commands(prog_name="modelgen")
    raise AssertionError("click ends the process")
