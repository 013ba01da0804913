"""A step-doubled method printed as C: the whole step and its halves share their times and, for angles, need no slopes.

Part of the compiler, beside ``steps``. The rate of an angle is a state of its own, its speed; such a pair is advanced by the
slopes of the speed alone. Where the argument of a stage rests on one earlier stage only, the angle takes the speed of that
stage as it stands; where it rests on more, the speeds are themselves sums of slopes, with the weights A (and A A for the angle),
as in the formulas of Nystrom (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.14).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial

from modelgen.lowering.tableau import Tableau

ZERO, ONE = Fraction(0), Fraction(1)

Row = Sequence[Fraction]
PLACES = {"plain": ("i",), "angles": ("q", "v")}  # names of a state's place in the loops


@dataclass(frozen=True)
class Kinds:
    """Which states are angles with a speed (place by place), and which are on their own.

    >>> Kinds.of([2, 3, None, None]).loops()["angles"]
    'for (int m = 0; m < 2; ++m) { const int q = m, v = m + 2;'
    """

    angles: tuple[int, ...]
    speeds: tuple[int, ...]
    plain: tuple[int, ...]

    @classmethod
    def of(cls, rate_is_state: Sequence[int | None]) -> Kinds:
        """From the state, if any, that the rate of each state is; each speed serves one angle, and is none itself."""
        pairs: dict[int, int] = {}
        for angle, speed in enumerate(rate_is_state):
            if speed is not None and rate_is_state[speed] is None and speed not in pairs.values():
                pairs[angle] = speed
        taken = {*pairs, *pairs.values()}
        plain = tuple(index for index in range(len(rate_is_state)) if index not in taken)
        return cls(tuple(pairs), tuple(pairs.values()), plain)

    def loops(self) -> dict[str, str]:
        """The heads of loops over the states of each kind."""
        heads = {}
        if self.angles:
            names = f"q = {_place(self.angles, 'ANGLES')}, v = {_place(self.speeds, 'SPEEDS')}"
            heads["angles"] = f"for (int m = 0; m < {len(self.angles)}; ++m) {{ const int {names};"
        if self.plain:
            heads["plain"] = f"for (int m = 0; m < {len(self.plain)}; ++m) {{ const int i = {_place(self.plain, 'PLAIN')};"
        return heads

    def tables(self) -> list[str]:
        """Tables of the places that do not follow each other."""
        rows = (("ANGLES", self.angles), ("SPEEDS", self.speeds), ("PLAIN", self.plain))
        return [
            f"static const int {name}[] = {{{', '.join(map(str, row))}}};"
            for name, row in rows
            if row and "[" in _place(row, name)
        ]


def _place(row: tuple[int, ...], table: str) -> str:
    if row != tuple(range(row[0], row[0] + len(row))):
        return f"{table}[m]"
    return f"m + {row[0]}" if row[0] else "m"


class DoubledStep:
    """Prints ``try_step`` of a doubled method with its middle stage, for states of some kinds.

    Arguments of stages start from k->base: the state at the start, and from the middle on the argument there. Slopes of the
    whole step and of both halves share their places, so that all stays in the first cache: the gains of the whole step and of
    the first half are formed as soon as their slopes are there.
    """

    def __init__(self, method: Tableau, middle: int, kinds: Kinds, time_of: dict[int, int]) -> None:
        self.method, self.middle, self.kinds, self.time_of = method, middle, kinds, time_of
        count = method.stages + 1
        self.whole = (middle + 1) // 2  # stages of the method itself
        self.rows = [[*row, *[ZERO] * (count - len(row))] for row in (*method.a, method.b)]

    def lines(self) -> list[str]:
        """C text: tables of places, and try_step."""
        lines = [*self.kinds.tables(), "static void try_step(Work *k, double correction, S *error, S *guard, S *size) {"]
        lines += ["  const S h = k->step, hh = h * h;", "  MEASURE_FROM_ZERO", "  (void)hh, times_at(k, k->time, h);"]
        for index in range(1, self.method.stages):
            lines += self._loops(partial(self._argument, index))
            stage = "state_stage" if index == self.middle else "force_stage"
            lines += [f"  {stage}(k->c, W_AT(k, {self.time_of[index]}), k->x, k->now.k[{self.place(index)}]);"]
        lines += self._loops(self._end)
        lines += ["  state_stage(k->c, W_AT(k, TIMES - 1), k->x, k->now.k[END]);"]
        lines += ["  for (int i = 0; i < NX; ++i) MEASURE(k, 1, i, h * k->now.k[END][i] * k->inverse[i]);"]
        lines += ["  *error = LARGEST(k, 2), *guard = SQUARES(k, 0) + SQUARES(k, 1) + SQUARES(k, 2), *size = LARGEST(k, 0);", "}"]
        return lines

    def place(self, stage: int) -> int:
        """Where the slopes of a stage stand."""
        if stage < self.whole:
            return stage
        if stage < self.middle:
            return stage - self.whole + 1
        if stage == self.middle:
            return self.whole
        return stage - self.middle if stage < self.method.stages else self.whole + 1

    def _loops(self, body: Callable[[str], list[str]]) -> list[str]:
        lines = []
        for kind, head in self.kinds.loops().items():
            self.constants: dict[str, str] = {}
            inside = body(kind)
            constants = "".join(f" const S {name} = {value};" for name, value in self.constants.items())
            lines += [f"  {{{constants}", f"    {head}", *(f"      {line}" for line in inside), "  } }"]
        return lines

    def _weights(self, row: Row, mark: str, power: int = 1) -> list[tuple[int, str]]:
        """The stages in a row, each with a constant: weight times h (or h^2)."""
        found = []
        for stage, weight in enumerate(row):
            if weight:
                name = f"{mark}{stage}"
                self.constants[name] = f"{'hh' if power == 2 else 'h'} * {_number(weight)}"
                found.append((stage, name))
        return found

    def _sum(self, row: Row, place: str, mark: str) -> str:
        return " + ".join(f"{name} * k->now.k[{self.place(stage)}][{place}]" for stage, name in self._weights(row, mark))

    def _angle(self, row: Row, index: int | None, mark: str, behind: bool) -> str:
        """h times a row of speeds, ``behind`` the middle or before; ``index``: the stage whose argument is being built."""
        stages = [stage for stage, weight in enumerate(row) if weight]
        if len(stages) == 1 and index is not None:
            (stage,) = stages
            places = {index - 1: "k->x[v]", 0: "k->base[v]", self.middle: "k->base[v]"}  # x holds the argument before
            if stage in places:
                ((_, name),) = self._weights(row, mark)
                return f"{name} * {places[stage]}"
        reference = self.rows[self.middle] if behind else [ZERO] * len(row)
        total = sum(row, ZERO)
        slopes = [sum((row[j] * (self.rows[j][n] - reference[n]) for j in stages), ZERO) for n in range(len(row))]
        self.constants[f"{mark}_speed"] = f"h * {_number(total)}"
        terms = [f"{name} * k->now.k[{self.place(stage)}][v]" for stage, name in self._weights(slopes, mark, 2)]
        return " + ".join([f"{mark}_speed * k->base[v]", *terms])

    def _gain(self, row: Row, place: str, mark: str, behind: bool) -> str:
        return self._angle(row, None, f"{mark}q", behind) if place == "q" else self._sum(row, place, f"{mark}{place}")

    def _argument(self, index: int, kind: str) -> list[str]:
        places, behind = PLACES[kind], index > self.middle
        lines = [f"k->base[{each}] = k->x0[{each}] + k->y[{each}];" for each in places if index == 1]
        if index == self.whole:
            whole = _minus(self.rows[-1], self.method.errors[0])
            lines += [f"k->gain[WHOLE][{each}] = {self._gain(whole, each, 'w', False)};" for each in places]
        row = _minus(self.rows[index], self.rows[self.middle]) if behind else self.rows[index]
        if index == self.middle:
            lines += [f"const S gain_{each} = {self._gain(row, each, 'a', False)};" for each in places]
            lines += [
                f"k->gain[FIRST][{each}] = gain_{each}, k->base[{each}] = k->x[{each}] = k->base[{each}] + gain_{each};"
                for each in places
            ]
            return lines
        for each in places:
            gain = self._angle(row, index, "q", behind) if each == "q" else self._sum(row, each, each)
            lines += [f"k->x[{each}] = k->base[{each}] + ({gain});"]
        return lines

    def _end(self, kind: str) -> list[str]:
        second = _minus(self.rows[-1], self.rows[self.middle])
        lines = []
        for each in PLACES[kind]:
            lines += [
                f"{{ const S first = k->gain[FIRST][{each}], gain = first + ({self._gain(second, each, 'b', True)});",
                f"  const S error0 = gain - k->gain[WHOLE][{each}], corrected = correction * error0;",
                f"  MEASURE(k, 2, {each}, error0 * k->inverse[{each}]);",
                f"  k->now.y_middle[{each}] = k->y[{each}] + (first + corrected / 2);",
                f"  const S y_end = k->y[{each}] + (gain + corrected);",
                f"  k->now.y_end[{each}] = y_end, k->x[{each}] = k->x0[{each}] + y_end;",
                f"  MEASURE(k, 0, {each}, y_end * k->inverse[{each}]); }}",
            ]
        return lines


def _minus(one: Row, other: Row) -> list[Fraction]:
    return [left - right for left, right in zip(one, [*other, *[ZERO] * (len(one) - len(other))], strict=True)]


def _number(value: Fraction) -> str:
    number = float(value)
    return f"({number!r})" if number < 0 else repr(number)
