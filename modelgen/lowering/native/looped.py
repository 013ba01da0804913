"""Large stages printed as loops over statements of one shape, in functions of bounded length; small ones as they are.

Part of the compiler, on ``statements`` and ``emission``. What is alike is found in the graph itself, so no element needs to say
so. Statements of one shape differ in places only, and a place is start + stride i or stands in a table. A loop runs in order: a
statement may take what the one before it gave, as in a long sum. What has no company is written out. Compilers take more than
linear time for a long function, so that loops, and functions of bounded length around the rest, keep a build in proportion.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from modelgen.lowering.native.emission import StagePrinter, literal
from modelgen.lowering.native.graph import Level
from modelgen.lowering.native.operations import MASKS
from modelgen.lowering.native.stages import Stages
from modelgen.lowering.native.statements import Statement, scheduled, statements_of

LARGE = 1000  # values in a stage: from here on its loops are built faster, and run about as fast
SHORTEST_LOOP = 8  # statements
LONGEST_FUNCTION = 300  # lines

_FUNCTION = "static __attribute__((noinline, unused)) void"


def stage_function(
    printer: StagePrinter,
    name: str,
    arguments: str,
    values: Sequence[int],
    results: Sequence[int | None],
    target: str,
    large: int | None = None,
) -> list[str]:
    """C text of ``name(arguments)``, which computes ``values`` (one stage, in order) and writes ``results`` to ``target``.

    Flat or in loops (from ``large`` values on, by default LARGE). Whatever a loop needs stands before the function.
    """
    if len(values) < (LARGE if large is None else large):
        quiet = _quiet(_names(arguments))
        return [
            f"{_FUNCTION} {name}({arguments}) {{",
            quiet,
            *printer.lines(tuple(values)),
            *printer.results(tuple(results), target),
            "}",
        ]
    return _Loops(printer, name, target, scheduled(statements_of(printer.stages, values, results))).function(arguments)


def arranged(stages: Stages) -> Stages:
    """The same stages with what they hand over in the order in which loops take it, so that most places need no table."""
    order: dict[int, None] = {}
    waves = [(group.values, group.results) for group in stages.waves]
    for values, results in (*waves, (stages.time, stages.time_values), (stages.state, stages.outputs)):
        if len(values) >= LARGE:
            for run in scheduled(statements_of(stages, values, results)):
                for column in zip(*(statement.leaves for statement in run), strict=True):
                    order.update(dict.fromkeys(column))

    def in_order(handed: tuple[int, ...]) -> tuple[int, ...]:
        known = set(handed)
        return (*(value for value in order if value in known), *(value for value in handed if value not in order))

    return replace(stages, parameter_values=in_order(stages.parameter_values), time_values=in_order(stages.time_values))


class _Loops(StagePrinter):
    """One stage in loops: i counts statements, now counts times; what statements keep for others stands in the array kept."""

    def __init__(self, like: StagePrinter, name: str, target: str, runs: list[list[Statement]]) -> None:
        super().__init__(
            like.stages, like.prefix, like.kind, like.level, like.times, tuple(like.wave_slots), like.time, like.clock
        )
        self.name, self.target, self.runs = name, target, runs
        kept = (value for run in runs for statement in run for value in statement.kept)
        self.places = {value: place for place, value in enumerate(kept)}
        self.tables: dict[tuple[str, tuple[object, ...]], str] = {}
        self.texts: dict[int, str] = {}  # how the values of the statement at hand are read
        self.inner: set[int] = set()  # those that it computes

    def function(self, arguments: str) -> list[str]:
        """The stage: a function of all its loops, or, where that would be too long, one that calls others in turn."""
        parts: list[list[str]] = [[]]
        for run in self.runs:
            for loop in [run] if len(run) >= SHORTEST_LOOP else [[each] for each in run]:
                block = self._loop(loop)
                if parts[-1] and len(parts[-1]) + len(block) > LONGEST_FUNCTION:
                    parts.append([])
                parts[-1] += block
        lines = [f"static const {kind} {name}[] = {{{', '.join(map(str, row))}}};" for (kind, row), name in self.tables.items()]
        names, body, turns = _names(arguments), parts[0], self.times > 1
        if len(parts) > 1:
            more, given = f", {self.kind} *kept" + ", int now" * turns, [*names, "kept", *["now"] * turns]
            for number, part in enumerate(parts):
                lines += [f"{_FUNCTION} {self.name}_{number}({arguments}{more}) {{", _quiet(given), *part, "}"]
            body = [f"  {self.name}_{number}({', '.join(given)});" for number in range(len(parts))]
        if turns:
            body = [f"  for (int now = 0; now < {self.times}; ++now) {{", *(f"  {line}" for line in body), "  }"]
        memory = [f"  {self.kind} kept[{len(self.places) or 1}];", "  (void)kept;"]
        return [*lines, f"{_FUNCTION} {self.name}({arguments}) {{", _quiet(names), *memory, *body, "}"]

    def _loop(self, loop: list[Statement]) -> list[str]:
        """Statements of one shape as one loop, or a single one."""
        first = loop[0]
        self.inner = {value for value, _ in first.inner}
        self.texts = {value: f"a{value}" for value in self.inner}
        for row, leaf in enumerate(first.leaves):
            self.texts[leaf] = self._leaf([statement.leaves[row] for statement in loop])
        lines = []
        for value, operands in first.inner:
            node = self.stages.nodes[value]
            kind = f"{self.prefix}mask" if node.operation in MASKS else self.kind
            lines.append(f"const {kind} a{value} = {self._formula(node._replace(operands=operands))};")
        given = self.number(first.inner[-1][0] if first.inner else first.leaves[0])
        if first.result is not None:
            rows = self._index([statement.result * self.times for statement in loop if statement.result is not None])
            lines.append(f"{self.target}[{rows}{' + now' if self.times > 1 else ''}] = {given};")
        elif first.is_clock:
            ends = (self._index([self.places[statement.kept[end]] for statement in loop]) for end in (0, 1))
            lines.append(f"{self.prefix}{self.clock}({given}, {self._time()}, {', '.join(f'&kept[{end}]' for end in ends)});")
        else:
            lines.append(f"kept[{self._index([self.places[statement.kept[0]] for statement in loop])}] = {given};")
        head = [f"for (int i = 0; i < {len(loop)}; ++i) {{"] if len(loop) > 1 else ["{"] if first.inner else []
        return [f"  {line}" for line in ([*head, *(f"  {line}" for line in lines), "}"] if head else lines)]

    def _leaf(self, alike: list[int]) -> str:
        """How a leaf is read that is another value in each statement of a loop."""
        nodes = self.stages.nodes
        node = nodes[alike[0]]
        if alike[0] in self.places:
            return f"kept[{self._index([self.places[each] for each in alike])}]"
        if node.operation == "constant":
            numbers = tuple(literal(nodes[each].value) for each in alike)
            return f"{self.prefix}all({numbers[0] if len(set(numbers)) == 1 else self._table('double', numbers) + '[i]'})"
        if alike[0] in self.wave_slots:
            return f"b[{self._index([self.wave_slots[each] * self.times for each in alike])}{' + now' if self.times > 1 else ''}]"
        if node.level is not self.level:
            slots, name = (self.parameter_slots, "C") if node.level is Level.PARAMETER else (self.time_slots, "W")
            return f"{name}({self._index([slots[each] for each in alike])})"
        return (
            self._time()
            if node.operation == "t"
            else f"{node.operation}[{self._index([int(nodes[each].value) for each in alike])}]"
        )

    def _index(self, places: list[int]) -> str:
        """Places as an expression in i."""
        start, offsets = places[0], tuple(place - places[0] for place in places)
        if not any(offsets):
            return f"{start}"
        step = offsets[1]
        walk = "i" if step == 1 else f"{step} * i"
        if offsets != tuple(step * number for number in range(len(offsets))):
            walk = f"{self._table('int', offsets)}[i]"
        return f"{start} + {walk}" if start else walk

    def _table(self, kind: str, row: tuple[object, ...]) -> str:
        return self.tables.setdefault((kind, row), f"{self.name}_{kind}s_{len(self.tables)}")

    def _time(self) -> str:
        return "t[now]" if self.times > 1 else self.time

    def _read(self, index: int) -> str:
        return self.texts[index]

    def _is_mask(self, index: int) -> bool:
        """Values are kept and handed on as numbers."""
        return index in self.inner and self.stages.nodes[index].operation in MASKS


def _names(arguments: str) -> list[str]:
    return re.findall(r"(\w+)(?=,|$)", arguments)


def _quiet(names: Sequence[str]) -> str:
    return f"  {', '.join(f'(void){name}' for name in names)};"
