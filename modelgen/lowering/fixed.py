"""What depends on parameters alone: ratios, operating speeds, base frequencies, and the fixed quantities of every law.

First part of ``lower``: ``clocks``, ``motion``, ``forces``, ``channels`` and ``mean_model`` all stand on this one record. It
holds CasADi expressions of the parameter vector p; nothing in it knows time or state.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from modelgen.equations.records import Equations, Instance
from modelgen.lowering.blocks import Block
from modelgen.lowering.parameters import ParameterTable
from modelgen.lowering.visitor import Visitor


@dataclass(frozen=True, eq=False)
class Fixed:
    """The equations with their blocks, and every expression of p alone.

    ``ratios`` are the angles of the groups in rigid rotation, ``node_ratios`` the angle of each node per angle of its group,
    ``coefficients`` what each form takes of each group's angle, ``constraints`` what each rigid gear takes of each node's angle,
    ``mean_speeds`` [rad/s] the uniform rotation of each group, ``frequencies`` [rad/s] those of the clocks. ``given`` are the
    arguments that every stage of an instance's block begins with: its parameters, node inertias [kg*m^2] and fixed quantities.
    """

    equations: Equations
    parameters: ParameterTable
    blocks: list[Block]
    ratios: list[ca.SX]
    node_ratios: list[ca.SX]
    coefficients: list[dict[int, ca.SX]]
    constraints: list[dict[int, ca.SX]]
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
    node_ratios = [visit(node.ratio) for node in equations.nodes]
    inertias = _node_inertias(equations, parameters, node_ratios)
    return Fixed(
        equations=equations,
        parameters=parameters,
        blocks=blocks,
        ratios=[visit(each) for each in equations.ratios],
        node_ratios=node_ratios,
        coefficients=[{group: visit(c) for group, c in form.coefficients.items()} for form in equations.forms],
        constraints=[{node: visit(c) for node, c in row.items()} for row in equations.constraints],
        mean_speeds=[visit(each) * speed for each in equations.mean_speeds],
        frequencies=[visit(clock.multiple) * speed for clock in equations.clocks],
        given=[_given(blocks[each.template], each, parameters, inertias) for each in equations.instances],
    )


def _given(block: Block, instance: Instance, parameters: ParameterTable, inertias: list[ca.SX]) -> list[ca.SX]:
    own = ca.vertcat(*(parameters.table[instance.symbols[symbol]] for symbol in block.slots.parameters))
    at_flanges = ca.vertcat(*(inertias[instance.nodes[flange]] for flange in block.template.flanges))
    return [own, at_flanges, block.fixed(own, at_flanges)]


def _node_inertias(equations: Equations, parameters: ParameterTable, node_ratios: list[ca.SX]) -> list[ca.SX]:
    """Inertia of each node's whole group as the node sees it, of the inertias that do not depend on angle."""
    total = [ca.SX(0)] * len(equations.groups)
    for instance in equations.instances:
        template = equations.templates[instance.template]
        if not template.mass:
            continue
        symbols = {local: parameters.table[other] for local, other in instance.symbols.items()}
        for (f, g), expression in template.mass.items():
            if f == g and expression.free_symbols <= set(symbols):
                node = instance.nodes[f]
                total[equations.nodes[node].group] += node_ratios[node] ** 2 * Visitor(symbols, instance.name)(expression)
    return [total[node.group] / ratio**2 for node, ratio in zip(equations.nodes, node_ratios, strict=True)]
