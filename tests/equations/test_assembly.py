"""From a driveline to its equations: parameters and their sharing, damping of modes, and what the record says."""

from __future__ import annotations

import pytest

from modelgen.elements import GroundSpring, HarmonicTorque, Inertia, RigidGear, Shaft
from modelgen.equations import assemble
from modelgen.errors import ModelError, ModelFileError, NamingError, UnitError
from modelgen.model import Driveline, NamedParameter

DISKS = Inertia("one", inertia=1.0), Inertia("two", inertia="mass")


def line(*more, parameters=None, shaft=None, **given):
    shaft = {"stiffness": 10.0, "damping_ratio": 0.1, **(shaft or {})}
    elements = [*DISKS, Shaft("s", "one", "two", **shaft), *more]
    return Driveline("line", elements, parameters={"mass": "2 kg*m^2", **(parameters or {})}, **given)


def expression(text, unit="1"):
    return NamedParameter(expression=text, unit=unit)


WRONG = [
    # shared parameters
    (
        line(shaft={"damping_ratio": "zetta"}, parameters={"zeta": 0.1}),
        NamingError,
        "shaft 's', damping_ratio: there is no parameter 'zetta'; ne",
    ),
    (line(parameters={"mass": "2 kg"}), UnitError, r"inertia 'two', inertia: parameter 'mass' is in kg; kg\*m\^2 is asked for"),
    (line(parameters={"mass": -2.0}), UnitError, r"inertia 'two', inertia: parameter 'mass' is in 1; kg\*m\^2 is asked for"),
    (
        line(parameters={"mass": "-2 kg*m^2"}),
        ModelError,
        r"inertia 'two', inertia, parameter 'mass': is -2 kg\*m\^2; give a positive value",
    ),
    (
        line(parameters={"mass": NamedParameter((1.0, 2.0), "kg*m^2")}),
        ModelError,
        "parameter 'mass' is a series; one number is asked for",
    ),
    (
        line(HarmonicTorque("t", "one", sine="mass", base="b"), bases={"b": 1}, speed=1.0, reference="one"),
        ModelError,
        "harmonic_torque 't', sine: parameter 'mass' is one number; a series is asked for",
    ),
    (
        line(RigidGear("g", "two", "three", teeth_a="z", teeth_b=3), Inertia("three", inertia=1.0), parameters={"z": 2.5}),
        ModelError,
        "rigid_gear 'g', teeth_a, parameter 'z': is 2.5; give a whole number",
    ),
    (
        Driveline(
            "line",
            [
                Inertia("one", inertia=1.0),
                Inertia("two", inertia=1.0),
                Shaft("s", "one", "two", stiffness=1.0, damping="loss_factor", loss_factor=0.1, reference_frequency="f"),
            ],
            parameters={"f": "50 Hz"},
        ),
        UnitError,
        "shaft 's', reference_frequency: parameter 'f' is in Hz; rad/s is asked for",
    ),
    # expressions
    (line(parameters={"a": expression("2*b")}), NamingError, "parameter 'a': there is no 'b'"),
    (
        line(parameters={"a": expression("2*(3")}),
        ModelFileError,
        r"parameter 'a': the parenthesis '\(' at character 3 is never closed",
    ),
    (
        line(parameters={"a": expression("__import__('os').system('true')")}),
        ModelFileError,
        "parameter 'a': '__import__' is no name",
    ),
    (
        line(parameters={"a": expression("b"), "b": expression("mass")}),
        ModelError,
        "parameter 'a': its expression uses b, which is an express",
    ),
    (
        line(parameters={"a": expression("a")}),
        ModelError,
        "parameter 'a': its expression uses a, which is an expression too; use plain",
    ),
    (
        line(parameters={"a": expression("1/(x - 1)"), "x": 1.0}),
        ModelError,
        "parameter 'a': its expression has no finite real value; check",
    ),
    (
        line(parameters={"a": expression("sqrt(x - 2)"), "x": 1.0}),
        ModelError,
        "parameter 'a': its expression has no finite real value",
    ),
    (
        line(parameters={"a": expression("exp(x)"), "x": 1e6}),
        ModelError,
        "parameter 'a': its expression has no finite real value",
    ),
    (line(parameters={"a": expression("mass + 1")}), UnitError, r"parameter 'a': its expression adds "),
    (
        line(parameters={"a": expression("sin(mass)")}),
        UnitError,
        r"parameter 'a': its expression takes a function or power of mass",
    ),
    (
        line(parameters={"a": expression("mass", "N*m")}),
        UnitError,
        r"parameter 'a': its expression has the dimension kg\*m\^2; its unit is N\*m",
    ),
    (line(parameters={"a": NamedParameter((1.0,)), "b": expression("a")}), NamingError, "parameter 'b': there is no 'a'"),
    # damping of modes
    (
        line(
            Shaft("t", "one", "two", stiffness=5.0, damping="modal", damping_ratio=0.2),
            shaft={"damping": "modal"},
        ),
        ModelError,
        r"driveline 'line': modal damping has different ratios \(s.damping_ratio, t.damping_ratio\); share one parameter",
    ),
]


@pytest.mark.parametrize(("wrong", "kind", "words"), WRONG)
def test_parameters_that_do_not_fit(wrong, kind, words):
    with pytest.raises(kind, match=words):
        assemble(wrong)


def test_an_expression_brings_its_unit():
    half = expression("mass*2/x")
    equations = assemble(line(parameters={"half": half, "x": "4 s"}))
    (found,) = (parameter for parameter in equations.parameters if parameter.name == "half")
    assert (found.values, found.unit) == ((1.0,), "kg*m^2/s")


def test_a_shared_parameter_takes_on_the_limits_of_those_that_use_it():
    equations = assemble(line(shaft={"damping_ratio": "zeta"}, parameters={"zeta": 0.1, "free": 1.0}))
    limits = {each.name: (each.positive, each.nonnegative, each.integer) for each in equations.parameters if "." not in each.name}
    assert limits == {"mass": (True, False, False), "zeta": (False, True, False), "free": (False, False, False)}


def test_one_ratio_for_all_modes_may_be_shared_or_equal():
    both = {"damping": "modal"}
    shared = line(
        Shaft("t", "one", "two", stiffness=5.0, damping="modal", damping_ratio="d"),
        shaft={**both, "damping_ratio": "d"},
        parameters={"d": 0.1},
    )
    assert assemble(shared).modal_ratio == "d"
    equal = line(Shaft("t", "one", "two", stiffness=5.0, damping="modal", damping_ratio=0.1), shaft=both)
    assert assemble(equal).modal_ratio == "s.damping_ratio"


def test_what_the_record_says():
    equations = assemble(line(GroundSpring("mount", "two", stiffness=3.0), description="a pair"))
    assert equations.description == "a pair"
    assert [state.name for state in equations.states] == ["mount.twist", "s.twist", "mount.twist_rate", "s.twist_rate"]
    assert [(state.unit, state.kind, state.is_rate) for state in equations.states[::3]] == [
        ("rad", "vibrating", False),
        ("rad/s", "vibrating", True),
    ]
    assert equations.rigid == ()
    assert equations.grounded == (True, True)
    assert "2 degrees of freedom" in str(equations)
    free = assemble(line(speed=10.0, reference="two"))
    assert [state.name for state in free.states[:2]] == ["two.angle_deviation", "s.twist"]
    assert free.rigid == (0,)
    names = [output.name for output in free.outputs]
    assert len(names) == len(set(names))
    assert {"s.torque", "s.stored_energy", "two.elastic_angle", "total.supplied_power"} <= set(names)
