"""Question: is there anything that a motion could settle to, or does a mode vibrate on for good?

Below ``motion_evidence``: without damping in every vibrating mode of the mean model there is no attractor to speak of. A motion
then depends on its start, and slow decay looks like a cloud of points.
"""

from __future__ import annotations

from typing import Any

from modelgen.analysis.linear.modal import damped_pairs
from modelgen.solvers.bound_model import bind

LEAST = 1e-6
"""Damping ratio of a mode below which it rings for more than a hundred thousand periods."""


def undamped(x: Any) -> bool:
    """Whether a vibrating mode of the mean model of a driveline, a model or a case has no damping, or next to none.

    >>> from modelgen import Case, Driveline, Inertia, Shaft
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])
    >>> undamped(Case(line, end=1.0)), undamped(Case(line, end=1.0, parameters={"shaft.damping_ratio": 0.01}))
    (True, False)
    """
    ratios = damped_pairs(bind(x, question="damping").operating_point).damping_ratios
    return bool(len(ratios) and ratios.min() < LEAST)
