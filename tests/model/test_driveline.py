"""The driveline as a value: what it holds, how another one is made from it, and what it refuses."""

from __future__ import annotations

import doctest
import math
import re
from fractions import Fraction

import numpy as np
import pytest

from modelgen.elements import HarmonicTorque, Inertia, Shaft
from modelgen.equations import assemble
from modelgen.errors import ModelError, NamingError, UnitError
from modelgen.lowering import lower
from modelgen.model import BaseFrequency, Driveline, NamedParameter, Shared


def line(**more):
    given = {
        "elements": [
            Inertia("engine", inertia=2.0),
            Inertia("pump", inertia=3.0),
            Shaft("shaft", "engine", "pump", stiffness=100.0, damping_ratio="zeta"),
            HarmonicTorque("firing", "engine", mean=5.0, cosine="rows", base="order"),
            HarmonicTorque("load", "pump", mean=-4.0),
        ],
        "parameters": {"zeta": 0.05, "rows": NamedParameter((1.0, 2.0), "N*m", note="measured"), "drag": "2 N*m"},
        "speed": "1500 rpm",
        "reference": "engine",
        "bases": {"order": ("engine", "3/2")},
    }
    return Driveline("line", **{**given, **more})


def test_a_driveline_is_a_value():
    assert line() == line()
    assert line(elements=list(line().elements)) == line()
    for more in ({"speed": 10.0}, {"parameters": {"zeta": 0.1}}, {"drifts": True}, {"description": "x"}, {"balanced": ("load",)}):
        assert line(**more) != line()
    with pytest.raises(TypeError, match="does not support item assignment"):
        line().parameters["zeta"] = 3


def test_what_it_holds():
    one = line()
    assert one.speed == pytest.approx(50 * math.pi, rel=1e-15)
    assert one.bases["order"] == BaseFrequency(Fraction(3, 2), "engine")
    assert one.parameters["drag"] == NamedParameter(2.0, "N*m")
    assert one["shaft"].values["damping_ratio"] == Shared("zeta")
    assert one.parameter_of(one["shaft"], "damping_ratio") is one.parameters["zeta"]
    assert one.parameter_of(one["shaft"], "stiffness") is None
    assert str(one) == "driveline 'line': 5 elements (2 inertia, 1 shaft, 2 harmonic_torque) at 1500 rpm of 'engine'"


def test_set_changes_parameters_and_keeps_their_units_and_notes():
    other = line().set(zeta=0.1, rows=[3.0, 4.0], drag=7.5, speed="1000 rpm")
    assert other.parameters["zeta"] == NamedParameter(0.1)
    assert other.parameters["rows"] == NamedParameter((3.0, 4.0), "N*m", note="measured")
    assert other.parameters["drag"] == NamedParameter(7.5, "N*m")
    assert line().set(drag="3 kN*m").parameters["drag"].value == 3000.0
    assert line().set(drag=np.float32(7.5)).parameters["drag"] == NamedParameter(7.5, "N*m")
    assert other.speed == pytest.approx(1000 * math.pi / 30)
    assert line().parameters["zeta"].value == 0.05
    assert assemble(other).parameters[2].values == (3.0, 4.0)


def test_change_reaches_one_element_or_every_element_of_a_kind():
    other = line().change("shaft", stiffness="1 kN*m/rad", damping="value", damping_coefficient=1.0)
    assert other["shaft"].given() == {
        "a": "engine", "b": "pump", "damping": "value", "stiffness": 1000.0, "damping_coefficient": 1.0,
    }  # fmt: skip
    assert {each.values["inertia"] for each in line().change("inertia", inertia=9.0).elements if each.kind == "inertia"} == {9.0}
    assert line().change("engine", inertia=9.0)["pump"].values["inertia"] == 3.0


