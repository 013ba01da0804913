"""The order conditions of Runge-Kutta methods, one for each rooted tree: what a tableau must meet before it is believed.

Part of ``lowering``, beside ``tableau``. Source: Butcher's theory as in Hairer, Norsett and Wanner, Solving Ordinary Differential
Equations I, II.2: a method is of order p if and only if sum_i b_i Phi_i(tree) = 1/gamma(tree) for all trees with up to p nodes.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

import numpy as np

from modelgen.errors import LoweringError
from modelgen.lowering.tableau import Tableau

DIGITS = 1e-13
UNIT = 10**40

Tree = tuple[Any, ...]  # the trees on its root, in order


@functools.cache
def rooted_trees(size: int) -> tuple[Tree, ...]:
    """All rooted trees with so many nodes.

    >>> [len(rooted_trees(size)) for size in range(1, 9)]
    [1, 1, 2, 4, 9, 20, 48, 115]
    """
    return tuple(_forests(size - 1, size - 1))


def _forests(nodes: int, largest: int) -> Iterator[Tree]:
    """Multisets of trees with so many nodes in all, none larger than ``largest``."""
    if nodes == 0:
        yield ()
    for size in range(min(nodes, largest), 0, -1):
        for count in range(1, nodes // size + 1):
            for chosen in itertools.combinations_with_replacement(rooted_trees(size), count):
                for rest in _forests(nodes - count * size, size - 1):
                    yield (*chosen, *rest)


def nodes_of(tree: Tree) -> int:
    """Number of nodes of a tree."""
    return 1 + sum(nodes_of(branch) for branch in tree)


def density(tree: Tree) -> int:
    """gamma: the product over all nodes of the numbers of nodes at and above them.

    >>> density(((), ((),)))
    8
    """
    product = nodes_of(tree)
    for branch in tree:
        product *= density(branch)
    return product


def check_orders(method: Tableau) -> None:
    """Raises LoweringError for the first condition that the weights, the error's or the dense output's, do not meet to 1e-13."""
    size = len(method.rows)

    def padded(weights: Any) -> np.ndarray:
        """Numbers with 40 digits behind the point, as whole numbers: doubles would lose what large coefficients cancel."""
        return np.array([round(entry * UNIT) for entry in weights] + [0] * (size - len(weights)), dtype=object)

    matrix = np.array([padded(row) for row in method.rows])

    @functools.cache
    def elementary(tree: Tree) -> Any:
        """Phi_i(tree) at every stage."""
        product = padded([1] * size)
        for branch in tree:
            product = product * (matrix @ elementary(branch) // UNIT) // UNIT
        return product

    # Each: what it is, its weights, the order it claims, and what stands for 1 in 1/gamma at a tree of so many nodes.
    wanted: list[tuple[str, np.ndarray, int, Callable[[int], float]]] = [("b", padded(method.b), method.order, lambda nodes: 1.0)]
    for index, (row, order) in enumerate(zip(method.errors, method.error_orders, strict=True)):
        wanted.append((f"errors, row {index}", padded(row), order, lambda nodes: 0.0))
    powers = [padded(column) for column in zip(*method.dense, strict=True)]
    for m, weights in enumerate(powers, start=1):  # y(t + theta h) has theta^nodes/gamma, a condition for each power of theta
        wanted.append((f"dense output, theta^{m}", weights, method.dense_order, functools.partial(lambda m, n: float(m == n), m)))
    for name, weights, order, one in wanted:
        for nodes in range(1, order + 1):
            for tree in rooted_trees(nodes):
                exact = one(nodes) / density(tree)
                found = float(Fraction(weights @ elementary(tree), UNIT**2))
                if not abs(found - exact) <= DIGITS:
                    problem = f"{name}: the condition of order {nodes} for the tree {tree} gives {found:.17g}, not {exact:.17g}"
                    raise LoweringError(f"method {method.name!r}", problem, "a coefficient is wrong, or the order is")
