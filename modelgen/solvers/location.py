"""Where in a step a guard passes zero, and where it only touches it: brackets closed to the last digits of time.

Part of ``solvers``, between ``root_counting`` and ``events``. A bracket keeps a point on the old side and one on the new; the
event is at the new one, so that what holds after it finds itself on its lawful side. The bracket is closed by ``close_in``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from modelgen.solvers.root_counting import RootCounting, close_in

NONE, EXCUSED = math.nan, math.inf
"""Where a guard came near zero: nowhere, or at an event or a start, where that is no touch; else it is a time."""


class Passing:
    """The walk of one guard over the places of a step: its passings of zero and its touches.

    ``sign``: the side that the guard has, 0 for one that starts at zero: the first side that it takes is no passing. ``graze``:
    the time at which it came near zero since it was last clear of it.
    """

    def __init__(self, counting: RootCounting, sign: float, graze: float) -> None:
        self.counting, self.sign, self.graze = counting, sign, graze

    def walk(self, t: float, h: float) -> Iterator[tuple[float, int]]:
        """The places (fractions of the step) where the guard passes zero, with its sign after each; 0 where it touches zero."""
        places = self.counting.find()
        before, closest = places[0], math.inf
        for place in places[1:]:
            clear = abs(place.value) > self.counting.near
            new = math.copysign(1.0, place.value) if abs(place.value) > place.rounding else 0.0
            # Right after its event a guard stands a little beyond zero: its way back is none, its return from there is.
            if self.sign * new < 0 and (place.heading or place.value - before.value) * new > 0:
                bracket = before.theta, place.theta, before.value, place.value
                yield close_in(self.counting.value, *bracket, self.counting.width), int(new)
                self.sign, self.graze = new, EXCUSED  # until it is clear of zero
            elif self.sign == 0:
                self.sign = new
            if clear:
                if self.graze < EXCUSED and self.sign == new:
                    yield (self.graze - t) / h, 0
                self.graze, closest = NONE, math.inf
            elif self.graze != EXCUSED and abs(place.value) < closest:
                self.graze, closest = t + place.theta * h, abs(place.value)
            before = place
