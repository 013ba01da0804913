"""Elements: what a class may declare, what an instance may be given, and an element as a value."""

from __future__ import annotations

import doctest
import math

import numpy as np
import pytest
import sympy

from modelgen.elements import GearPair, HarmonicTorque, Inertia, RigidGear, Shaft
from modelgen.errors import ModelError, NamingError, UnitError
from modelgen.model import Choice, Element, Flange, Param, Shared, State, quantity


def shaft(name="s", /, *, k=5.0, **given):
    return Shaft(name, "left", "right", stiffness=k, **given)


def test_values_are_si_floats_however_they_are_given():
    assert shaft(k="35 kN*m/deg").values["stiffness"] == pytest.approx(35e3 * 180 / math.pi, rel=1e-15)
    assert [shaft(k=k).values["stiffness"] for k in (7, 7.0, np.float64(7), np.int64(7), sympy.Integer(7))] == [7.0] * 5
    assert all(type(shaft(k=k).values["stiffness"]) is float for k in (7, np.float64(7), sympy.Integer(7)))
    assert shaft(k="soft").values["stiffness"] == shaft(k=Shared("soft")).values["stiffness"] == Shared("soft")
    table = GearPair(
        "m", "a", "b", teeth_a=2, teeth_b=3, module=1, mesh="table", stiffness_table=np.array([1, 2]), damping_ratio=Shared("xi")
    ).values
    assert table["stiffness_table"] == (1.0, 2.0)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (-1.0, "is -1 N.m/rad; give a positive value"),
        (0, "is 0 N.m/rad; give a positive value"),
        (math.nan, "nan is not a finite number; give a finite value"),
        (-math.inf, "-inf is not a finite number; give a finite value"),
        (10**400, "the number is out of range"),
        ("1e999 N*m/rad", "inf is not a finite number"),
        (None, "stiffness is missing; give it in N.m/rad"),
        (True, "True is not a number; give a number in N.m/rad"),
        (1j, "1j is not a number"),
        ([1.0], r"\[1.0\] is not a number"),
        (np.ones(2), "is not a number"),
        (sympy.Symbol("k"), "k is not a number"),
        ("5", "5.0 has no unit; write \"5.0 N.m/rad\" or another unit"),
        ("5 kg", "'kg' has the dimension .mass.; 'N.m/rad' .kg.m.2/s.2. is asked for"),
        ("5 foo", "'foo' is not a known unit"),
        ("five N*m/rad", "'five N.m/rad' is not a number with a unit; write for example"),
    ],
)  # fmt: skip
def test_unlawful_values(value, words):
    with pytest.raises(ModelError, match=f"^shaft 's'.*{words}"):
        shaft(k=value)


def test_whole_numbers_are_asked_for_where_teeth_are_counted():
    with pytest.raises(ModelError, match=r"^rigid_gear 'g', teeth_a: is 20.5; give a whole number"):
        RigidGear("g", "a", "b", teeth_a=20.5, teeth_b=40)
    with pytest.raises(ModelError, match=r"^rigid_gear 'g', teeth_a: is 0; give a positive value"):
        RigidGear("g", "a", "b", teeth_a=0, teeth_b=40)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"damping_ratio": -0.1}, "damping_ratio: is -0.1; give zero or a positive value"),
        ({"stifness": 3.0}, "has no parameter 'stifness'; nearest is 'stiffness'"),
        ({"damping": "valu"}, "damping is 'valu'; nearest is 'value'"),
        ({"damping": "value"}, "damping_coefficient is missing; give it in N.m.s/rad"),
        (
            {"damping_coefficient": 1.0},
            "damping_coefficient is given, but damping='per_shaft' does not use it; drop it or change the",
        ),
        ({"a": "other"}, "flange 'a' is given twice; give it once"),
        ({"self": 1}, "has no parameter 'self'"),
        ({"name": "x"}, "has no parameter 'name'"),
        ({"lengths": 1}, "has no parameter 'lengths'"),
    ],
)
def test_unlawful_parameters(given, words):
    with pytest.raises(ModelError, match=f"^shaft 's'.*{words}"):
        shaft(**given)


def test_unlawful_joints():
    with pytest.raises(ModelError, match=r"^shaft 's': is joined to 3 things; it has 2 flange\(s\): a, b"):
        Shaft("s", "x", "y", "z", stiffness=1.0)
    with pytest.raises(ModelError, match=r"^shaft 's': flange 'b' is joined to 5; give the name of an element or element.flange"):
        Shaft("s", "x", 5, stiffness=1.0)
    with pytest.raises(ModelError, match=r"^harmonic_torque 't': base is 5; give the name of a base frequency"):
        HarmonicTorque("t", "x", base=5)


