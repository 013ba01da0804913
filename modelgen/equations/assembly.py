"""Driveline to Equations: parameters, nodes, groups, coordinates, clocks, outputs. The grammar's main sentence.

Element by element: each contributes torques to its nodes, nobody writes one big Lagrangian (a Lagrange derivation proves this
in the tests). Second stage of the flow: ``Driveline -> Equations``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import sympy

from modelgen.equations.clocks import assign_clocks
from modelgen.equations.conditions import Condition, Exact
from modelgen.equations.coordinates import Coordinates, choose_coordinates
from modelgen.equations.mean_rotation import MeanRotation, mean_rotation
from modelgen.equations.nodes import Nodes, check_inertia, group_nodes
from modelgen.equations.outputs import list_outputs
from modelgen.equations.parameter_table import ParameterTable, with_lengths
from modelgen.equations.parts import Part, TemplateTable
from modelgen.equations.records import Equations, Instance, StateVariable
from modelgen.equations.topology import check_connected, check_senses, join_flanges, reference_node, shaft_node
from modelgen.errors import ModelError, refuse_unless
from modelgen.model import Driveline, Flange, Shared


def assemble(line: Driveline) -> Equations:
    """The equations of motion of a driveline. Raises ModelError, NamingError or UnitError where it cannot exist.

    >>> from modelgen import Driveline, Inertia, Shaft, assemble
    >>> line = Driveline("two_disks", elements=[
    ...     Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), Shaft("shaft", "engine", "load", stiffness=1e4)])
    >>> print(assemble(line))  # doctest: +ELLIPSIS
    equations of 'two_disks': 2 degrees of freedom
      4 states: 1 rigid and 1 vibrating angles, their rates
      ...
    """
    refuse_unless(line, Driveline, "assemble")
    if not line.elements:
        raise ModelError(f"driveline {line.name!r}", "has no elements", "add inertias and what joins them")
    table = ParameterTable(line)
    elements = [with_lengths(line, element) for element in line.elements]
    symbols = [table.add_element(element) for element in elements]
    templates = TemplateTable(elements)
    exact = Exact(table.values, table.derived_values)

    flanges, node_of = join_flanges(line)
    check_connected(line, flanges, node_of)
    check_senses(elements, templates.senses, node_of)
    reference = reference_node(line, node_of)
    parts = templates.parts(elements, symbols, node_of)
    nodes = group_nodes(line, parts, flanges, reference, exact)
    check_inertia(parts, nodes, exact)

    first = nodes.nodes[reference].group
    if not nodes.groups:
        raise ModelError(f"driveline {line.name!r}", "its constraints hold every shaft to ground", "leave something that turns")
    if first is None and line.reference is None:
        first = 0
    if first is None:
        what = f"the reference shaft {line.reference!r} is held to ground by a constraint"
        raise ModelError(f"driveline {line.name!r}", what, "name a shaft that turns")
    coordinates = choose_coordinates(parts, nodes, first, line.reference, exact)
    given = {
        name: (shaft_node(line, name, node_of, f"driveline {line.name!r}, speeds,"), symbol / table.speed)
        for name, symbol in table.speeds.items()
    }
    mean = mean_rotation(line, parts, nodes, coordinates, first, given, exact)

    def ratio(node: int) -> sympy.Expr:
        return nodes.nodes[node].over(mean.ratios)

    for name in (line.reference, *(base.shaft for base in line.bases.values()), *line.speeds):
        if name is not None and name in line.names:
            _check_one_speed(line, name, node_of, nodes, mean, exact)
    clocks, clocks_of_parts, still = assign_clocks(line, parts, node_of, ratio, table.values)
    instances, states = _instances(parts, coordinates, clocks_of_parts)
    return Equations(
        name=line.name,
        description=line.description,
        templates=tuple(templates.templates),
        instances=instances,
        parameters=table.parameters,
        derived=tuple(table.derived),
        nodes=nodes.nodes,
        groups=nodes.groups,
        grounded=tuple(bool(speed == 0) for speed in mean.mean_speeds),
        ratios=mean.ratios,
        mean_speeds=mean.mean_speeds,
        by_speed=mean.by_speed,
        forms=coordinates.forms,
        steps=coordinates.steps,
        rotations=coordinates.rotations,
        clocks=tuple(clocks),
        states=states,
        outputs=list_outputs(parts),
        rigid=_rigid_rotations(parts, coordinates),
        reference=line.reference,
        speed=table.speed,
        modal_ratio=_modal_ratio(line, parts, table),
        balanced=tuple(f"{name}.{line[name].balanced_by}" for name in line.balanced),
        drifts=line.drifts,
        balance_may_drive=line.balance_may_drive,
        constraints=nodes.constraints,
        redundant=nodes.redundant,
        conditions=_distinct((*nodes.conditions, *coordinates.conditions, *mean.conditions, *still)),
        guards=tuple((part.name, guard) for part in parts for guard in part.template.guards),
        modes={f"{part.name}.{modes.name}": modes.values for part in parts for modes in part.template.modes},
        assemblies=dict(line.assemblies),
        source=line,
    )


def _instances(
    parts: Sequence[Part], coordinates: Coordinates, clocks_of_parts: Sequence[dict[str, int]]
) -> tuple[tuple[Instance, ...], tuple[StateVariable, ...]]:
    """The elements as records, and all states: angles, their rates, then the elements' own."""
    angles = coordinates.states
    states = [*angles, *(replace(s, name=f"{s.name}_rate", unit=f"{s.unit}/s", is_rate=True) for s in angles)]
    instances = []
    for part, forms, clocks in zip(parts, coordinates.forms_of_parts, clocks_of_parts, strict=True):
        own = [
            StateVariable(f"{part.name}.{key}", unit, "own", start=start, scale=scale)
            for key, _, unit, start, scale in part.template.states
        ]
        indices = tuple(range(len(states), len(states) + len(own)))
        states += own
        instances.append(Instance(part.name, part.index, part.symbols, part.nodes, clocks, forms, indices))
    return tuple(instances), tuple(states)


