"""Mean speeds: how fast every group turns in the mean, from the operating speed and the further speeds that are given.

Part of the grammar, after the coordinates are chosen (``modelgen.equations.coordinates``). What holds the mean speeds together,
from strong to weak: constraints and relative angles, which cannot wind up; the speeds that are given; and where these leave a
speed open, the laws that see a speed difference alone, such as a damper or a clutch, which then turns without slip. What ties a
member of a constraint over three flanges to ground counts with the relative angles as long as the reference shaft turns beside
it, as with the ring of a planetary set; where ground holds the reference shaft too, nothing has a mean speed to be given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy

from modelgen.equations.conditions import Condition, Exact
from modelgen.equations.coordinates import Coordinates, element_of
from modelgen.equations.nodes import Nodes, over_nodes
from modelgen.equations.null_space import NullSpace, Row, null_space
from modelgen.equations.parts import Part
from modelgen.equations.records import Form
from modelgen.errors import ModelError
from modelgen.model import Driveline

Speeds = dict[str, sympy.Expr]


@dataclass(frozen=True)
class MeanRotation:
    """Speeds of the groups per speed of the reference shaft, and what each given speed contributes.

    ``ratios`` ignore ground, so that a locked driveline can still refer its angles; ``mean_speeds`` are zero where it holds.
    ``by_speed``: for every group its speed per each of the given speeds (the reference shaft's first), which sum to its own.
    """

    ratios: tuple[sympy.Expr, ...]
    mean_speeds: tuple[sympy.Expr, ...]
    by_speed: tuple[tuple[sympy.Expr, ...], ...]
    conditions: tuple[Condition, ...]


def mean_rotation(
    line: Driveline,
    parts: Sequence[Part],
    nodes: Nodes,
    coordinates: Coordinates,
    first: int,
    given: Mapping[str, tuple[int, sympy.Expr]],
    exact: Exact,
) -> MeanRotation:
    """The mean speeds. ``given``: further speeds by name, each with its node and its value per speed of the reference shaft.

    Raises ModelError for loops that would wind up, for a speed that follows from the others, and for one that is missing.
    """
    count = len(nodes.groups)
    joining = [form for form in coordinates.forms if len(form.coefficients) > 1 and not form.to_ground]
    loose = _without_wind_up(line, parts, nodes, coordinates, first, exact)
    open_speeds = _OpenSpeeds(loose, first, exact)
    for name, (node, _) in given.items():
        row = _over_groups(nodes.nodes[node].row, loose.over)
        if not open_speeds.require(row, name):
            what = f"gives a mean speed to {name!r}, which follows from the others or is held"
            raise ModelError(f"driveline {line.name!r}", what, "take it out of speeds")
    for form in joining:
        if not form.sees_angle:
            open_speeds.require(_over_groups(form.coefficients, loose.over))
    missing = open_speeds.close(
        _must_be_given(nodes, coordinates, joining, loose, open_speeds) if line.speed is not None else set()
    )
    if missing:
        what = f"leaves {len(missing)} further mean speed{'s' * (len(missing) > 1)} free beside that of {line.reference!r}"
        example = ", ".join(f'{name} = "... rpm"' for name in (nodes.groups[group] for group in missing))
        raise ModelError(f"driveline {line.name!r}", what, f"give speeds = {{ {example} }}, or those of other shafts")
    loose_speeds = [open_speeds.of(_over_groups({group: sympy.Integer(1)}, loose.over)) for group in range(count)]
    held = [_combined(row, loose_speeds) for row in coordinates.rotations]
    keys = ("", *given)
    return MeanRotation(
        ratios=tuple(_total(each, given) for each in loose_speeds),
        mean_speeds=tuple(_total(each, given) for each in held),
        by_speed=tuple(tuple(each.get(key, sympy.Integer(0)) for key in keys) for each in held),
        conditions=tuple(loose.conditions),
    )


def _without_wind_up(
    line: Driveline, parts: Sequence[Part], nodes: Nodes, coordinates: Coordinates, first: int, exact: Exact
) -> NullSpace:
    """The rotations that wind up no relative angle, those of ground left out where they hold the reference shaft.

    Raises ModelError for a loop in which nothing can turn though nothing in it is tied to ground.
    """
    count = len(nodes.groups)
    mixed = {group for node in nodes.nodes if len(node.row) > 1 for group in node.row}
    seen = [form for form in coordinates.forms if form.sees_angle and form.coefficients]
    hard = [form for form in seen if len(form.coefficients) > 1 and not form.to_ground]
    ground = [form for form in seen if form.to_ground and mixed & set(form.coefficients)]

    def rotations(forms: Sequence[Form]) -> NullSpace:
        return null_space(count, [form.coefficients for form in forms], first, exact, lambda index: element_of(forms[index]))

    loose = rotations(hard)
    if not all(loose.over.values()):
        _check_loops(line, parts, nodes, hard[list(loose.solved.values())[-1]], exact)
    held = rotations([*hard, *ground]) if ground else loose
    if held.over[first]:
        return held
    return loose if loose.over[first] else rotations([])


def _check_loops(line: Driveline, parts: Sequence[Part], nodes: Nodes, last: Form, exact: Exact) -> None:
    """Raises ModelError where a loop locks itself: its nodes cannot turn even when no constraint holds a node to ground.

    Without an operating speed only members of two flanges count, such as gears and shafts; what springs over three flanges
    leave no rotation is a system that rests, with its natural frequencies.
    """
    rows = [row for row in nodes.constraints if len(row) > 1]
    for part in parts:
        joining = [each.coefficients for each in part.template.relatives if each.sees_angle and len(each.coefficients) > 1]
        rows += [over_nodes(part, row) for row in joining]
    if line.speed is None:
        rows = [row for row in rows if len(row) == 2]
    if not all(null_space(len(nodes.nodes), rows, 0, exact).over.values()):
        what = "closes a loop whose gear ratios do not agree"
        raise ModelError(element_of(last), what, "check the tooth numbers on the loop")


def _must_be_given(
    nodes: Nodes, coordinates: Coordinates, joining: Sequence[Form], loose: NullSpace, open_speeds: _OpenSpeeds
) -> set[int]:
    """Groups beside others whose mean speed something must say: those that a rotation which stays free turns with."""
    touched = {group for form in joining for group in form.coefficients}
    for each in nodes.nodes:
        touched |= set(each.row) if len(each.row) > 1 else set()
    free = [step.group for step in coordinates.steps if step.form is None]
    turning = [set(open_speeds.open(_over_groups({group: sympy.Integer(1)}, loose.over))) for group in free]
    return touched & set().union(*turning)


def _over_groups(row: Row, over: Mapping[int, Row]) -> dict[int, list[sympy.Expr]]:
    """A row over groups as terms over the independent ones."""
    terms: dict[int, list[sympy.Expr]] = {}
    for group, c in row.items():
        for root, ratio in over[group].items():
            terms.setdefault(root, []).append(c * ratio)
    return terms


def _combined(row: Row, speeds: Sequence[Speeds]) -> Speeds:
    """The speed that a row over groups gives."""
    terms: dict[str, list[sympy.Expr]] = {}
    for group, c in row.items():
        for key, value in speeds[group].items():
            terms.setdefault(key, []).append(c * value)
    return {key: sympy.Add(*each) for key, each in terms.items()}


def _total(speeds: Speeds, given: Mapping[str, tuple[int, sympy.Expr]]) -> sympy.Expr:
    """A speed per speed of the reference shaft."""
    return sympy.Add(*(value * given[key][1] if key else value for key, value in speeds.items()))


class _OpenSpeeds:
    """Speeds of the independent groups: found in terms of the given speeds ("" is the reference shaft's), or still open."""

    def __init__(self, loose: NullSpace, first: int, exact: Exact) -> None:
        self.roots, self.exact = loose.independent, exact
        self.solved: dict[int, tuple[dict[int, sympy.Expr], Speeds]] = {first: ({}, {"": sympy.Integer(1)})}
        """Groups with their speed: coefficients over groups that were open then, and what the given speeds add."""

    def require(self, terms: Mapping[int, Sequence[sympy.Expr]], speed: str | None = None) -> bool:
        """Solves a row for an open group, so that it turns with the given speed, or not at all; False where none is open."""
        left, known = self._split(terms)
        if not left:
            return False
        pivot = next(reversed(left))
        c = left.pop(pivot)
        added = {key: -value / c for key, value in known.items()}
        if speed is not None:
            added[speed] = added.get(speed, sympy.Integer(0)) + 1 / c
        self.solved[pivot] = ({root: -each / c for root, each in left.items()}, added)
        return True

    def close(self, must_be_given: set[int]) -> list[int]:
        """Gives what is still open the reference shaft's speed, and returns the groups whose speed should have been given."""
        missing = [root for root in self.roots if root not in self.solved]
        for root in missing:
            self.solved[root] = ({}, {"": sympy.Integer(1)})
        return [root for root in missing if root in must_be_given]

    def of(self, terms: Mapping[int, Sequence[sympy.Expr]]) -> Speeds:
        """The speed of a row, when all are closed."""
        return self._split(terms)[1]

    def open(self, terms: Mapping[int, Sequence[sympy.Expr]]) -> dict[int, sympy.Expr]:
        """What a row takes of the groups that are still open."""
        return self._split(terms)[0]

    def _split(self, terms: Mapping[int, Sequence[sympy.Expr]]) -> tuple[dict[int, sympy.Expr], Speeds]:
        """Coefficients over open groups, and what the solved ones give."""
        still_open: dict[int, list[sympy.Expr]] = {}
        known: dict[str, list[sympy.Expr]] = {}

        def add(root: int, c: sympy.Expr) -> None:
            if root not in self.solved:
                still_open.setdefault(root, []).append(c)
                return
            row, speeds = self.solved[root]
            for other, value in row.items():
                add(other, c * value)
            for key, value in speeds.items():
                known.setdefault(key, []).append(c * value)

        for root, each in terms.items():
            for c in each:
                add(root, c)
        left = {root: sympy.Add(*each) for root, each in still_open.items() if len(each) == 1 or not self.exact.vanishes(each)}
        return left, {key: sympy.Add(*each) for key, each in known.items()}