def test_add_and_connect():
    other = line().add(Inertia("fan", inertia=0.1), Shaft("belt", "engine", stiffness=5.0)).connect("belt.b", "fan")
    assert other.connections == (("belt.b", "fan"),)
    assert len(assemble(other).groups) == 3
    assert assemble(other).states[1].name == "shaft.twist"


def test_balance_names_the_loads_that_are_scaled():
    other = line().balance("load")
    assert other.balanced == ("load",)
    assert assemble(other).balanced == ("load.scale",)


def test_include_takes_in_a_sub_assembly():
    pump = Driveline(
        "pump",
        [
            Inertia("crank", inertia=1.0),
            Inertia("head", inertia=0.2),
            Shaft("rod", "crank", stiffness=50.0, damping_ratio="zeta"),
            HarmonicTorque("stroke", "head", sine=(1.0,), mean=-1.0, base="cycle"),
        ],
        connections=[("rod.b", "head")],
        parameters={"zeta": 0.05},
        reference="crank",
        bases={"cycle": 2, "own": ("rod.b", 1)},
        balanced=("stroke",),
        assemblies={"end": ("head", "stroke")},
    )
    whole = line().include("left", pump).add(Shaft("joint", "pump", "left_crank", stiffness=10.0))
    assert [e.name for e in whole.elements[5:9]] == ["left_crank", "left_head", "left_rod", "left_stroke"]
    assert whole["left_rod"].targets == {"a": "left_crank"}
    assert whole.connections == (("left_rod.b", "left_head"),)
    # "Per turn of the reference shaft" keeps meaning the shaft of the assembly.
    assert whole.bases["cycle"] == BaseFrequency(Fraction(2), "left_crank")
    assert whole.bases["own"] == BaseFrequency(Fraction(1), "left_rod.b")
    assert whole.balanced == ("left_stroke",)
    assert whole.assemblies == {
        "left": ("left_crank", "left_head", "left_rod", "left_stroke"),
        "left_end": ("left_head", "left_stroke"),
    }
    assert len(assemble(whole).groups) == 4
    with pytest.raises(
        NamingError, match=r"^driveline 'line': the name 'left_crank' is given twice \(element and element\); rename one"
    ):
        whole.include("left", pump)
    with pytest.raises(NamingError, match=r"^assembly 'right': 'zeta' differs from the driveline's own; rename one of them"):
        line().include("right", pump.set(zeta=0.3))


def test_one_parameter_serves_several_elements():
    shafts = [
        Shaft("shaft", "engine", "pump", stiffness=100.0, damping_ratio="zeta"),
        Shaft("second", "engine", "pump", stiffness="k"),
    ]
    two = line(elements=[*line().elements[:2], *shafts], parameters={"zeta": 0.05, "k": "3 kN*m/rad"}, bases={})
    model = lower(assemble(two))
    now = model.evaluate(0.0, [0.0, 0.1, 0.0, 0.0], model.parameters.vector({"k": 700.0}))
    assert now["second.torque"] == pytest.approx(70.0)