def _check_one_speed(
    line: Driveline, name: str, node_of: Mapping[str, int], nodes: Nodes, mean: MeanRotation, exact: Exact
) -> None:
    """Raises ModelError for an element named as a shaft whose flanges turn at different speeds."""
    flanges = list(line[name].declared(Flange))
    if len(flanges) < 2:
        return
    found = [float(exact(nodes.nodes[node_of[f"{name}.{flange}"]].over(mean.ratios))) for flange in flanges]
    if max(found) - min(found) > 1e-9 * max(map(abs, found)):
        named = ", ".join(f"{name}.{flange}" for flange in flanges)
        what = f"{name!r} stands for a shaft, but its flanges turn at different speeds"
        raise ModelError(f"driveline {line.name!r}", what, f"name an inertia, or one of {named}")


def _distinct(conditions: Sequence[Condition]) -> tuple[Condition, ...]:
    """The conditions without those that say the same of the same parameters."""
    return tuple({(each.terms, each.vanishes): each for each in conditions}.values())


def _rigid_rotations(parts: Sequence[Part], coordinates: Coordinates) -> tuple[int, ...]:
    """States of rigid rotations whose angle no law sees."""
    if any(part.template.absolute_angles for part in parts):
        return ()
    return tuple(step.state for step in coordinates.steps if step.form is None)


def _modal_ratio(line: Driveline, parts: Sequence[Part], table: ParameterTable) -> str | None:
    """Name of the parameter that is the damping ratio of all modes, where elements ask for modal damping."""
    names = set()
    for part in parts:
        key = part.template.modal_ratio
        if key is not None:
            value = part.element.values[key]
            names.add(value.name if isinstance(value, Shared) else f"{part.name}.{key}")
    if len(names) > 1 and len({table.by_name[name].values for name in names}) > 1:
        what = f"modal damping has different ratios ({', '.join(sorted(names))})"
        raise ModelError(f"driveline {line.name!r}", what, "share one parameter: all modes have one ratio")
    return min(names, default=None)
