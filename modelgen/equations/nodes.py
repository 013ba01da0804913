"""Nodes and their groups: what rigid gears join turns in a fixed ratio, and every group needs an inertia.

Part of the grammar, after the flanges are joined (``modelgen.equations.topology``) and before the coordinates are chosen.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy

from modelgen.equations.parts import Part
from modelgen.equations.records import Node
from modelgen.equations.topology import Exact, Placement, place, solve_ratio
from modelgen.errors import ModelError
from modelgen.model import Driveline, Flange


@dataclass(frozen=True)
class Nodes:
    """The nodes, the names of their groups, and the rigid constraints as coefficients of node angles."""

    nodes: tuple[Node, ...]
    groups: tuple[str, ...]
    constraints: tuple[Mapping[int, sympy.Expr], ...]


def group_nodes(line: Driveline, parts: Sequence[Part], flanges: Sequence[Sequence[str]], reference: int, exact: Exact) -> Nodes:
    """Groups of nodes that rigid constraints join, with the ratio of each node to its group (1 for the reference shaft)."""
    constraints = [(part, _over_nodes(part, row)) for part in parts for row in part.template.constraints]
    rows = [terms for _, terms in constraints]
    placement = place(len(flanges), rows, reference)
    roots = {node: sympy.Integer(1) for node, index in placement.steps if index is None}
    ratio = solve_ratio(placement.steps, rows, roots)
    group_of = _groups(placement, constraints)
    for index in placement.dependent:
        part, terms = constraints[index]
        total = sympy.Add(*(c * ratio[node] for node, c in terms.items()))
        if not exact.vanishes(total, next(iter(terms.values()))):
            what = "closes a loop of rigid gears whose ratios do not agree"
            raise ModelError(part.where, what, "check the tooth numbers on the loop")
    order = {group: index for index, group in enumerate(dict.fromkeys(group_of[node] for node in range(len(flanges))))}
    inertial = {f"{part.name}.{flange}" for part in parts for flange, _ in part.template.mass}
    nodes = tuple(
        Node(_name(line, members, inertial), tuple(members), order[group_of[node]], ratio[node])
        for node, members in enumerate(flanges)
    )
    names = tuple(next(node.name for node in nodes if node.group == group and node.ratio == 1) for group in order.values())
    return Nodes(nodes, names, tuple(rows))


def _over_nodes(part: Part, row: Mapping[str, sympy.Expr]) -> dict[int, sympy.Expr]:
    """Coefficients over flanges of a template as coefficients over nodes."""
    terms: dict[int, sympy.Expr] = {}
    for flange, c in row.items():
        node = part.nodes[flange]
        terms[node] = terms.get(node, sympy.Integer(0)) + c.xreplace(part.symbols)
    return terms


def _groups(placement: Placement, constraints: Sequence[tuple[Part, Mapping[int, sympy.Expr]]]) -> dict[int, int]:
    """The group of each node: a root starts one, and the others follow what their constraint joins them to."""
    group_of: dict[int, int] = {}
    for node, index in placement.steps:
        if index is None:
            group_of[node] = len(set(group_of.values()))
            continue
        part, terms = constraints[index]
        others = [other for other in terms if other != node]
        if not others:
            raise ModelError(part.where, "its constraint fixes one node to ground", "use a ground spring")
        group_of[node] = group_of[others[0]]
    return group_of


def _name(line: Driveline, members: Sequence[str], inertial: set[str]) -> str:
    """A node is named after the first inertia on it, else after its first flange."""
    flange = next((name for name in members if name in inertial), members[0])
    element = flange.split(".")[0]
    return element if len(line[element].declared(Flange)) == 1 else flange


def check_inertia(parts: Sequence[Part], found: Nodes) -> None:
    """Raises ModelError for a group without inertia, and for a law that needs a constant one where there is none."""
    nodes, heavy, constant = found.nodes, set(), set()
    for part in parts:
        parameters = {symbol for _, symbols in part.template.parameters for symbol in symbols}
        for (f, g), inertia in part.template.mass.items():
            if f == g:
                heavy.add(nodes[part.nodes[f]].group)
                if inertia.free_symbols <= parameters:
                    constant.add(nodes[part.nodes[f]].group)
    for group, name in enumerate(found.groups):
        if group not in heavy:
            node = next(node for node in nodes if node.group == group)
            what = f"has no inertia; it joins {', '.join(node.flanges)}"
            raise ModelError(f"node {name!r}", what, "put an Inertia on it, or merge the elements")
    for part in parts:
        for flange, index in part.nodes.items():
            if nodes[index].group not in constant and f"{flange}.inertia" in part.names_in_laws:
                what = f"needs the inertia at its flange {flange!r}, but node {nodes[index].name!r} has none that is constant"
                raise ModelError(part.where, what, "put an Inertia on it, or choose another form of damping")
