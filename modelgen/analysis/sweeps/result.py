"""The answer of a sweep: what was swept, what came out, and how every point ended; as arrays, CSV or xarray.

Part of ``sweeps``. It holds data only. Numbers in CSV have as many digits as tell them apart from every other double.
"""

from __future__ import annotations

import csv
import io
import os
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError, nearest

Array = NDArray[np.float64]
GOOD = ("SUCCESS", "EVENT")


@dataclass(frozen=True, eq=False)
class SweepResult:
    """``names`` swept, with ``units``, ``values`` (points, names) and, on a grid, ``axes``; ``collected`` with
    ``collected_units`` and ``table`` (points, collected), NaN where a point failed; ``series`` (points, samples) of whole
    channels with ``series_units`` over ``times``; ``outcomes``, ``messages`` (empty where all went well) and ``keys`` (digest of
    the Case) of every point; ``engine``: what computed it; ``notes``: what was found wrong on the way, in sentences.

    ``result["coupling.torque.highest"]`` has one dimension per swept name on a grid, else one for the points.
    """

    model: str
    sampling: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    axes: tuple[Array, ...]
    collected: tuple[str, ...]
    collected_units: tuple[str, ...]
    table: Array
    series: dict[str, Array]
    series_units: tuple[str, ...]
    times: Array
    outcomes: tuple[str, ...]
    messages: tuple[str, ...]
    keys: tuple[str, ...]
    engine: dict[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.values)

    @property
    def shape(self) -> tuple[int, ...]:
        """One length per swept name on a grid, else the number of points."""
        return tuple(len(axis) for axis in self.axes) or (len(self.values),)

    @property
    def succeeded(self) -> NDArray[np.bool_]:
        """Whether each point did what was asked, in the shape of the sweep."""
        return np.array([outcome in GOOD for outcome in self.outcomes]).reshape(self.shape)

    def __getitem__(self, name: str) -> Array:
        """A collected quantity or a swept parameter in the shape of the sweep. Raises CaseError with the nearest name."""
        if name in self.series:
            return self.series[name].reshape(*self.shape, -1)
        if name in self.collected:
            return self.table[:, self.collected.index(name)].reshape(self.shape)
        if name in self.names:
            return self.values[:, self.names.index(name)].reshape(self.shape)
        known = [*self.collected, *self.series, *self.names]
        raise CaseError(f"sweep of {self.model!r}", f"no quantity {name!r}", nearest(name, known))

    def unit(self, name: str) -> str:
        """Unit of a collected quantity or a swept parameter."""
        self[name]
        every = (*self.collected, *self.series, *self.names), (*self.collected_units, *self.series_units, *self.units)
        return dict(zip(*every, strict=True))[name]

    def csv_text(self) -> str:
        """The table as CSV: number, swept values, outcome, what was collected, digest of the Case, message."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        swept = [f"{name} [{unit}]" for name, unit in zip(self.names, self.units, strict=True)]
        collected = [f"{name} [{unit}]" for name, unit in zip(self.collected, self.collected_units, strict=True)]
        writer.writerow(["point", *swept, "outcome", *collected, "case", "message"])
        for k, (values, row) in enumerate(zip(self.values, self.table, strict=True)):
            cells = ["" if each != each else repr(each) for each in row.tolist()]
            writer.writerow(
                [k, *map(repr, values.tolist()), self.outcomes[k], *cells, self.keys[k], self.messages[k]]
            )  # fmt: skip
        return text.getvalue()

    def to_csv(self, path: str | Path) -> Path:
        """Writes the table (without series)."""
        path = Path(path)
        path.write_text(self.csv_text(), encoding="utf-8", newline="")
        return path

    def to_xarray(self) -> Any:
        """An xarray.Dataset: one dimension per swept name on a grid, else ``point``; ``time`` for series; units as attributes.

        Raises CaseError without xarray (extra ``xarray``).
        """
        try:
            import xarray
        except ImportError:
            raise CaseError("sweep", "xarray is not installed", 'pip install "modelgen[xarray]"') from None
        grid = bool(self.axes)
        dims = self.names if grid else ("point",)
        units = dict(zip(self.names, self.units, strict=True))
        if grid:
            coordinates = {name: (name, axis, {"units": units[name]}) for name, axis in zip(self.names, self.axes, strict=True)}
        else:
            coordinates = {name: ("point", self[name], {"units": units[name]}) for name in self.names}
        data: dict[str, Any] = {name: (dims, self[name], {"units": self.unit(name)}) for name in self.collected}
        if self.series:
            coordinates["time"] = ("time", self.times, {"units": "s"})
            data |= {name: ((*dims, "time"), self[name], {"units": self.unit(name)}) for name in self.series}
        data["outcome"] = (dims, np.array(self.outcomes).reshape(self.shape))
        data["case"] = (dims, np.array(self.keys).reshape(self.shape))
        engine = ", ".join(f"{name} {value}" for name, value in self.engine.items())
        return xarray.Dataset(data, coordinates, {"model": self.model, "sampling": self.sampling, "engine": engine})

    def to_netcdf(self, path: str | Path) -> Path:
        """Writes ``to_xarray()`` as NetCDF. Raises CaseError without the extra ``xarray``."""
        dataset, path = self.to_xarray(), Path(path)
        unfinished = path.with_name(f".unfinished-{path.name}")
        try:
            dataset.to_netcdf(unfinished, engine="netcdf4")
            os.replace(unfinished, path)
        except (ImportError, ValueError) as error:
            raise CaseError(str(path), f"cannot be written as NetCDF: {error}", 'pip install "modelgen[xarray]"') from None
        except OSError as error:
            raise CaseError(str(path), f"cannot be written: {error.strerror or error}", "check the path and the space") from None
        finally:
            unfinished.unlink(missing_ok=True)
        return path

    def __str__(self) -> str:
        over = " x ".join(f"{name} ({len(axis)})" for name, axis in zip(self.names, self.axes, strict=False))
        what = over or f"{', '.join(self.names)} ({self.sampling} of {len(self)})"
        endings = ", ".join(f"{count} {name.lower().replace('_', ' ')}" for name, count in Counter(self.outcomes).most_common())
        rows = [f"sweep of {self.model!r} over {what}: {len(self)} points, {endings}"]
        for name, unit in zip(self.collected, self.collected_units, strict=True):
            column = self[name][np.isfinite(self[name])]
            if column.size:
                rows.append(f"  {name}: {column.min():.6g} to {column.max():.6g} {unit}")
        return "\n".join([*rows, *(f"  {note}" for note in self.notes)])

    __repr__ = __str__
