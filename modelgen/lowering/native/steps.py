"""A step of any explicit Runge-Kutta method printed as C: its stages, its error, its dense output.

Part of the compiler, between ``lowering.tableau`` and ``march.h``. Printed are the loops over the states around ``state_stage``:
the argument of a stage is built on that earlier argument from which it differs in the fewest terms, stages at equal times share
the time stage, and the slope at the end is the next step's at its start. A doubled method adds Richardson's term at run time, has
the quintic through start, middle and end as its dense output, and a step of its own: ``doubled_step``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction

from modelgen.lowering.native.doubled_step import DoubledStep, Kinds
from modelgen.lowering.tableau import QUINTIC, Tableau, doubled, read_tableau

DOUBLED = frozenset({"rk4"})  # methods that measure their error by step doubling
WIDEST_BUNDLE = 6  # times for which the time stage of lanes is computed side by side

Row = Sequence[Fraction]
ZERO, HALF = Fraction(0), Fraction(1, 2)


def method_named(name: str) -> tuple[Tableau, int | None]:
    """The method of a name, and its stage in the middle of the step where it is doubled."""
    tableau = read_tableau(name)
    return (doubled(tableau, extrapolate=False), 2 * tableau.stages - 1) if name in DOUBLED else (tableau, None)


def step_functions(method: Tableau, middle: int | None, kinds: Kinds, guarded: bool = False) -> str:
    """C text: ``try_step``, ``dense_stages``, ``middle_node`` and ``dense_weights`` of a method for states of some kinds."""
    printer = _StepPrinter(method, middle, guarded)
    if middle is None:
        return "\n".join([*printer.step(), *printer.lines()]) + "\n"
    time_of = {index: printer.times.index(node) for index, node in enumerate(method.c) if node}
    return "\n".join([*DoubledStep(method, middle, kinds, time_of).lines(), *printer.lines()]) + "\n"


def bundle(method: Tableau, middle: int | None, guarded: bool = False) -> int:
    """For how many times the time stage of lanes is computed side by side."""
    times = len(_StepPrinter(method, middle, guarded).times)
    return -(-times // -(-times // WIDEST_BUNDLE))


def step_sizes(method: Tableau, middle: int | None, surfaces: int = 0) -> str:
    """The macros that say how large a step's memory is; they come before the stages. ``surfaces``: guards of the model."""
    printer = _StepPrinter(method, middle, surfaces > 0)
    times, width, s = len(printer.times), bundle(method, middle, surfaces > 0), method.stages
    sizes = {
        "SLOTS": len(method.nodes) if middle is None else (middle + 1) // 2 + 2,
        "END": s if middle is None else (middle + 1) // 2 + 1,
        "EVALUATED": s,
        "EXTRA": len(method.extra_c),
        "GAINS": len(printer.stored) if middle is None else 2,
        "MEASURES": len(method.errors) + 2,
        "MIDDLE": ((middle or 0) + 1) // 2,
        "EXPONENT": f"(1.0 / {method.control})",
        "NODES": int(middle is not None),
        "SURFACES": surfaces,
        "MIDDLE_TIME": printer.times.index(HALF) if surfaces else 0,
    }
    lines = [f"#define {name} {size}" for name, size in sizes.items()]
    lines += [f"enum {{ TIMES = {times} }};"]
    for name, nodes in (("FRACTIONS", printer.times), ("LATE_FRACTIONS", method.extra_c or (ZERO,))):
        lines += [f"static const double {name}[] = {{{', '.join(map(_number, nodes))}}};"]
    lines += ["#ifdef SINGLE", "#define BUNDLE WIDTH", f"#define BUNDLES (({times} + WIDTH - 1) / WIDTH)", "#else"]
    lines += [f"#define BUNDLE {width}", f"#define BUNDLES {-(-times // width)}", "#endif"]
    return "\n".join(lines) + "\n"


