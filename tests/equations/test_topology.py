"""How a driveline hangs together: every way it cannot, each with its one sentence."""

from __future__ import annotations

import pytest

from modelgen.elements import GearPair, GroundDamper, GroundSpring, HarmonicTorque, Inertia, RigidGear, Shaft
from modelgen.equations import assemble
from modelgen.errors import ModelError, NamingError
from modelgen.lowering import lower
from modelgen.model import Driveline

ONE, TWO, THREE = (Inertia(name, inertia=1.0) for name in ("one", "two", "three"))


def shaft(name, a, b):
    return Shaft(name, a, b, stiffness=10.0)


def gear(name, a, b, teeth_a, teeth_b):
    """An elastic pair whose base radii have exactly the ratio of the teeth."""
    return GearPair(name, a, b, teeth_a=teeth_a, teeth_b=teeth_b, module=0.01, mean_stiffness=1e8)


def line(*elements, **more):
    return Driveline("line", elements, **more)


TURNING = {"speed": 100.0, "reference": "one"}


WRONG = [
    # joints
    (line(), ModelError, "driveline 'line': has no elements; add inertias and what joins them"),
    (line(ONE, TWO, Shaft("s", "one", stiffness=1.0)), ModelError, "inertia 'two': is joined to nothing; give flange="),
    (
        line(ONE, Shaft("s", "one", stiffness=1.0)),
        ModelError,
        "shaft 's': flange 'b' is joined to nothing; give b=\"name of an element\" or",
    ),
    (
        line(ONE, shaft("s", "one", "twoo"), TWO),
        NamingError,
        "shaft 's', flange 'b': is joined to 'twoo', but there is no element 'twoo';",
    ),
    (
        line(ONE, shaft("s", "one", "two.b"), TWO),
        NamingError,
        "shaft 's', flange 'b': inertia 'two' has no flange 'b'; known are flange",
    ),
    (
        line(ONE, shaft("s", "one", "t"), shaft("t", "one", "s.b")),
        ModelError,
        "shaft 's', flange 'b': is joined to 't', which has 2 flanges;",
    ),
    (
        line(ONE, shaft("s", "one", "s.a")),
        ModelError,
        "shaft 's': flange 'b' is joined to the element itself; join it to another element",
    ),
    (
        line(ONE, shaft("s", "one", "one")),
        ModelError,
        "shaft 's': its flanges 'a' and 'b' are joined to each other; join them to different",
    ),
    (
        line(ONE, RigidGear("g", "one", "one", teeth_a=2, teeth_b=3)),
        ModelError,
        "rigid_gear 'g': its flanges 'a' and 'b' are joined to each other; join them to different elements",
    ),
    (
        line(ONE, TWO, shaft("s", "one", "two"), connections=[("s.b", "thre")]),
        NamingError,
        "connection 's.b' - 'thre': is joined to 'thre', but there is no element 'thre'; known are",
    ),
    # parts
    (
        line(ONE, TWO, THREE, shaft("s", "one", "two"), GroundDamper("d", "three", damping=1.0)),
        ModelError,
        "driveline 'line': falls into parts: 'three' has no path to 'one'; join the parts with an element",
    ),
    # nodes without inertia
    (
        line(ONE, TWO, shaft("s", "one", "t.a"), shaft("t", "s.b", "two")),
        ModelError,
        "node 's.b': has no inertia; it joins s.b, t.a; put an Inertia on it, or merge the elements",
    ),
    (
        line(ONE, shaft("s", "one", "spring"), GroundSpring("spring", stiffness=1.0)),
        ModelError,
        "node 's.b': has no inertia; it joins s.b, spring.flange; put an Inertia on it",
    ),
    (
        line(ONE, TWO, shaft("s", "one", "g.a"), RigidGear("g", "s.b", "h.a", teeth_a=2, teeth_b=3), shaft("h", "g.b", "two")),
        ModelError,
        "node '.*': has no inertia; it joins .*; put an Inertia on it",
    ),
    # closed loops
    (
        line(ONE, TWO, gear("g", "one", "two", 20, 40), gear("h", "one", "two", 20, 41), **TURNING),
        ModelError,
        "element '[gh]': closes a loop whose gear ratios do not agree; check the tooth numbers on the loop",
    ),
    (
        line(
            ONE,
            TWO,
            THREE,
            gear("g", "one", "two", 20, 40),
            gear("h", "two", "three", 20, 40),
            gear("k", "three", "one", 40, 10),
            **TURNING,
        ),
        ModelError,
        "gear_pair 'k': closes a loop of gears whose senses of rotation contradict; an even number of external gear pairs",
    ),
    (
        line(
            ONE, TWO, RigidGear("g", "one", "two", teeth_a=20, teeth_b=40), RigidGear("h", "one", "two", teeth_a=20, teeth_b=41)
        ),
        ModelError,
        "rigid_gear '[gh]': closes a loop of rigid gears whose ratios do not agree; check the tooth numbers on the loop",
    ),
    (
        line(ONE, TWO, RigidGear("g", "one", "two", teeth_a=20, teeth_b=40), gear("h", "one", "two", 20, 41), **TURNING),
        ModelError,
        "gear_pair 'h': joins two shafts that a rigid gear already joins; take one of them out",
    ),
    (
        line(ONE, TWO, RigidGear("g", "one", "two", mesh="internal", teeth_a=20, teeth_b=40), shaft("s", "one", "two")),
        ModelError,
        "shaft 's': joins two shafts that a rigid gear already joins; take one of them out",
    ),
    # the operating point
    (line(ONE, speed=1.0), ModelError, "driveline 'line': has an operating speed but no reference shaft; give reference="),
    (line(ONE, speed=1.0, reference="on"), NamingError, "reference shaft 'on': there is no such element; nearest is 'one'"),
    (
        line(ONE, TWO, shaft("s", "one", "two"), speed=1.0, reference="s.c"),
        NamingError,
        "reference shaft 's.c': shaft 's' has no flange 'c'; known are a, b",
    ),
    (
        line(ONE, bases={"cycle": ("on", 1)}, **TURNING),
        NamingError,
        "base frequency 'cycle', shaft 'on': there is no such element; nearest is 'one'",
    ),
    (
        line(ONE, HarmonicTorque("t", "one", sine=(1.0,)), **TURNING),
        ModelError,
        "harmonic_torque 't': base is missing; name a base frequency of the driveline",
    ),
    (
        line(ONE, HarmonicTorque("t", "one", sine=(1.0,), base="cycel"), bases={"cycle": 1}, **TURNING),
        NamingError,
        "harmonic_torque 't': there is no base frequency 'cycel'; nearest is 'cycle'",
    ),
    (
        line(ONE, HarmonicTorque("t", "one", sine=(1.0,), base="cycle"), bases={"cycle": 1}),
        ModelError,
        r"driveline 'line': has base frequencies \('cycle'\) but no operating speed; give speed=\"1500 rpm\" and a reference",
    ),
    (
        # of constant stiffness it would need none: nothing then varies with the mesh
        line(ONE, TWO, gear("g", "one", "two", 20, 40).copy(error_amplitude=1e-5)),
        ModelError,
        r"driveline 'line': has base frequencies \('g.contact'\) but no operating speed",
    ),
]


