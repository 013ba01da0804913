"""Progress of long work on stderr: a bar on a terminal, a plain line every ten seconds otherwise.

Part of ``cli``. Stages follow each other; a stage may say how far it is.
"""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any

from modelgen.cli.streams import tell

PATIENCE = 10.0  # s between two plain lines of one stage


class Progress:
    """The stages of a run, as a context; ``stage`` begins the next one, ``fraction`` (0 to 1) moves it on."""

    def __init__(self) -> None:
        self._bar: Any = None
        self._task: Any = None
        self._name = ""
        self._said = 0.0

    def __enter__(self) -> Progress:
        if sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn

            times = (TimeElapsedColumn(), TimeRemainingColumn())  # gone, and left where a stage says how far it is
            columns = (TextColumn("{task.description}", markup=False), BarColumn(), TaskProgressColumn(), *times)
            self._bar = Progress(*columns, console=Console(stderr=True))
            self._bar.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._bar is not None:
            if kind is None:
                self._complete()
            self._bar.stop()

    def stage(self, name: str, measured: bool = False) -> None:
        """Begins a stage; ``measured`` stages say how far they are."""
        self._name, self._said = name, time.monotonic()
        if self._bar is None:
            tell(f"modelgen: {name}")
            return
        self._complete()
        self._task = self._bar.add_task(name, total=1.0 if measured else None)

    def fraction(self, done: float) -> None:
        """How far the stage is, from 0 to 1."""
        if self._bar is not None:
            self._bar.update(self._task, completed=min(1.0, max(0.0, done)))
        elif time.monotonic() - self._said > PATIENCE:
            self._said = time.monotonic()
            tell(f"modelgen: {self._name}: {100 * done:.0f} %")

    def _complete(self) -> None:
        if self._task is not None:
            self._bar.update(self._task, total=1.0, completed=1.0)
