"""Values of the time stage that are sums of waves, in groups of one bandwidth: a solver may follow them by polynomials in time.

Part of the compiler, between ``collection`` and ``stages``. A sine or cosine of frequency times time is a wave, and so is what
sums and products make of waves; the highest multiple of each frequency in it bounds how fast it can change, whatever its
amplitudes are. A group is worth a polynomial where its waves take much more work than reading the polynomial off does.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from modelgen.lowering.native.collection import live
from modelgen.lowering.native.graph import Graph, Level, Node

LEAST_WORK = 32  # values that a group must compute for each of its results
MOST_GROUPS = 12  # each is a function of its own; a model with more of them keeps the largest

Spread = dict[int, int]  # frequency -> its highest multiple


@dataclass(frozen=True)
class WaveGroup:
    """Some values of the time stage over the same frequencies.

    ``values``: what they take, in order. ``results``: those that others read. ``bandwidth``: the value (of the parameter stage)
    that no angular frequency in them exceeds [rad/s].
    """

    values: tuple[int, ...]
    results: tuple[int, ...]
    bandwidth: int


def wave_groups(graph: Graph) -> tuple[WaveGroup, ...]:
    """The groups of a graph that are worth a polynomial; their bandwidths are added to it.

    >>> t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p", 21)
    >>> torque = sum(p[k] * ca.cos(k * p[0] * t) for k in range(1, 21))
    >>> [len(group.results) for group in wave_groups(Graph.of(ca.Function("f", [t, x, p], [torque - x])))]
    [1]
    """
    order = live(graph)
    spreads: dict[int, Spread] = {}
    for index in order:
        if graph.nodes[index].level is Level.TIME and (spread := _spread(graph.nodes, index, spreads)) is not None:
            spreads[index] = spread
    read = {each for each in graph.outputs if each in spreads}
    for index in order:
        if index not in spreads:
            read.update(each for each in graph.nodes[index].operands if each in spreads)
    by_frequency: dict[frozenset[int], list[int]] = {}
    for index in sorted(read):
        by_frequency.setdefault(frozenset(spreads[index]), []).append(index)
    found = [(results, _needed(graph.nodes, results, spreads)) for results in by_frequency.values()]
    found = [(results, values) for results, values in found if len(values) >= LEAST_WORK * len(results)]
    found = sorted(sorted(found, key=lambda each: -len(each[1]))[:MOST_GROUPS])
    bandwidths = [_bandwidth(graph, [spreads[each] for each in results]) for results, _ in found]
    return tuple(
        WaveGroup(tuple(values), tuple(results), bandwidth)
        for (results, values), bandwidth in zip(found, bandwidths, strict=True)
    )


def clock_frequency(nodes: tuple[Node, ...] | list[Node], index: int) -> int | None:
    """The value of the frequency, where a value is sin or cos (frequency times t)."""
    node = nodes[index]
    if node.operation not in (ca.OP_SIN, ca.OP_COS):
        return None
    product = nodes[node.operands[0]]
    if product.operation == ca.OP_MUL:
        for time, frequency in (product.operands, product.operands[::-1]):
            if nodes[time].operation == "t" and nodes[frequency].level < Level.TIME:
                return frequency
    return None


def _spread(nodes: list[Node], index: int, spreads: dict[int, Spread]) -> Spread | None:
    """The frequencies in a value with their highest multiples; None where it is no sum of products of waves."""
    if (frequency := clock_frequency(nodes, index)) is not None:
        return {frequency: 1}
    node, product = nodes[index], False
    if node.operation in (ca.OP_MUL, ca.OP_SQ):
        product = True
    elif node.operation not in (ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE, ca.OP_ASSIGN):
        return None
    total: Spread = {}
    for operand in node.operands * (2 if node.operation == ca.OP_SQ else 1):
        if nodes[operand].level is Level.TIME and operand not in spreads:
            return None
        for frequency, multiple in spreads.get(operand, {}).items():
            before = total.get(frequency, 0)
            total[frequency] = before + multiple if product else max(before, multiple)
    return total


def _needed(nodes: list[Node], results: list[int], spreads: dict[int, Spread]) -> list[int]:
    found: set[int] = set()
    waiting = list(results)
    while waiting:
        index = waiting.pop()
        if index in spreads and index not in found:
            found.add(index)
            waiting += nodes[index].operands
    return sorted(found)


def _bandwidth(graph: Graph, spreads: list[Spread]) -> int:
    """The largest sum of multiples of frequencies, each counted positive."""
    most: int | None = None
    for terms in sorted({tuple(sorted(spread.items())) for spread in spreads}):
        total: int | None = None
        for frequency, multiple in terms:
            term = graph.make(ca.OP_MUL, graph.constant(float(multiple)), graph.make(ca.OP_FABS, frequency))
            total = term if total is None else graph.make(ca.OP_ADD, total, term)
        assert total is not None
        most = total if most is None else graph.make(ca.OP_FMAX, most, total)
    assert most is not None
    return most
