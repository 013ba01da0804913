"""The stages as portable C: C99 that is also C++, needs nothing but libm, reentrant, without globals and allocation.

Part of the compiler, beside ``library``: what a model hands to a program of others, one function per stage.
"""

from __future__ import annotations

import re
from pathlib import Path

import casadi as ca

from modelgen.errors import LoweringError
from modelgen.lowering.native.emission import StagePrinter
from modelgen.lowering.native.graph import Level
from modelgen.lowering.native.stages import Stages

_PREFIX = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}")


def portable_stages(function: ca.Function, prefix: str) -> str:
    """C text of the stages of an SX function (t, x, p) -> dx/dt; memory is the caller's, its sizes are enumeration constants.

    ``prefix_parameters(p, c)`` once per set of parameters, ``prefix_time(c, t, w)`` once per time, and
    ``prefix_rates(c, w, x, rates)`` for every state; c holds ``prefix_C`` doubles, w ``prefix_W``, x ``prefix_X``, p
    ``prefix_P``.
    Raises LoweringError for an operation without C, or a prefix that is no identifier.
    """
    if not _PREFIX.fullmatch(prefix):
        raise LoweringError("native code", f"{prefix!r:.80} is no prefix of C names", "give letters, digits and underscores")
    stages = Stages.of(function)
    c, w = stages.parameter_values, stages.time_values
    sizes = {"X": stages.sizes[0], "P": stages.sizes[1], "C": len(c), "W": len(w)}
    head = (Path(__file__).parent / "scalar.h").read_text(encoding="utf-8")
    lines = [head, f"enum {{ {', '.join(f'{prefix}_{name} = {size}' for name, size in sizes.items())} }};"]
    parts = (
        ("parameters", Level.PARAMETER, stages.parameter, c, "const double *p", "c"),
        ("time", Level.TIME, stages.time, w, "const double *c, double t", "w"),
        ("rates", Level.STATE, stages.state, stages.outputs, "const double *c, const double *w, const double *x", "rates"),
    )
    lines += [f"void {prefix}_{name}({arguments}, double *{target});" for name, _, _, _, arguments, target in parts]
    lines += ["#define C(i) c[i]", "#define W(i) w[i]"]
    for name, level, values, results, arguments, target in parts:
        printer = StagePrinter(stages, "s_", "double", level)
        used = "".join(f"(void){each.split()[-1].lstrip('*')}; " for each in (*arguments.split(","), target))
        lines += [f"void {prefix}_{name}({arguments}, double *{target}) {{", f"  {used.strip()}"]
        lines += [*printer.lines(values), *printer.results(results, target), "}"]
    return "\n".join([*lines, "#undef C", "#undef W", ""])
