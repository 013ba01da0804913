"""The limit that a driveline's torsional angle is held against, and the verdict.

Part of ``cli``. The figure is that of the paper, which quotes SY/T 5211-2009 (fracturing pump sets); the standard's own text was
not seen, so neither its definition of the angle nor its range of use is known. The largest absolute value of the physical
vibration angle is held against it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees

from modelgen.analysis import AnglesResult

NAME = "SY/T 5211-2009 as the paper quotes it"
QUANTITY = "vibration_peak"
DEGREES = 0.5


@dataclass(frozen=True)
class Verdict:
    """The element whose vibration angle is largest, its value [deg, physical, 0-peak], and all that exceed the limit."""

    element: str
    value: float
    exceeding: Mapping[str, float]

    @property
    def ok(self) -> bool:
        """Whether no angle exceeds the limit."""
        return not self.exceeding


def verdict(found: AnglesResult) -> Verdict | None:
    """The verdict on all inertias; None for a driveline without any."""
    peaks = {name: degrees(each.vibration.peak) for name, each in found.inertias.items()}
    if not peaks:
        return None
    largest = max(peaks, key=lambda name: peaks[name])
    above = {name: peaks[name] for name in sorted(peaks, key=lambda name: -peaks[name]) if peaks[name] > DEGREES}
    return Verdict(largest, peaks[largest], above)
