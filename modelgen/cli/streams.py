"""The standard streams: there from the first line on, and written to the end, or it is said that they were not.

Part of ``cli``, called once by ``main``. A shell may close a stream (``modelgen list >&-``) or send it to a full disk.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import click


def open_streams() -> None:
    """Puts the null device in place of streams that are closed, so that no file that is opened later takes their number."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, os.O_RDONLY if number == 0 else os.O_WRONLY)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, "r" if number == 0 else "w", encoding="utf-8"))
    for stream in (sys.stdout, sys.stderr):
        # A description may hold characters that the terminal cannot show.
        stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]  # both are text files here


def tell(text: str) -> None:
    """A line on stderr; where it cannot be written, as on a full disk, the work goes on and nothing more is told."""
    try:
        click.echo(text, err=True)
    except OSError:
        _nowhere(sys.stderr.fileno())
        with suppress(OSError):
            sys.stderr.flush()  # what is left goes to the null device


@contextmanager
def written_out() -> Iterator[None]:
    """Ends the process with 1 and one line where what was printed could not be written."""
    try:
        try:
            yield
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        _nowhere(sys.stdout.fileno())
        raise SystemExit(1) from None
    except OSError as error:
        with suppress(OSError):
            sys.stderr.write(f"modelgen: the standard output cannot be written: {error.strerror}; free some space\n")
            sys.stderr.flush()
        _nowhere(sys.stdout.fileno())
        raise SystemExit(1) from None
    finally:
        try:
            sys.stderr.flush()
        except OSError:
            _nowhere(sys.stderr.fileno())


def _nowhere(number: int) -> None:
    """What is still waiting to be written goes to the null device, instead of failing once more at the end."""
    with suppress(OSError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, number)
        os.close(null)
