"""The scene of a driveline drawing that fits a page: columns and shaft lines as far apart as its labels ask for.

Before ``drawing``. Tried out from wide to narrow, until every label stands at its place and nothing lies on anything else.
"""

from __future__ import annotations

from itertools import product

from modelgen.plots.layout import Layout
from modelgen.plots.names import put_names
from modelgen.plots.parts import Parts
from modelgen.plots.signs import BORDER, Scene, set_signs
from modelgen.plots.style import WIDTH

PITCHES = (2.4, 2.2, 2.0, 1.9, 1.8, 1.7, 1.65, 1.6, 1.55, 1.5, 1.4)  # distances of columns [cm]
DISTANCES = (2.6, 3.0, 3.4, 3.8, 4.4)  # of shaft lines [cm]
FAR = 0.6  # cm that a label may move
HOPELESS = 1.8  # cm too wide, which moving the shaft lines apart does not cure
LARGE = 60  # nodes, from which on few scenes are tried


def scene(places: Layout, found: Parts) -> Scene:
    """The widest scene that fits the page with every label at its place; where none does, the one that comes nearest."""
    pitches: tuple[float, ...] = PITCHES if places.columns > 1 else PITCHES[:1]
    distances: tuple[float, ...] = DISTANCES if places.levels > 1 else DISTANCES[:1]
    if len(places.place) > LARGE:
        pitches, distances = (1.6, 1.4), (3.0, 3.8)
    best: tuple[tuple[float, float, float], Scene] | None = None
    hopeless = None
    for pitch, distance in product(pitches, distances):
        if pitch == hopeless:
            continue
        made = put_names(set_signs(places, found, pitch, distance))
        excess = max(0.0, made.size[0] - WIDTH - BORDER)
        fault = (round(made.room.lost, 6), excess, max(0.0, made.room.moved - FAR))
        if not any(fault):
            return made
        if excess > HOPELESS:
            hopeless = pitch
        if best is None or fault < best[0]:
            best = (fault, made)
    assert best is not None
    return best[1]
