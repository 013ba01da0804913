"""Question: do the gears hammer, that is, does the vibratory torque exceed the mean torque that keeps the flanks together?

Read from a forced response: mean + vibration over the cycle, with phases. Where the sum changes its sign, flanks part and
strike; a linear answer says that they do, not what follows (that takes time integration with the backlash).
Source: W. Ker Wilson, Practical Solution of Torsional Vibration Problems, vol. 2 (1963) (gear hammer); classification societies
ask the same of marine gears.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.linear.forced import ForcedResult
from modelgen.errors import CaseError, refuse_unless

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GearLoad:
    """Load of one gear over the speeds, in ``unit``: mean, largest departure from it, least value in the sense of the mean.

    ``ratio`` = ``alternating`` / |mean| (infinite without a mean); ``hammer``: whether the load reaches zero. ``exact``: over the
    common cycle, or else a bound (``Swings``).
    """

    channel: str
    unit: str
    mean: Array
    alternating: Array
    least: Array
    ratio: Array
    hammer: NDArray[np.bool_]
    exact: bool


@dataclass(frozen=True, eq=False)
class HammerResult:
    """Loads of all gears by element, over ``speeds`` [rad/s]."""

    model: str
    speeds: Array
    gears: Mapping[str, GearLoad]

    def __str__(self) -> str:
        rows = [f"gear hammer of {self.model!r} at {len(self.speeds)} speeds"]
        for name, load in self.gears.items():
            beaten = self.speeds[load.hammer] * 30 / np.pi
            said = "never" if not beaten.size else f"at {beaten.size} speeds, first at {beaten[0]:.6g} rpm"
            rows.append(f"  {name}: {said}; largest alternating per mean {load.ratio.max():.3g}")
        return "\n".join(rows)

    __repr__ = __str__


def gear_hammer(result: ForcedResult) -> HammerResult:
    """Whether and where the gears hammer. Raises CaseError where the response holds no load of a gear."""
    refuse_unless(result, ForcedResult, "gear_hammer")
    if not result.gears:
        raise CaseError(
            f"forced response of {result.model!r}", "holds no load of a gear", "ask a driveline with gears, with their forces"
        )
    found = {}
    for channel in result.gears:
        swing = result.swing(channel)
        forward = np.where(swing.mean < 0, -1.0, 1.0)
        least = np.where(forward > 0, swing.least, -swing.largest)
        mean = np.abs(swing.mean)
        # A mean that is rounding is none: flanks without load part at the slightest vibration.
        loaded = mean > 1e-9 * swing.peak
        found[channel.rpartition(".")[0]] = GearLoad(
            channel=channel,
            unit=result.unit(channel),
            mean=swing.mean,
            alternating=swing.peak,
            least=least,
            ratio=np.where(loaded, swing.peak / np.where(loaded, mean, 1.0), np.where(swing.peak > 0, np.inf, 0.0)),
            hammer=(least <= 0) & (swing.peak > 0),
            exact=swing.exact,
        )
    return HammerResult(result.model, result.speeds, found)
