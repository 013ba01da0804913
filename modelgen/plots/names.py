"""What is written beside the signs of a driveline drawing, and where it would like to stand.

After ``signs``; ``labels`` finds the first place that is free. Torques and ground come first, because they have the least choice,
gear pairs and speeds last, because they say by themselves what they belong to.
"""

from __future__ import annotations

from collections.abc import Iterator

from modelgen.plots.glyphs import ARROW, BRONZE, DISK, GROUND, WHEEL, torque_color
from modelgen.plots.labels import Block, Line, Point
from modelgen.plots.layout import Joint
from modelgen.plots.signs import Scene, stem_of
from modelgen.plots.style import GRAY

NAME, NOTE = 6.5, 5.8  # pt
SLIDE = 0.16  # cm by which a label moves on while its place is taken
RISE_COSTS, SHIFT_COSTS = 0.3, 0.4  # what a node's name above the shaft, or a cm aside, is worth in cm


def put_names(made: Scene) -> Scene:
    """The scene with all its labels."""
    shafts = [joint for joint in made.places.joints if joint.kind == "shaft"]
    _torques(made)
    _anchors(made)
    for joint in made.wheels:
        _teeth(made, joint)
    for node in made.at:
        _inertias(made, node)
    for joint in shafts:
        _shaft(made, joint)
    for joint in (*made.wheels, *made.distant):
        _gear_pair(made, joint)
    _speeds(made)
    return made


def _torques(made: Scene) -> None:
    for x, y, arrow in made.arrows:
        block = Block.of(arrow.name, NAME, 0.95 * made.pitch, color=torque_color(arrow.drives))
        above = y + ARROW[1] + 0.02 + block.height / 2
        beside = ARROW[0] + 0.1 + block.width / 2
        sideways = [(x + beside, y + 0.1), (x - beside, y + 0.1)]
        made.room.put((block, [*_shifts(x, above, 1, 2), *sideways, *_shifts(x, above, 1, 10)]))


def _anchors(made: Scene) -> None:
    for x, y, anchor, side in made.anchors:
        block = Block.of(anchor.name, NAME, 0.9 * made.pitch, anchor.size)
        beside, below = block.width / 2 + 0.30, y - GROUND - 0.18 - block.height / 2
        under = [(x, below), (x - 0.3, below), (x + 0.3, below), (x, below - 0.3), (x, below - 0.6)]
        level = [(x + way * beside, y - GROUND / 2 - down) for down in (0.0, 0.2, 0.4) for way in (side or 1.0, -(side or 1.0))]
        made.room.put((block, [*level, *under] if side else [*under, *level]))


def _teeth(made: Scene, joint: Joint) -> None:
    wheels = made.found.wheels[joint.names[0]]
    if not all(wheels.teeth):
        return
    teeth = {wheels.first: wheels.teeth[0], wheels.second: wheels.teeth[1]}
    for wheel, way in zip(made.wheels[joint], (-1, 1), strict=True):
        block = Block((Line(f"z = {teeth[wheel.node]}", NAME, BRONZE),))
        out = 1 if wheel.x > made.at[wheel.node][0] else -1
        beside = block.width / 2 + 0.16
        heights = [wheel.y + way * max(share * wheel.radius, 0.15) for share in (0.75, 0.55, 0.9, 0.35)]
        made.room.put((block, [(wheel.x + side * beside, height) for height in heights for side in (out, -out)]))


def _inertias(made: Scene, node: int) -> None:
    """Below the disk, or the nearest place around it."""
    x, y = made.at[node]
    for disk in made.found.disks.get(node, ()):
        block = Block.of(disk.name, NAME, 0.75 * made.pitch, "" if disk.inertia is None else f"{disk.inertia:.4g}")
        away = made.half_height[node] + 0.05 + block.height / 2
        aside = block.width / 2 + 0.05
        wheels = made.offsets.get(node, {})
        along_wheels = [(-1 if offset > 0 else 1) * (aside + 0.02 + WHEEL / 2 - abs(offset)) for offset in wheels]
        shifts = (0.0, 0.35, -0.35, *along_wheels, aside, -aside, aside + 0.45, -aside - 0.45)
        spots = [(shift, way * (away + index * SLIDE)) for way in (-1, 1) for index in range(14) for shift in shifts]
        spots.sort(key=lambda spot: abs(spot[1]) + SHIFT_COSTS * abs(spot[0]) + RISE_COSTS * (spot[1] > 0))
        made.room.put((block, [(x + dx, y + dy) for dx, dy in spots]), tied=not wheels)