class _StepPrinter:
    """Prints a step, its dense output and what guards need of it."""

    def __init__(self, method: Tableau, middle: int | None, guarded: bool = False) -> None:
        self.method, self.middle = method, middle
        s = method.stages
        self.rows = [_padded(row, s + 1) for row in (*method.a, method.b)]
        self.times = sorted({node for node in (*method.c[1:], Fraction(1), *[HALF] * guarded) if node})
        self.late = any(row[s] for row in method.errors)  # the error needs the slope at the end
        # Row -> the earlier row that it is built on; rows that others are built on are stored as gains.
        self.base = {index: self._best_base(self.rows[index], range(1, index)) for index in range(1, s + 1)}
        self.base_of_error = [self._best_base(row, range(1, s if self.late else s + 1)) for row in method.errors]
        used = {*self.base.values(), *self.base_of_error} - {None, s}
        self.stored = {row: slot for slot, row in enumerate(sorted(row for row in used if row is not None))}

    def _best_base(self, row: Row, earlier: Iterable[int]) -> int | None:
        best, cost = None, _terms(row)
        for index in earlier:
            if (found := _terms(_minus(row, self.rows[index])) + 1) < cost:
                best, cost = index, found
        return best

    def _rest(self, row: Row, base: int | None) -> list[Fraction]:
        return list(row) if base is None else _minus(row, self.rows[base])

    def lines(self) -> list[str]:
        return [*self._dense_stages(), *self._middle_node(), *self._dense_weights()]

    def _sum(self, row: Row, base: int | None, name: str) -> tuple[str, str]:
        """Constants of a sum of slopes, and the sum for state i."""
        rest = self._rest(row, base)
        stages = [stage for stage, weight in enumerate(rest) if weight]
        constants = "".join(f" const S {name}{stage} = h * {_number(rest[stage])};" for stage in stages)
        known = [] if base is None else ["gain" if base == self.method.stages else f"k->gain[{self.stored[base]}][i]"]
        return constants, " + ".join(known + [f"{name}{stage} * k->now.k[{stage}][i]" for stage in stages])

    def _stage(self, index: int) -> list[str]:
        slot = self.stored.get(index)
        constants, total = self._sum(self.rows[index], self.base[index], "a")
        gain = "" if slot is None else f"k->gain[{slot}][i] = {total}; "
        body = f"{gain}k->x[i] = k->base[i] + ({total if slot is None else f'k->gain[{slot}][i]'});"
        assert self.method.c[index], "a stage at the start of the step"
        return [
            f"  {{{constants}",
            f"    for (int i = 0; i < NX; ++i) {{ {body} }} }}",
            f"  state_stage(k->c, W_AT(k, {self.times.index(self.method.c[index])}), k->x, k->now.k[{index}]);",
        ]

    def step(self) -> list[str]:
        """``try_step``."""
        s, method, late = self.method.stages, self.method, self.late
        lines = ["static void try_step(Work *k, double correction, S *error, S *guard, S *size) {"]
        lines += ["  const S h = k->step;", "  MEASURE_FROM_ZERO"]
        lines += ["  (void)correction;", "  times_at(k, k->time, h);"]
        lines += ["  for (int i = 0; i < NX; ++i) k->base[i] = k->x0[i] + k->y[i];"]
        for index in range(1, s):
            lines += self._stage(index)
        constants, total = self._sum(self.rows[s], self.base[s], "b")
        lines += [f"  {{{constants}"]
        lines += [] if late else [f"  {self._error_sum(n)[0]}" for n in range(len(method.errors))]
        lines += ["  for (int i = 0; i < NX; ++i) {", f"    const S gain = {total};"]
        lines += [] if late else self._errors()
        lines += ["    k->now.y_end[i] = k->y[i] + gain;", "    k->x[i] = k->x0[i] + k->now.y_end[i];"]
        lines += ["    MEASURE(k, 0, i, k->now.y_end[i] * k->inverse[i]);", "  } }"]
        lines += ["  state_stage(k->c, W_AT(k, TIMES - 1), k->x, k->now.k[END]);", "  {"]
        lines += [f"  {self._error_sum(n)[0]}" for n in range(len(method.errors))] if late else []
        lines += ["  for (int i = 0; i < NX; ++i) {"]
        lines += self._errors() if late else []
        lines += ["    MEASURE(k, 1, i, h * k->now.k[END][i] * k->inverse[i]);", "  } }"]
        lines += [f"  const S worst{n} = LARGEST(k, {n + 2});" for n in range(len(method.errors))]
        lines += [f"  *guard = {' + '.join(f'SQUARES(k, {n})' for n in range(len(method.errors) + 2))};"]
        if len(method.errors) == 1:
            lines += ["  *error = worst0;"]
        else:  # of two estimates the higher order, weighed by the lower
            lines += ["  const S both = worst0 * worst0 + 0.01 * worst1 * worst1;"]
            lines += ["  *error = S_(select)(both == 0.0, both, worst0 * worst0 / S_(sqrt)(both));"]
        return [*lines, "  *size = LARGEST(k, 0);", "}"]

    def _error_sum(self, n: int) -> tuple[str, str]:
        return self._sum(self.method.errors[n], self.base_of_error[n], f"e{n}_")

    def _errors(self) -> list[str]:
        lines = []
        for n in range(len(self.method.errors)):
            lines += [f"    const S error{n} = {self._error_sum(n)[1]};"]
            lines += [f"    MEASURE(k, {n + 2}, i, error{n} * k->inverse[i]);"]
        return lines

    def _dense_stages(self) -> list[str]:
        lines = ["/* Slopes that only the dense output needs. */", "static void dense_stages(Work *k) {"]
        lines += ["  if (k->dense_ready) return;", "  k->dense_ready = 1;"]
        if self.method.extra_c:
            lines += ["  const S h = k->step;", "  stage_times(k, k->time, h, LATE_FRACTIONS, EXTRA, LATE, 1);"]
        for j, row in enumerate(self.method.extra_a):
            terms = [(slot, weight) for slot, weight in enumerate(row) if weight]
            constants = "".join(f" const S a{slot} = h * {_number(weight)};" for slot, weight in terms)
            total = " + ".join(f"a{slot} * k->now.k[{slot}][i]" for slot, _ in terms)
            lines += [f"  {{{constants}"]
            lines += [f"    for (int i = 0; i < NX; ++i) k->x[i] = k->base[i] + ({total}); }}"]
            lines += [f"  state_stage(k->c, W_AT(k, LATE + {j}), k->x, k->now.k[END + {j + 1}]);"]
        return [*lines, "}"]

    def _middle_node(self) -> list[str]:
        lines = [
            "/* State and slope in the middle of the step, where they are not known. */",
            "static void middle_node(Work *k) {",
        ]
        if self.middle is not None:
            return [*lines, "  (void)k;", "}"]
        lines += ["  dense_stages(k);", "  const S h = k->step;"]
        value = [sum((w * HALF ** (m + 1) for m, w in enumerate(row)), ZERO) for row in self.method.dense]
        slope = [sum((w * (m + 1) * HALF**m for m, w in enumerate(row)), ZERO) for row in self.method.dense]
        values = " + ".join(f"{_number(w)} * k->now.k[{n}][i]" for n, w in enumerate(value) if w)
        slopes = " + ".join(f"{_number(w)} * k->now.k[{n}][i]" for n, w in enumerate(slope) if w)
        lines += ["  for (int i = 0; i < NX; ++i) {"]
        lines += [f"    k->now.y_middle[i] = k->y[i] + h * ({values});", f"    k->now.middle_slope[i] = {slopes};"]
        return [*lines, "  }", "}"]

    def _dense_weights(self) -> list[str]:
        if self.middle is not None:
            slots, places = [0, self.middle, self.method.stages], [0, (self.middle + 1) // 2, (self.middle + 1) // 2 + 1]
            polynomials: list[Sequence[Fraction | int]] = [QUINTIC[1], QUINTIC[3], QUINTIC[5]]
        else:
            slots = [n for n, row in enumerate(self.method.dense) if any(row)]
            places, polynomials = slots, [(0, *self.method.dense[n]) for n in slots]
        lines = [
            f"enum {{ TERMS = {len(slots)} }};",
            f"static const int TERM[] = {{{', '.join(map(str, places))}}};",
        ]
        lines += ["/* What slopes, middle and end (from the start) weigh in the state at a fraction theta, and in its rate. */"]
        lines += ["static void dense_weights(V theta, V h, V *value, V *rate) {"]
        for n, polynomial in enumerate(polynomials):
            lines += [f"  value[{n}] = h * ({_horner(polynomial)});", f"  rate[{n}] = {_horner(_derivative(polynomial))};"]
        if self.middle is not None:
            for n, polynomial in enumerate((QUINTIC[2], QUINTIC[4])):
                at = len(slots) + n
                lines += [f"  value[{at}] = {_horner(polynomial)};", f"  rate[{at}] = ({_horner(_derivative(polynomial))}) / h;"]
        return [*lines, "}"]


def _padded(row: Row, length: int) -> list[Fraction]:
    return [*row, *[ZERO] * (length - len(row))]


def _minus(one: Row, other: Row) -> list[Fraction]:
    return [left - right for left, right in zip(one, other, strict=True)]


def _terms(row: Row) -> int:
    return sum(1 for weight in row if weight)


def _derivative(polynomial: Sequence[Fraction | int]) -> list[Fraction]:
    return [Fraction(m * weight) for m, weight in enumerate(polynomial)][1:]


def _number(value: Fraction | int) -> str:
    number = float(value)
    return f"({number!r})" if number < 0 else repr(number)


def _horner(polynomial: Sequence[Fraction | int]) -> str:
    """A polynomial in theta, exact at 0 and, with whole coefficients, at 1."""
    text = ""
    for weight in reversed(polynomial):
        if text and weight:
            text = f"({_number(weight)} + theta * {text})"
        elif text:
            text = f"(theta * {text})"
        elif weight:
            text = f"v_all({_number(weight)})"
    return text or "v_all(0.0)"
