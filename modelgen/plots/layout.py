"""Where the parts of a driveline stand when it is drawn: shaft lines as rows, gear pairs between them, branches below.

Plain graph work on ``Equations``; ``drawing`` puts it to paper and ``modes`` draws shapes along it. Nodes joined by shafts make a
shaft line. Its longest path is a row; what branches off becomes a row of its own. Rows hang from the first one, level by level,
each over the column where it is joined, and turn back where they would make the drawing wider.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from modelgen.equations.records import Equations, Instance, Template

Links = Mapping[int, Iterable[int]]
Place = tuple[int, int]
Spans = Mapping[int, list[tuple[int, int]]]
Option = tuple[float, int, list[int], list[int]]
"""Cost, level, columns, and the levels that its connection crosses."""

LONGEST = 10
"""Nodes in a row; a longer line goes on below, on its way back."""


@dataclass(frozen=True)
class Joint:
    """Elements side by side between the same two nodes; ``kind`` is "shaft" or "gear"."""

    first: int
    second: int
    names: tuple[str, ...]
    kind: str


@dataclass(frozen=True)
class Row:
    """Nodes in line. ``hangs_from`` is a node of another row, ``joined_at`` its own node there.

    ``kind`` says by what it hangs: a "gear", a "shaft" that branches off, or a "fold" of one line that is too long.
    """

    nodes: tuple[int, ...]
    hangs_from: int | None = None
    joined_at: int | None = None
    kind: str = ""


@dataclass(frozen=True)
class Layout:
    """``place``: column and level of each node, from (0, 0) at the top left; ``rows`` in the order of hanging together."""

    rows: tuple[Row, ...]
    joints: tuple[Joint, ...]
    place: Mapping[int, Place]

    @property
    def columns(self) -> int:
        return 1 + max((column for column, _ in self.place.values()), default=0)

    @property
    def levels(self) -> int:
        return 1 + max((level for _, level in self.place.values()), default=0)


def is_gear(template: Template) -> bool:
    """Whether an element joins two shafts that turn apart from each other, as wheels do."""
    return template.sense < 0 or {"teeth_a", "teeth_b"} <= {name for name, _ in template.parameters}


def layout(equations: Equations) -> Layout:
    """The layout of a driveline; the same driveline always gives the same one."""
    joints = _joints(equations)
    count = len(equations.nodes)
    shafts, gears = (_links(count, [joint for joint in joints if joint.kind == kind]) for kind in ("shaft", "gear"))
    forward = {(joint.first, joint.second) for joint in joints}
    rows = _rows(count, shafts, gears, forward)
    return Layout(tuple(rows), joints, _places(rows))


def _joints(equations: Equations) -> tuple[Joint, ...]:
    found: dict[tuple[int, int, str], list[str]] = {}
    for instance in equations.instances:
        template = equations.templates[instance.template]
        for first, second in _pairs(instance):
            kind = "gear" if is_gear(template) or len(template.flanges) > 2 else "shaft"
            key = (first, second, kind)
            found.setdefault((second, first, kind) if (second, first, kind) in found else key, []).append(instance.name)
    return tuple(Joint(first, second, tuple(names), kind) for (first, second, kind), names in found.items())


def _pairs(instance: Instance) -> list[tuple[int, int]]:
    """The pairs of nodes that an element joins; one with three flanges or more joins the first to each other one."""
    first, *others = instance.nodes.values()
    return [(first, other) for other in others if other != first]


def _links(count: int, joints: Iterable[Joint]) -> dict[int, list[int]]:
    links: dict[int, list[int]] = {node: [] for node in range(count)}
    for joint in joints:
        links[joint.first].append(joint.second)
        links[joint.second].append(joint.first)
    return links


def _rows(count: int, shafts: Links, gears: Links, forward: set[tuple[int, int]]) -> list[Row]:
    """Rows in the order of hanging together: the one with the first node, what its gears drive, what branches off, and so on."""
    rows: list[Row] = []
    taken: set[int] = set()
    waiting: deque[tuple[int, int | None]] = deque()

    def line_through(node: int, hangs_from: int | None) -> None:
        """The shaft line of a node: its longest path, then its branches."""
        path = _longest_path(_longest_path(node, shafts, taken)[-1], shafts, taken)
        if not _runs_forward(path, forward):
            path.reverse()
        if hangs_from is not None and path[-1] == node:
            path.reverse()
        add(Row(tuple(path), hangs_from, node if hangs_from is not None else None, "gear" if hangs_from is not None else ""))

    def add(row: Row) -> None:
        rows.extend(_folded(row))
        taken.update(row.nodes)
        branches = [(node, other) for node in row.nodes for other in shafts[node]]
        for node, other in branches:
            if other not in taken:
                path = _longest_path(other, shafts, taken)
                add(Row(tuple(path), node, other, "shaft"))
        waiting.extend((other, node) for node in row.nodes for other in gears[node])

    for start in range(count):
        if start in taken:
            continue
        line_through(start, None)
        while waiting:
            node, hangs_from = waiting.popleft()
            if node not in taken:
                line_through(node, hangs_from)
    return rows


def _folded(row: Row) -> list[Row]:
    """A row in parts of bearable length, the one first by which it hangs; the others hang from it on both sides."""
    pieces = [row.nodes[start : start + LONGEST] for start in range(0, len(row.nodes), LONGEST)]
    first = next((index for index, piece in enumerate(pieces) if row.joined_at in piece), 0)
    after = [Row(b, a[-1], b[0], "fold") for a, b in pairwise(pieces[first:])]
    before = [Row(a, b[0], a[-1], "fold") for a, b in pairwise(pieces[: first + 1])]
    return [replace(row, nodes=pieces[first]), *after, *before[::-1]]


def _longest_path(start: int, links: Links, barred: set[int]) -> list[int]:
    """The way from a node to the farthest one that can be reached (the first such in the order of declaration)."""
    before: dict[int, int | None] = {start: None}
    distance, waiting = {start: 0}, deque([start])
    while waiting:
        node = waiting.popleft()
        for other in links[node]:
            if other not in before and other not in barred:
                before[other], distance[other] = node, distance[node] + 1
                waiting.append(other)
    far = max(distance, key=lambda node: (distance[node], -node))
    path = [far]
    while (previous := before[path[-1]]) is not None:
        path.append(previous)
    return path[::-1]


def _runs_forward(path: list[int], forward: set[tuple[int, int]]) -> bool:
    """Whether more elements drive along the path than against it; for a draw, whether it starts at the earlier node."""
    along = sum((a, b) in forward for a, b in pairwise(path))
    against = sum((b, a) in forward for a, b in pairwise(path))
    return along > against or (along == against and path[0] <= path[-1])


def _places(rows: Sequence[Row]) -> dict[int, Place]:
    """Columns and levels, from zero."""
    widest = max(len(row.nodes) for row in rows)
    place: dict[int, Place] = {}
    spans: dict[int, list[tuple[int, int]]] = {}
    stems: dict[int, list[int]] = {}
    waiting, late = deque(rows), set()
    while waiting:
        row = waiting.popleft()
        hung = row.hangs_from is not None
        if hung and row.hangs_from not in place:
            waiting.append(row)
            continue
        options = _options(row, place, spans, stems, widest) if hung else []
        if hung and not options and row not in late:  # everything around is taken: after all others
            late.add(row)
            waiting.append(row)
            continue
        at_the_bottom: Option = (0.0, max(spans, default=-1) + 1, list(range(len(row.nodes))), [])
        _, level, columns, between = min(options, default=at_the_bottom, key=lambda option: option[:2])
        place.update({node: (column, level) for node, column in zip(row.nodes, columns, strict=True)})
        at = [place[row.hangs_from][0]] if row.hangs_from is not None and options else []
        corner = at if row.kind == "shaft" else []
        spans.setdefault(level, []).append((min(*columns, *corner, columns[0]), max(*columns, *corner, columns[0])))
        for each in between:
            stems.setdefault(each, []).extend(at)
    left, top = min(column for column, _ in place.values()), min(level for _, level in place.values())
    return {node: (column - left, level - top) for node, (column, level) in place.items()}


def _options(row: Row, place: Mapping[int, Place], spans: Spans, stems: Mapping[int, list[int]], widest: int) -> list[Option]:
    """Where a row can stand: next to the row it hangs from, onward or back, rather than farther off, above, or wider."""
    assert row.hangs_from is not None
    assert row.joined_at is not None
    column, level = place[row.hangs_from]
    at = row.nodes.index(row.joined_at)
    reach = max(spans) - min(spans) + 1
    options: list[Option] = []
    for way in (1, -1):
        shift = way if row.kind == "shaft" else 0  # a branch leaves its node sideways
        columns = [column + shift + way * (index - at) for index in range(len(row.nodes))]
        first, last = min(*columns, column), max(*columns, column)
        outside = sum(not 0 <= each < widest for each in columns)
        for step in (each for each in range(-reach, reach + 1) if each):
            between = [level + each for each in range(min(step, 0) + 1, max(step, 0))]
            crosses = any(a <= column <= b for each in between for a, b in spans.get(each, []))
            ends = all(last + 1 < a or b + 1 < first for a, b in spans.get(level + step, []))
            if ends and not crosses and not any(first <= stem <= last for stem in stems.get(level + step, [])):
                cost = 10.0 * (abs(step) - 1) + (3.0 if step < 0 else 0.0) + 2.0 * outside + (0.5 if way < 0 else 0.0)
                options.append((cost, level + step, columns, between))
    return options
