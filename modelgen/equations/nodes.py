"""Nodes and the independent angles among them: every node's angle is a row over those that the constraints leave free.

Part of the grammar, after the flanges are joined (``modelgen.equations.topology``) and before the coordinates are chosen. A rigid
gear leaves one angle of two, a planetary set two of three. A constraint of one flange holds its node to ground.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy

from modelgen.equations.conditions import Condition, Exact
from modelgen.equations.null_space import NullSpace, null_space
from modelgen.equations.parts import Part
from modelgen.equations.records import Node
from modelgen.errors import ModelError
from modelgen.model import Driveline, Flange

SMALL = 1e-9  # of the largest entry: a share of a row that is rounding


@dataclass(frozen=True)
class Nodes:
    """The nodes, the names of their groups (the independent angles), and the constraints as coefficients of node angles.

    ``redundant``: constraints that say nothing new. ``conditions``: what must stay so for the choice to be right.
    """

    nodes: tuple[Node, ...]
    groups: tuple[str, ...]
    constraints: tuple[Mapping[int, sympy.Expr], ...]
    redundant: tuple[int, ...]
    conditions: tuple[Condition, ...]


def group_nodes(line: Driveline, parts: Sequence[Part], flanges: Sequence[Sequence[str]], reference: int, exact: Exact) -> Nodes:
    """The independent angles, the reference shaft's among them, and every node's angle as a row over them.

    Raises ModelError where constraints leave a node no rotation without holding it to ground.
    """
    owners = [part for part in parts for _ in part.template.constraints]
    rows = [over_nodes(part, row) for part in parts for row in part.template.constraints]
    found = null_space(len(flanges), rows, reference, exact, lambda index: owners[index].where)
    inertial = {f"{part.name}.{flange}" for part in parts for flange, _ in part.template.mass}
    names = [_name(line, members, inertial) for members in flanges]
    _check_locked(found, rows, owners, names, exact)
    order: dict[int, int] = {}
    for node in range(len(flanges)):
        for root in found.over[node]:
            order.setdefault(root, len(order))
    nodes = tuple(
        Node(names[node], tuple(members), {order[root]: c for root, c in found.over[node].items()})
        for node, members in enumerate(flanges)
    )
    return Nodes(nodes, tuple(names[root] for root in order), tuple(rows), tuple(found.redundant), tuple(found.conditions))


def over_nodes(part: Part, row: Mapping[str, sympy.Expr]) -> dict[int, sympy.Expr]:
    """Coefficients over flanges of a template as coefficients over nodes."""
    terms: dict[int, sympy.Expr] = {}
    for flange, c in row.items():
        node = part.nodes[flange]
        terms[node] = terms.get(node, sympy.Integer(0)) + c.xreplace(part.symbols)
    return {node: c for node, c in terms.items() if c != 0}


def _check_locked(
    found: NullSpace, rows: Sequence[Mapping[int, sympy.Expr]], owners: Sequence[Part], names: Sequence[str], exact: Exact
) -> None:
    """Raises ModelError for a node whose angle is zero though nothing holds it to ground, with the loop that locks it."""
    still = [node for node, row in found.over.items() if not row]
    if not still:
        return
    free = [index for index, row in enumerate(rows) if len(row) > 1]
    matrix = np.zeros((len(free), len(names)))
    for place, index in enumerate(free):
        for node, c in rows[index].items():
            matrix[place, node] = float(exact(c))
        matrix[place] /= np.abs(matrix[place]).max()
    for node in still:
        unit = np.zeros(len(names))
        unit[node] = 1.0
        shares = np.linalg.lstsq(matrix.T, unit, rcond=None)[0]
        if len(free) and np.abs(matrix.T @ shares - unit).max() < SMALL:
            loop = [owners[free[k]] for k in np.flatnonzero(np.abs(shares) > SMALL * np.abs(shares).max())]
            listed = ", ".join(dict.fromkeys(repr(part.name) for part in loop))
            what = "closes a loop of rigid gears whose ratios do not agree"
            remedy = f"check the tooth numbers on the loop: {listed} together are locked, and {names[node]!r} cannot turn"
            raise ModelError(loop[-1].where, what, remedy)


def _name(line: Driveline, members: Sequence[str], inertial: set[str]) -> str:
    """A node is named after the first inertia on it, else after its first flange."""
    flange = next((name for name in members if name in inertial), members[0])
    element = flange.split(".")[0]
    return element if len(line[element].declared(Flange)) == 1 else flange


def check_inertia(parts: Sequence[Part], found: Nodes, exact: Exact) -> None:
    """Raises ModelError for a rotation without inertia, and for a law that needs a constant one where there is none."""
    nodes, groups = found.nodes, len(found.groups)
    heavy: list[dict[int, sympy.Expr]] = []
    varying: list[dict[int, sympy.Expr]] = []
    for part in parts:
        parameters = {symbol for _, symbols in part.template.parameters for symbol in symbols}
        for (f, g), inertia in part.template.mass.items():
            if f == g:
                row = dict(nodes[part.nodes[f]].row)
                (heavy if inertia.free_symbols <= parameters else varying).append(row)
    _check_every_rotation(found, heavy + varying, exact)
    constant = _Span(heavy, groups, exact)
    for part in parts:
        for flange, index in part.nodes.items():
            if f"{flange}.inertia" in part.names_in_laws and not constant.holds(nodes[index].row):
                what = f"needs the inertia at its flange {flange!r}, but node {nodes[index].name!r} has none that is constant"
                raise ModelError(part.where, what, "put an Inertia on it, or choose another form of damping")


def _check_every_rotation(found: Nodes, heavy: Sequence[Mapping[int, sympy.Expr]], exact: Exact) -> None:
    """Raises ModelError for a group that no inertia resists, by itself or together with others."""
    span = _Span(heavy, len(found.groups), exact)
    for group in range(len(found.groups)):
        if span.holds({group: sympy.Integer(1)}):
            continue
        touching = [node for node in found.nodes if group in node.row]
        node = next((each for each in touching if each.name == found.groups[group]), touching[0])
        what = f"has no inertia; it joins {', '.join(node.flanges)}"
        if any(group in row for row in heavy):
            others = ", ".join(repr(each.name) for each in touching[:4] if each is not node)
            what += f"; those of {others} leave one rotation of the constraints without any"
        raise ModelError(f"node {node.name!r}", what, "put an Inertia on it, or merge the elements")


class _Span:
    """The rotations that a set of rows resists: those that are combinations of them."""

    def __init__(self, rows: Sequence[Mapping[int, sympy.Expr]], groups: int, exact: Exact) -> None:
        self.alone = {next(iter(row)) for row in rows if len(row) == 1}
        self.groups, self.exact = groups, exact
        mixed = [self._numbers(row) for row in rows if len(row) > 1 and not set(row) <= self.alone]
        self.basis = np.array(mixed).reshape(len(mixed), groups)

    def holds(self, row: Mapping[int, sympy.Expr]) -> bool:
        """Whether a row is a combination of the others."""
        if set(row) <= self.alone:
            return True
        wanted = self._numbers(row)
        if not len(self.basis):
            return not wanted.any()
        shares = np.linalg.lstsq(self.basis.T, wanted, rcond=None)[0]
        return bool(np.abs(self.basis.T @ shares - wanted).max() < SMALL)

    def _numbers(self, row: Mapping[int, sympy.Expr]) -> np.ndarray:
        """The row without the groups that are held alone, scaled to 1."""
        numbers = np.zeros(self.groups)
        for group, c in row.items():
            if group not in self.alone:
                numbers[group] = float(self.exact(c))
        return numbers / (np.abs(numbers).max() or 1.0)