@pytest.mark.parametrize(
    "name", ["1st", "a b", "x;rm -rf", "__import__('os')", "for", "int", "nul", "a__b", "", "ä", "x" * 64, None, 3]
)
def test_unlawful_names(name):
    with pytest.raises(NamingError, match="inertia: name"):
        Inertia(name, inertia=1.0)


def test_an_element_is_a_value():
    assert shaft(damping_ratio=0.1) == shaft(damping_ratio="0.1")
    assert hash(shaft(damping_ratio=0.1)) == hash(shaft(damping_ratio=0.1))
    different = [
        shaft(),
        shaft("t"),
        shaft(k=6),
        shaft(note="x"),
        shaft(damping="modal"),
        shaft(damping_ratio="zeta"),
        Inertia("s", inertia=5),
    ]
    assert len(set(different)) == len(different)


def test_what_is_given_makes_the_element_again():
    gear = GearPair(
        "m", "x", "y.b", teeth_a=20, teeth_b=30, module=0.01, mesh="geometry", face_width=0.1, stiffness_orders=[1, 3],
        viscous="contact_only", damping_ratio="xi", half_backlash="75 um", note="estimate",
    )  # fmt: skip
    again = GearPair("m", **gear.given(), note=gear.note)
    assert again == gear
    assert gear.given()["stiffness_orders"] == (1, 3)
    assert "young_modulus" not in gear.given()
    assert repr(shaft(damping_ratio=0.1)) == "Shaft('s', a='left', b='right', stiffness=5.0, damping_ratio=0.1)"


def test_a_copy_differs_in_what_is_changed():
    one = shaft(damping_ratio=0.1, note="measured")
    assert one.copy(stiffness="6 N*m/rad") == shaft(k=6.0, damping_ratio=0.1, note="measured")
    assert one.copy("t", note="moved") == shaft("t", damping_ratio=0.1, note="moved")


def test_a_changed_switch_drops_what_it_does_not_use():
    one = shaft(damping_ratio=0.1)
    assert one.copy(damping="modal") == shaft(damping="modal", damping_ratio=0.1)
    assert one.copy(damping="value", damping_coefficient=2.0) == shaft(damping="value", damping_coefficient=2.0)
    with pytest.raises(ModelError, match="damping_ratio is given, but damping='value' does not use it"):
        one.copy(damping="value", damping_coefficient=2.0, damping_ratio=0.1)


def test_a_kind_is_named_after_its_class_and_only_once():
    assert (HarmonicTorque.kind, RigidGear.kind) == ("harmonic_torque", "rigid_gear")
    assert Element.vocabulary["gear_pair"] is GearPair
    with pytest.raises(
        NamingError, match=r"^element class Shaft: the kind 'shaft' is already taken by modelgen.elements.shaft; rename"
    ):
        type("Shaft", (Element,), {"__module__": "elsewhere"})


@pytest.mark.parametrize(
    ("name", "declaration"),
    [
        ("values", Param()),
        ("name", Flange()),
        ("torques", quantity("N*m")(lambda self: 0)),
        ("stored_energy", quantity("J")(lambda self: 0)),
        ("lengths", Choice("short", "long")),
        ("copy", State("m")),
    ],
)
def test_a_declaration_may_not_hide_what_every_element_has(name, declaration):
    with pytest.raises(
        NamingError, match=f"^element class Odd: declares '{name}', a name that every element uses itself; choose"
    ):
        type("Odd", (Element,), {name: declaration, "__module__": __name__})
    assert "odd" not in Element.vocabulary


def test_a_unit_is_checked_when_it_is_declared():
    with pytest.raises(UnitError, match=r"^unit 'kN': is not an SI unit text; write it with 1 rad kg m s"):
        Param("kN")


def test_describe_says_what_may_be_given():
    text = GearPair.describe()
    assert text.startswith("gear_pair: Two gears in mesh")
    assert "mesh = fourier | table | rectangular | geometry" in text
    assert "half_backlash [m] default 0.0" in text


def test_the_new_element_of_the_docstring_fits_in_fifteen_lines():
    source = example(Element, "class HardeningShaft")
    assert "a, b = Flange(), Flange()" in source
    assert len(source.strip().splitlines()) <= 15


def example(thing, start):
    """The source of the docstring's example that starts so; the doctest run shows that it works."""
    found = doctest.DocTestFinder(recurse=False).find(thing, thing.__name__)
    return next(each.source for test in found for each in test.examples if each.source.startswith(start))
