"""Model files: read strictly, written without loss, and every mistake named with its line."""

from __future__ import annotations

import itertools
import os
import re

import numpy as np
import pytest

from modelgen.drivelines import catalogue, load
from modelgen.elements import Inertia, Shaft
from modelgen.errors import CaseError, ModelFileError
from modelgen.model import Choice, Clock, Driveline, Element, Flange, NamedParameter, Orders, Param
from modelgen.model.files import LARGEST_FILE, model_text, parse_model, read_model, write_model

TEXT = """\
format = 1
name = "pair"

[operation]
speed = "1500 rpm"
reference = "engine"
balance = ["load"]

[bases.order]
shaft = "engine"
order = "3/2"

[parameters]
zeta = 0.05
push = "2 kN*m"
rows = { unit = "kN*m", values = [1, 2.5] }
half = { expression = "zeta/2", note = "half of it" }
big = { value = 3, unit = "kN*m", note = "measured" }

[defaults.shaft]
damping_ratio = "zeta"

[elements.engine]
kind = "inertia"
inertia = "2 kg*m^2"
note = "estimate"

[elements.pump]
kind = "inertia"
inertia = "300 kg*cm^2"

[elements.shaft]
kind = "shaft"
a = "engine"
b = "pump"
stiffness = "35 kN*m/deg"

[elements.second]
kind = "shaft"
a = "engine"
b = "pump"
stiffness = "7 N*m/rad"
damping = "value"
damping_coefficient = "1 N*m*s/rad"

[elements.firing]
kind = "harmonic_torque"
flange = "engine"
base = "order"
mean = "push"
sine = "rows"
cosine = { unit = "N*m", values = [0.1, 0.2] }
orders = [1, 3]
phase = "30 deg"

[elements.load]
kind = "harmonic_torque"
flange = "pump"
mean = "-1 N*m"
"""


def test_what_a_file_says():
    line = parse_model(TEXT)
    assert line.speed == pytest.approx(50 * np.pi, rel=1e-15)
    assert line.parameters["push"] == NamedParameter(2000.0, "kg*m^2/s^2")
    assert line.parameters["rows"].value == (1000.0, 2500.0)
    assert line.parameters["half"] == NamedParameter(0.0, "1", "zeta/2", "half of it")
    assert line.parameters["big"] == NamedParameter(3000.0, "kg*m^2/s^2", None, "measured")
    assert line["engine"].note == "estimate"
    assert line["pump"].values["inertia"] == pytest.approx(0.03)
    assert line["shaft"].values["stiffness"] == pytest.approx(35e3 * 180 / np.pi, rel=1e-15)
    assert line["firing"].values["phase"] == pytest.approx(np.pi / 6, rel=1e-15)
    assert line["firing"].harmonics["orders"] == (1, 3)


def test_defaults_go_to_those_that_can_use_them():
    line = parse_model(TEXT)
    assert line["shaft"].values["damping_ratio"].name == "zeta"
    assert "damping_ratio" not in line["second"].values


AWKWARD = (0.1 + 0.2, 1 / 3, 5e-324, 1.7976931348623157e308, 123456789.123456789, 1e22)


def values(param, rng):
    if param.series:
        return tuple(rng.lognormal(0, 9, 3)) if param.positive else AWKWARD
    if param.integer:
        return int(rng.integers(10, 99))
    if param.least is not None and param.largest is not None:
        return float(rng.uniform(param.least, param.largest))
    return float(rng.lognormal(0, 9))


def everything():
    """A driveline that uses every element in every setting of its switches, and everything else that a file can hold."""
    rng, elements = np.random.default_rng(8), [Inertia("hub", inertia=1 / 3, note='a "quoted" note\nof two lines, ä')]
    parameters = {
        "shared": NamedParameter(0.1 + 0.2, note="x"),
        "rows": NamedParameter(AWKWARD, "N*m"),
        "twice": NamedParameter(0.0, "m", "2*length"),
    }
    parameters["length"] = NamedParameter(1e-300, "m")
    for cls in [each for each in Element.vocabulary.values() if each.__module__.startswith("modelgen.")]:
        switches = cls.declared(Choice)
        for options in itertools.product(*(switch.options for switch in switches.values())):
            chosen = dict(zip(switches, options, strict=True))
            given = {key: values(p, rng) for key, p in cls.declared(Param).items() if p.exists(chosen)}
            given.update({key: (1, 2, 7) for key, orders in cls.declared(Orders).items() if orders.exists(chosen)})
            given.update({key: "cycle" for key, clock in cls.declared(Clock).items() if clock.flange is None})
            given.update({key: "shared" for key in given if key.endswith("ratio") and key.startswith("damping")})
            given.update(dict.fromkeys(cls.declared(Flange), "hub"))
            elements.append(cls(f"each_{len(elements)}", **chosen, **given))
    return Driveline(
        "every-thing",
        elements,
        connections=[("each_1.flange", "hub.flange")],
        parameters=parameters,
        speed=1900 * np.pi / 30,
        reference="hub",
        bases={"cycle": ("hub", "7/3"), "plain": 2},
        balanced=[e.name for e in elements if e.kind == "harmonic_torque"],
        assemblies={"all": [e.name for e in elements[:3]]},
        drifts=True,
        description='lines\nof "text" \\ with = [signs]',
    )


