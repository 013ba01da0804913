"""A CasADi function at many instants: blocks of calls with one parameter vector.

Part of the compiler, under ``compiled`` and ``switched``.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

import casadi as ca
import numpy as np

BLOCK = 256
"""Instants that are evaluated by one call."""


def sampled(function: ca.Function, columns: Sequence[np.ndarray], p: np.ndarray, rows: Sequence[int]) -> np.ndarray:
    """Rows of the function's one output, (number of rows, n), from arguments with a column per instant and p for all."""
    instants = columns[0].shape[1]
    if instants == 0 or not rows:
        return np.empty((len(rows), instants))
    # CasADi repeats p for every instant of a map, so blocks are small; the last is filled up with its own last instant.
    mapped, whole = _mapped(function, tuple(rows)), -(-instants // BLOCK) * BLOCK
    columns = [np.pad(column, ((0, 0), (0, whole - instants)), mode="edge") for column in columns]
    values = np.empty((len(rows), whole))
    for first in range(0, whole, BLOCK):
        part = slice(first, first + BLOCK)
        values[:, part] = mapped(*(column[:, part] for column in columns), p)
    return values[:, :instants]


@functools.lru_cache(maxsize=16)
def _mapped(function: ca.Function, rows: tuple[int, ...]) -> ca.Function:
    """The chosen rows of a function, over a block of instants."""
    inputs = [ca.SX.sym(f"i{k}", function.sparsity_in(k)) for k in range(function.n_in())]
    result = ca.densify(function(*inputs)[list(rows)])
    return ca.Function("channels", inputs, [result]).map(BLOCK)
