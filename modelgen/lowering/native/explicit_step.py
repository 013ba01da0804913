"""A step of an explicit Runge-Kutta method printed as C, and the slopes of angles that only its dense output needs.

Part of the compiler, beside ``doubled_step``, on ``kinds``.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from modelgen.lowering.native.kinds import PLACES, Kinds, StepPrinter
from modelgen.lowering.tableau import Tableau


class ExplicitStep(StepPrinter):
    """Prints ``try_step`` of a method with an error of its own, for states of some kinds."""

    def __init__(self, method: Tableau, kinds: Kinds, time_of: Mapping[int, int]) -> None:
        super().__init__((*method.a, method.b), kinds)
        self.method, self.time_of = method, time_of
        self.late = any(row[method.stages] for row in method.errors)  # the error needs the slope at the end

    def lines(self) -> list[str]:
        """C text: tables of places, try_step and angle_slopes."""
        s, estimates = self.method.stages, range(len(self.method.errors))
        lines = [*self.kinds.tables(), "static void try_step(Work *k, double correction, S *error, S *guard, S *size) {"]
        lines += ["  const S h = k->step, hh = h * h;", "  MEASURE_FROM_ZERO", "  (void)hh, (void)correction;"]
        lines += ["  times_at(k, k->time, h);"]
        for index in range(1, s):
            assert self.method.c[index], "a stage at the start of the step"
            lines += self.loops(partial(self.argument, index))
            lines += [f"  force_stage(k->c, W_AT(k, {self.time_of[index]}), k->x, k->now.k[{index}]);"]
        lines += self.loops(self._end)
        lines += ["  state_stage(k->c, W_AT(k, TIMES - 1), k->x, k->now.k[END]);"]
        lines += self.loops(self._after)
        lines += [f"  const S worst{n} = LARGEST(k, {n + 2});" for n in estimates]
        lines += [f"  *guard = {' + '.join(f'SQUARES(k, {n})' for n in range(len(estimates) + 2))}, *size = LARGEST(k, 0);"]
        if len(estimates) == 1:
            lines += ["  *error = worst0;"]
        else:  # of two estimates the higher order, weighed by the lower
            lines += ["  const S both = worst0 * worst0 + 0.01 * worst1 * worst1;"]
            lines += ["  *error = S_(select)(both == 0.0, both, worst0 * worst0 / S_(sqrt)(both));"]
        return [*lines, "}", *self._angle_slopes()]

    def _end(self, kind: str) -> list[str]:
        lines = []
        for each in PLACES[kind]:
            lines += [f"{{ const S y_end = k->y[{each}] + ({self.gain(self.rows[-1], each, 'b')});"]
            lines += [f"  k->now.y_end[{each}] = y_end, k->x[{each}] = k->x0[{each}] + y_end;"]
            lines += [f"  MEASURE(k, 0, {each}, y_end * k->inverse[{each}]); }}"]
            lines += [] if self.late else self._errors(each)
        return lines

    def _after(self, kind: str) -> list[str]:
        lines = []
        for each in PLACES[kind]:
            lines += self._errors(each) if self.late else []
            lines += [f"MEASURE(k, 1, {each}, h * k->now.k[END][{each}] * k->inverse[{each}]);"]
        return lines

    def _errors(self, place: str) -> list[str]:
        return [
            f"MEASURE(k, {n + 2}, {place}, ({self.gain(row, place, f'e{n}')}) * k->inverse[{place}]);"
            for n, row in enumerate(self.method.errors)
        ]

    def _angle_slopes(self) -> list[str]:
        """The slopes of angles within the step: the speeds of the arguments."""

        def body(kind: str) -> list[str]:
            rows = enumerate(self.rows[1 : self.method.stages], start=1)
            return [f"k->now.k[{n}][q] = k->base[v] + ({self.sum(row, 'v', f's{n}_')});" for n, row in rows if kind == "angles"]

        lines = ["static void angle_slopes(Work *k) {", "  const S h = k->step;", "  (void)h;"]
        return [*lines, *self.loops(body), "}"]
