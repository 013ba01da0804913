from __future__ import annotations

import math
from collections.abc import Callable
from itertools import combinations
from typing import Any

import pytest
from matplotlib.figure import Figure

from modelgen.drivelines import load
from modelgen.elements import GroundSpring, Inertia, RigidGear, Shaft, SteppedTorque
from modelgen.equations import assemble
from modelgen.errors import ModelError
from modelgen.model import Driveline, Element, Flange, Param, quantity
from modelgen.plots import draw
from modelgen.plots.labels import overlap
from modelgen.plots.layout import layout
from modelgen.plots.parts import parts
from modelgen.plots.scene import scene
from modelgen.plots.signs import Scene


def scene_of(driveline: Driveline) -> Scene:
    equations = assemble(driveline)
    return scene(layout(equations), parts(equations))


def texts(figure: Figure) -> str:
    return " ".join(text.get_text() for axes in figure.axes for text in axes.texts)


def check_apart(made: Scene) -> None:
    for one, other in combinations(made.at.values(), 2):
        assert math.dist(one, other) > 1.0  # cm
    for (_, one), (_, other) in combinations(made.room.labels, 2):
        assert overlap(one, other) < 1e-9
    assert made.room.lost == 0


def test_truck_fits_the_page_without_overlaps(readable: Callable[..., None]) -> None:
    truck = load("fracturing-truck")
    made = scene_of(truck)
    check_apart(made)
    assert made.size[0] <= 16.5
    assert made.size[0] > made.size[1]
    assert (len(made.at), len(made.arrows), len(made.wheels)) == (16, 9, 2)
    figure = draw(truck)
    readable(figure, numbers=False)
    words = texts(figure)
    for element in truck.elements:
        for word in element.name.split("_"):
            assert word in words
    assert "z = 26" in words
    assert "i = 108/17 = 6.353" in words
    assert "169 rpm" in words


def test_branched_driveline_keeps_its_parts_apart(results: Any, readable: Callable[..., None]) -> None:
    made = scene_of(results.driveline)
    check_apart(made)
    drives = {arrow.name: arrow.drives for _, _, arrow in made.arrows}
    assert drives == {"firing": True, "load": False}
    ((upper, lower),) = made.wheels.values()
    assert upper.x == lower.x
    assert upper.y - upper.radius == pytest.approx(lower.y + lower.radius)  # in mesh
    assert upper.radius < lower.radius
    figure = draw(results.case.model.equations)
    readable(figure, numbers=False)
    assert "500 rpm" in texts(figure)
    assert "[kN·m/rad]" in " ".join(text.get_text() for text in figure.texts)


def test_size_of_a_disk_follows_its_inertia() -> None:
    disks = [Inertia("small", inertia=1.0), Inertia("large", inertia=16.0)]
    made = scene_of(Driveline("pair", elements=[*disks, Shaft("shaft", "small", "large", stiffness=1e4)]))
    assert made.half_height[1] / made.half_height[0] == pytest.approx(2.0)


def test_elements_of_others_are_drawn_by_their_laws(readable: Callable[..., None]) -> None:
    class Propeller(Element):
        """Inertia with water that turns with it."""

        flange = Flange()
        polar = Param("kg*m^2", positive=True)
        water = Param(default=0.25)

        def inertias(self) -> Any:
            return {self.flange: self.polar * (1 + self.water)}

    class WaterDrag(Element):
        """Torque against the square of the speed."""

        flange = Flange()
        drag = Param("N*m*s^2", nonnegative=True)

        @quantity("N*m")
        def resistance(self) -> Any:
            return self.drag * self.flange.speed**2

        def torques(self) -> Any:
            return {self.flange: -self.resistance}

    try:
        line = Driveline(
            "boat",
            elements=[
                Inertia("engine", inertia=1.0),
                Propeller("screw", "screw_shaft.b", polar=4.0),
                Shaft("screw_shaft", "engine", "screw", stiffness=1e5),
                WaterDrag("drag", "screw", drag=0.0),
                GroundSpring("mount", "engine", stiffness=1e3),
                SteppedTorque("start", "engine", after=-20.0),
            ],
        )
        found = parts(assemble(line))
        assert [disk.inertia for disks in found.disks.values() for disk in disks] == [1.0, 5.0]
        assert sorted((anchor.name, anchor.springs) for anchors in found.anchors.values() for anchor in anchors) == [
            ("drag", False),
            ("mount", True),
        ]
        assert [arrow.drives for arrows in found.arrows.values() for arrow in arrows] == [False]
        check_apart(scene_of(line))
        readable(draw(line), numbers=False)
    finally:
        for kind in (Propeller, WaterDrag):
            del Element.vocabulary[kind.kind]


def test_three_gears_on_one_node_are_all_drawn(readable: Callable[..., None]) -> None:
    disks = [Inertia(name, inertia=1.0) for name in ("sun", "one", "two", "three")]
    gears = [RigidGear(f"gear_{name}", "sun", name, teeth_a=20, teeth_b=31) for name in ("one", "two", "three")]
    line = Driveline("spread", elements=[*disks, *gears])
    made = scene_of(line)
    check_apart(made)
    assert len(made.wheels) + len(made.distant) == 3
    readable(draw(line), numbers=False)


def test_two_shafts_side_by_side_are_both_named() -> None:
    disks = [Inertia("one", inertia=1.0), Inertia("two", inertia=2.0)]
    shafts = [Shaft("inner", "one", "two", stiffness=1e4), Shaft("outer", "two", "one", stiffness=2e4)]
    made = scene_of(Driveline("pair", elements=[*disks, *shafts]))
    check_apart(made)
    written = [line.text for block, _ in made.room.labels for line in block.lines]
    assert {"inner", "outer", "10", "20"} <= set(written)


def test_driveline_that_cannot_exist_is_refused_by_its_own_error() -> None:
    line = Driveline("loose", elements=[Inertia("disk", inertia=1.0), Shaft("shaft", "disk", stiffness=1.0)])
    with pytest.raises(ModelError, match=r"shaft 'shaft': flange 'b' is joined to nothing"):
        draw(line)
