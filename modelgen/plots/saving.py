"""Saving a figure: whole or not at all, and the same bytes for the same figure.

Last step of the flow, ``Figure -> file``.
"""

from __future__ import annotations

import os
import threading
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from modelgen.errors import CaseError, nearest
from modelgen.plots.style import DPI, style

# Dates, versions and machines stay out of the files.
METADATA: dict[str, dict[str, Any]] = {
    ".png": {"Software": None},
    ".pdf": {"Creator": "modelgen", "Producer": None, "CreationDate": None},
    ".svg": {"Creator": "modelgen", "Date": None},
}


def save(figure: Figure, path: str | Path) -> Path:
    """Writes a figure as PNG (200 dpi), PDF or SVG, by the ending of the path; what was there before is replaced at once.

    Raises CaseError for another ending, for something that is no figure, and where the file cannot be written.
    """
    path = Path(path)
    where = f"figure {str(path)!r}"
    if not isinstance(figure, Figure):
        raise CaseError(where, f"is given a {type(figure).__name__}", "give what plot() or draw() returns")
    if path.suffix not in METADATA:
        raise CaseError(where, f"has the ending {path.suffix!r}", nearest(path.suffix, METADATA))
    temporary = path.with_name(f".{path.name}.{os.getpid()}.{threading.get_ident()}")
    title = {"Title": str(figure.get_label())} if figure.get_label() else {}
    try:
        with style(), temporary.open("wb") as file:
            figure.savefig(file, format=path.suffix[1:], dpi=DPI, metadata={**METADATA[path.suffix], **title})
        os.replace(temporary, path)
    except OSError as error:
        problem = f"cannot be written ({error.strerror or error})"
        raise CaseError(where, problem, "choose a folder that exists and can be written") from None
    finally:
        temporary.unlink(missing_ok=True)
    return path
