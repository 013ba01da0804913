"""What is left to do of a sweep: points in batches of a fitting size, and what becomes of a batch whose worker died.

Part of ``sweeps``; knows nothing of processes or machines. A batch that dies is tried again in pieces, so that one bad point is
found out and does not take its neighbors with it. Only a point that was alone when its worker died can be at fault. It is tried
again when all else is done, one such point at a time: if then workers die with it and none without it, it is marked after the
third time. Somebody who kills workers at random gets a good point marked only by hitting it three times in a row and nothing
else in between; and as a mark is not kept in the store, the next run of the same sweep mends that too.
"""

from __future__ import annotations

import collections

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.int64]
TARGET = 2.0  # s that a batch should take: many rounds of lanes, the last of which is never full; and what a kill may cost
MOST = 4096  # points in a batch
PIECES = 8  # that a batch is cut into when its worker died
DEATHS = 3  # of workers alone with one point, after which it is marked


class Work:
    """The points that are left; ``width``: how many run side by side in one worker."""

    def __init__(self, points: Numbers, width: int, workers: int) -> None:
        self.left, self.width, self.workers = points, max(width, 1), max(workers, 1)
        self.again: collections.deque[Numbers] = collections.deque()
        self.suspects: collections.deque[int] = collections.deque()
        self.tried: int | None = None
        self.deaths: collections.Counter[int] = collections.Counter()
        self.seconds_per_point: float | None = None

    def __bool__(self) -> bool:
        return bool(len(self.left) or self.again or self.suspects)

    def take(self) -> Numbers | None:
        """The next batch; None where nothing is left, or only suspects while one of them is tried."""
        if self.again:
            return self.again.popleft()
        if len(self.left):
            batch, self.left = self.left[: self.size()], self.left[self.size() :]
            return batch
        if self.suspects and self.tried is None:
            self.tried = self.suspects.popleft()
            return np.array([self.tried], dtype=np.int64)
        return None

    def size(self) -> int:
        """Points of a batch: whole rounds of lanes, in a good time, and no more than a fair share of what is left."""
        rounds = 1
        if self.seconds_per_point is not None:
            fair = len(self.left) / (2 * self.workers)
            rounds = int(min(TARGET / max(self.seconds_per_point, 1e-9), fair, MOST) / self.width)
        return max(rounds, 1) * self.width

    def took(self, batch: Numbers, seconds: float) -> None:
        """A batch is finished after so many seconds of one worker."""
        self.seconds_per_point = seconds / max(len(batch), 1)
        if self.tried in batch:
            self.tried = None

    def died(self, batch: Numbers) -> int | None:
        """The worker of this batch died; returns a point to be marked, if it was the third time in a row with this one alone."""
        if len(batch) > 1:
            self.disturbed()
            self.again.extend(np.array_split(batch, min(PIECES, len(batch))))
            return None
        point = int(batch[0])
        if point != self.tried:
            self.disturbed()
            self.deaths[point] = 1
            self.suspects.append(point)
            return None
        self.tried = None
        self.deaths[point] += 1
        if self.deaths[point] >= DEATHS:
            return point
        self.suspects.appendleft(point)
        return None

    def returned(self, batch: Numbers) -> None:
        """A batch comes back undone, and its points have nothing to do with it."""
        self.disturbed()
        if self.tried is not None and len(batch) == 1 and int(batch[0]) == self.tried:
            self.suspects.appendleft(self.tried)
            self.tried = None
        else:
            self.again.appendleft(batch)

    def disturbed(self) -> None:
        """A worker died of something else: then the point that is tried may not be at fault either."""
        if self.tried is not None:
            self.deaths[self.tried] = 0
