"""What varies with time only, over one turn of the clocks, and its means: sampled once for the parameters that it depends on.

Part of ``lowering``, on the functions of the mean model; the balance of loads, the operating point and the scales use it.
Sampling is their dearest part; a sweep of other parameters does it once, and none repeats what it does not need.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
KEPT = 16  # sets of parameters
SAMPLES = 2048  # of one turn of each clock: exact for Fourier rows below this order


def mean_values(mean_model: Mapping[str, ca.Function], p: Array) -> Array:
    """Means over a period of every quantity that varies with time only: as stated by its element, else by sampling."""
    stated, explicit = (np.asarray(each).ravel() for each in mean_model["means"](p))
    if explicit.all():
        return stated
    rows = np.flatnonzero(explicit == 0)
    stated[rows] = sampled_turn(mean_model["timed"], SAMPLES, tuple(rows.tolist()))(p).mean(axis=1)
    return stated


@functools.lru_cache(maxsize=16)
def sampled_turn(timed: ca.Function, samples: int, rows: tuple[int, ...] | None = None) -> Callable[[Array], Array]:
    """A function p -> values (rows, samples), read-only, of the timed quantities of these rows, by default of all."""
    clocks, t, p = (ca.SX.sym(timed.name_in(k), timed.size_in(k)) for k in range(3))
    values = timed(clocks, t, p)
    wanted = ca.Function("wanted", [clocks, t, p], [values if rows is None else values[list(rows)]], {"cse": True})
    entries = sorted(set(wanted.jac_sparsity(0, 2).get_triplet()[1]))
    some, whole = ca.SX.sym("some", len(entries)), ca.SX.zeros(p.size1())
    whole[entries] = some
    mapped = ca.Function("sampled", [clocks, t, some], [wanted(clocks, t, whole)]).map(samples)
    angles = np.tile(np.arange(samples) * (2 * np.pi / samples), (timed.size1_in(0), 1))

    @functools.lru_cache(maxsize=KEPT)
    def turn(given: bytes) -> Array:
        found = np.asarray(mapped(angles, np.zeros((1, samples)), np.frombuffer(given)))
        found.setflags(write=False)
        return found

    return lambda p: turn(p[entries].tobytes())
