"""How many nodes a mode has: the places of the train that stand still while the others vibrate.

Below ``modal``. Along every element that has stiffness, the angle referred to the reference shaft passes through zero where its
two ends swing against each other; an inertia that stands still itself between neighbors of both signs counts once. The modes of
a train without branches have 1, 2, 3, ... nodes, as the trade names them.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from modelgen.lowering import Compiled

Array = NDArray[np.float64]
STILL = 1e-13  # of the largest angle of a mode


def node_counts(model: Compiled, referred: Array, potential: Array) -> NDArray[np.intp]:
    """Nodes of each mode (modes,) of ``referred`` angles (nodes, modes); ``potential`` (elements, modes): shares of energy."""
    elastic = np.any(potential != 0, axis=1)
    joined = [list(each.nodes.values()) for each, has in zip(model.equations.instances, elastic, strict=True) if has]
    edges = np.array([pair for nodes in joined for pair in pairwise(nodes)], dtype=np.intp).reshape(-1, 2)
    referred = np.nan_to_num(referred)  # what stands still in the mean has no referred angle
    sign = np.where(np.abs(referred) > STILL * np.abs(referred).max(axis=0, initial=0.0), np.sign(referred), 0.0)
    first, second = sign[edges[:, 0]], sign[edges[:, 1]]
    counts = np.sum(first * second < 0, axis=0)
    beside = np.zeros((2, *sign.shape), dtype=bool)  # a neighbor that swings ahead, one that swings back
    for here, there in ((edges[:, 0], second), (edges[:, 1], first)):
        np.logical_or.at(beside[0], here, there > 0)
        np.logical_or.at(beside[1], here, there < 0)
    return np.asarray(counts + np.sum((sign == 0) & beside[0] & beside[1], axis=0), dtype=np.intp)
