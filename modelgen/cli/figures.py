"""Which figures a run draws, where they stand in the report, and what is written below them.

Part of ``cli``; the drawing is that of ``plots``.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Figure:
    """A figure in the report: file path relative to it, section, title and caption."""

    path: str
    place: str
    title: str
    caption: str


def draw_figures(response, folder, progress):
    return []
