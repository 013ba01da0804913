"""Angles, speeds and other states, and sums of slopes over them printed as C: what the steps of all methods have in common.

Part of the compiler, below ``explicit_step`` and ``doubled_step``. The rate of an angle is a state of its own, its speed; such a
pair is advanced by the slopes of the speed alone. Where the argument of a stage rests on one earlier stage only, the angle takes
the speed of that stage as it stands; where it rests on more, the speeds are themselves sums of slopes, with the weights A (and
A A for the angle), as in the formulas of Nystrom (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.14).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

ZERO = Fraction(0)

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


class StepPrinter:
    """Prints sums of slopes for states of some kinds. ``rows``: the weights of all stages, the end behind the last of them.

    Arguments of stages start from k->base: the state at the start or, where a method is doubled, the argument in the middle.
    """

    def __init__(self, rows: Sequence[Row], kinds: Kinds, middle: int | None = None) -> None:
        count = max(len(row) for row in rows) + 1
        self.rows = [[*row, *[ZERO] * (count - len(row))] for row in rows]
        self.kinds, self.middle = kinds, middle
        self.constants: dict[str, str] = {}

    def place(self, stage: int) -> int:
        """Where the slopes of a stage stand."""
        return stage

    def loops(self, body: Callable[[str], list[str]]) -> list[str]:
        """Loops over the states of each kind, with the constants that their bodies ask for."""
        lines = []
        for kind, head in self.kinds.loops().items():
            self.constants = {}
            if not (inside := body(kind)):
                continue
            constants = "".join(f" const S {name} = {value};" for name, value in self.constants.items())
            lines += [f"  {{{constants}", f"    {head}", *(f"      {line}" for line in inside), "  } }"]
        return lines

    def argument(self, index: int, kind: str, behind: bool = False) -> list[str]:
        """Statements that build the argument of a stage from base on; ``behind`` the middle of a doubled step."""
        row = minus(self.rows[index], self.rows[self.middle]) if behind and self.middle else self.rows[index]
        lines = [f"k->base[{each}] = k->x0[{each}] + k->y[{each}];" for each in PLACES[kind] if index == 1]
        for each in PLACES[kind]:
            gain = self.angle(row, index, each, behind) if each == "q" else self.sum(row, each, each)
            lines += [f"k->x[{each}] = k->base[{each}] + ({gain});"]
        return lines

    def gain(self, row: Row, place: str, mark: str, behind: bool = False) -> str:
        """h times a row of slopes, for the state at a place."""
        return self.angle(row, None, f"{mark}q", behind) if place == "q" else self.sum(row, place, f"{mark}{place}")

    def sum(self, row: Row, place: str, mark: str) -> str:
        """h times a row of slopes, slope by slope."""
        terms = [f"{name} * k->now.k[{self.place(stage)}][{place}]" for stage, name in self._weights(row, mark)]
        return " + ".join(terms) or "S_(all)(0.0)"

    def angle(self, row: Row, index: int | None, mark: str, behind: bool = False) -> str:
        """h times a row of speeds, by the slopes of the speed; ``index``: the stage whose argument is being built."""
        stages = [stage for stage, weight in enumerate(row) if weight]
        if len(stages) == 1 and index is not None:
            places = {index - 1: "k->x[v]", 0: "k->base[v]", self.middle: "k->base[v]"}  # x holds the argument before
            if stages[0] in places:
                ((stage, name),) = self._weights(row, mark)
                return f"{name} * {places[stage]}"
        reference = self.rows[self.middle] if behind and self.middle else [ZERO] * len(row)
        slopes = [sum((row[j] * (self.rows[j][n] - reference[n]) for j in stages), ZERO) for n in range(len(row))]
        terms = [f"{name} * k->now.k[{self.place(stage)}][v]" for stage, name in self._weights(slopes, mark, 2)]
        if total := sum(row, ZERO):
            self.constants[f"{mark}_speed"] = f"h * {number(total)}"
            terms.insert(0, f"{mark}_speed * k->base[v]")
        return " + ".join(terms) or "S_(all)(0.0)"

    def _weights(self, row: Row, mark: str, power: int = 1) -> list[tuple[int, str]]:
        """The stages in a row, each with a constant: weight times h (or h^2). What rounding left of a zero is none."""
        found, least = [], 1e-15 * max(abs(weight) for weight in row)
        for stage, weight in enumerate(row):
            if abs(weight) > least:
                self.constants[f"{mark}{stage}"] = f"{'hh' if power == 2 else 'h'} * {number(weight)}"
                found.append((stage, f"{mark}{stage}"))
        return found


def minus(one: Row, other: Row) -> list[Fraction]:
    """The difference of two rows, the second padded to the length of the first."""
    return [left - right for left, right in zip(one, [*other, *[ZERO] * (len(one) - len(other))], strict=True)]


def number(value: Fraction | int) -> str:
    """A weight as C reads it."""
    text = repr(float(value))
    return f"({text})" if text.startswith("-") else text
