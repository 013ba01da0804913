"""Several functions of one model as portable C: C99 that is also C++, reentrant, without globals and allocation.

Part of the compiler, beside ``library``: what a model hands to a program of others. All functions share one parameter stage;
each has a time stage and a state stage of what it needs itself. ``portable_files`` puts a whole model around them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import casadi as ca

from modelgen.errors import LoweringError
from modelgen.lowering.native.emission import StagePrinter
from modelgen.lowering.native.graph import Level
from modelgen.lowering.native.stages import Stages

_PREFIX = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}")


@dataclass(frozen=True)
class PortableStages:
    """C text of the stages, and how many doubles they hand on: ``prepared`` (from the parameters), ``timed`` (of one time)."""

    text: str
    prepared: int
    timed: int


def portable_stages(functions: Mapping[str, ca.Function], prefix: str) -> PortableStages:
    """The stages of SX functions (t, x, p) -> dense column, by the name that each has in C.

    ``prefix_prepare(p, c)`` once per set of parameters; for each function ``NAME_at(c, t, w)`` once per time and
    ``NAME_of(c, w, x, NAME)`` for every state, both static, and ``prefix_NAME(c, t, x, NAME)``, which is both.
    Raises LoweringError for an operation without C, or a prefix or name that is no identifier.

    >>> t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p")
    >>> stages = portable_stages({"rates": ca.Function("f", [t, x, p], [ca.cos(p**2 * t) - x])}, "decay")
    >>> stages.prepared, stages.timed, "void decay_rates(const double *c" in stages.text
    (1, 1, True)
    """
    for name in (prefix, *functions):
        if not _PREFIX.fullmatch(name):
            raise LoweringError("native code", f"{name!r:.80} is no prefix of C names", "give letters, digits and underscores")
    stages, outputs = _together(functions)
    printer = StagePrinter(stages, "s_", "double", Level.PARAMETER)
    lines = [(Path(__file__).parent / "scalar.h").read_text(encoding="utf-8"), "#define C(i) c[i]", "#define W(i) w[i]"]
    lines += [f"void {prefix}_prepare(const double *p, double *c) {{", "  (void)p, (void)c;"]
    lines += [*printer.lines(stages.parameter), *printer.results(stages.parameter_values, "c"), "}"]
    for name, wanted in outputs.items():
        lines += ["", *_function(stages, wanted, name)]
        lines += [
            f"void {prefix}_{name}(const double *c, double t, const double *x, double *{name}) {{",
            f"  double w[{prefix}_W];",
            f"  {name}_at(c, t, w);",
            f"  {name}_of(c, w, x, {name});",
            "}",
        ]
    text = "\n".join([*lines, "#undef C", "#undef W", ""])
    return PortableStages(text, len(stages.parameter_values), len(stages.time_values))


def _together(functions: Mapping[str, ca.Function]) -> tuple[Stages, dict[str, tuple[int, ...]]]:
    """The stages of all functions at once, and the values that each gives."""
    first = next(iter(functions.values()))
    t, x, p = (ca.SX.sym(name, *first.size_in(index)) for index, name in enumerate("txp"))
    columns = {name: function(t, x, p) for name, function in functions.items()}
    stages = Stages.of(ca.Function("model", [t, x, p], [ca.densify(ca.vertcat(*columns.values()))]))
    outputs, done = {}, 0
    for name, column in columns.items():
        outputs[name] = stages.outputs[done : done + column.numel()]
        done += column.numel()
    return stages, outputs


def _function(stages: Stages, outputs: tuple[int, ...], name: str) -> list[str]:
    """The time stage and the state stage of some of the outputs."""
    part = _part(stages, outputs)
    time, state = (StagePrinter(stages, "s_", "double", level) for level in (Level.TIME, Level.STATE))
    return [
        f"static void {name}_at(const double *c, double t, double *w) {{",
        "  (void)c, (void)t, (void)w;",
        *time.lines(part.time),
        *(f"  w[{slot}] = {time.number(value)};" for value, slot in time.time_slots.items() if value in part.time_values),
        "}",
        f"static void {name}_of(const double *c, const double *w, const double *x, double *{name}) {{",
        "  (void)c, (void)w, (void)x;",
        *state.lines(part.state),
        *state.results(outputs, name),
        "}",
    ]


def _part(stages: Stages, outputs: tuple[int, ...]) -> Stages:
    """What some of the outputs need of the time stage and of the state stage."""
    needed: set[int] = set()
    waiting = list(outputs)
    while waiting:
        index = waiting.pop()
        if index not in needed:
            needed.add(index)
            frequency = stages.clock_frequency(index)  # its sine is formed from frequency and time, not from their product
            waiting += stages.nodes[index].operands if frequency is None else ()
    state, time, values = (
        tuple(each for each in numbers if each in needed) for numbers in (stages.state, stages.time, stages.time_values)
    )
    return replace(stages, state=state, time=time, time_values=values, outputs=outputs)
