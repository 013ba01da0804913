"""A step-doubled method printed as C: the whole step and its halves share their times, and all its slopes the first cache.

Part of the compiler, beside ``explicit_step``, on ``kinds``.
"""

from __future__ import annotations

from functools import partial

from modelgen.lowering.native.kinds import PLACES, Kinds, StepPrinter, minus
from modelgen.lowering.tableau import Tableau


def place_of(stage: int, middle: int, stages: int) -> int:
    """Where the slopes of a stage stand: those of the whole step and of both halves share their places.

    >>> [place_of(stage, 7, 11) for stage in range(12)]
    [0, 1, 2, 3, 1, 2, 3, 4, 1, 2, 3, 5]
    """
    whole = (middle + 1) // 2  # stages of the method itself
    if stage in (middle, stages):
        return whole + (stage == stages)
    return stage if stage < whole else stage - (whole - 1 if stage < middle else middle)


class DoubledStep(StepPrinter):
    """Prints ``try_step`` of a doubled method with its middle stage, for states of some kinds.

    k->base is the state at the start, and from the middle on the argument there. The gains of the whole step and of the first
    half are formed as soon as their slopes are there, before others take the places of these.
    """

    def __init__(self, method: Tableau, middle: int, kinds: Kinds, time_of: dict[int, int]) -> None:
        super().__init__((*method.a, method.b), kinds, middle)
        self.method, self.time_of, self.half = method, time_of, middle

    def lines(self) -> list[str]:
        """C text: tables of places, and try_step."""
        lines = [*self.kinds.tables(), "static void try_step(Work *k, double correction, S *error, S *guard, S *size) {"]
        lines += ["  const S h = k->step, hh = h * h;", "  MEASURE_FROM_ZERO", "  (void)hh, times_at(k, k->time, h);"]
        for index in range(1, self.method.stages):
            lines += self.loops(partial(self._argument, index))
            stage = "state_stage" if index == self.half else "force_stage"
            lines += [f"  {stage}(k->c, W_AT(k, {self.time_of[index]}), k->x, k->now.k[{self.place(index)}]);"]
        lines += self.loops(self._end)
        lines += ["  state_stage(k->c, W_AT(k, TIMES - 1), k->x, k->now.k[END]);"]
        lines += ["  for (int i = 0; i < NX; ++i) MEASURE(k, 1, i, h * k->now.k[END][i] * k->inverse[i]);"]
        lines += ["  *error = LARGEST(k, 2), *guard = SQUARES(k, 0) + SQUARES(k, 1) + SQUARES(k, 2), *size = LARGEST(k, 0);", "}"]
        return lines

    def place(self, stage: int) -> int:
        """Where the slopes of a stage stand."""
        return place_of(stage, self.half, self.method.stages)

    def _argument(self, index: int, kind: str) -> list[str]:
        places, lines = PLACES[kind], []
        if index == (self.half + 1) // 2:  # the first stage of the first half
            whole = minus(self.rows[-1], self.method.errors[0])
            lines += [f"k->gain[WHOLE][{each}] = {self.gain(whole, each, 'w')};" for each in places]
        if index != self.half:
            return [*lines, *self.argument(index, kind, index > self.half)]
        lines += [f"const S gain_{each} = {self.gain(self.rows[index], each, 'a')};" for each in places]
        for each in places:
            lines += [f"k->gain[FIRST][{each}] = gain_{each}, k->base[{each}] = k->x[{each}] = k->base[{each}] + gain_{each};"]
        return lines

    def _end(self, kind: str) -> list[str]:
        second = minus(self.rows[-1], self.rows[self.half])
        lines = []
        for each in PLACES[kind]:
            lines += [
                f"{{ const S first = k->gain[FIRST][{each}], gain = first + ({self.gain(second, each, 'b', True)});",
                f"  const S error0 = gain - k->gain[WHOLE][{each}], corrected = correction * error0;",
                f"  MEASURE(k, 2, {each}, error0 * k->inverse[{each}]);",
                f"  k->now.y_middle[{each}] = k->y[{each}] + (first + corrected / 2);",
                f"  const S y_end = k->y[{each}] + (gain + corrected);",
                f"  k->now.y_end[{each}] = y_end, k->x[{each}] = k->x0[{each}] + y_end;",
                f"  MEASURE(k, 0, {each}, y_end * k->inverse[{each}]); }}",
            ]
        return lines
