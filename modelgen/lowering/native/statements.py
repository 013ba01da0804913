"""The values of a stage as statements of bounded size, and an order in which those of one shape stand together.

Part of the compiler, between ``stages`` and ``looped``. A statement is a tree of operations whose inner values nobody else takes,
down to its leaves: inputs, numbers, values of earlier stages and of other statements. Two statements have one shape if they
differ in their leaves' places only. The order is that of list scheduling (Kahn's algorithm), one shape at a time.
"""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import casadi as ca

from modelgen.lowering.native.operations import COMMUTATIVE
from modelgen.lowering.native.stages import Stages

LARGEST = 64  # operations in one statement, about; a longer sum becomes several statements that take one another

Operation = tuple[int, tuple[int, ...]]  # a value and its operands, in an order that is the same for all statements of its shape


class Statement(NamedTuple):
    """What is computed in one piece: ``inner`` from ``leaves``; the last inner value (or the only leaf) is what it gives.

    ``kept``: the value that other statements take, or the sine and cosine of a clock, whose frequency is the only leaf (where
    nobody takes one, a negative number). ``result``: else, the row of the results that it writes.
    """

    shape: int
    inner: tuple[Operation, ...]
    leaves: tuple[int, ...]
    kept: tuple[int, ...]
    result: int | None

    @property
    def is_clock(self) -> bool:
        """Whether it gives the sine and cosine of frequency times t."""
        return len(self.kept) == 2


def statements_of(stages: Stages, values: Sequence[int], results: Sequence[int | None]) -> list[Statement]:
    """The statements that compute ``values`` (of one stage, in order) as far as ``results`` need them, and write these."""
    trees = _Trees(stages, values, results)
    return [*trees.kept(), *(trees.statement(value, row) for row, value in enumerate(results) if value is not None)]


