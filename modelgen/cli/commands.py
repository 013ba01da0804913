"""The group of commands and how each ends: 0, or one line on stderr with 1, 2 or 130. Never a traceback for bad input.

Stands at the root of ``cli``; each command is a file of its own.
"""

from __future__ import annotations

from typing import Any

import click

from modelgen import __version__
from modelgen.cli.bifurcation import bifurcation
from modelgen.cli.campbell import campbell
from modelgen.cli.check import check
from modelgen.cli.compare import compare
from modelgen.cli.crosscheck import crosscheck
from modelgen.cli.elements import elements
from modelgen.cli.ending import FAILED, INTERRUPTED, REFUSED, Ending
from modelgen.cli.equivalent import equivalent
from modelgen.cli.forced import forced
from modelgen.cli.generate import generate
from modelgen.cli.limits import limits
from modelgen.cli.listing import listing
from modelgen.cli.lyapunov import lyapunov
from modelgen.cli.map import operating_map
from modelgen.cli.modal import modal
from modelgen.cli.new import new
from modelgen.cli.orbit import orbit
from modelgen.cli.poincare import poincare
from modelgen.cli.referee import referee
from modelgen.cli.reproduce import reproduce
from modelgen.cli.run import run
from modelgen.cli.show import show
from modelgen.cli.solvers import solvers
from modelgen.cli.sweep import sweep
from modelgen.cli.transmission_error import transmission_error
from modelgen.cli.wording import in_words_of_the_command_line
from modelgen.errors import ModelgenError, RunFailedError

EXAMPLES = """
\b
Examples:
  modelgen list
  modelgen run fracturing-truck --out out/truck
  modelgen modal fracturing-truck --out out/modes
  modelgen check my_driveline.toml
"""


class Commands(click.Group):
    """A group whose refusals are one line, ``modelgen: where: problem; remedy``."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except RunFailedError as failure:
            raise Ending(in_words_of_the_command_line(str(failure)), FAILED) from None
        except ModelgenError as refusal:
            raise Ending(in_words_of_the_command_line(str(refusal)), REFUSED) from None
        except KeyboardInterrupt:
            raise Ending("interrupted; nothing was written", INTERRUPTED) from None
        except OSError as failure:
            if failure.filename is None:  # of a stream, not of a path that somebody gave
                raise
            raise Ending(f"{str(failure.filename)[:200]!r}: {failure.strerror}; check the path", REFUSED) from None
        except SystemError as failure:
            # A signal that arrives inside a call of CasADi comes out as this, with the signal's own exception behind it.
            if isinstance(failure.__cause__, KeyboardInterrupt):
                raise Ending("interrupted; nothing was written", INTERRUPTED) from None
            if isinstance(failure.__cause__, SystemExit):
                raise failure.__cause__ from None
            raise


@click.group(cls=Commands, epilog=EXAMPLES, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(__version__, prog_name="modelgen")
def commands() -> None:
    """A symbolic-to-numeric model compiler for drivelines.

    MODEL is a name from the catalogue (modelgen list) or a model file (TOML).
    """


COMMANDS = (
    *(bifurcation, poincare, operating_map, transmission_error),
    *(lyapunov, orbit, reproduce),
    *(run, modal, campbell, forced, sweep, limits, compare),
    *(crosscheck, referee),
    *(new, equivalent, generate, check, listing, show, elements, solvers),
)
for command in COMMANDS:
    commands.add_command(command)
