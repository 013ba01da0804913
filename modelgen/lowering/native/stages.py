"""The three stages of a right-hand side: what parameters fix, what time adds, what the state needs.

Part of the compiler. Each stage is a list of values to compute in order; ``parameter_values`` and ``time_values`` are what the
later stages take over. A model without a stage has an empty list there and pays nothing for it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import casadi as ca

from modelgen.lowering.native.collection import collected, live
from modelgen.lowering.native.graph import Graph, Level, Node
from modelgen.lowering.native.waves import WaveGroup, clock_frequency, wave_groups


@dataclass(frozen=True)
class Stages:
    """A right-hand side taken apart by dependence.

    ``nodes``: all values. ``parameter``, ``time``, ``state``: values (by number) that each stage computes, in order.
    ``parameter_values``, ``time_values``: those of them that later stages take over, in the order of the hand-over.
    ``outputs``: value of each rate. ``waves``: groups of time values that are sums of waves, which ``time`` takes as given.

    >>> t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p")
    >>> stages = Stages.of(ca.Function("f", [t, x, p], [ca.cos(p * t) - x]))
    >>> len(stages.time_values), len(stages.state), stages.sizes
    (1, 2, (1, 1))
    """

    nodes: tuple[Node, ...]
    parameter: tuple[int, ...]
    time: tuple[int, ...]
    state: tuple[int, ...]
    parameter_values: tuple[int, ...]
    time_values: tuple[int, ...]
    outputs: tuple[int, ...]
    sizes: tuple[int, int]
    waves: tuple[WaveGroup, ...] = ()

    @classmethod
    def of(cls, function: ca.Function, with_waves: bool = False) -> Stages:
        """The stages of an SX function (t, x, p) -> one dense column. Raises LoweringError for an operation that has no C.

        ``with_waves``: groups of waves are taken out of the time stage, for a solver that follows them by polynomials.
        """
        graph = collected(Graph.of(function))
        waves = wave_groups(graph) if with_waves else ()
        bandwidths = {group.bandwidth for group in waves}
        order, nodes = live(graph, bandwidths), graph.nodes
        level = {index: nodes[index].level for index in order}
        after: dict[Level, set[int]] = {Level.PARAMETER: set(), Level.TIME: set()}
        for index in order:
            for operand in nodes[index].operands:
                if level[operand] in after and level[operand] < level[index]:
                    after[level[operand]].add(operand)
        for index in graph.outputs:  # rates that need no state are handed on to the last stage all the same
            if level[index] in after:
                after[level[index]].add(index)
        after[Level.PARAMETER] |= bandwidths
        by_level = {each: tuple(index for index in order if level[index] is each) for each in Level}
        given = {result for group in waves for result in group.results}
        return cls(
            nodes=tuple(nodes),
            parameter=by_level[Level.PARAMETER],
            time=_needed(nodes, by_level[Level.TIME], set(graph.outputs) | after[Level.TIME], given),
            state=by_level[Level.STATE],
            parameter_values=tuple(sorted(after[Level.PARAMETER])),
            time_values=tuple(sorted(after[Level.TIME])),
            outputs=tuple(graph.outputs),
            sizes=(int(function.numel_in(1)), int(function.numel_in(function.n_in() - 1))),
            waves=waves,
        )

    @property
    def wave_values(self) -> tuple[int, ...]:
        """The results of all groups of waves, group by group."""
        return tuple(result for group in self.waves for result in group.results)

    def state_for(self, outputs: Iterable[int]) -> tuple[int, ...]:
        """The values of the state stage that some of the outputs need, in order."""
        needed = set(outputs)
        for index in reversed(self.state):
            if index in needed:
                needed.update(self.nodes[index].operands)
        return tuple(index for index in self.state if index in needed)

    def clock_frequency(self, index: int) -> int | None:
        """The frequency, where a value is the sine or cosine of frequency times time."""
        return clock_frequency(self.nodes, index)


def _needed(nodes: list[Node], time: tuple[int, ...], wanted: set[int], given: set[int]) -> tuple[int, ...]:
    """Values of the time stage that are wanted or taken by such, but for those that are given.

    A sine or cosine of frequency times t is formed from both, with all digits: the product itself is not needed then.
    """
    needed = set(wanted)
    for index in reversed(time):
        if index in given or index not in needed:
            continue
        if clock_frequency(nodes, index) is None:
            needed.update(nodes[index].operands)
        else:
            product = nodes[nodes[index].operands[0]]
            needed.update(each for each in product.operands if nodes[each].operation == "t")
    return tuple(index for index in time if index in needed and index not in given)
