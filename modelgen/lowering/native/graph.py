"""The instructions of an SX function as a graph of distinct values, each with what it depends on.

Part of the compiler, first step towards C. CasADi hands out the instruction list of an SX function over a few work registers;
here every value is written once, equal values are one (value numbering), and what depends on parameters only is told from what
depends on time and on the state. Two rewritings move work to the earlier stage; both change results by rounding only: a / b with
b of an earlier stage becomes a (1/b), and p (q a) becomes (p q) a.
"""

from __future__ import annotations

import enum
from typing import NamedTuple

import casadi as ca

from modelgen.errors import LoweringError
from modelgen.lowering.instructions import instructions
from modelgen.lowering.native.operations import COMMUTATIVE, OPERATIONS

INPUTS = {3: ("t", "x", "p"), 4: ("t", "x", "v", "p")}  # v: the rates of the state, where a function is told them


class Level(enum.IntEnum):
    """What a value depends on at most; each stage is computed less often than the next."""

    CONSTANT = 0
    PARAMETER = 1
    TIME = 2
    STATE = 3


_LEVEL_OF_INPUT = {"t": Level.TIME, "x": Level.STATE, "v": Level.STATE, "p": Level.PARAMETER}


class Node(NamedTuple):
    """One value: its operation (a CasADi code, "constant", or an input's name), operands, and the number or row it stands for."""

    operation: int | str
    operands: tuple[int, ...]
    value: float | int
    level: Level


class Graph:
    """Distinct values in an order in which they can be computed, and which of them are the outputs.

    >>> t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p", 2)
    >>> graph = Graph.of(ca.Function("f", [t, x, p], [p[0] * p[1] * ca.sin(p[0] * t) - x / p[1]]))
    >>> [level.name for level in Level if any(node.level is level for node in graph.nodes)]
    ['CONSTANT', 'PARAMETER', 'TIME', 'STATE']
    """

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self.outputs: list[int] = []
        self._known: dict[tuple[object, ...], int] = {}

    @classmethod
    def of(cls, function: ca.Function) -> Graph:
        """The graph of an SX function (t, x, p) or (t, x, v, p) -> column. Raises LoweringError for an operation without C."""
        if not function.is_a("SXFunction"):
            raise LoweringError("native code", "the right-hand side is no SX function", "expand() it first")
        graph, inputs = cls(), INPUTS[function.n_in()]
        work: dict[int, int] = {}
        graph.outputs = [graph.constant(0.0)] * int(function.numel_out(0))
        for code, source, target, number in instructions(function):
            if code == ca.OP_CONST:
                work[target[0]] = graph.constant(number)
            elif code == ca.OP_INPUT:
                work[target[0]] = graph.input(inputs[source[0]], source[1])
            elif code == ca.OP_OUTPUT:
                graph.outputs[target[1]] = work[source[0]]
            elif code not in OPERATIONS:
                raise LoweringError(
                    "native code", f"operation {operation_name(code)} has no C", "run this model on CasADi's virtual machine"
                )
            else:
                work[target[0]] = graph.make(code, *(work[register] for register in source))
        return graph

    def constant(self, value: float) -> int:
        """The value of a number; zeros of both signs and NaN are told apart."""
        return self._add(("constant", float(value).hex()), Node("constant", (), float(value), Level.CONSTANT))

    def input(self, name: str, row: int) -> int:
        """The value of an entry of t, x, v or p."""
        return self._add((name, row), Node(name, (), row, _LEVEL_OF_INPUT[name]))

    def make(self, code: int, *operands: int) -> int:
        """The value of an operation."""
        levels = [self.nodes[each].level for each in operands]
        if code == ca.OP_DIV and Level.CONSTANT < levels[0] > levels[1]:
            return self.make(ca.OP_MUL, operands[0], self.make(ca.OP_INV, operands[1]))
        if code == ca.OP_MUL and (moved := self._regrouped(*operands)) is not None:
            return moved
        if code == ca.OP_NEG and (inner := self.nodes[operands[0]]).operation == ca.OP_SUB:
            return self.make(ca.OP_SUB, inner.operands[1], inner.operands[0])
        if code in COMMUTATIVE:
            operands = tuple(sorted(operands))
        key = (code, *operands)
        return self._add(key, Node(code, operands, 0, max(Level.PARAMETER, *levels)))

    def _regrouped(self, one: int, other: int) -> int | None:
        """p (q a) as (p q) a where p and q come from an earlier stage than a."""
        for factor, product in ((one, other), (other, one)):
            outer, inner = self.nodes[factor].level, self.nodes[product]
            if inner.operation == ca.OP_MUL and inner.level > Level.PARAMETER:
                for early, late in (inner.operands, inner.operands[::-1]):
                    if self.nodes[late].level is inner.level and max(outer, self.nodes[early].level) < inner.level:
                        return self.make(ca.OP_MUL, self.make(ca.OP_MUL, factor, early), late)
        return None

    def _add(self, key: tuple[object, ...], node: Node) -> int:
        if key not in self._known:
            self._known[key] = len(self.nodes)
            self.nodes.append(node)
        return self._known[key]


def operation_name(code: int) -> str:
    """CasADi's name of an operation code."""
    found = [name for name in dir(ca) if name.startswith("OP_") and getattr(ca, name) == code]
    return found[0] if found else f"number {code}"