class _Trees:
    """Which value belongs to which statement; a result's statement is called -1 - row, any other one as its value."""

    def __init__(self, stages: Stages, values: Sequence[int], results: Sequence[int | None]) -> None:
        self.stages, self.nodes = stages, stages.nodes
        self.computed = [value for value in values if not isinstance(self.nodes[value].operation, str)]
        self.clocks = {value: of for value in self.computed if (of := stages.clock_frequency(value)) is not None}
        self.inside = set(self.computed)
        self.shapes: dict[object, int] = {}
        self.owner = self._owners(results, set())
        if cut := self._too_large():
            self.owner = self._owners(results, cut)
        self.computed = [value for value in self.computed if value in self.owner]
        self.shape_of: dict[int, int] = {}
        self.operands: dict[int, tuple[int, ...]] = {}
        for value in self.computed:
            self._compare(value)

    def kept(self) -> Iterator[Statement]:
        """The statements of values that others take."""
        pairs: dict[int, list[int]] = {}
        for value in self.computed:
            if (frequency := self.clocks.get(value)) is not None:
                pairs.setdefault(frequency, [-1 - 2 * frequency, -2 - 2 * frequency])[
                    self.nodes[value].operation != ca.OP_SIN
                ] = value
        for frequency, pair in pairs.items():
            yield Statement(self._shape(("clock", self._kind(frequency))), (), (frequency,), tuple(pair), None)
        for value in self.computed:
            if self.owner[value] == value and value not in self.clocks:
                yield self.statement(value)

    def statement(self, value: int, row: int | None = None) -> Statement:
        """The statement of a kept value, or of a result."""
        owner = value if row is None else -1 - row
        inner: list[Operation] = []
        leaves: list[int] = []
        places: dict[int, int] = {}
        listing: list[object] = [row is None]

        def visit(each: int) -> None:
            if self.owner.get(each) == owner:
                for operand in self.operands[each]:
                    if operand not in places:
                        visit(operand)
                listing.append((self.nodes[each].operation, *(places[operand] for operand in self.operands[each])))
                inner.append((each, self.operands[each]))
            else:
                listing.append(self._kind(each))
                leaves.append(each)
            places[each] = len(places)

        visit(value)
        return Statement(self._shape(tuple(listing)), tuple(inner), tuple(leaves), (value,) if row is None else (), row)

    def _owners(self, results: Sequence[int | None], cut: set[int]) -> dict[int, int]:
        """The statement of each value that is needed, last value first: that of all who take it, if they are in one."""
        taker: dict[int, int | None] = {}  # None: several statements
        for row, value in enumerate(results):
            if value is None:
                continue
            taker[value] = None if value in taker else -1 - row
        owner: dict[int, int] = {}
        for value in reversed(self.computed):
            if value not in taker:
                continue
            only = taker[value]
            owner[value] = mine = value if only is None or value in cut or value in self.clocks else only
            for operand in self._operands(value):
                if taker.setdefault(operand, mine) != mine:
                    taker[operand] = None
        return owner

    def _too_large(self) -> set[int]:
        """Values up to which a statement has become too large, so that they must be kept."""
        sizes: dict[int, int] = {}
        cut: set[int] = set()
        for value, owner in reversed(self.owner.items()):
            sizes[value] = 1 + sum(sizes.get(operand, 0) for operand in set(self._operands(value)))
            if sizes[value] > LARGEST:
                cut.add(value)
            if owner == value or value in cut:
                sizes[value] = 0
        return cut

    def _operands(self, value: int) -> tuple[int, ...]:
        return () if value in self.clocks else self.nodes[value].operands

    def _kind(self, leaf: int) -> str:
        """Where a leaf is found: another statement's value, a number, an input, or an earlier stage."""
        node = self.nodes[leaf]
        return "kept" if leaf in self.inside else node.operation if isinstance(node.operation, str) else node.level.name

    def _compare(self, value: int) -> None:
        """The operands in an order by shape where their order does not matter: that of the graph is by age."""
        operation, operands = self.nodes[value].operation, self._operands(value)
        shapes = [
            self.shape_of[each] if each in self.inside and self.owner[each] != each else self._shape(self._kind(each))
            for each in operands
        ]
        if operation in COMMUTATIVE and shapes != sorted(shapes):
            operands, shapes = operands[::-1], shapes[::-1]
        self.operands[value] = operands
        self.shape_of[value] = self._shape((operation, *shapes))

    def _shape(self, key: object) -> int:
        return self.shapes.setdefault(key, len(self.shapes))


def scheduled(statements: Sequence[Statement]) -> list[list[Statement]]:
    """The statements in an order in which they can be computed, in runs of one shape that are as long as possible.

    Taken next is a shape of which all are ready, else the one of which most are; what becomes ready by its own shape joins.
    """
    producer = {value: number for number, each in enumerate(statements) for value in each.kept}
    takers: defaultdict[int, list[int]] = defaultdict(list)
    missing: Counter[int] = Counter()
    for number, each in enumerate(statements):
        for source in {producer[leaf] for leaf in each.leaves if leaf in producer}:
            takers[source].append(number)
            missing[number] += 1
    left = Counter(each.shape for each in statements)
    ready: defaultdict[int, list[int]] = defaultdict(list)
    waiting: list[tuple[bool, int, int]] = []  # a heap: whether incomplete, how many are ready (negative), shape

    def release(numbers: Iterable[int]) -> None:
        for number in numbers:
            shape = statements[number].shape
            ready[shape].append(number)
            heapq.heappush(waiting, (len(ready[shape]) < left[shape], -len(ready[shape]), shape))

    release(number for number in range(len(statements)) if not missing[number])
    runs = []
    while waiting:
        _, count, shape = heapq.heappop(waiting)
        if len(ready[shape]) != -count:
            continue  # more have become ready since, or all are taken
        run: list[Statement] = []
        while wave := sorted(ready.pop(shape, ())):
            run += (statements[number] for number in wave)
            left[shape] -= len(wave)
            for number in wave:
                missing.subtract(takers[number])
                release(each for each in takers[number] if not missing[each])
        runs.append(run)
    return runs
