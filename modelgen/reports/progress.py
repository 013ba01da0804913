"""Whom long work tells how far it is. Part of ``reports``; the command line shows a bar, a notebook may show nothing."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """The stages of a run: ``stage`` begins the next one, ``fraction`` (0 to 1) moves it on."""

    def stage(self, name: str, measured: bool = False) -> None:
        """Begins a stage; ``measured`` stages say how far they are."""

    def fraction(self, done: float) -> None:
        """How far the stage is, from 0 to 1."""


class Silence:
    """Nobody is told."""

    def stage(self, name: str, measured: bool = False) -> None:
        """Nothing."""

    def fraction(self, done: float) -> None:
        """Nothing."""