@pytest.mark.parametrize(
    ("more", "kind", "words"),
    [
        (
            {"elements": [Inertia("a", inertia=1.0), Inertia("a", inertia=1.0)]},
            NamingError,
            r"the name 'a' is given twice \(element and",
        ),
        (
            {"parameters": {"engine": 1.0}},
            NamingError,
            r"the name 'engine' is given twice \(parameter and element\); rename one of them",
        ),
        (
            {"parameters": {"speed": 1.0}},
            NamingError,
            "parameter 'speed' has a name that modelgen uses itself; choose another name",
        ),
        ({"elements": [Inertia("modal", inertia=1.0)]}, NamingError, "element 'modal' has a name that modelgen uses itself"),
        ({"parameters": {"a b": 1.0}}, NamingError, r"parameter 'a b' holds ' ' \(SPACE\) at character 2; write 'a_b'"),
        ({"parameters": {"zeta": "5 apples"}}, UnitError, "^parameter 'zeta': 'apples' is not a known unit"),
        ({"parameters": {"zeta": "five"}}, UnitError, "^parameter 'zeta': 'five' is not a number with a unit"),
        ({"parameters": {"zeta": math.nan}}, UnitError, "^parameter 'zeta': nan is not a finite number"),
        ({"parameters": {"zeta": (1.0, math.inf)}}, UnitError, r"^parameter 'zeta'\[2\]: inf is not a finite number"),
        ({"parameters": {"zeta": ["a"]}}, UnitError, r"^parameter 'zeta'\[1\]: 'a' is not a number; give a number"),
        ({"parameters": {"zeta": True}}, UnitError, "^parameter 'zeta': True is not a number; give a number"),
        ({"parameters": {"zeta": None}}, UnitError, "^parameter 'zeta': None is not a number; give a number"),
        ({"parameters": {"zeta": NamedParameter(math.nan)}}, UnitError, "^parameter 'zeta': nan is not a finite number"),
        (
            {"parameters": {"zeta": NamedParameter(1.0, "furlong")}},
            UnitError,
            "^parameter 'zeta': unit 'furlong' is not an SI unit text",
        ),
        ({"speed": 0.0}, ModelError, "the operating speed is 0 rad/s; give a positive speed: angles count forward"),
        ({"speed": "50 Hz"}, UnitError, "speed: 'Hz' is ambiguous for an angular speed; write rad/s, rpm or turn/s"),
        ({"speed": "50 m/s"}, UnitError, "speed: 'm/s' has the dimension .*; 'rad/s' .1/s. is asked for"),
        ({"speed": math.inf}, UnitError, "speed: inf is not a finite number; give a finite value"),
        ({"speed": [1.0]}, UnitError, r"speed: \[1.0\] is not a number; give a number in rad/s"),
        ({"reference": 5}, ModelError, "the reference shaft is 5; give the name of an inertia"),
        ({"elements": ["engine"]}, ModelError, "holds 'engine' among its elements; give elements such as Inertia"),
        ({"connections": [("a",)]}, ModelError, r"holds the connection \('a',\); give pairs such as"),
        ({"balanced": ("shaft",)}, ModelError, "^shaft 'shaft': is no load that can be scaled; known are firing, load"),
        ({"balanced": ("lode",)}, NamingError, "has no element 'lode'; nearest is 'load'"),
        (
            {"assemblies": {"left": ("pumpe",)}},
            NamingError,
            "^assembly 'left': holds 'pumpe', which is no element; nearest is 'pump'",
        ),
        ({"bases": {"order": 0}}, ModelError, "^base frequency 'order': the order is 0; give a positive fraction such as 2 or"),
        ({"bases": {"order": "-1/2"}}, ModelError, "^base frequency 'order': the order is '-1/2'; give a positive fraction"),
        ({"bases": {"order": "1/0"}}, ModelError, "^base frequency 'order': the order is '1/0'; give a positive fraction"),
        ({"bases": {"order": "1e999999999"}}, ModelError, "^base frequency 'order': the order is '1e999999999'; give a positive"),
        ({"bases": {"order": math.pi}}, ModelError, "^base frequency 'order': the order is 3.14.*; give a positive fraction"),
        ({"bases": {"order": math.inf}}, ModelError, "^base frequency 'order': the order is inf; give a positive fraction"),
        ({"bases": {"order": True}}, ModelError, "^base frequency 'order': the order is True; give a positive fraction"),
        (
            {"bases": {"order": ("engine", 1, 2)}},
            ModelError,
            r"^base frequency 'order': is \('engine', 1, 2\); give an order, or a shaft",
        ),
        ({"bases": {"order": (7, 1)}}, ModelError, "^base frequency 'order': the shaft is 7; give the name of an element"),
    ],
)
def test_unlawful_drivelines(more, kind, words):
    with pytest.raises(kind, match=words):
        line(**more)


def test_half_orders_may_be_floats():
    assert line(bases={"order": 0.5}).bases["order"].order == Fraction(1, 2)


