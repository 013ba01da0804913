"""Stages printed as C: one function per stage, one line per value.

Part of the compiler. A stage is printed for one double (prefix ``s_``) or for lanes (``v_``); the functions with these prefixes
stand in ``scalar.h`` and ``lanes.h``. No name of the model reaches the text: only x[i], p[i] and numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import casadi as ca

from modelgen.lowering.native.graph import Level, Node
from modelgen.lowering.native.operations import ARITHMETIC, COMPARISONS, FUNCTIONS, LOGIC, MASKS
from modelgen.lowering.native.stages import Stages


class StagePrinter:
    """Prints the values of one stage. ``prefix``: "s_" or "v_"; ``kind``: the C type of a value.

    Values of earlier stages are read by C(i) (parameters) and W(i) (time), macros around it. ``times``: for how many times
    the stage is computed side by side, value by value, so that a coefficient is loaded once for all of them. ``waves``: values
    of the stage that stand in the array b already. ``time``, ``clock``: names of the time, and of a frequency's sine and cosine.
    """

    def __init__(
        self, stages: Stages, prefix: str, kind: str, level: Level, times: int = 1,
        waves: Sequence[int] = (), time: str = "t", clock: str = "clock",
    ) -> None:  # fmt: skip
        self.stages, self.prefix, self.kind, self.level = stages, prefix, kind, level
        self.times, self.now, self.time, self.clock = times, 0, time, clock
        self.wave_slots = {value: slot for slot, value in enumerate(waves)}
        self.parameter_slots = {value: slot for slot, value in enumerate(stages.parameter_values)}
        self.time_slots = {value: slot for slot, value in enumerate(stages.time_values)}

    def lines(self, values: tuple[int, ...]) -> list[str]:
        """Declarations of all values of the stage, in order."""
        lines: list[str] = []
        clocks: dict[tuple[int, int], str] = {}
        for index in values:
            node = self.stages.nodes[index]
            if isinstance(node.operation, str):
                continue
            for now in range(self.times):
                self.now = now
                name, frequency = self._name(index), self.stages.clock_frequency(index)
                if frequency is None:
                    kind = f"{self.prefix}mask" if node.operation in MASKS else self.kind
                    lines.append(f"  const {kind} {name} = {self._formula(node)};")
                    continue
                if (frequency, self.now) not in clocks:
                    clocks[frequency, self.now] = name
                    lines.append(f"  {self.kind} sine_{name}, cosine_{name};")
                    clock = f"{self.prefix}{self.clock}({self.number(frequency)}, {self._time()}"
                    lines.append(f"  {clock}, &sine_{name}, &cosine_{name});")
                part = "sine" if node.operation == ca.OP_SIN else "cosine"
                lines.append(f"  const {self.kind} {name} = {part}_{clocks[frequency, self.now]};")
        return lines

    def results(self, values: Sequence[int | None], target: str) -> list[str]:
        """What the stage hands on, written to an array: times side by side. None: a place that is left as it is."""
        lines = []
        for slot, value in enumerate(values):
            if value is None:
                continue
            for now in range(self.times):
                self.now = now
                lines.append(f"  {target}[{slot * self.times + self.now}] = {self.number(value)};")
        return lines

    def _name(self, index: int) -> str:
        return f"a{index}_{self.now}" if self.times > 1 else f"a{index}"

    def _time(self) -> str:
        return f"t[{self.now}]" if self.times > 1 else self.time

    def number(self, index: int) -> str:
        """A value as a number; a mask counts as 1 or 0."""
        text = self._read(index)
        return f"{self.prefix}number({text})" if self._is_mask(index) else text

    def _mask(self, index: int) -> str:
        return self._read(index) if self._is_mask(index) else f"({self._read(index)} != {self.prefix}all(0.0))"

    def _is_mask(self, index: int) -> bool:
        """Whether a value is a mask here; stages hand on numbers only."""
        node = self.stages.nodes[index]
        return node.operation in MASKS and self._is_own(node)

    def _is_own(self, node: Node) -> bool:
        return node.level is self.level or node.level is Level.CONSTANT

    def _read(self, index: int) -> str:
        node = self.stages.nodes[index]
        if node.operation == "constant":
            return f"{self.prefix}all({literal(node.value)})"
        if index in self.wave_slots:
            return f"b[{self.wave_slots[index] * self.times + self.now}]"
        if not self._is_own(node):
            return f"C({self.parameter_slots[index]})" if node.level is Level.PARAMETER else f"W({self.time_slots[index]})"
        if isinstance(node.operation, str):
            return self._time() if node.operation == "t" else f"{node.operation}[{node.value}]"
        return self._name(index)

    def _formula(self, node: Node) -> str:
        code, f = node.operation, self.prefix
        assert isinstance(code, int)
        if code in LOGIC:
            return f"{f}{LOGIC[code]}({', '.join(map(self._mask, node.operands))})"
        if code == ca.OP_IF_ELSE_ZERO:
            return f"{f}where({self._mask(node.operands[0])}, {self.number(node.operands[1])})"
        operands = [self.number(each) for each in node.operands]
        if code in FUNCTIONS:
            return f"{f}{FUNCTIONS[code]}({', '.join(operands)})"
        return (ARITHMETIC | COMPARISONS)[code].format(*operands, f=f)


def literal(value: float) -> str:
    """A double as C reads it back, digit for digit.

    >>> literal(0.1), literal(-2.0), literal(math.inf)
    ('0.1', '(-2.0)', 'INFINITY')
    """
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    return f"({value!r})" if value < 0 or math.copysign(1.0, value) < 0 else repr(value)
