"""Coordinates of a driveline: the relative angles over groups of nodes, which of them become states, and the mean speeds.

Part of the grammar, after the nodes are grouped (``modelgen.equations.nodes``). The choice itself is that of
``modelgen.equations.topology.place``; here it is applied twice, once with ground for the states and once without for the ratios.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import sympy

from modelgen.equations.nodes import Nodes
from modelgen.equations.parts import Part
from modelgen.equations.records import Form, StateVariable, Step
from modelgen.equations.topology import Exact, place, solve_ratio
from modelgen.errors import ModelError


@dataclass(frozen=True)
class Coordinates:
    """The relative angles (those of each part by index), the chosen ones, and speeds per speed of the reference shaft.

    ``ratios`` ignore ground, so that a locked driveline can still refer its angles; ``mean_speeds`` are zero where it holds.
    ``states`` are the angles; their rates follow from them.
    """

    forms: tuple[Form, ...]
    forms_of_parts: tuple[tuple[int, ...], ...]
    steps: tuple[Step, ...]
    states: tuple[StateVariable, ...]
    ratios: tuple[sympy.Expr, ...]
    mean_speeds: tuple[sympy.Expr, ...]


def choose_coordinates(parts: Sequence[Part], nodes: Nodes, first: int, reference: str | None, exact: Exact) -> Coordinates:
    """The coordinates, counted from the group ``first``. Raises ModelError for gear ratios that contradict each other."""
    forms, forms_of_parts = _forms(parts, nodes, exact)
    rows = [form.coefficients for form in forms]
    count = len(nodes.groups)

    seen = [index for index, form in enumerate(forms) if form.sees_angle and form.coefficients]
    placement = place(count, [rows[index] for index in seen], first)
    chosen = [(group, None if index is None else seen[index]) for group, index in placement.steps]

    turning = [index for index, row in enumerate(rows) if len(row) > 1]
    loose = place(count, [rows[index] for index in turning], first)
    loose_steps = [(group, None if index is None else turning[index]) for group, index in loose.steps]
    ones = {group: sympy.Integer(1) for group, index in loose_steps if index is None}
    ratios = [each for _, each in sorted(solve_ratio(loose_steps, rows, ones).items())]

    mean = solve_ratio(chosen, rows, {group: ratios[group] for group, index in chosen if index is None})
    for index in (seen[each] for each in placement.dependent):
        row = rows[index]
        total = sympy.Add(*(c * mean[group] for group, c in row.items()))
        if len(row) > 1 and not exact.vanishes(total, next(iter(row.values()))):
            name = forms[index].name.rpartition(".")[0]
            what = "closes a loop whose gear ratios do not agree"
            raise ModelError(f"element {name!r}", what, "check the tooth numbers on the loop")

    steps = tuple(Step(group, state, index) for state, (group, index) in enumerate(chosen))
    states = _states(forms, steps, nodes.groups, reference)
    for step in steps:
        if step.form is not None:
            forms[step.form] = replace(forms[step.form], state=step.state)
    means = tuple(each for _, each in sorted(mean.items()))
    return Coordinates(tuple(forms), tuple(forms_of_parts), steps, states, tuple(ratios), means)


def _forms(parts: Sequence[Part], nodes: Nodes, exact: Exact) -> tuple[list[Form], list[tuple[int, ...]]]:
    """Every relative angle over groups, and which of them belong to each part."""
    forms: list[Form] = []
    forms_of_parts: list[tuple[int, ...]] = []
    for part in parts:
        start = len(forms)
        for relative in part.template.relatives:
            terms: dict[int, sympy.Expr] = {}
            for flange, c in relative.coefficients.items():
                node = nodes.nodes[part.nodes[flange]]
                terms[node.group] = terms.get(node.group, sympy.Integer(0)) + c.xreplace(part.symbols) * node.ratio
            if len(relative.coefficients) > 1 and len(terms) == 1:
                if not exact.vanishes(next(iter(terms.values())), sympy.Integer(1)):
                    raise ModelError(part.where, "joins two shafts that a rigid gear already joins", "take one of them out")
                terms = {}
            forms.append(Form(f"{part.name}.{relative.name}", relative.unit, terms, relative.sees_angle))
        forms_of_parts.append(tuple(range(start, len(forms))))
    return forms, forms_of_parts


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
