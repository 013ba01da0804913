"""Answers: every result as a figure, ``plot(result)``, and the driveline itself, ``draw(driveline)``. Matplotlib lives here only.

Last stage of the flow before the command line: ``Solution -> <Question>Result -> Figure``.
"""

from modelgen.plots.dispatch import plot
from modelgen.plots.drawing import draw
from modelgen.plots.saving import save

__all__ = ["draw", "plot", "save"]