@pytest.mark.parametrize(("wrong", "kind", "words"), WRONG)
def test_what_cannot_hang_together(wrong, kind, words):
    with pytest.raises(kind, match=f"^{words}"):
        assemble(wrong)


def test_one_element_may_stand_alone():
    assert assemble(line(ONE)).groups == ("one",)


def test_a_loop_of_agreeing_elastic_gears_is_lawful():
    closed = line(ONE, TWO, gear("g", "one", "two", 20, 40), gear("h", "one", "two", 30, 60), **TURNING)
    equations = assemble(closed)
    assert [form.state is not None for form in equations.forms] == [True, False]


def test_joined_flanges_share_a_node():
    equations = assemble(
        line(ONE, TWO, shaft("s", "one", "two"), shaft("t", "s.a", "s.b"), HarmonicTorque("load", "t.b", mean=1.0))
    )
    assert [node.flanges for node in equations.nodes] == [
        ("one.flange", "s.a", "t.a"),
        ("two.flange", "s.b", "t.b", "load.flange"),
    ]
    assert [node.name for node in equations.nodes] == ["one", "two"]


@pytest.mark.parametrize(("reference", "speeds"), [("one", (100, 50)), ("two", (200, 100))])
def test_the_operating_speed_is_that_of_the_reference_shaft(reference, speeds):
    for joint in (RigidGear("g", "one", "two", teeth_a=20, teeth_b=40), gear("g", "one", "two", 20, 40)):
        model = lower(assemble(line(ONE, TWO, joint, speed=100.0, reference=reference)))
        now = model.evaluate(0.0, [0.0] * len(model.states), model.parameters.vector())
        assert (now["one.speed"], now["two.speed"]) == pytest.approx(speeds, rel=1e-15)
        assert model.states[0] == f"{reference}.angle_deviation"
