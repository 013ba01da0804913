"""The stages of a function as C functions: those that a solver calls, and those that an observer of its runs calls.

Part of the compiler, on ``emission`` and ``looped``, below ``library``, which puts run-time headers and the solver around them.
"""

from __future__ import annotations

from collections.abc import Sequence

from modelgen.lowering.native import looped
from modelgen.lowering.native.emission import StagePrinter
from modelgen.lowering.native.graph import Level
from modelgen.lowering.native.kinds import Kinds
from modelgen.lowering.native.looped import arranged, stage_function
from modelgen.lowering.native.stages import Stages
from modelgen.lowering.native.windows import window_functions


def stage_functions(stages: Stages, state_prefix: str, times: int = 4) -> str:
    """The stages as static C functions, and their sizes as macros.

    ``parameter_stage(p, c)`` on doubles; ``time_stage(c, t, b, w)`` for so many new times of a step, with the waves in b;
    ``state_stage(c, w, x, k)`` with k = dx/dt, and ``force_stage``, but for the rates of angles; ``guard_stage(c, w, x, v, out)``
    with the guards and their rates, which are the outputs behind k. Where one trajectory runs (``state_prefix`` "s_"), the times
    are the lanes of one V.
    """
    stages, lanes = arranged(stages), state_prefix == "v_"
    kind, t = ("V", "const V *t") if lanes else ("double", "V t")
    sizes = {"NX": stages.sizes[0], "NP": stages.sizes[1], "NC": len(stages.parameter_values), "NW": len(stages.time_values)}
    parameter = StagePrinter(stages, "s_", "double", Level.PARAMETER)
    time = StagePrinter(stages, "v_", "V", Level.TIME, times=times if lanes else 1, waves=stages.wave_values)
    state = StagePrinter(stages, state_prefix, kind, Level.STATE)
    of_time, of_state = f"const S *c, {t}, const V *b, V *w", "const S *c, const TIME_VALUE *w, const S *x, S *k"
    of_guards = "const S *c, const TIME_VALUE *w, const S *x, const S *v, S *out"
    rates, guards = stages.outputs[: sizes["NX"]], stages.outputs[sizes["NX"] :]
    lines = [
        *(f"#define {name} {size}" for name, size in sizes.items()),
        *stage_function(
            parameter, "parameter_stage", "const double *p, double *c", stages.parameter, stages.parameter_values, "c"
        ),
        "#define C(i) TIME_PARAMETER(c[i])",
        *stage_function(time, "time_stage", of_time, stages.time, stages.time_values, "w"),
        *window_functions(stages),
        *("#undef C", "#define C(i) c[i]", "#define W(i) w[(i) * TIME_STRIDE]"),
        *stage_function(state, "state_stage", of_state, stages.state_for(rates), rates, "k"),
        *_force_stage(state, stages, rates, of_state),
        *stage_function(state, "guard_stage", of_guards, stages.state_for(guards), guards, "out"),
    ]
    return "\n".join([*lines, ""])


def kinds_of(stages: Stages) -> Kinds:
    """Which states are angles: those whose rate is a state as it stands."""
    rates = [stages.nodes[rate] for rate in stages.outputs[: stages.sizes[0]]]
    return Kinds.of([int(rate.value) if rate.operation == "x" else None for rate in rates])


def _force_stage(state: StagePrinter, stages: Stages, rates: Sequence[int], arguments: str) -> list[str]:
    """The state stage without the rates of angles; where it is long, the whole one serves, so that it is built once."""
    angles, values = set(kinds_of(stages).angles), stages.state_for(rates)
    if not angles or len(values) >= looped.LARGE:
        return ["#define force_stage state_stage"]
    others = [None if index in angles else rate for index, rate in enumerate(rates)]
    return stage_function(state, "force_stage", arguments, values, others, "k")


def observer_functions(stages: Stages) -> str:
    """The stages of a function (t, x, v, p) -> column that is asked for at single times, in lanes.

    ``observer_parameters(p, c)`` on doubles; ``observer_at(c, t, x, v, out)`` from the time to the result.
    """
    stages = arranged(stages)
    parameter = StagePrinter(stages, "s_", "double", Level.PARAMETER)
    time, state = (StagePrinter(stages, "v_", "V", level) for level in (Level.TIME, Level.STATE))
    of_state = "const V *c, const V *w, const V *x, const V *v, V *out"
    sizes = (len(stages.parameter_values), len(stages.outputs), *stages.sizes)
    lines = [
        *stage_function(
            parameter, "observer_stage_p", "const double *p, double *c", stages.parameter, stages.parameter_values, "c"
        ),
        *("#define C(i) c[i]", "#define W(i) w[i]"),
        *stage_function(time, "observer_stage_t", "const V *c, V t, V *w", stages.time, stages.time_values, "w"),
        *stage_function(state, "observer_stage_x", of_state, stages.state, stages.outputs, "out"),
        "void observer_parameters(const double *p, double *c) { observer_stage_p(p, c); }",
        "void observer_at(const V *c, const V *t, const V *x, const V *v, V *out) {",
        f"  V w[{len(stages.time_values) + 1}];",
        "  observer_stage_t(c, *t, w);",
        "  observer_stage_x(c, w, x, v, out);",
        "}",
        "int64_t observer_sizes(int64_t which) {",
        f"  const int64_t sizes[] = {{{', '.join(map(str, sizes))}, WIDTH}};",
        "  return which >= 0 && which < 5 ? sizes[which] : -1;",
        "}",
    ]
    return "\n".join([*lines, ""])
