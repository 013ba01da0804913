"""Driveline to Equations: parameters, nodes, groups, coordinates, clocks, outputs. The grammar's main sentence.

Element by element: each contributes torques to its nodes, nobody writes one big Lagrangian (a Lagrange derivation proves this
in the tests). Second stage of the flow: ``Driveline -> Equations``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import sympy

from modelgen.equations.clocks import assign_clocks
from modelgen.equations.coordinates import Coordinates, choose_coordinates
from modelgen.equations.nodes import check_inertia, group_nodes
from modelgen.equations.outputs import list_outputs
from modelgen.equations.parameter_table import ParameterTable, with_lengths
from modelgen.equations.parts import Part, TemplateTable
from modelgen.equations.records import Equations, Instance, StateVariable
from modelgen.equations.topology import Exact, check_connected, check_senses, join_flanges, reference_node
from modelgen.errors import ModelError, refuse_unless
from modelgen.model import Driveline, Shared


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
    exact = Exact(table.values)

    flanges, node_of = join_flanges(line)
    check_connected(line, flanges, node_of)
    check_senses(elements, templates.senses, node_of)
    reference = reference_node(line, node_of)
    parts = templates.parts(elements, symbols, node_of)
    nodes = group_nodes(line, parts, flanges, reference, exact)
    check_inertia(parts, nodes)

    coordinates = choose_coordinates(parts, nodes, nodes.nodes[reference].group, line.reference, exact)

    def ratio(node: int) -> sympy.Expr:
        return coordinates.ratios[nodes.nodes[node].group] * nodes.nodes[node].ratio

    clocks, clocks_of_parts = assign_clocks(line, parts, node_of, ratio)
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
        grounded=tuple(bool(speed == 0) for speed in coordinates.mean_speeds),
        ratios=coordinates.ratios,
        mean_speeds=coordinates.mean_speeds,
        forms=coordinates.forms,
        steps=coordinates.steps,
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