LINES = {
    "everything": everything,
    "text": lambda: parse_model(TEXT),
    **{name: lambda name=name: load(name) for name in catalogue()},
}


@pytest.mark.parametrize("name", LINES)
def test_reading_what_was_written_gives_the_same_driveline(name):
    line = LINES[name]()
    again = parse_model(model_text(line))
    assert again == line
    # Equal floats are equal to the last bit; and the order of elements is that of the file.
    assert [e.name for e in again.elements] == [e.name for e in line.elements]
    assert model_text(again) == model_text(line)


def test_both_trucks_are_there():
    assert {"fracturing-truck", "fracturing-truck-commensurate"} <= set(catalogue())


def test_a_file_is_written_whole(tmp_path):
    path = write_model(everything(), tmp_path / "line.toml")
    assert read_model(path) == everything()
    assert load(path) == everything()
    assert os.listdir(tmp_path) == ["line.toml"]


def test_a_mark_of_a_windows_editor_is_no_mistake(tmp_path):
    (tmp_path / "line.toml").write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode())
    assert read_model(tmp_path / "line.toml") == parse_model(TEXT)


def changed(old, new):
    """The text with one passage replaced."""
    assert TEXT.count(old) == 1, old
    return TEXT.replace(old, new)


def after(header, *lines):
    return changed(f"[{header}]\n", "\n".join([f"[{header}]", *lines, ""]))


