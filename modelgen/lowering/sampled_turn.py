"""What varies with time only, over one turn of the clocks, sampled once for the parameters that it depends on.

Part of ``lowering``, below ``mean_model``; the scales of the states use it too.
Sampling is their dearest part; a sweep of other parameters does it once, and none repeats what it does not need.
"""

from __future__ import annotations

import functools
from collections.abc import Callable

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
KEPT = 16  # sets of parameters


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
