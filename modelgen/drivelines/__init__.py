"""Worked drivelines as model files, and the one way to open a driveline by name or path.

Reading makes the vocabulary of elements known, so this package stands below ``elements``; all that asks questions stands below
it, and takes a driveline by its name.
"""

from __future__ import annotations

import os
from os import PathLike
from pathlib import Path

import modelgen.elements  # noqa: F401 - defining the elements makes their kinds known to model files
from modelgen.errors import CaseError, nearest
from modelgen.model import Driveline
from modelgen.model.files import read_model

FOLDER = Path(__file__).parent


def catalogue() -> dict[str, Path]:
    """Names of the worked drivelines and their model files.

    >>> "fracturing-truck" in catalogue()
    True
    """
    return {path.stem: path for path in sorted(FOLDER.glob("*.toml"))}


def load(model: str | Path) -> Driveline:
    """The driveline of a catalogue name or of a model file. Raises CaseError for an unknown name, ModelFileError for a bad file.

    >>> print(load("fracturing-truck"))
    driveline 'fracturing-truck': 40 elements (16 inertia, 13 shaft, 2 gear_pair, 9 harmonic_torque) at 1900 rpm of 'flywheel'
    """
    if not isinstance(model, (str, PathLike)):
        raise CaseError("load", f"is given {type(model).__name__}", "give a name of the catalogue, or the path of a model file")
    known = catalogue()
    if str(model) in known:
        return read_model(known[str(model)])
    path = Path(model)
    if path.suffix != ".toml" and not os.path.exists(path):
        raise CaseError(f"model {str(model)!r}", "is neither in the catalogue nor a model file", nearest(str(model), known))
    return read_model(path)
