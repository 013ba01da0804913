"""The steps of a method printed as C: what they need of memory, the step itself, its dense output, its middle.

Part of the compiler, between ``lowering.tableau`` and ``march.h``; the step is printed by ``explicit_step`` or ``doubled_step``.
Stages at equal times share the time stage, and the slope at the end is the next step's at its start. A doubled method adds
Richardson's term at run time, and has the quintic through start, middle and end as its dense output.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import comb

from modelgen.lowering.native.doubled_step import DoubledStep, place_of
from modelgen.lowering.native.explicit_step import ExplicitStep
from modelgen.lowering.native.kinds import Kinds, number
from modelgen.lowering.tableau import QUINTIC, Tableau, doubled

WIDEST_BUNDLE = 6  # times for which the time stage of lanes is computed side by side

Row = Sequence[Fraction]
Powers = Sequence[Fraction | int]  # coefficients of a polynomial
ZERO, HALF = Fraction(0), Fraction(1, 2)
QUINTIC_DEGREE = 5
_SQUARE = [Fraction(each) for each in ("0", "0", "1/4", "-3/2", "13/4", "-3", "1", "0")]
BEYOND = {"SQUARE": _SQUARE, "CUBE": [ZERO, *_SQUARE[:-1]]}
"""(theta (theta - 1/2) (theta - 1))^2 and theta times it, by powers."""


def with_error(tableau: Tableau) -> tuple[Tableau, int | None]:
    """The method that measures its error: itself, or doubled, with its stage in the middle of the step."""
    return (doubled(tableau, extrapolate=False), 2 * tableau.stages - 1) if tableau.is_doubled else (tableau, None)


def step_functions(method: Tableau, middle: int | None, kinds: Kinds, guarded: bool = False) -> str:
    """C text: ``try_step``, ``dense_stages``, ``middle_node`` and ``dense_weights`` of a method for states of some kinds."""
    times = _times(method, guarded)
    time_of = {index: times.index(node) for index, node in enumerate(method.c) if node}
    step = ExplicitStep(method, kinds, time_of) if middle is None else DoubledStep(method, middle, kinds, time_of)
    lines = [*step.lines(), *_dense_stages(method, middle)]
    lines += [*(_middle_node(method) if middle is None else []), *_dense_weights(method, middle)]
    lines += _high_powers(method) if _is_high(method, middle) else []
    return "\n".join(lines) + "\n"


def bundle(method: Tableau, guarded: bool = False) -> int:
    """For how many times the time stage of lanes is computed side by side."""
    times = len(_times(method, guarded))
    return -(-times // -(-times // WIDEST_BUNDLE))


def step_sizes(method: Tableau, middle: int | None, surfaces: int = 0) -> str:
    """The macros that say how large a step's memory is; they come before the stages. ``surfaces``: guards of the model."""
    nodes = _times(method, surfaces > 0)
    times, width, s = len(nodes), bundle(method, surfaces > 0), method.stages
    places = [n if middle is None else place_of(n, middle, s) for n in range(len(method.nodes))]
    sizes = {
        "SLOTS": max(places) + 1,
        "END": places[s],
        "EVALUATED": s,
        "EXTRA": len(method.extra_c),
        "GAINS": 0 if middle is None else 2,
        "MEASURES": len(method.errors) + 2,
        "MIDDLE": places[middle or 0],
        "EXPONENT": f"(1.0 / {method.control})",
        "NODES": int(middle is not None),
        "DEGREE": QUINTIC_DEGREE if middle is not None else len(method.dense[0]),
        "HIGH": int(_is_high(method, middle)),
        "SURFACES": surfaces,
        "MIDDLE_TIME": nodes.index(HALF) if surfaces else 0,
    }
    lines = [f"#define {name} {size}" for name, size in sizes.items()]
    lines += [f"enum {{ TIMES = {times} }};"]
    for name, fractions in (("FRACTIONS", nodes), ("LATE_FRACTIONS", method.extra_c or (ZERO,))):
        lines += [f"static const double {name}[] = {{{', '.join(map(number, fractions))}}};"]
    lines += ["#ifdef SINGLE", "#define BUNDLE WIDTH", f"#define BUNDLES (({times} + WIDTH - 1) / WIDTH)", "#else"]
    lines += [f"#define BUNDLE {width}", f"#define BUNDLES {-(-times // width)}", "#endif"]
    return "\n".join(lines) + "\n"


def _times(method: Tableau, guarded: bool) -> list[Fraction]:
    """The times of a step, as fractions of it."""
    return sorted({node for node in (*method.c[1:], Fraction(1), *[HALF] * guarded) if node})


def _dense_stages(method: Tableau, middle: int | None) -> list[str]:
    lines = ["/* Slopes that only the dense output needs. */", "static void dense_stages(Work *k) {"]
    lines += ["  if (k->dense_ready) return;", "  k->dense_ready = 1;", *["  angle_slopes(k);"] * (middle is None)]
    if method.extra_c:
        lines += ["  const S h = k->step;", "  stage_times(k, k->time, h, LATE_FRACTIONS, EXTRA, LATE, 1);"]
    for j, row in enumerate(method.extra_a):
        terms = [(slot, weight) for slot, weight in enumerate(row) if weight]
        constants = "".join(f" const S a{slot} = h * {number(weight)};" for slot, weight in terms)
        total = " + ".join(f"a{slot} * k->now.k[{slot}][i]" for slot, _ in terms)
        lines += [f"  {{{constants}"]
        lines += [f"    for (int i = 0; i < NX; ++i) k->x[i] = k->base[i] + ({total}); }}"]
        lines += [f"  state_stage(k->c, W_AT(k, LATE + {j}), k->x, k->now.k[END + {j + 1}]);"]
    return [*lines, "}"]


