"""Coordinates of a driveline: the relative angles over groups of nodes, and which of them become states.

Part of the grammar, after the nodes are grouped (``modelgen.equations.nodes``). A relative angle that a law sees is a
coordinate where it is independent of those before it; what turns freely keeps a rigid angle of its own. The mean speeds along
these rotations are worked out in ``modelgen.equations.mean_rotation``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import sympy

from modelgen.equations.conditions import Condition, Exact
from modelgen.equations.nodes import Nodes
from modelgen.equations.null_space import NullSpace, Row, null_space
from modelgen.equations.parts import Part
from modelgen.equations.records import Form, StateVariable, Step
from modelgen.errors import ModelError

Placed = dict[int, sympy.Expr]


@dataclass(frozen=True)
class Coordinates:
    """The relative angles (those of each part by index) and the chosen ones, as steps and as states.

    ``rotations``: every group's angle as a row over the groups that keep a rigid angle, when all relative angles stay zero.
    ``states`` are the angles; their rates follow from them.
    """

    forms: tuple[Form, ...]
    forms_of_parts: tuple[tuple[int, ...], ...]
    steps: tuple[Step, ...]
    states: tuple[StateVariable, ...]
    rotations: tuple[Mapping[int, sympy.Expr], ...]
    conditions: tuple[Condition, ...]


def choose_coordinates(parts: Sequence[Part], nodes: Nodes, first: int, reference: str | None, exact: Exact) -> Coordinates:
    """The coordinates, counted from the group ``first``. Raises ModelError for shafts that a rigid gear would wind up."""
    forms, forms_of_parts, conditions = _forms(parts, nodes, exact)
    seen = [index for index, form in enumerate(forms) if form.sees_angle and form.coefficients]
    rows = [forms[index].coefficients for index in seen]
    found = null_space(len(nodes.groups), rows, first, exact, lambda index: element_of(forms[seen[index]]))
    over = _solved_over_coordinates(found, rows, exact)
    steps = []
    for state, (group, row) in enumerate(found.steps):
        form = row if row is not None else found.solved.get(group)
        steps.append(Step(group, state, None if form is None else seen[form], over.get(group)))
    states = _states(forms, steps, nodes.groups, reference)
    for step in steps:
        if step.form is not None:
            forms[step.form] = replace(forms[step.form], state=step.state)
    rotations = tuple(found.over[group] for group in range(len(nodes.groups)))
    return Coordinates(tuple(forms), forms_of_parts, tuple(steps), states, rotations, (*conditions, *found.conditions))


def element_of(form: Form) -> str:
    """Whose relative angle it is, in the words of an error."""
    return f"element {form.name.rpartition('.')[0]!r}"


def _forms(
    parts: Sequence[Part], nodes: Nodes, exact: Exact
) -> tuple[list[Form], tuple[tuple[int, ...], ...], list[Condition]]:
    """Every relative angle over groups, and which of them belong to each part."""
    forms: list[Form] = []
    forms_of_parts: list[tuple[int, ...]] = []
    conditions: list[Condition] = []
    grounded = any(not node.row for node in nodes.nodes)
    for part in parts:
        start = len(forms)
        for relative in part.template.relatives:
            terms: dict[int, list[sympy.Expr]] = {}
            for flange, c in relative.coefficients.items():
                for group, ratio in nodes.nodes[part.nodes[flange]].row.items():
                    terms.setdefault(group, []).append(c.xreplace(part.symbols) * ratio)
            kept = {}
            for group, each in terms.items():
                if len(each) == 1 or not exact.vanishes(each):
                    kept[group] = sympy.Add(*each)
                else:
                    conditions.append(Condition(part.where, tuple(each)))
            wound = len(relative.coefficients) > 1 and len(terms) == 1 and kept
            if wound and relative.sees_angle and not grounded:
                raise ModelError(part.where, "joins two shafts that a rigid gear already joins", "take one of them out")
            to_ground = len(relative.coefficients) == 1
            forms.append(Form(f"{part.name}.{relative.name}", relative.unit, kept, relative.sees_angle, to_ground=to_ground))
        forms_of_parts.append(tuple(range(start, len(forms))))
    return forms, tuple(forms_of_parts), conditions


def _solved_over_coordinates(found: NullSpace, rows: Sequence[Row], exact: Exact) -> dict[int, Placed]:
    """Groups that a left-over relative angle determines, as rows over the states; empty where every row placed its own group.

    A row that was left over becomes a coordinate too: q = sum(c_g angle_g), with each angle over the coordinates before it.
    """
    if not found.solved:
        return {}
    state_of = {group: state for state, (group, _) in enumerate(found.steps)}
    placed: dict[int, Placed] = {}
    for group, row in found.steps:
        if row is None:
            placed[group] = {state_of[group]: sympy.Integer(1)}
        else:
            c = rows[row][group]
            rest = _sum([(-factor / c, placed[other]) for other, factor in rows[row].items() if other != group], exact)
            placed[group] = {**rest, state_of[group]: 1 / c}
    solution: dict[int, Placed] = {}
    for group, row in found.solved.items():
        mine = state_of[group]
        terms = [(c, placed[other]) for other, c in rows[row].items()]
        known = _substituted(_sum(terms, exact), solution, exact)
        pivot = known.pop(mine)
        # The state of this group now stands for the relative angle itself, no longer for the group's angle.
        new = {**{state: -c / pivot for state, c in known.items()}, mine: 1 / pivot}
        solution = {state: _substituted(each, {mine: new}, exact) for state, each in solution.items()}
        solution[mine] = new
    return {group: solution[state_of[group]] for group in found.solved}


def _sum(terms: Sequence[tuple[sympy.Expr, Placed]], exact: Exact) -> Placed:
    """Sum of factors times rows, without entries that cancel."""
    collected: dict[int, list[sympy.Expr]] = {}
    for factor, row in terms:
        for state, c in row.items():
            collected.setdefault(state, []).append(factor * c)
    return {state: sympy.Add(*each) for state, each in collected.items() if len(each) == 1 or not exact.vanishes(each)}


def _substituted(row: Placed, solution: Mapping[int, Placed], exact: Exact) -> Placed:
    """A row with the angles of solved groups written over the coordinates."""
    kept = {state: c for state, c in row.items() if state not in solution}
    return _sum([(sympy.Integer(1), kept), *((c, solution[state]) for state, c in row.items() if state in solution)], exact)


def _states(
    forms: Sequence[Form], steps: Sequence[Step], groups: Sequence[str], reference: str | None
) -> tuple[StateVariable, ...]:
    """A chosen relative angle is a state of its own name; a root's is the deviation from uniform rotation."""
    states: list[StateVariable] = []
    for step in steps:
        if step.form is None:
            name = reference if reference and not states else groups[step.group]
            states.append(StateVariable(f"{name}.angle_deviation", "rad", "rigid"))
        else:
            states.append(StateVariable(forms[step.form].name, forms[step.form].unit, "vibrating"))
    return tuple(states)
