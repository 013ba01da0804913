"""The points of a sweep: a grid, a list, random or Sobol' points over parameters by name.

Part of ``sweeps``. Every point has a number, its row in ``values``; a grid runs through its last parameter first. Random points
come from NumPy's PCG64, Sobol' points from SciPy's scrambled sequence.
Source: I. M. Sobol', USSR Comput. Math. Math. Phys. 7 (1967) 86; A. B. Owen, J. Complexity 14 (1998) 466 (scrambling).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modelgen.errors import CaseError, ModelgenError, nearest
from modelgen.lowering import Compiled
from modelgen.units import read_quantity

Array = NDArray[np.float64]
SAMPLINGS = ("grid", "list", "random", "sobol")
MOST_POINTS = 100_000_000
ROW = re.compile(r"(.+)\[\d+\]")


@dataclass(frozen=True, eq=False)
class Points:
    """``values`` (points, names) in SI, with the ``units`` of the names; ``axes``: the values of each name on a grid, else empty.

    ``seed``: of random and Sobol' points.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    axes: tuple[Array, ...]
    sampling: str
    seed: int | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        """One length per name on a grid, else the number of points."""
        return tuple(len(axis) for axis in self.axes) or (len(self.values),)

    def __len__(self) -> int:
        return len(self.values)


def points_of(
    model: Compiled,
    over: Mapping[str, Any],
    sampling: str = "grid",
    count: int | None = None,
    seed: int = 0,
    most: int = MOST_POINTS,
) -> Points:
    """The points over parameters by name.

    ``grid``: all combinations of the values of each name. ``list``: the first values of all names, then the second ones, and so
    on. ``random``, ``sobol``: ``count`` points between the two values of each name. Values are numbers in SI or texts with units.
    Raises NamingError for an unknown name, CaseError for values that cannot be, ModelError for unlawful ones.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble, lower
    >>> model = lower(assemble(Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])))
    >>> points_of(model, {"shaft.stiffness": ["10 kN*m/rad", 2e4], "load.inertia": [1, 2, 3]}).values[:4].tolist()
    [[10000.0, 1.0], [10000.0, 2.0], [10000.0, 3.0], [20000.0, 1.0]]
    """
    if sampling not in SAMPLINGS:
        raise CaseError("sweep, sampling", f"is {sampling!r}", nearest(str(sampling), SAMPLINGS))
    if not isinstance(over, Mapping) or not over:
        raise CaseError("sweep, over", f"is {over!r:.60}", 'give values by name, such as {"zeta": [0.01, 0.02]}')
    names = tuple(over)
    for name in names:
        if not isinstance(name, str):
            raise CaseError("sweep, over", f"names {name!r:.60}", "give values by the names of parameters")
    units = tuple(_unit(model, name) for name in names)
    columns = [_numbers(model, name, unit, over[name]) for name, unit in zip(names, units, strict=True)]
    spread = sampling in ("random", "sobol")
    if count is not None and not spread:
        raise CaseError("sweep, count", f"is given for a {sampling}", "leave it out, or take random or sobol points")
    sizes = {name: len(column) for name, column in zip(names, columns, strict=True)}
    if sampling == "grid":
        total = math.prod(sizes.values())
    elif sampling == "list":
        if len(set(sizes.values())) > 1:
            raise CaseError("sweep, over", f"has {sizes} values", "a list needs as many of each name")
        total = next(iter(sizes.values()))
    else:
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            raise CaseError("sweep, count", f"is {count!r}", "give the number of points")
        if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
            raise CaseError("sweep, seed", f"is {seed!r}", "give a whole number from 0 up")
        total = count
    if total > most:
        raise CaseError("sweep", f"has {total} points; memory holds the results of {most}", "take fewer values, or collect less")
    if sampling == "grid":
        mesh = np.meshgrid(*columns, indexing="ij")
        return Points(names, units, np.stack([each.ravel() for each in mesh], axis=1), tuple(columns), sampling)
    if sampling == "list":
        return Points(names, units, np.stack(columns, axis=1), (), sampling)
    low, high = _bounds(names, columns)
    make = _sobol if sampling == "sobol" else _random
    return Points(names, units, low + (high - low) * make(total, len(names), seed), (), sampling, seed)


def _unit(model: Compiled, name: str) -> str:
    """The unit of a parameter, or of a row of a series. Raises NamingError for one that is not there."""
    return model.parameters.unit_of_number(name, "sweep over")


def _numbers(model: Compiled, name: str, unit: str, given: Any) -> Array:
    """The values of one name in SI, finite and within the limits of the parameter."""
    where = f"sweep over {name!r}"
    if isinstance(given, (str, int, float, np.number)) or not isinstance(given, Iterable) or getattr(given, "ndim", 1) == 0:
        given = [given]
    try:
        numbers = np.array([read_quantity(v, unit, where) if isinstance(v, str) else float(v) for v in given], dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise CaseError(where, f"holds {given!r:.60}", f"give numbers in {unit} or texts with units") from None
    if not numbers.size:
        raise CaseError(where, "has no values", "give at least one")
    if (bad := np.flatnonzero(~np.isfinite(numbers))).size:
        raise CaseError(where, f"value {bad[0] + 1} is {numbers[bad[0]]}", "give finite numbers")
    for value in (float(numbers.min()), float(numbers.max())):
        try:
            model.parameters.unbalanced({name: value})
        except ModelgenError as error:
            # What goes wrong further down concerns one point, and ends there as its outcome.
            if error.where == f"parameter {name!r}":
                raise
    return numbers


def _bounds(names: tuple[str, ...], columns: list[Array]) -> tuple[Array, Array]:
    for name, column in zip(names, columns, strict=True):
        if len(column) != 2 or not column[0] < column[1]:
            raise CaseError(f"sweep over {name!r}", f"goes from {column.tolist()}", "give the lowest and the highest value")
    return np.array([column[0] for column in columns]), np.array([column[1] for column in columns])


def _random(count: int, names: int, seed: int) -> Array:
    return np.random.default_rng(seed).random((count, names))


def _sobol(count: int, names: int, seed: int) -> Array:
    try:
        from scipy.stats import qmc
    except ImportError:
        raise CaseError("sweep, sampling", "'sobol' needs SciPy", "pip install scipy, or take random") from None
    sequence = qmc.Sobol(names, scramble=True, seed=seed)
    # A whole power of two keeps the balance of the sequence; what is too many is left out.
    return np.asarray(sequence.random_base2(max(0, (count - 1).bit_length())))[:count]
