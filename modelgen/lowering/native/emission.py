"""Stages printed as C: one function per stage, one line per value.

Part of the compiler. A stage is printed for one double (prefix ``s_``) or for lanes (``v_``); the functions with these prefixes stand
in ``prelude.h``. No name of the model reaches the text: only x[i], p[i] and numbers (architecture, decision 12).
"""

from __future__ import annotations

import math

import casadi as ca

from modelgen.lowering.native.graph import Level, Node
from modelgen.lowering.native.operations import ARITHMETIC, COMPARISONS, FUNCTIONS, LOGIC, MASKS
from modelgen.lowering.native.stages import Stages



class StagePrinter:
    """Prints the values of one stage. ``prefix``: "s_" or "v_"; ``kind``: the C type of a value.

    Values of earlier stages are read by C(i) (parameters) and W(i) (time), macros of the text around.
    """

    def __init__(self, stages: Stages, prefix: str, kind: str, level: Level) -> None:
        self.stages, self.prefix, self.kind, self.level = stages, prefix, kind, level
        self.parameter_slots = {value: slot for slot, value in enumerate(stages.parameter_values)}
        self.time_slots = {value: slot for slot, value in enumerate(stages.time_values)}

    def lines(self, values: tuple[int, ...]) -> list[str]:
        """Declarations of all values of the stage, in order."""
        lines, clocks = [], {}
        for index in values:
            node = self.stages.nodes[index]
            if isinstance(node.operation, str):
                continue
            frequency = self.stages.clock_frequency(index)
            if frequency is None:
                kind = f"{self.prefix}mask" if node.operation in MASKS else self.kind
                lines.append(f"  const {kind} a{index} = {self._formula(node)};")
                continue
            if frequency not in clocks:
                clocks[frequency] = index
                lines.append(f"  {self.kind} sine{index}, cosine{index};")
                lines.append(f"  {self.prefix}clock({self.number(frequency)}, t, &sine{index}, &cosine{index});")
            part = "sine" if node.operation == ca.OP_SIN else "cosine"
            lines.append(f"  const {self.kind} a{index} = {part}{clocks[frequency]};")
        return lines

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
        if not self._is_own(node):
            return f"C({self.parameter_slots[index]})" if node.level is Level.PARAMETER else f"W({self.time_slots[index]})"
        if isinstance(node.operation, str):
            return "t" if node.operation == "t" else f"{node.operation}[{node.value}]"
        return f"a{index}"

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


def stage_functions(stages: Stages, time_prefix: str, state_prefix: str) -> str:
    """The three stages as static C functions, and their sizes as macros.

    ``parameter_stage(p, c)`` on doubles; ``time_stage(c, t, w)``; ``state_stage(c, w, x, k)`` with k = dx/dt.
    """
    kinds = {"s_": "double", "v_": "V"}
    parts = {
        "parameter_stage": ("s_", Level.PARAMETER, stages.parameter, stages.parameter_values, "const double *p, double *c", "c"),
        "time_stage": (time_prefix, Level.TIME, stages.time, stages.time_values, f"const S *c, {kinds[time_prefix]} t, {kinds[time_prefix]} *w", "w"),
        "state_stage": (state_prefix, Level.STATE, stages.state, stages.outputs, "const S *c, const TIME_VALUE *w, const S *x, S *k", "k"),
    }
    nx, count = stages.sizes
    text = [
        *(f"#define {name} {number}" for name, number in (("NX", nx), ("NP", count))),
        *(f"#define {name} {number}" for name, number in (("NC", len(stages.parameter_values)), ("NW", len(stages.time_values)))),
    ]
    for name, (prefix, level, values, results, arguments, target) in parts.items():
        printer = StagePrinter(stages, prefix, kinds[prefix], level)
        if level is Level.TIME:
            text.append("#undef C\n#define C(i) TIME_PARAMETER(c[i])")
        elif level is Level.STATE:
            text.append("#undef C\n#define C(i) c[i]\n#define W(i) w[(i) * TIME_STRIDE]")
        unused = [each.split()[-1].lstrip("*") for each in arguments.split(",")]
        text += [f"static __attribute__((noinline, unused)) void {name}({arguments}) {{", f"  {' '.join(f'(void){each};' for each in unused)}"]
        text += printer.lines(values)
        text += [f"  {target}[{slot}] = {printer.number(value)};" for slot, value in enumerate(results)]
        text.append("}")
    return "\n".join([*text, ""])
