"""plot(result): every result knows its figure by its type.

A file of this package that draws a type registers it here; the error for any other type lists what there is.
"""

from __future__ import annotations

import functools
from typing import Any

from matplotlib.figure import Figure

from modelgen.errors import CaseError


@functools.singledispatch
def plot(result: Any, /, **options: Any) -> Figure:
    """The figure of a result. ``options`` are those of its type. Raises CaseError for what has no figure.

    >>> plot("a text")
    Traceback (most recent call last):
    ...
    modelgen.errors.CaseError: plot: there is no figure of a str; give ...
    """
    known = sorted(kind.__name__ for kind in plot.registry if kind is not object)
    remedy = f"give {', '.join(known)}; draw() takes a Driveline"
    raise CaseError("plot", f"there is no figure of a {type(result).__name__}", remedy)