BIG = "1" + "0" * 400
WRONG = [
    # the file as such
    ("", "pair.toml: has no format; write format = 1 at the top"),
    (changed("format = 1", "format = 2"), "pair.toml: has format 2; write format = 1 at the top"),
    (changed("format = 1", "format = 1.0"), "pair.toml: has format 1.0; write format = 1"),
    (changed("format = 1", "format = true"), "pair.toml: has format True; write format = 1"),
    (changed('name = "pair"', "name = 5"), 'pair.toml, line 2, .name.: is 5; write name = "..."'),
    (changed('name = "pair"\n', ""), "pair.toml, .name.: is missing; write name ="),
    (changed('name = "pair"', 'name = "my pair"'), r"name 'my pair' holds ' ' \(SPACE\) at character 3; write 'my_pair'"),
    (
        changed('name = "pair"', 'name = "pair"\nx = = 3'),
        r"pair.toml: is not TOML: Invalid value \(at line 3, column 5\); see toml.io",
    ),
    (changed("zeta = 0.05", "zeta = 0.05\nzeta = 0.06"), r"is not TOML: Cannot overwrite a value \(at line 15, column 12\)"),
    (TEXT + "[elements.pump]\n", r"is not TOML: Cannot declare \('elements', 'pump'\) twice \(at line 60"),
    (changed('name = "pair"', 'name = "pair"\ncolor = 3'), "pair.toml: has an unknown key 'color'; known are format, name"),
    (changed("zeta = 0.05", "zeta = nan"), r"pair.toml, line 14, \[parameters.zeta\]: holds nan; give finite numbers"),
    (changed("zeta = 0.05", "zeta = -inf"), r"line 14, \[parameters.zeta\]: holds -inf; give finite numbers"),
    (changed("zeta = 0.05", "zeta = 1979-05-27"), r"line 14, \[parameters.zeta\]: holds a date; give numbers, texts and tables"),
    (changed("zeta = 0.05", "zeta = " + "[" * 40 + "]" * 40), "pair.toml: nests deeper than 32; model files are flat"),
    (changed("zeta = 0.05", "zeta" + ".x" * 3000 + " = 1"), "nests deeper than 32; model files are flat"),
    # operation
    (changed('"1500 rpm"', "1500"), r"line 5, \[operation.speed\]: is 1500; give it with a unit, such as \"1900 rpm\""),
    (
        changed('"1500 rpm"', '"1500"'),
        "pair.toml: driveline 'pair', speed: 1500.0 has no unit; write \"1500.0 rad/s\" or another unit",
    ),
    (changed('"1500 rpm"', '"25 Hz"'), "speed: 'Hz' is ambiguous for an angular speed; write rad/s, rpm or turn/s"),
    (changed('"1500 rpm"', '"-1500 rpm"'), "the operating speed is -157.08 rad/s; give a positive speed"),
    (changed('reference = "engine"', "reference = 5"), r"line 6, \[operation.reference\]: is 5; write reference ="),
    (changed('balance = ["load"]', 'balance = "load"'), r"line 7, \[operation.balance\]: holds 'load'; write a list"),
    (changed('balance = ["load"]', 'balance = ["lode"]'), "driveline 'pair': has no element 'lode'; nearest is 'load'"),
    (changed('balance = ["load"]', 'balance = ["pump"]'), "inertia 'pump': is no load that can be scaled"),
    (after("operation", 'drifts = "yes"'), r"line 5, \[operation.drifts\]: is 'yes'; write true or false"),
    (
        after("operation", "gear = 2"),
        r"line 4, \[operation\]: has an unknown key 'gear'; known are speed, reference, balance, drifts",
    ),
    # base frequencies
    (
        changed('order = "3/2"', "order = 1.5"),
        r"line 11, \[bases.order.order\]: is 1.5; write a whole number or a fraction such as \"1/2\"",
    ),
    (
        changed('order = "3/2"', 'order = "1e999999999"'),
        "base frequency 'order': the order is '1e999999999'; give a positive fraction",
    ),
    (changed('order = "3/2"', 'order = "-3/2"'), "base frequency 'order': the order is '-3/2'; give a positive fraction"),
    (changed('shaft = "engine"', "shaft = 5"), "base frequency 'order': the shaft is 5; give the name of an element"),
    (changed('shaft = "engine"', "shafts = 5"), r"line 9, \[bases.order\]: has an unknown key 'shafts'; nearest is 'shaft'"),
    # parameters
    (
        changed("zeta = 0.05", "zeta = true"),
        r"line 14, \[parameters.zeta\]: is True; give a number, a text with a unit, or a table",
    ),
    (changed("zeta = 0.05", "zeta = [1.0]"), r"line 14, \[parameters.zeta\]: is \[1.0\]; give a number"),
    (
        changed("zeta = 0.05", f"zeta = {BIG}"),
        "parameter 'zeta': the number is out of range; give a number between -1e308 and 1e308",
    ),
    (changed("zeta = 0.05", 'zeta = "0.05 bushels per"'), "parameter 'zeta': 'bushels per' is not a known unit"),
    (
        changed("zeta = 0.05", "zeta = { note = 'x' }"),
        r"line 14, \[parameters.zeta\]: does not hold one of value, values and expression",
    ),
    (
        changed("zeta = 0.05", "zeta = { value = 1, values = [1] }"),
        "does not hold one of value, values and expression; give exactly one",
    ),
    (
        changed("zeta = 0.05", "zeta = { value = '1 m', unit = 'm' }"),
        "has the unit 'm' beside the text '1 m'; give the unit once",
    ),
    (
        changed("zeta = 0.05", "zeta = { value = { value = 1 } }"),
        "is {'value': 1}; give a number, a text with a unit, or a table",
    ),
    (
        changed("[1, 2.5]", "[1, '2.5']"),
        r"line 16, \[parameters.rows\]: values is no list of numbers; write values = \[1.0, 2.0\]",
    ),
    (changed('note = "measured"', "note = 5"), r"line 18, \[parameters.big.note\]: is 5; write note ="),
    (changed('note = "measured"', "color = 5"), r"line 18, \[parameters.big\]: has an unknown key 'color'; known are value"),
    # elements
    (
        changed('kind = "inertia"\ninertia = "2 kg', 'kind = "os"\ninertia = "2 kg'),
        r"line 23, \[elements.engine\]: kind is 'os'; known are",
    ),
    (
        changed('kind = "inertia"\ninertia = "2 kg', 'kind = "modelgen.elements.Inertia"\ninertia = "2 kg'),
        "kind is 'modelgen.elements.Inertia'",
    ),
    (
        changed('kind = "inertia"\ninertia = "2 kg', 'inertia = "2 kg'),
        r"line 23, \[elements.engine\]: kind is missing; known are",
    ),
    (
        changed("[elements.pump]", '[elements."pump;rm"]'),
        r"line 28, \[elements.pump;rm\]: inertia: name 'pump;rm' holds ';' \(SEMICOLON\)",
    ),
    (
        changed("[elements.pump]", "[elements.int]"),
        r"line 28, \[elements.int\]: inertia: name 'int' is a keyword of C and C\+\+; write 'int_1'",
    ),
    (changed("[elements.pump]", "[elements.engine.pump]"), "engine.*has no parameter 'pump'"),
    (changed("[elements.load]", "[[elements2]]"), "pair.toml: has an unknown key 'elements2'; nearest is 'elements'"),
    (
        changed('stiffness = "7 N*m/rad"', "stiffness = 7"),
        r'line 42, \[elements.second.stiffness\]: 7 has no unit; write "7 N.m/rad"',
    ),
    (changed('stiffness = "7 N*m/rad"', 'stiffness = "7"'), "shaft 'second', stiffness: 7.0 has no unit; write \"7.0 N.m/rad\""),
    (changed('stiffness = "7 N*m/rad"', 'stiffness = "7 N/m"'), "'N/m' has the dimension .*'N.m/rad' .* is asked for"),
    (
        changed('stiffness = "7 N*m/rad"', 'stiffness = "-7 N*m/rad"'),
        r"line 38, .*shaft 'second', stiffness: is -7 N.m/rad; give a positive value",
    ),
    (changed('stiffness = "7 N*m/rad"', 'stifness = "7 N*m/rad"'), r"line 38, .*stiffness is missing; give it in N.m/rad"),
    (
        changed('stiffness = "7 N*m/rad"', 'stiffness = "7 N*m/rad"\ncolor = 3'),
        "shaft 'second': has no parameter 'color'; known are a, b,",
    ),
    (changed('stiffness = "7 N*m/rad"', 'stiffness = "7 N*m/rad"\nself = 3'), "shaft 'second': has no parameter 'self'"),
    (
        changed('stiffness = "7 N*m/rad"', 'stiffness = "7 N*m/rad"\ndamping_ratio = 0.1'),
        "damping_ratio is given, but damping='value' does not",
    ),
    (
        changed('stiffness = "7 N*m/rad"', "stiffness = { unit = 'N*m/rad', values = [7.0] }"),
        r"stiffness: \(7.0,\) is not a number; give a",
    ),
    (
        changed('stiffness = "7 N*m/rad"', "stiffness = { x = 3 }"),
        r"line 42, \[elements.second.stiffness\]: has an unknown key 'x'; known are",
    ),
    (changed('damping = "value"', 'damping = "valu"'), r"line 38, .*shaft 'second': damping is 'valu'; nearest is 'value'"),
    (
        changed('damping = "value"', "damping = 3"),
        r"shaft 'second': damping is 3; known are per_shaft, modal, value, loss_factor",
    ),
    (
        changed('cosine = { unit = "N*m", values = [0.1, 0.2] }', "cosine = [0.1, 0.2]"),
        r"line 52, .*has no unit; write { unit = \"N.m\", values =",
    ),
    (changed('cosine = { unit = "N*m"', 'cosine = { unit = "kg"'), "'kg' has the dimension .*; 'N.m' .* is asked for"),
    (
        changed('cosine = { unit = "N*m", values = [0.1, 0.2] }', 'cosine = "3 N*m"'),
        "cosine: 3.0 is one number; give a series of numbers",
    ),
    (changed("orders = [1, 3]", "orders = [1, 1]"), r"orders are \[1, 1\]; give different whole numbers from 1 to 1000"),
    (changed("orders = [1, 3]", "orders = 3"), "orders are 3; give different whole numbers"),
    (changed('base = "order"', "base = 3"), "base is 3; give the name of a base frequency"),
    (changed('note = "estimate"', "note = 3"), r"line 26, \[elements.engine.note\]: is 3; write note ="),
    (
        changed("[defaults.shaft]", "[defaults.shift]"),
        r"line 20, \[defaults.shift\]: 'shift' is no kind of element; nearest is 'shaft'",
    ),
    # connections and assemblies
    (
        changed('name = "pair"', 'name = "pair"\nconnections = [["engine"]]'),
        r"line 3, \[connections\]: holds \['engine'\]; write pairs such as",
    ),
    (changed('name = "pair"', 'name = "pair"\nconnections = "engine"'), r"line 3, \[connections\]: holds 'engine'; write a list"),
    (TEXT + "[assemblies]\nleft = 5\n", r"line 61, \[assemblies.left\]: holds 5; write a list of names of elements"),
    (TEXT + '[assemblies]\nleft = ["pumpe"]\n', "assembly 'left': holds 'pumpe', which is no element; nearest is 'pump'"),
]