@pytest.mark.parametrize(
    ("act", "kind", "words"),
    [
        (lambda d: d["pumpe"], NamingError, "^driveline 'line': has no element 'pumpe'; nearest is 'pump'"),
        (lambda d: d.set(zetta=1.0), NamingError, "^driveline 'line': has no parameter 'zetta'; nearest is 'zeta'"),
        (
            lambda d: d.change("shafts", stiffness=1.0),
            NamingError,
            "^driveline 'line': has no element or kind 'shafts'; nearest is 'shaft'",
        ),
        (
            lambda d: d.change("shaft", stifness=1.0),
            NamingError,
            "^shaft 'shaft': has no parameter 'stifness'; nearest is 'stiffness'",
        ),
        (
            lambda d: d.connect("shaft", "pump"),
            ModelError,
            "^connection 'shaft' - 'pump': is joined to 'shaft', which has 2 flanges; write",
        ),
        (lambda d: d.connect("shaft.c", "pump"), NamingError, "shaft 'shaft' has no flange 'c'; known are a, b"),
        (
            lambda d: d.connect("shaft.a", "pumq"),
            NamingError,
            "is joined to 'pumq', but there is no element 'pumq'; nearest is 'pump'",
        ),
        (lambda d: d.include("1", d), NamingError, "^assembly '1': name '1_engine' starts with '1', not with a letter; write"),
    ],
)
def test_unlawful_changes(act, kind, words):
    with pytest.raises(kind, match=words):
        act(line())


def test_the_branched_topology_of_the_docstring_fits_in_twenty_lines():
    found = doctest.DocTestFinder(recurse=False).find(Driveline, "Driveline")
    source = next(each.source for test in found for each in test.examples if each.source.startswith("line = Driveline("))
    assert '"branched"' in source
    assert len(source.strip().splitlines()) <= 20


def test_a_line_holds_and_lists_its_elements_and_has_a_hash() -> None:
    line = Driveline("pair", elements=[Inertia("m", inertia=1.0), Inertia("n", inertia=2.0)])
    assert "m" in line
    assert line["n"] in line
    assert "o" not in line
    assert 3 not in line
    assert [each.name for each in line] == ["m", "n"]
    again = Driveline("pair", elements=[Inertia("m", inertia=1.0), Inertia("n", inertia=2.0)])
    assert {line: 1}[again] == 1
    assert len({line, again, line.set(speed=3.0)}) == 2
    with pytest.raises(NamingError, match="has no element 0; known are m, n"):
        line[0]  # type: ignore[index]


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        (3, "limits: are 3; give a list, such as"),
        ([4], 'limits: hold 4; give {"rule": "syt_5211_angle"}'),
        ([{"rule": "x", "element": []}], "limits: hold an unknown key 'element'; nearest is 'elements'"),
        ([{"rule": "x", "elements": "a"}], "limit 'x': is for the elements 'a'; give a list of names"),
        ([{"elements": ["a"]}], "names no rule"),
        ([{"rule": "x", "inputs": {"y": True}}], "limit 'x', y: is True; give a number or a text with a unit"),
    ],
)
def test_what_is_no_limit_is_refused(limits, words):
    with pytest.raises(ModelError, match=re.escape(words)):
        Driveline("line", limits=limits)


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("elements", Inertia("m", inertia=1.0), r"elements are Inertia.*; give a list such as \[Inertia"),
        ("elements", None, r"elements are None; give a list"),
        ("connections", "ab", r"connections are 'ab'; give a list"),
        ("balanced", "load", r"balanced are 'load'; give a list such as \[\"load\"\]"),
        ("parameters", [1], r"parameters are \[1\]; give a dict such as"),
        ("bases", 3, r"bases are 3; give a dict"),
    ],
)
def test_a_field_of_another_kind_is_one_sentence(field, value, words):
    with pytest.raises(ModelError, match=f"driveline 'x': {words}"):
        Driveline("x", **{field: value})
