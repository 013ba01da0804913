"""What depends on parameters alone: ratios, operating speeds, base frequencies, and the fixed quantities of every law.

First part of ``lower``: ``clocks``, ``motion``, ``forces``, ``channels`` and ``mean_model`` all stand on this one record. It
holds CasADi expressions of the parameter vector p; nothing in it knows time or state.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import sympy

from modelgen.equations.records import Equations, Instance
from modelgen.lowering.blocks import Block
from modelgen.lowering.mass import Terms, add, solve_symmetric
from modelgen.lowering.parameters import ParameterTable
from modelgen.lowering.visitor import Visitor


@dataclass(frozen=True, eq=False)
class Fixed:
    """The equations with their blocks, and every expression of p alone.

    ``ratios`` are the angles of the groups in rigid rotation, ``node_rows`` what each node's angle takes of each group's,
    ``coefficients`` what each form takes of each group's angle, ``constraints`` what each constraint takes of each node's angle,
    ``arms`` what it takes of each flange's,
    ``placed`` the rows over the states of groups that a relative angle determines together with others,
    ``rotations`` the groups' angles over the free rotations, ``by_speed`` their mean speeds over the given ones,
    ``mean_speeds`` [rad/s] the uniform rotation of each group, ``frequencies`` [rad/s] those of the clocks. ``given`` are the
    arguments that every stage of an instance's block begins with: its parameters, node inertias [kg*m^2] and fixed quantities.
    """

    equations: Equations
    parameters: ParameterTable
    blocks: list[Block]
    ratios: list[ca.SX]
    node_rows: list[dict[int, ca.SX]]
    coefficients: list[dict[int, ca.SX]]
    constraints: list[dict[int, ca.SX]]
    arms: list[dict[str, ca.SX]]
    placed: dict[int, dict[int, ca.SX]]
    rotations: list[dict[int, ca.SX]]
    by_speed: list[list[ca.SX]]
    mean_speeds: list[ca.SX]
    frequencies: list[ca.SX]
    given: list[list[ca.SX]]

    @property
    def order(self) -> int:
        """Number of chosen coordinates: the states begin with these, then their rates, then the elements' own states."""
        return len(self.equations.steps)

    @property
    def own_count(self) -> int:
        """Number of the elements' own states."""
        return len(self.equations.states) - 2 * self.order

    def at_node(self, node: int, values: Sequence[ca.SX]) -> ca.SX:
        """The node's angle (or speed, or acceleration), from those of the groups."""
        return sum((c * values[group] for group, c in self.node_rows[node].items()), start=ca.SX(0))

    def block(self, instance: Instance) -> Block:
        """The block that an instance calls."""
        return self.blocks[instance.template]


def fixed_part(equations: Equations) -> Fixed:
    """Everything that parameters alone decide. Raises LoweringError for a law that has no numeric counterpart."""
    parameters = ParameterTable(equations)
    table = parameters.table
    visit = Visitor(table, f"driveline {equations.name!r}")
    blocks = [Block(template) for template in equations.templates]
    speed = table[equations.speed] if equations.speed is not None else ca.SX(0)
    node_rows = [{group: visit(c) for group, c in node.row.items()} for node in equations.nodes]
    inertias = _node_inertias(equations, parameters, node_rows)
    return Fixed(
        equations=equations,
        parameters=parameters,
        blocks=blocks,
        ratios=[visit(each) for each in equations.ratios],
        node_rows=node_rows,
        coefficients=[{group: visit(c) for group, c in form.coefficients.items()} for form in equations.forms],
        constraints=[{node: visit(c) for node, c in row.items()} for row in equations.constraints],
        arms=[
            {flange: Visitor({**table, **_local(parameters, each)}, each.name)(c) for flange, c in row.items()}
            for each in equations.instances
            for row in equations.templates[each.template].constraints
        ],
        placed={
            step.group: {state: visit(c) for state, c in step.over.items()} for step in equations.steps if step.over is not None
        },
        rotations=[{root: visit(c) for root, c in row.items()} for row in equations.rotations],
        by_speed=[[visit(c) for c in row] for row in equations.by_speed],
        mean_speeds=[visit(each) * speed for each in equations.mean_speeds],
        frequencies=[visit(clock.multiple) * speed for clock in equations.clocks],
        given=[_given(blocks[each.template], each, parameters, inertias) for each in equations.instances],
    )


def _given(block: Block, instance: Instance, parameters: ParameterTable, inertias: list[ca.SX]) -> list[ca.SX]:
    own = ca.vertcat(*(parameters.table[instance.symbols[symbol]] for symbol in block.slots.parameters))
    at_flanges = ca.vertcat(*(inertias[instance.nodes[flange]] for flange in block.template.flanges))
    return [own, at_flanges, block.fixed(own, at_flanges)]


def _local(parameters: ParameterTable, instance: Instance) -> dict[sympy.Symbol, ca.SX]:
    """What the parameters of an instance's template are."""
    return {local: parameters.table[other] for local, other in instance.symbols.items()}


def _node_inertias(equations: Equations, parameters: ParameterTable, node_rows: list[dict[int, ca.SX]]) -> list[ca.SX]:
    """Inertia that each node sees rigidly joined to it, of the inertias that do not depend on angle.

    Where planetary sets couple groups it is 1 / (n M^-1 n^T) with the node's row n: what resists a torque on the node while the
    other rotations are free. Zero where nothing constant does.
    """
    alone: dict[int, ca.SX] = {}
    coupled: list[tuple[dict[int, ca.SX], ca.SX]] = []
    for instance in equations.instances:
        template = equations.templates[instance.template]
        if not template.mass:
            continue
        symbols = _local(parameters, instance)
        for (f, g), expression in template.mass.items():
            if f == g and expression.free_symbols <= set(symbols):
                row, inertia = node_rows[instance.nodes[f]], Visitor(symbols, instance.name)(expression)
                if len(row) == 1:
                    [(group, ratio)] = row.items()
                    alone[group] = alone.get(group, ca.SX(0)) + ratio**2 * inertia
                elif row:
                    coupled.append((row, inertia))
    mass: Terms = {(group, group): value for group, value in alone.items()}
    for row, inertia in coupled:
        for i, a in row.items():
            for j, b in row.items():
                add(mass, (i, j), a * b * inertia)
    return [_seen_inertia(row, mass) for row in node_rows]


def _seen_inertia(row: dict[int, ca.SX], mass: Terms) -> ca.SX:
    if not all((group, group) in mass for group in row):
        return ca.SX(0)
    if len(row) == 1:
        [(group, ratio)] = row.items()
        if not any(group in pair and pair != (group, group) for pair in mass):
            return mass[group, group] / ratio**2
    mobility = solve_symmetric(mass, row)
    return 1 / sum((c * mobility[group] for group, c in row.items()), start=ca.SX(0)) if row else ca.SX(0)