@pytest.mark.parametrize(("text", "words"), WRONG)
def test_a_wrong_file_is_refused_in_one_sentence(text, words):
    with pytest.raises(ModelFileError, match=words) as refusal:
        parse_model(text, "pair.toml")
    assert str(refusal.value).startswith("pair.toml")
    assert "\n" not in str(refusal.value)
    assert refusal.value.remedy


def test_each_mistake_is_in_one_place():
    assert parse_model(TEXT)
    assert len({text for text, _ in WRONG}) == len(WRONG)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"name = '\xff'", "is not UTF-8 text at byte 8; save it as UTF-8"),
        (b"#" * (LARGEST_FILE + 1), f"has more than {LARGEST_FILE} bytes; model files are small"),
    ],
)
def test_a_file_that_is_no_model_file(tmp_path, content, words):
    path = tmp_path / "pair.toml"
    path.write_bytes(content)
    with pytest.raises(ModelFileError, match=rf"^{re.escape(str(path))}: {words}"):
        read_model(path)


def test_what_is_no_file(tmp_path):
    with pytest.raises(ModelFileError, match=r"pair.toml: cannot be read: No such file or directory; check the path"):
        read_model(tmp_path / "pair.toml")
    with pytest.raises(ModelFileError, match=r": is no file; give a model file"):
        read_model(tmp_path)
    with pytest.raises(
        CaseError, match=r"^model 'fracturing-trick': is neither in the catalogue nor a model file; nearest is 'fracturing-tr"
    ):
        load("fracturing-trick")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes here")