def _shaft(made: Scene, joint: Joint) -> None:
    """Names above the shaft, stiffness below it; beside the stem of a fold."""
    (x1, y1), (x2, y2) = made.ends(joint)
    x, y, gap = (x1 + x2) / 2, min(y1, y2), max(made.pitch - DISK - 0.08, 0.8)
    for name in joint.names:
        stiffness = made.found.shafts[name].stiffness
        size = "" if stiffness is None else f"{float(made.found.stiffness(stiffness)):.4g}"
        if y1 != y2 and x1 == x2:
            block = Block.of(name, NAME, gap, size)
            inward = stem_of(made, joint) + (-1 if x > made.middle else 1) * (block.width / 2 + 0.10)
            made.room.put((block, [(inward, (y1 + y2) / 2 + step * SLIDE) for step in (0, 1, -1, 2, -2, 3, -3, 4, -4)]))
            continue
        if size:
            block = Block((Line(size, NOTE, GRAY),))
            away = 0.09 + block.height / 2
            made.room.put((block, [*_shifts(x, y - away, -1, 2), *_shifts(x, y + away, 1, 8)]))
        forms = [Block.of(name, NAME, width) for width in (gap, gap / 2)]
        near = [(form, _shifts(x, y + form.height / 2 + 0.05, 1, 2)) for form in forms]
        far = [(form, _shifts(x, y + way * (form.height / 2 + 0.05), way, 14)) for form in forms for way in (1, -1)]
        made.room.put(*near, *far)


def _gear_pair(made: Scene, joint: Joint) -> None:
    """Beside the point of contact, on the inner side of the drawing first."""
    wheels = made.found.wheels[joint.names[0]]
    driving, driven = wheels.teeth
    ratio = f"i = {driven}/{driving} = {driven / driving:.4g}" if driving and driven else ""
    block = Block.of(wheels.name, NAME, 2.0, ratio, *(f"and {name}" for name in joint.names[1:]), color=BRONZE)
    (x1, y1), (x2, y2) = made.ends(joint)
    x, contact = (x1 + x2) / 2, (y1 + y2) / 2
    if joint in made.wheels:
        upper, _ = made.wheels[joint]
        x, contact = upper.x, upper.y - upper.radius
    inward, beside = -1 if x > made.middle else 1, block.width / 2 + 0.16
    steps = [0.0, *(sign * k * SLIDE for k in range(1, 9) for sign in (1, -1))]
    spots = [(side * (beside + more), step) for more in (0.0, 0.8) for step in steps for side in (inward, -inward)]
    made.room.put((block, [(x + dx, contact + dy) for dx, dy in spots]), tied=False)


def _speeds(made: Scene) -> None:
    """The speed of every shaft line, near its free end."""
    for row in made.places.rows:
        ends = sorted({row.nodes[0], row.nodes[-1]}, key=lambda node: (node == row.joined_at, made.at[node][0]))
        if row.kind in ("shaft", "fold") or ends[0] not in made.found.rpm:
            continue
        block = Block((Line(f"{made.found.rpm[ends[0]]:.4g} rpm", NOTE, GRAY),))
        reach = block.width / 2 + DISK / 2 + 0.08
        spots: list[Point] = []
        for node in ends:
            x, y = made.at[node]
            over = y + made.half_height[node] + 0.05 + block.height / 2
            beside = [(x + side * (reach + more), y) for more in (0.0, 0.45) for side in (-1, 1)]
            spots += [(x, over), *beside, (x, over + 0.4), (x, over + 0.8)]
        made.room.put((block, spots), tied=False)


def _shifts(x: float, y: float, way: float, count: int) -> Iterator[Point]:
    """Places away from a line, and a little along it."""
    for index in range(count):
        for shift in (0.0, 0.12, -0.12, 0.25, -0.25):
            yield x + shift, y + way * index * SLIDE
