"""The command line: ``modelgen run``, ``modal``, ``limits`` and the others of ``commands``. Only ``__main__`` stands below it.

A command asks the packages above and puts their answers into files or lines. What is heavy is imported inside the commands, so
that ``modelgen --help`` answers at once.
"""

from __future__ import annotations

import os
from typing import NoReturn


def main() -> NoReturn:
    """The script ``modelgen``; ends the process with its exit code."""
    from modelgen.cli.streams import open_streams, written_out

    open_streams()
    os.environ["MPLBACKEND"] = "agg"  # a command draws into files; whatever a shell has set is for windows

    from modelgen.cli.commands import commands
    from modelgen.cli.signals import end_by_signals

    end_by_signals()
    with written_out():
        commands(prog_name="modelgen")
    raise AssertionError("click ends the process")