def _middle_node(method: Tableau) -> list[str]:
    lines = ["/* State and slope in the middle of the step, as far as guards read them. */"]
    lines += ["static void middle_node(const Task *task, Work *k) {", "  dense_stages(k);", "  const S h = k->step;"]
    value = [sum((w * HALF ** (m + 1) for m, w in enumerate(row)), ZERO) for row in method.dense]
    slope = [sum((w * (m + 1) * HALF**m for m, w in enumerate(row)), ZERO) for row in method.dense]
    values = " + ".join(f"{number(w)} * k->now.k[{n}][i]" for n, w in enumerate(value) if w)
    slopes = " + ".join(f"{number(w)} * k->now.k[{n}][i]" for n, w in enumerate(slope) if w)
    lines += ["  for (int64_t n = 0; n < task->reads; ++n) {", "    const int64_t i = task->read[n];"]
    lines += [f"    k->now.y_middle[i] = k->y[i] + h * ({values});", f"    k->now.middle_slope[i] = {slopes};"]
    return [*lines, "  }", "}"]


def _is_high(method: Tableau, middle: int | None) -> bool:
    """Whether the dense output has a higher degree than the quintic through start, middle and end."""
    return middle is None and len(method.dense[0]) > QUINTIC_DEGREE


def _high_powers(method: Tableau) -> list[str]:
    lines = ["/* What the dense output has beyond a quintic, as far as guards read it (see guards.h). */"]
    lines += ["static void high_powers(const Task *task, Work *k) {", "  const S h = k->step;"]
    six, seven = ([row[power - 1] if len(row) >= power else ZERO for row in method.dense] for power in (6, 7))
    sums = [[a + 3 * b for a, b in zip(six, seven, strict=True)], seven]
    lines += ["  for (int64_t n = 0; n < task->reads; ++n) {", "    const int64_t i = task->read[n];"]
    for each, weights in enumerate(sums):
        total = " + ".join(f"{number(w)} * k->now.k[{n}][i]" for n, w in enumerate(weights) if w) or "S_(all)(0.0)"
        lines += [f"    k->now.high[{each}][i] = h * ({total});"]
    return [*lines, "  }", "}"]


def _weights(
    method: Tableau, middle: int | None
) -> tuple[list[int], list[Sequence[Fraction | int]], list[Sequence[Fraction | int]]]:
    """Places of the slopes in the dense output, and polynomials that weigh them, and those of middle and end from the start."""
    if middle is not None:
        places = [place_of(n, middle, method.stages) for n in (0, middle, method.stages)]
        return places, [QUINTIC[1], QUINTIC[3], QUINTIC[5]], [QUINTIC[2], QUINTIC[4]]
    slots = [n for n, row in enumerate(method.dense) if any(row)]
    return slots, [(0, *method.dense[n]) for n in slots], []


def _dense_weights(method: Tableau, middle: int | None) -> list[str]:
    places, polynomials, nodes = _weights(method, middle)
    lines = [
        f"enum {{ TERMS = {len(places)} }};",
        f"static const int TERM[] = {{{', '.join(map(str, places))}}};",
    ]
    lines += ["/* Bernstein coefficients of what they weigh in the state. */"]
    rows = [f"{{{', '.join(map(number, bernstein(each)))}}}" for each in (*polynomials, *nodes)]
    lines += [f"static const double BERNSTEIN[][DEGREE + 1] = {{{', '.join(rows)}}};"]
    lines += [f"#define {name}_COEFFICIENTS {{{', '.join(map(number, bernstein(each)))}}}" for name, each in BEYOND.items()]
    lines += ["/* What slopes, middle and end (from the start) weigh in the state at a fraction theta, and in its rate. */"]
    lines += ["static void dense_weights(V theta, V h, V *value, V *rate) {"]
    for n, polynomial in enumerate(polynomials):
        lines += [f"  value[{n}] = h * ({_horner(polynomial)});", f"  rate[{n}] = {_horner(_derivative(polynomial))};"]
    for n, polynomial in enumerate(nodes, start=len(places)):
        lines += [f"  value[{n}] = {_horner(polynomial)};", f"  rate[{n}] = ({_horner(_derivative(polynomial))}) / h;"]
    return [*lines, "}"]


def bernstein(powers: Sequence[Fraction | int]) -> list[Fraction]:
    """The Bernstein coefficients of a polynomial given by its coefficients in powers.

    >>> [float(each) for each in bernstein([0, 0, 1])]
    [0.0, 0.0, 1.0]
    """
    degree = len(powers) - 1
    share = [[Fraction(comb(i, j), comb(degree, j)) for j in range(degree + 1)] for i in range(degree + 1)]
    return [sum((s * Fraction(p) for s, p in zip(row, powers, strict=True)), ZERO) for row in share]


def _derivative(polynomial: Sequence[Fraction | int]) -> list[Fraction]:
    return [Fraction(m * weight) for m, weight in enumerate(polynomial)][1:]


def _horner(polynomial: Sequence[Fraction | int]) -> str:
    """A polynomial in theta, exact at 0 and, with whole coefficients, at 1."""
    text = ""
    for weight in reversed(polynomial):
        if text and weight:
            text = f"({number(weight)} + theta * {text})"
        elif text:
            text = f"(theta * {text})"
        elif weight:
            text = f"v_all({number(weight)})"
    return text or "v_all(0.0)"
