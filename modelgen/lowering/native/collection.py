"""Sums of time waves collected: each quantity of time only becomes one sum of waves with coefficients of the parameters.

Part of the compiler, between ``graph`` and ``stages``. A row of firing torques is a sum of amplitude times (cos k theta
cos phase - sin k theta sin phase); taken apart and put together again, it costs one product per wave, and the rest moves to the
parameter stage. What is used once and only in sums is expanded; what is used more often, or is long, stays a value of its own.
"""

from __future__ import annotations

from collections.abc import Iterable

import casadi as ca

from modelgen.lowering.native.graph import Graph, Level, Node

LONGEST = 128  # waves in a sum that is still expanded: without a bound, sums within sums cost more than linear time

Form = dict[int | None, int]  # new value -> its coefficient; None: what depends on parameters only


def collected(graph: Graph) -> Graph:
    """The same outputs with the sums of the time stage collected; equal but for rounding."""
    return _Collection(graph).result()


class _Collection:
    def __init__(self, graph: Graph) -> None:
        self.old, self.new = graph, Graph()
        self.one, self.minus = self.new.constant(1.0), self.new.constant(-1.0)
        self.place: dict[int, int] = {}
        self.forms: dict[int, Form] = {}
        self.readers: dict[int, list[int | None]] = {}

    def result(self) -> Graph:
        order = live(self.old)
        for index in order:
            for operand in self.old.nodes[index].operands:
                self.readers.setdefault(operand, []).append(index)
        for output in self.old.outputs:
            self.readers.setdefault(output, []).append(None)
        for index in order:
            node = self.old.nodes[index]
            if not self._is_sum(node):
                self.place[index] = self._copied(node)
                continue
            form = self._form(node)
            readers = self.readers[index]
            reader = readers[0] if len(readers) == 1 and len(form) <= LONGEST else None
            if reader is not None and self._is_sum(self.old.nodes[reader]):
                self.forms[index] = form
            else:
                self.place[index] = self._written(form)
        self.new.outputs = [self.place[output] for output in self.old.outputs]
        return self.new

    def _copied(self, node: Node) -> int:
        if node.operation == "constant":
            return self.new.constant(node.value)
        if isinstance(node.operation, str):
            return self.new.input(node.operation, int(node.value))
        return self.new.make(node.operation, *(self.place[each] for each in node.operands))

    def _is_sum(self, node: Node) -> bool:
        """Whether a value of the time stage is linear in the others of its stage."""
        if node.level is not Level.TIME:
            return False
        if node.operation == ca.OP_MUL:
            return min(self.old.nodes[each].level for each in node.operands) < Level.TIME
        return node.operation in (ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE)

    def _form(self, node: Node) -> Form:
        if node.operation == ca.OP_MUL:
            early, late = sorted(node.operands, key=lambda each: self.old.nodes[each].level)
            return self._scaled(self._of(late), self.place[early])
        if node.operation == ca.OP_NEG:
            return self._scaled(self._of(node.operands[0]), self.minus)
        if node.operation == ca.OP_TWICE:
            return self._scaled(self._of(node.operands[0]), self.new.constant(2.0))
        left, right = (self._of(each) for each in node.operands)
        if node.operation == ca.OP_SUB:
            right = self._scaled(right, self.minus)
        total = dict(left)
        for key, coefficient in right.items():
            total[key] = self.new.make(ca.OP_ADD, total[key], coefficient) if key in total else coefficient
        return total

    def _of(self, index: int) -> Form:
        if index in self.forms:
            return self.forms[index]
        late = self.old.nodes[index].level is Level.TIME
        return {self.place[index]: self.one} if late else {None: self.place[index]}

    def _scaled(self, form: Form, factor: int) -> Form:
        return {key: self._times(factor, coefficient) for key, coefficient in form.items()}

    def _times(self, factor: int, value: int) -> int:
        for one, other in ((factor, value), (value, factor)):
            if one == self.one:
                return other
            if one == self.minus:
                known = self.new.nodes[other]
                return self.new.constant(-known.value) if known.operation == "constant" else self.new.make(ca.OP_NEG, other)
        return self.new.make(ca.OP_MUL, factor, value)

    def _written(self, form: Form) -> int:
        """A sum as operations of the new graph: what is added first, then what is subtracted."""
        make, total = self.new.make, form.get(None)
        waves = [(key, coefficient) for key, coefficient in form.items() if key is not None]
        waves.sort(key=lambda each: each[1] == self.minus)
        for value, coefficient in waves:
            if coefficient == self.minus:
                total = make(ca.OP_NEG, value) if total is None else make(ca.OP_SUB, total, value)
                continue
            term = value if coefficient == self.one else make(ca.OP_MUL, coefficient, value)
            total = term if total is None else make(ca.OP_ADD, total, term)
        assert total is not None
        return total


def live(graph: Graph, more: Iterable[int] = ()) -> list[int]:
    """The values that the outputs (and some more) need, in their order."""
    found: set[int] = set()
    waiting = [*graph.outputs, *more]
    while waiting:
        index = waiting.pop()
        if index not in found:
            found.add(index)
            waiting += graph.nodes[index].operands
    return sorted(found)
