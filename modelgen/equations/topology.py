"""How a driveline hangs together: which flanges share a node, whether all is joined, and in which sense loops of gears turn.

Part of the grammar, first look at a driveline (``modelgen.equations.assembly``), before its constraints are solved
(``modelgen.equations.nodes``).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from modelgen.errors import ModelError, NamingError, nearest
from modelgen.model import Driveline, Element, Flange


def join_flanges(line: Driveline) -> tuple[list[list[str]], dict[str, int]]:
    """Nodes as lists of ``element.flange`` and the node of each; raises for a dangling flange or an unknown name."""
    parent = {f"{e.name}.{f}": f"{e.name}.{f}" for e in line.elements for f in e.declared(Flange)}

    def root(name: str) -> str:
        while parent[name] != name:
            parent[name] = parent[parent[name]]
            name = parent[name]
        return name

    def join(first: str, second: str) -> None:
        parent[root(second)] = root(first)

    for element in line.elements:
        for flange, target in element.targets.items():
            name, other = line.flange(target, f"{element.where}, flange {flange!r}")
            if name == element.name:
                raise ModelError(
                    element.where, f"flange {flange!r} is joined to the element itself", "join it to another element"
                )
            join(f"{name}.{other}", f"{element.name}.{flange}")
    for first, second in line.connections:
        pair = [".".join(line.flange(text, f"connection {first!r} - {second!r}")) for text in (first, second)]
        join(*pair)
    nodes: dict[str, list[str]] = {}
    for name in parent:
        nodes.setdefault(root(name), []).append(name)
    for members in nodes.values():
        if len(members) == 1 and len(line.elements) > 1:
            name, flange = members[0].split(".")
            element = line[name]
            what = f"flange {flange!r} is joined to nothing" if len(element.declared(Flange)) > 1 else "is joined to nothing"
            raise ModelError(element.where, what, f'give {flange}="name of an element" or connect({members[0]!r}, ...)')
    listed = list(nodes.values())
    node_of = {name: index for index, members in enumerate(listed) for name in members}
    for element in line.elements:
        flanges = list(element.declared(Flange))
        if len(flanges) == 2 and len({node_of[f"{element.name}.{flange}"] for flange in flanges}) == 1:
            what = f"its flanges {flanges[0]!r} and {flanges[1]!r} are joined to each other"
            raise ModelError(element.where, what, "join them to different elements")
    return listed, node_of


def check_connected(line: Driveline, nodes: Sequence[Sequence[str]], node_of: Mapping[str, int]) -> None:
    """Raises ModelError when the driveline falls into parts."""
    neighbors: dict[int, set[int]] = {index: set() for index in range(len(nodes))}
    for element in line.elements:
        touched = {node_of[f"{element.name}.{f}"] for f in element.declared(Flange)}
        for node in touched:
            neighbors[node] |= touched
    reached, waiting = {0}, [0]
    while waiting:
        for other in neighbors[waiting.pop()] - reached:
            reached.add(other)
            waiting.append(other)
    apart = [nodes[index][0].split(".")[0] for index in neighbors if index not in reached]
    if apart:
        inside = nodes[0][0].split(".")[0]
        shown = ", ".join(repr(name) for name in apart[:4]) + (" ..." if len(apart) > 4 else "")
        raise ModelError(
            f"driveline {line.name!r}", f"falls into parts: {shown} has no path to {inside!r}", "join the parts with an element"
        )


def check_senses(elements: Iterable[Element], senses: Iterable[int], node_of: Mapping[str, int]) -> None:
    """Raises ModelError when a closed loop of gears would have to turn against itself."""
    parent: dict[int, tuple[int, int]] = {}

    def root(node: int) -> tuple[int, int]:
        above, sense = parent.get(node, (node, 1))
        if above == node:
            return node, 1
        top, further = root(above)
        parent[node] = (top, sense * further)
        return parent[node]

    for element, sense in zip(elements, senses, strict=True):
        ends = [node_of[f"{element.name}.{f}"] for f in element.declared(Flange)]
        if len(ends) != 2:
            continue
        (first, s1), (second, s2) = root(ends[0]), root(ends[1])
        if first != second:
            parent[second] = (first, s1 * s2 * sense)
        elif s1 * s2 != sense:
            raise ModelError(
                element.where,
                "closes a loop of gears whose senses of rotation contradict",
                "an even number of external gear pairs must lie on a closed loop",
            )


def reference_node(line: Driveline, node_of: Mapping[str, int]) -> int:
    """Node of the reference shaft; the first node where none is named."""
    if line.reference is None:
        if line.speed is not None and len(line.elements):
            raise ModelError(
                f"driveline {line.name!r}", "has an operating speed but no reference shaft", 'give reference="name of an inertia"'
            )
        return 0
    return shaft_node(line, line.reference, node_of, "reference shaft")


def shaft_node(line: Driveline, name: str, node_of: Mapping[str, int], what: str) -> int:
    """Node of an element named as a shaft (its only or first flange)."""
    where = f"{what} {name!r}"
    if name.partition(".")[0] not in line.names:
        raise NamingError(where, "there is no such element", nearest(name, line.names))
    if "." not in name:
        return node_of[f"{name}.{next(iter(line[name].declared(Flange)))}"]
    return node_of[".".join(line.flange(name, where))]
