"""The table of a sweep while it fills: a place for every point, taken by batches in whatever order they come.

Part of ``sweeps``. A batch that comes twice says the same twice.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.analysis.sweeps.collect import Collection
from modelgen.analysis.sweeps.points import Points
from modelgen.analysis.sweeps.result import SweepResult
from modelgen.analysis.sweeps.shard import Batch
from modelgen.errors import CaseError
from modelgen.solvers.case import Case


class Record:
    """``numbers`` (points, width) with outcome, message and key of every point; ``left``: how many are missing."""

    def __init__(self, points: int, width: int) -> None:
        self.numbers = np.full((points, width), np.nan)
        self.done = np.zeros(points, dtype=bool)
        self.outcomes, self.messages, self.keys = [""] * points, [""] * points, [""] * points

    @property
    def left(self) -> int:
        """Points that are missing."""
        return int(self.done.size - np.count_nonzero(self.done))

    def missing(self) -> NDArray[np.int64]:
        """Numbers of the points that are missing."""
        return np.flatnonzero(~self.done)

    def put(self, batch: Batch) -> None:
        """Take a batch in. Raises CaseError for one of another shape."""
        points = batch.points
        lawful = len(points) and 0 <= points.min() <= points.max() < len(self.done)
        if not lawful or batch.numbers.shape[1] != self.numbers.shape[1]:
            raise CaseError("sweep", "a batch does not fit this sweep", "start over with fresh (--fresh)")
        self.numbers[points] = batch.numbers
        self.done[points] = True
        for point, outcome, message, key in zip(points.tolist(), batch.outcomes, batch.messages, batch.keys, strict=True):
            self.outcomes[point], self.messages[point], self.keys[point] = outcome, message, key

    def result(
        self, case: Case, engine: Mapping[str, Any], points: Points, wanted: Collection, notes: tuple[str, ...] = ()
    ) -> SweepResult:
        """The answer, when no point is missing."""
        assert not self.left
        first, samples = len(wanted.names), wanted.samples
        starts = {name: first + k * samples for k, name in enumerate(wanted.series)}
        return SweepResult(
            model=case.model.name,
            sampling=points.sampling,
            names=points.names,
            units=points.units,
            values=points.values,
            axes=points.axes,
            collected=wanted.names,
            collected_units=wanted.units,
            table=self.numbers[:, :first],
            series={name: self.numbers[:, start : start + samples] for name, start in starts.items()},
            series_units=wanted.series_units,
            times=case.times(),
            outcomes=tuple(self.outcomes),
            messages=tuple(self.messages),
            keys=tuple(self.keys),
            engine=dict(engine),
            notes=notes,
        )
