"""Where the signs of a driveline drawing stand, in cm, for one distance of columns and one of shaft lines.

Between ``layout`` (columns and levels), ``parts`` (what stands there) and ``names`` (what is written beside it). Every sign takes
its box, so that names keep off it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

from modelgen.plots.glyphs import ARROW, ARROW_STEP, anchor_box, disk_box, torque_box, wheel_box
from modelgen.plots.labels import Point, Room, overlap
from modelgen.plots.layout import Joint, Layout
from modelgen.plots.parts import Anchor, Arrow, Parts, Wheels

LARGEST_DISK, SMALLEST_DISK = 0.80, 0.22  # half heights [cm]
ARROWS_FROM = 0.62  # above a shaft [cm], so that its name finds room below
LARGEST_SHARE = 0.62  # of the distance of two shaft lines that a wheel takes
WHEEL_OFFSETS = (0.33, -0.33, 0.56, -0.56)
BORDER = 0.25


@dataclass(frozen=True)
class WheelPlace:
    """A wheel at a point, of a radius, on a node."""

    node: int
    x: float
    y: float
    radius: float


@dataclass
class Scene:
    """The signs by node, by joint, or in order; ``room`` holds every box that is taken, and the labels."""

    places: Layout
    found: Parts
    pitch: float
    distance: float
    room: Room = field(default_factory=Room)
    at: dict[int, Point] = field(default_factory=dict)
    half_height: dict[int, float] = field(default_factory=dict)
    disks: dict[int, int] = field(default_factory=dict)
    wheels: dict[Joint, tuple[WheelPlace, WheelPlace]] = field(default_factory=dict)
    offsets: dict[int, dict[float, float]] = field(default_factory=dict)
    distant: dict[Joint, tuple[Point, Point]] = field(default_factory=dict)
    shafts: list[tuple[Point, ...]] = field(default_factory=list)
    arrows: list[tuple[float, float, Arrow]] = field(default_factory=list)
    anchors: list[tuple[float, float, Anchor, float]] = field(default_factory=list)

    @property
    def size(self) -> Point:
        left, bottom, right, top = self.room.bounds
        return right - left + 2 * BORDER, top - bottom + 2 * BORDER

    @property
    def middle(self) -> float:
        """Half way across."""
        return (self.places.columns - 1) * self.pitch / 2

    def ends(self, joint: Joint) -> tuple[Point, Point]:
        """Places of the nodes of a joint, the upper one first."""
        first, second = sorted((self.at[joint.first], self.at[joint.second]), key=lambda point: -point[1])
        return first, second


def set_signs(places: Layout, found: Parts, pitch: float, distance: float) -> Scene:
    """The scene with all its signs, without names."""
    made = Scene(places, found, pitch, distance)
    _nodes(made)
    for joint in places.joints:
        if joint.kind == "gear":
            _mesh(made, joint)
    for joint in places.joints:
        if joint.kind == "shaft":
            _shaft(made, joint)
    for node in made.at:
        _anchors(made, node)
        _arrows(made, node)
    _count_signs_that_meet(made)
    return made


def _nodes(made: Scene) -> None:
    largest = max((disk.inertia or 0 for disks in made.found.disks.values() for disk in disks), default=0) or 1.0
    for node, (column, level) in made.places.place.items():
        disks = made.found.disks.get(node, ())
        made.at[node] = (column * made.pitch, -level * made.distance)
        made.disks[node] = len(disks)
        inertia = sum(disk.inertia or 0 for disk in disks)
        # Disks of equal thickness: J grows with the fourth power of the radius.
        made.half_height[node] = max(SMALLEST_DISK, LARGEST_DISK * min(1.0, inertia / largest) ** 0.25)
        made.room.take(disk_box(*made.at[node], made.half_height[node]))


def _mesh(made: Scene, joint: Joint) -> None:
    """Two wheels that touch, or a line between the nodes where they do not stand below each other."""
    upper, lower = sorted((joint.first, joint.second), key=lambda node: -made.at[node][1])
    (upper_column, upper_level), (lower_column, lower_level) = made.places.place[upper], made.places.place[lower]
    if upper_column != lower_column or lower_level - upper_level != 1:
        made.distant[joint] = (made.at[upper], made.at[lower])
        (x1, y1), (x2, y2) = made.distant[joint]
        on_the_way = [(x1 + (x2 - x1) * k / 24, y1 + (y2 - y1) * k / 24) for k in range(25)]
        made.room.take(*((x - 0.05, y - 0.05, x + 0.05, y + 0.05) for x, y in on_the_way))
        return
    share = _share(made.found.wheels[joint.names[0]], upper)
    offset = _offset(made, (upper, lower))
    placed = []
    for node, radius in ((upper, share * made.distance), (lower, (1 - share) * made.distance)):
        x, y = made.at[node]
        made.offsets.setdefault(node, {})[offset] = radius
        made.room.take(wheel_box(x + offset, y, radius))
        made.shafts.append(((x, y), (x + offset, y)))
        placed.append(WheelPlace(node, x + offset, y, radius))
    made.wheels[joint] = (placed[0], placed[1])


def _share(wheels: Wheels, upper: int) -> float:
    """Share of the upper wheel in the distance of the shafts, from the tooth numbers."""
    first, second = wheels.teeth if all(wheels.teeth) else (1, 1)
    share = min(max(first / (first + second), 1 - LARGEST_SHARE), LARGEST_SHARE)
    return share if wheels.first == upper else 1 - share


def _offset(made: Scene, nodes: tuple[int, int]) -> float:
    """Beside the disks, on the side where fewer shafts are."""
    right, left = (sum(_has_neighbor(made.places, node, side) for node in nodes) for side in (1, -1))
    ways = [offset if right <= left else -offset for offset in WHEEL_OFFSETS]
    return next((way for way in ways if not any(way in made.offsets.get(node, {}) for node in nodes)), ways[0])


def _has_neighbor(places: Layout, node: int, side: int) -> bool:
    column, level = places.place[node]
    joined = [joint for joint in places.joints if joint.kind == "shaft" and node in (joint.first, joint.second)]
    return any(places.place[other] == (column + side, level) for joint in joined for other in (joint.first, joint.second))


def _shaft(made: Scene, joint: Joint) -> None:
    (x1, y1), (x2, y2) = made.ends(joint)
    points: tuple[Point, ...] = ((x1, y1), (x2, y2))
    if y1 == y2 and abs(x1 - x2) > 1.5 * made.pitch:  # closes a loop: under the nodes between
        low = y1 - made.distance / 2
        points = ((x1, y1), (x1, low), (x2, low), (x2, y2))
    elif y1 != y2:  # a fold, or a branch: down beside the upper node, then to the lower one
        stem = stem_of(made, joint)
        points = ((x1, y1), (stem, y1), (stem, y2), (x2, y2))
    made.shafts.append(points)
    for (xa, ya), (xb, yb) in pairwise(points):
        made.room.take((min(xa, xb) - 0.03, min(ya, yb) - 0.03, max(xa, xb) + 0.03, max(ya, yb) + 0.03))


def stem_of(made: Scene, joint: Joint) -> float:
    """Where a shaft that leaves its line runs down: outside at a fold, beside the disk at a branch."""
    (x1, _), (x2, _) = made.ends(joint)
    if x1 == x2:
        return x1 + (0.45 if x1 > made.middle else -0.45)
    return x1 + (0.30 if x2 > x1 else -0.30)


def _arrows(made: Scene, node: int) -> None:
    x, y = made.at[node]
    top = y + max([made.half_height[node], ARROWS_FROM, *made.offsets.get(node, {}).values()]) + 0.10
    for arrow in made.found.arrows.get(node, ()):
        made.arrows.append((x, top, arrow))
        made.room.take(torque_box(x, top))
        top += ARROW[1] + ARROW_STEP


def _anchors(made: Scene, node: int) -> None:
    """Below the disk, or beside it where there are several or where wheels mesh."""
    x, y = made.at[node]
    wheels, anchors = made.offsets.get(node), made.found.anchors.get(node, ())
    side = -1.0 if wheels and next(iter(wheels)) > 0 else 1.0
    aside = bool(wheels) or len(anchors) > 1
    for index, anchor in enumerate(anchors):
        along = x + side * (0.42 + 0.5 * index) if aside else x
        top = y if aside else y - made.half_height[node]
        made.anchors.append((along, top, anchor, side if len(anchors) == 1 else 0.0))
        made.room.take(anchor_box(along, top))
        if aside:
            made.shafts.append(((x, y), (along, y)))


def _count_signs_that_meet(made: Scene) -> None:
    """Wheels that reach into another line count as overlaps, as labels do."""
    disks = [disk_box(*made.at[node], made.half_height[node]) for node in made.at]
    placed = [wheel for pair in made.wheels.values() for wheel in pair]
    wheels = [wheel_box(wheel.x, wheel.y, wheel.radius - 0.05) for wheel in placed]  # teeth in mesh may touch
    for index, box in enumerate(wheels):
        made.room.lost += sum(overlap(box, other) for other in (*disks, *wheels[:index]))
