"""The scene of a driveline drawing: the place of every sign and label in cm, before anything is drawn.

Between ``layout`` (columns and levels), ``parts`` (what stands there) and ``drawing``. Columns and levels move apart until no
label lies on anything else.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise, product

from modelgen.plots.glyphs import ARROW, BRONZE, DISK, GROUND, WHEEL, anchor_box, disk_box, torque_box, torque_color, wheel_box
from modelgen.plots.labels import Block, Line, Point, Room, overlap
from modelgen.plots.layout import Joint, Layout
from modelgen.plots.parts import Parts, Wheels
from modelgen.plots.style import GRAY, WIDTH

NAME, NOTE = 6.5, 5.8  # pt
LARGEST_DISK, SMALLEST_DISK = 0.80, 0.22  # half heights [cm]
ARROWS_FROM = 0.62  # above a shaft [cm], so that its name finds room below
LARGEST_SHARE = 0.62  # of the distance of two shaft lines that a wheel takes
SLIDE = 0.16  # cm by which a label moves on while its place is taken
FAR = 0.6  # cm that a label may move
WHEEL_OFFSETS = (0.33, -0.33, 0.56, -0.56)
PITCHES = (2.4, 2.2, 2.0, 1.9, 1.8, 1.7, 1.65, 1.6, 1.55, 1.5, 1.4)
DISTANCES = (2.6, 3.0, 3.4, 3.8, 4.4)
LARGE = 60  # nodes, from which on few scenes are tried
HOPELESS = 1.8  # cm too wide, which moving the shaft lines apart does not cure
BORDER = 0.25

WheelPlace = tuple[float, float, float]


@dataclass
class Scene:
    """Signs by node or joint, columns a ``pitch`` apart; ``room`` holds the labels and every box that is taken."""

    pitch: float = 0.0
    at: dict[int, Point] = field(default_factory=dict)
    half_height: dict[int, float] = field(default_factory=dict)
    disks: dict[int, int] = field(default_factory=dict)
    wheels: list[WheelPlace] = field(default_factory=list)
    shafts: list[tuple[Point, ...]] = field(default_factory=list)
    distant: list[tuple[Point, ...]] = field(default_factory=list)
    arrows: list[tuple[float, float, bool]] = field(default_factory=list)
    anchors: list[tuple[float, float, bool]] = field(default_factory=list)
    room: Room = field(default_factory=Room)

    @property
    def size(self) -> Point:
        left, bottom, right, top = self.room.bounds
        return right - left + 2 * BORDER, top - bottom + 2 * BORDER


def scene(places: Layout, found: Parts) -> Scene:
    """The widest scene that fits the page with every label at its place; where none does, the one that comes nearest."""
    pitches = PITCHES if places.columns > 1 else PITCHES[:1]
    distances = DISTANCES if places.levels > 1 else DISTANCES[:1]
    if len(places.place) > LARGE:
        pitches, distances = (1.6, 1.4), (3.0, 3.8)
    best: tuple[tuple[float, ...], Scene] | None = None
    for pitch, distance in product(pitches, distances):
        if best is not None and best[1].pitch == pitch and best[0][1] > HOPELESS:
            continue
        made = Builder(places, found, pitch, distance).build()
        fault = (round(made.room.lost, 6), max(0.0, made.size[0] - WIDTH - BORDER), max(0.0, made.room.moved - FAR))
        if not any(fault):
            return made
        if best is None or fault < best[0]:
            best = (fault, made)
    assert best is not None
    return best[1]


class Builder:
    """Makes the scene for one distance of columns (``pitch``) and one of shaft lines, both in cm."""

    def __init__(self, places: Layout, found: Parts, pitch: float, distance: float) -> None:
        self.places, self.found, self.pitch, self.distance = places, found, pitch, distance
        self.made = Scene(pitch)
        self.room = self.made.room
        self.offsets: dict[int, dict[float, float]] = {}  # of each node's wheels: offset and radius
        right = max(column for column, _ in places.place.values())
        self.middle = right * pitch / 2

    def build(self) -> Scene:
        made, joints = self.made, self.places.joints
        self._nodes()
        gears = [(joint, self._mesh(joint)) for joint in joints if joint.kind == "gear"]
        shafts = [joint for joint in joints if joint.kind == "shaft"]
        for joint in shafts:
            self._shaft(joint)
        for node in made.at:
            self._arrows(node)
            self._anchors(node)
        for joint, placed in gears:
            self._label_teeth(joint, placed)
        for node in made.at:
            self._label_node(node)
        for joint in shafts:
            self._label_shaft(joint)
        for joint, placed in gears:
            self._label_gear(joint, placed)
        self._label_speeds()
        self._count_signs_that_meet()
        return made

    # -- signs -------------------------------------------------------------------------------------------------------------

    def _nodes(self) -> None:
        made, found = self.made, self.found
        largest = max((disk.inertia or 0 for disks in found.disks.values() for disk in disks), default=0) or 1.0
        for node, (column, level) in self.places.place.items():
            made.at[node] = (column * self.pitch, -level * self.distance)
            made.disks[node] = len(found.disks.get(node, ()))
            inertia = sum(disk.inertia or 0 for disk in found.disks.get(node, ()))
            # Disks of equal thickness: J grows with the fourth power of the radius.
            made.half_height[node] = max(SMALLEST_DISK, LARGEST_DISK * min(1.0, inertia / largest) ** 0.25)
            self.room.take(disk_box(*made.at[node], made.half_height[node]))

    def _mesh(self, joint: Joint) -> list[WheelPlace]:
        """Places and radii of the two wheels, upper one first; empty where they stand too far apart."""
        made = self.made
        nodes = sorted((joint.first, joint.second), key=lambda node: -made.at[node][1])
        (upper_column, upper_level), (lower_column, lower_level) = (self.places.place[node] for node in nodes)
        if upper_column != lower_column or lower_level - upper_level != 1:
            made.distant.append((made.at[nodes[0]], made.at[nodes[1]]))
            (x1, y1), (x2, y2) = made.distant[-1]
            on_the_way = [(x1 + (x2 - x1) * k / 24, y1 + (y2 - y1) * k / 24) for k in range(25)]
            self.room.take(*((x - 0.05, y - 0.05, x + 0.05, y + 0.05) for x, y in on_the_way))
            return []
        share = _share(self.found.wheels[joint.names[0]], nodes[0])
        offset = self._offset(nodes)
        placed = []
        for node, radius in zip(nodes, (share * self.distance, (1 - share) * self.distance), strict=True):
            x, y = made.at[node]
            self.offsets.setdefault(node, {})[offset] = radius
            placed.append((x + offset, y, radius))
            self.room.take(wheel_box(x + offset, y, radius))
            made.shafts.append(((x, y), (x + offset, y)))
        made.wheels += placed
        return placed

    def _offset(self, nodes: list[int]) -> float:
        """Beside the disks, on the side where fewer shafts are."""
        right, left = (sum(self._has_neighbor(node, side) for node in nodes) for side in (1, -1))
        ways = [offset if right <= left else -offset for offset in WHEEL_OFFSETS]
        return next((way for way in ways if not any(way in self.offsets.get(node, {}) for node in nodes)), ways[0])

    def _has_neighbor(self, node: int, side: int) -> bool:
        column, level = self.places.place[node]
        joined = [j for j in self.places.joints if j.kind == "shaft" and node in (j.first, j.second)]
        return any(self.places.place[other] == (column + side, level) for j in joined for other in (j.first, j.second))

    def _shaft(self, joint: Joint) -> None:
        upper, lower = sorted((self.made.at[joint.first], self.made.at[joint.second]), key=lambda point: -point[1])
        (x1, y1), (x2, y2) = upper, lower
        points: tuple[Point, ...] = (upper, lower)
        if y1 == y2 and abs(x1 - x2) > 1.5 * self.pitch:  # closes a loop: under the nodes between
            low = y1 - self.distance / 2
            points = (upper, (x1, low), (x2, low), lower)
        elif y1 != y2:  # a fold, or a branch: down beside the upper node, then to the lower one
            side = 1 if x2 > x1 or (x1 == x2 and x1 > self.middle) else -1
            stem = x1 + side * (0.45 if x1 == x2 else 0.30)
            points = (upper, (stem, y1), (stem, y2), lower)
        self.made.shafts.append(points)
        for (xa, ya), (xb, yb) in pairwise(points):
            self.room.take((min(xa, xb) - 0.03, min(ya, yb) - 0.03, max(xa, xb) + 0.03, max(ya, yb) + 0.03))

    def _arrows(self, node: int) -> None:
        x, y = self.made.at[node]
        top = y + max([self.made.half_height[node], ARROWS_FROM, *self.offsets.get(node, {}).values()]) + 0.10
        for arrow in self.found.arrows.get(node, ()):
            block = Block.of(arrow.name, NAME, 0.95 * self.pitch, color=torque_color(arrow.drives))
            self.made.arrows.append((x, top, arrow.drives))
            self.room.take(torque_box(x, top))
            self.room.put((block, _shifts(x, top + ARROW[1] + block.height / 2 + 0.02, 1, 10)))
            top += ARROW[1] + block.height + 0.12

    def _anchors(self, node: int) -> None:
        """Below the disk, or beside it where there are several or where wheels mesh."""
        x, y = self.made.at[node]
        wheels, anchors = self.offsets.get(node), self.found.anchors.get(node, ())
        side = -1.0 if wheels and next(iter(wheels)) > 0 else 1.0
        aside = bool(wheels) or len(anchors) > 1
        placed = []
        for index, anchor in enumerate(anchors):
            along = x + side * (0.42 + 0.5 * index) if aside else x
            top = y if aside else y - self.made.half_height[node]
            placed.append((along, top, anchor))
            self.made.anchors.append((along, top, anchor.springs))
            self.room.take(anchor_box(along, top))
            if aside:
                self.made.shafts.append(((x, y), (along, y)))
        for along, top, anchor in placed:
            block = Block.of(anchor.name, NAME, 0.9 * self.pitch, anchor.size)
            beside, below = block.width / 2 + 0.30, top - GROUND - 0.18 - block.height / 2
            under = [(along, below), (along - 0.3, below), (along + 0.3, below), (along, below - 0.3), (along, below - 0.6)]
            level = [(along + s * beside, top - GROUND / 2 - down) for down in (0.0, 0.2, 0.4) for s in (side, -side)]
            self.room.put((block, [*under, *level] if len(placed) > 1 else [*level, *under]))

    # -- labels ------------------------------------------------------------------------------------------------------------

    def _label_teeth(self, joint: Joint, placed: list[WheelPlace]) -> None:
        wheels = self.found.wheels[joint.names[0]]
        if not placed or not all(wheels.teeth):
            return
        upper_first = self.made.at[wheels.first][1] > self.made.at[wheels.second][1]
        out = 1 if placed[0][0] > self.made.at[joint.first][0] else -1
        for (x, y, radius), count, way in zip(placed, wheels.teeth if upper_first else wheels.teeth[::-1], (-1, 1), strict=True):
            block = Block((Line(f"z = {count}", NAME, BRONZE),))
            heights = [y + way * max(share * radius, 0.15) for share in (0.75, 0.55, 0.9, 0.35)]
            self.room.put((block, [(x + side * (block.width / 2 + 0.16), height) for height in heights for side in (out, -out)]))

    def _label_node(self, node: int) -> None:
        x, y = self.made.at[node]
        for disk in self.found.disks.get(node, ()):
            size = "" if disk.inertia is None else f"{disk.inertia:.4g}"
            block = Block.of(disk.name, NAME, 0.75 * self.pitch, size)
            away = self.made.half_height[node] + 0.05 + block.height / 2
            aside = block.width / 2 + 0.05
            flush = [-sign * (aside + 0.02 + WHEEL / 2 - abs(offset)) for offset in self.offsets.get(node, {}) for sign in [1 if offset > 0 else -1]]
            shifts = (0.0, 0.35, -0.35, *flush, aside, -aside, aside + 0.45, -aside - 0.45)
            spots = [(x + shift, y + way * (away + index * SLIDE)) for way in (-1, 1) for index in range(14) for shift in shifts]
            self.room.put((block, sorted(spots, key=lambda spot: abs(spot[1] - y) + 0.4 * abs(spot[0] - x) + 0.3 * (spot[1] > y))), tied=not self.offsets.get(node))

    def _label_shaft(self, joint: Joint) -> None:
        """Names above the shaft, stiffness below it; beside the stem of one that turns down."""
        (x1, y1), (x2, y2) = self.made.at[joint.first], self.made.at[joint.second]
        x, gap = (x1 + x2) / 2, max(self.pitch - DISK - 0.08, 0.8)
        for name in joint.names:
            stiffness = self.found.shafts[name].stiffness
            size = "" if stiffness is None else f"{float(self.found.stiffness(stiffness)):.4g}"
            if y1 != y2 and x1 == x2:
                block = Block.of(name, NAME, gap, size)
                stem = x + (0.45 if x > self.middle else -0.45)
                inward = stem + (-1 if x > self.middle else 1) * (block.width / 2 + 0.10)
                self.room.put((block, [(inward, (y1 + y2) / 2 + step * SLIDE) for step in (0, 1, -1, 2, -2, 3, -3, 4, -4)]))
                continue
            y = min(y1, y2)
            if size:
                block = Block((Line(size, NOTE, GRAY),))
                away = 0.09 + block.height / 2
                self.room.put((block, [*_shifts(x, y - away, -1, 2), *_shifts(x, y + away, 1, 8)]))
            forms = [Block.of(name, NAME, width) for width in (gap, gap / 2)]
            near = [(form, _shifts(x, y + form.height / 2 + 0.05, 1, 2)) for form in forms]
            far = [(form, _shifts(x, y + side * (form.height / 2 + 0.05), side, 14)) for form in forms for side in (1, -1)]
            self.room.put(*near, *far)

    def _label_gear(self, joint: Joint, placed: list[WheelPlace]) -> None:
        wheels = self.found.wheels[joint.names[0]]
        driving, driven = wheels.teeth
        ratio = f"i = {driven}/{driving} = {driven / driving:.4g}" if driving and driven else ""
        block = Block.of(wheels.name, NAME, 2.0, ratio, *(f"and {name}" for name in joint.names[1:]), color=BRONZE)
        (x1, y1), (x2, y2) = self.made.at[joint.first], self.made.at[joint.second]
        x, contact = (placed[0][0], placed[0][1] - placed[0][2]) if placed else ((x1 + x2) / 2, (y1 + y2) / 2)
        steps = [0.0, *(sign * k * SLIDE for k in range(1, 9) for sign in (1, -1))]
        inward = -1 if x > self.middle else 1
        beside = block.width / 2 + 0.16
        spots = [(x + side * (beside + more), contact + step) for more in (0.0, 0.8) for step in steps for side in (inward, -inward)]
        self.room.put((block, spots), tied=False)

    def _label_speeds(self) -> None:
        """The speed of every shaft line, near its free end."""
        for row in self.places.rows:
            ends = sorted({row.nodes[0], row.nodes[-1]}, key=lambda node: (node == row.joined_at, self.made.at[node][0]))
            if row.kind in ("shaft", "fold") or ends[0] not in self.found.rpm:
                continue
            block = Block((Line(f"{self.found.rpm[ends[0]]:.4g} rpm", NOTE, GRAY),))
            spots = []
            for node in ends:
                x, y = self.made.at[node]
                over = y + self.made.half_height[node] + 0.05 + block.height / 2
                reach = block.width / 2 + DISK / 2 + 0.08
                spots += [(x, over), *((x + side * (reach + more), y) for more in (0.0, 0.45) for side in (-1, 1)), (x, over + 0.4), (x, over + 0.8)]
            self.room.put((block, spots), tied=False)

    def _count_signs_that_meet(self) -> None:
        """Wheels that reach into another line count as overlaps too."""
        made = self.made
        disks = [disk_box(*made.at[node], made.half_height[node]) for node in made.at]
        wheels = [wheel_box(x, y, radius - 0.05) for x, y, radius in made.wheels]  # teeth in mesh may touch
        for index, box in enumerate(wheels):
            self.room.lost += sum(overlap(box, other) for other in (*disks, *wheels[:index]))


def _share(wheels: Wheels, upper: int) -> float:
    """Share of the upper wheel in the distance of the shafts, from the tooth numbers."""
    first, second = wheels.teeth if all(wheels.teeth) else (1, 1)
    share = min(max(first / (first + second), 1 - LARGEST_SHARE), LARGEST_SHARE)
    return share if wheels.first == upper else 1 - share


def _shifts(x: float, y: float, way: float, count: int) -> Iterator[Point]:
    """Places away from a line, and a little along it."""
    for index in range(count):
        for shift in (0.0, 0.12, -0.12, 0.25, -0.25):
            yield x + shift, y + way * index * SLIDE

