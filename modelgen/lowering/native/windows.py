"""Groups of waves printed as C, and the numbers by which times.h turns them into polynomials over windows of time.

Part of the compiler, between ``looped`` and ``functions``. Interpolation at Chebyshev's points, then powers: Trefethen,
Approximation Theory and Approximation Practice (2013), chapters 3 and 8. Chebyshev's polynomials stand in between because the
powers alone would lose digits; the coefficients in a window fall off so fast that the step from one to the other loses none.
"""

from __future__ import annotations

import math

from modelgen.lowering.native.emission import StagePrinter
from modelgen.lowering.native.graph import Level
from modelgen.lowering.native.looped import stage_function
from modelgen.lowering.native.stages import Stages

COEFFICIENTS = 16  # of a polynomial; times.h says how wide a window they serve
SELDOM = 100  # values: functions that are called seldom are in loops from here on, which are built faster

Table = list[list[float]]


def window_functions(stages: Stages) -> list[str]:
    """C text of the groups, and tables: their first results, places of their bandwidths, points, shares, powers.

    ``group_at(group, c, t, b)``: waves at one time of each lane, put down in strides of SIDE_BY_SIDE.
    ``group_between(group, c, lane, t, rest, out)``: at the times t + rest of one lane.
    """
    slots, first = {value: slot for slot, value in enumerate(stages.parameter_values)}, [0]
    for group in stages.waves:
        first.append(first[-1] + len(group.results))
    lines = [f"#define GROUPS {len(stages.waves)}", f"#define WAVES {first[-1]}", f"#define COEFFICIENTS {COEFFICIENTS}"]
    if not stages.waves:
        return lines
    most = max(len(group.results) for group in stages.waves)
    points = [math.cos((2 * j + 1) * math.pi / (2 * COEFFICIENTS)) for j in range(COEFFICIENTS)]
    lines += [f"enum {{ MOST_RESULTS = {most}, HALF_COUNT = COEFFICIENTS / 2 }};"]
    lines += [f"static const int RESULTS[] = {{{', '.join(map(str, first))}}};"]
    lines += [f"static const int BANDWIDTH[] = {{{', '.join(str(slots[group.bandwidth]) for group in stages.waves)}}};"]
    lines += [f"static const double POINTS[] = {_row(points)};"]
    for name, table in (
        ("EVEN_SHARE", shares(0)),
        ("ODD_SHARE", shares(1)),
        ("EVEN_POWER", powers(0)),
        ("ODD_POWER", powers(1)),
    ):
        lines += [f"static const double {name}[][HALF_COUNT] __attribute__((aligned(64))) = {{{', '.join(map(_row, table))}}};"]
    of_one = "const S *c, int lane, V t, V rest, V *out"
    for macro, clock, time, arguments, name in (
        ("TIME_PARAMETER(c[i])", "clock", "t", "const S *c, V t, V *out", "at"),
        ("v_all(((const double *)&c[i])[lane])", "clock_between", "t, rest", of_one, "between"),
    ):
        lines += ["#undef C", f"#define C(i) {macro}"]
        for number, group in enumerate(stages.waves):
            printer = StagePrinter(stages, "v_", "V", Level.TIME, time=time, clock=clock)
            lines += stage_function(printer, f"group_{number}_{name}", arguments, group.values, group.results, "out", SELDOM)
    numbers = range(len(stages.waves))
    lines += ["static void group_between(int group, const S *c, int lane, V t, V rest, V *out) {", "  switch (group) {"]
    lines += [f"  case {number}: group_{number}_between(c, lane, t, rest, out); break;" for number in numbers]
    lines += ["  }", "}", "static void group_at(int group, const S *c, V t, V *b) {"]
    lines += ["  V out[MOST_RESULTS];", "  switch (group) {"]
    lines += [f"  case {number}: group_{number}_at(c, t, out); break;" for number in numbers]
    lines += ["  }", "  for (int n = 0; n < RESULTS[group + 1] - RESULTS[group]; ++n) b[n * SIDE_BY_SIDE] = out[n];", "}"]
    return lines


def shares(odd: int) -> Table:
    """What the sums (odd: differences) of values at opposite points weigh in each even (odd) Chebyshev polynomial.

    >>> round(sum(row[0] for row in shares(0)), 15)  # the mean of a constant, taken twice
    0.5
    """
    half, count = COEFFICIENTS // 2, COEFFICIENTS

    def share(j: int, order: int) -> float:
        return (2 if order else 1) / count * math.cos(order * (2 * j + 1) * math.pi / (2 * count))

    return [[share(j, 2 * m + odd) for m in range(half)] for j in range(half)]


def powers(odd: int) -> Table:
    """The coefficients of the even (odd) Chebyshev polynomials in even (odd) powers.

    >>> powers(0)[1][:2], powers(1)[1][:2]  # 2 s^2 - 1, 4 s^3 - 3 s
    ([-1.0, 2.0], [-3.0, 4.0])
    """
    rows = [[1.0], [0.0, 1.0]]
    while len(rows) < COEFFICIENTS:
        older, last = rows[-2], rows[-1]
        rows.append([2 * (last[k - 1] if k else 0.0) - (older[k] if k < len(older) else 0.0) for k in range(len(last) + 1)])
    padded = [[*row, *[0.0] * (COEFFICIENTS - len(row))] for row in rows]
    return [row[odd::2] for row in padded[odd::2]]


def _row(values: list[float]) -> str:
    return f"{{{', '.join(map(repr, values))}}}"
