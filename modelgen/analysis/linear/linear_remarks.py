"""What is to be known of a linear model before its numbers are read, in sentences.

Below every linear question: a stiffness that is not symmetric, rates that are coupled gyroscopically, laws with a kink.
"""

from __future__ import annotations

from modelgen.analysis.linear.kinks import kink_words, kinked_elements
from modelgen.lowering import Compiled
from modelgen.solvers.coupled_modes import coupling_words
from modelgen.solvers.operating_point import OperatingPoint


def linear_remarks(model: Compiled, point: OperatingPoint) -> tuple[str, ...]:
    """Of a linear model about a point; none where there is nothing to be said."""
    words = (kink_words(kinked_elements(model, point)),)
    return tuple(each for each in words if each)


def mode_remarks(model: Compiled, point: OperatingPoint) -> tuple[str, ...]:
    """The same, and what is to be known of its modes."""
    coupling = coupling_words(point.stiffness, point.damping)
    return (*((coupling,) if coupling else ()), *linear_remarks(model, point))