def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pair.toml")
    with pytest.raises(ModelFileError, match=r": is no file; give a model file"):
        read_model(tmp_path / "pair.toml")


def test_text_of_a_driveline_made_in_python():
    line = Driveline("two", [Inertia("a", inertia=1.0), Inertia("b", inertia=0.1), Shaft("s", "a", "b", stiffness=1e22)])
    assert (
        model_text(line)
        == """\
format = 1
name = "two"

[elements.a]
kind = "inertia"
inertia = "1.0 kg*m^2"

[elements.b]
kind = "inertia"
inertia = "0.1 kg*m^2"

[elements.s]
kind = "shaft"
a = "a"
b = "b"
stiffness = "1e+22 N*m/rad"
"""
    )


LIMITS = """
format = 1
name = "chosen"
[[limits]]
rule = "iacs_m68"
elements = ["s"]
inputs = { tensile_strength = "600 MPa", shape_factor = "integral_flange" }
[[limits]]
rule = "syt_5211_angle"
[elements.a]
kind = "inertia"
inertia = "1 kg*m^2"
[elements.b]
kind = "inertia"
inertia = "1 kg*m^2"
[elements.s]
kind = "shaft"
a = "a"
b = "b"
stiffness = "1 kN*m/rad"
"""


def test_chosen_limits_are_read_and_written():
    line = parse_model(LIMITS)
    assert [(each.rule, each.elements, dict(each.inputs)) for each in line.limits] == [
        ("iacs_m68", ("s",), {"tensile_strength": "600 MPa", "shape_factor": "integral_flange"}),
        ("syt_5211_angle", (), {}),
    ]
    assert parse_model(model_text(line)) == line
    inner = Driveline("outer").include("box", line)
    assert [(each.rule, each.elements) for each in inner.limits] == [("iacs_m68", ("box_s",))]
    assert Driveline("one", limits="syt_5211_angle").limits[0].rule == "syt_5211_angle"
    given = ({"rule": "iacs_m68", "elements": ["s"], "inputs": dict(line.limits[0].inputs)}, "syt_5211_angle")
    assert Driveline("chosen", elements=line.elements, limits=given) == line


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('rule = "iacs_m68"', "rule = 3", "[limits.rule]: is 3"),
        ('elements = ["s"]', 'elements = ["t"]', "limit 'iacs_m68': is for 't', which is no element; known are a, b, s"),
        ('elements = ["s"]', 'elements = "s"', "write a list"),
        ('elements = ["s"]', 'element = ["s"]', "has an unknown key 'element'; nearest is 'elements'"),
        ('inputs = { tensile_strength = "600 MPa"', "inputs = { tensile_strength = [1]", "give a number or a text with a unit"),
    ],
)
def test_a_wrong_limit_is_refused(old, new, words):
    with pytest.raises(ModelFileError, match=re.escape(words)):
        parse_model(LIMITS.replace(old, new, 1))
