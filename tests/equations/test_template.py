"""The laws of an element class: what they may say, and how a mistake in them is named."""

from __future__ import annotations

import pytest
import sympy

from modelgen.elements import Inertia, Shaft
from modelgen.equations import assemble
from modelgen.equations.template import build_template
from modelgen.errors import ModelError, NamingError, UnitError
from modelgen.lowering import lower
from modelgen.model import Choice, Clock, Derived, Driveline, Element, Flange, Param, State, quantity
from modelgen.model.declarations import TIME


@pytest.fixture(autouse=True)
def _vocabulary():
    """The classes made here are nobody else's."""
    before = dict(Element.vocabulary)
    yield
    Element.vocabulary.clear()
    Element.vocabulary.update(before)


def template(more, values=None, inherit=None):
    """The template of a spring with more said about it, or something else said."""

    class Spring(Element):
        a, b = Flange(), Flange()
        stiffness = Param("N*m/rad", positive=True)
        inertia = Param("kg*m^2", positive=True, default=1.0)
        ratio = Param(default=0.5)

        @quantity("rad")
        def twist(self):
            return self.a.angle - self.b.angle

        def torques(self):
            return {self.a: -self.stiffness * self.twist, self.b: self.stiffness * self.twist}

    made = type("Odd", (Spring,), {"__module__": __name__, **more})
    return build_template(made("it", "x", "y", stiffness=3.0, **(values or {})))


def law(unit="N*m"):
    return quantity(unit)


FOREIGN = sympy.Symbol("k_of_mine")
UNKNOWN = sympy.Function("friction")
WRONG = [
    # units
    (
        {"torques": lambda s: {s.a: s.stiffness * s.a.speed}},
        UnitError,
        r"torque on a is .*\[kg\*m\^2/s\^3\]; its unit is N\*m \[kg\*m\^2/s\^2\]",
    ),
    ({"torques": lambda s: {s.a: s.inertia}}, UnitError, r"torque on a is inertia \[kg\*m\^2\]; its unit is N\*m"),
    (
        {"torques": lambda s: {s.a: s.stiffness * (s.twist + s.a.speed)}},
        UnitError,
        r"torque on a adds .*a.speed \[1/s\].*; did you mean a speed where an angle stands",
    ),
    ({"energy": law("J")(lambda s: s.stiffness + s.inertia)}, UnitError, r"energy adds .*; check the units of its parameters"),
    (
        {"wave": law("1")(lambda s: sympy.sin(s.stiffness))},
        UnitError,
        r"wave takes a function or power of stiffness \[.*\]; make the argument",
    ),
    ({"wave": law("1")(lambda s: s.ratio**s.stiffness)}, UnitError, r"wave takes a function or power of stiffness \[.*\]"),
    (
        {"wave": law("1")(lambda s: s.stiffness**s.ratio)},
        UnitError,
        r"wave raises stiffness \[.*\] to ratio; only numbers may have such powers",
    ),
    ({"wave": law("1")(lambda s: sympy.Max(s.ratio, s.a.speed))}, UnitError, r"wave compares "),
    (
        {"wave": law("1")(lambda s: sympy.Piecewise((s.ratio, s.twist > 0), (s.a.speed, True)))},
        UnitError,
        r"wave chooses between ",
    ),
    ({"wave": law("1")(lambda s: sympy.Piecewise((s.ratio, s.twist > s.a.speed), (1, True)))}, UnitError, r"wave compares "),
    (
        {"wave": law("1")(lambda s: UNKNOWN(s.ratio))},
        UnitError,
        r"wave uses friction, whose dimension is not known; write it with ordinary",
    ),
    (
        {"wave": law("1")(lambda s: sympy.Integral(s.ratio, s.ratio))},
        UnitError,
        r"wave uses Integral, whose dimension is not known",
    ),
    (
        {"wave": law("1")(lambda s: s.ratio / sympy.Integer(0))},
        UnitError,
        r"wave uses ComplexInfinity, whose dimension is not known",
    ),
    ({"stored_energy": lambda s: s.stiffness * s.a.speed}, UnitError, r"stored_energy is .*; its unit is J"),
    ({"dissipated_power": lambda s: s.stiffness * s.twist**2}, UnitError, r"dissipated_power is .*; its unit is W"),
    ({"inertias": lambda s: {s.a: s.stiffness}}, UnitError, r"inertia on a is stiffness \[.*\]; its unit is kg\*m\^2"),
    ({"kinetic_energy": lambda s: s.stiffness * s.a.speed**2}, UnitError, r"inertia on a is .*; its unit is kg\*m\^2"),
    ({"constraints": lambda s: [s.stiffness * s.a.angle - s.b.angle]}, UnitError, r"constraint adds "),
    (
        {"slip": State("rad"), "rates": lambda s: {s.slip: s.twist}},
        UnitError,
        r"rate of slip times a second is .*; its unit is rad",
    ),
    (
        {"wave": quantity("N*m", mean=lambda s: s.ratio)(lambda s: s.stiffness * TIME * s.a.speed)},
        UnitError,
        "mean of wave is ratio",
    ),
    # symbols
    (
        {"torques": lambda s: {s.a: FOREIGN * s.twist}},
        ModelError,
        "torque on a uses k_of_mine; use only the element's own declarations",
    ),
    (
        {"wave": law()(lambda s: sympy.Symbol("stiffness") * s.twist)},
        ModelError,
        "wave uses stiffness; use only the element's own decl",
    ),
    ({"torques": lambda s: {s.a: "k * u"}}, ModelError, r"torque on a is 'k \* u'; return a SymPy expression"),
    ({"torques": lambda s: {s.a: True}}, ModelError, r"torque on a is True; return a SymPy expression"),
    (
        {"torques": lambda s: {s.a.angle: 0}},
        ModelError,
        r"torques names a.angle; use the element's own flanges as keys, such as self.a",
    ),
    ({"torques": lambda s: {"a": 0}}, ModelError, r"torques names 'a'; use the element's own flanges as keys"),
    # quantities
    (
        {"first": law("1")(lambda s: s.second), "second": law("1")(lambda s: s.first)},
        ModelError,
        "quantities .*first, second define each other; break the circle",
    ),
    ({"first": law("1")(lambda s: s.first + 1)}, ModelError, "quantities first define each other; break the circle"),
    ({"t": Param("1", default=1.0)}, NamingError, "declares two things that its laws both call 't'; rename one of them"),
    (
        {"row": Param(series=True, default=(1.0, 2.0)), "row_2": Param(default=1.0)},
        NamingError,
        "declares two things that its laws both call 'row_2'; rename one of them",
    ),
    # inertia and constraints
    (
        {"inertias": lambda s: {s.a: s.inertia * sympy.cos(s.a.angle)}},
        ModelError,
        r"inertia on a depends on a.angle; an inertia that depends on angle belongs in kinetic_energy\(\)",
    ),
    (
        {"kinetic_energy": lambda s: s.inertia * s.a.speed**3 / s.b.speed},
        ModelError,
        "kinetic energy is not quadratic in the speeds; write",
    ),
    (
        {"kinetic_energy": lambda s: s.inertia * s.a.speed**2 * sympy.sin(TIME * s.b.speed)},
        ModelError,
        "kinetic energy depends on t; write it with parameters, flange angles and speeds",
    ),
    (
        {"constraints": lambda s: [s.a.angle**2 - s.b.angle**2]},
        ModelError,
        r"constraint .* is no linear combination of angles; write n_a",
    ),
    (
        {"constraints": lambda s: [s.a.angle - s.b.angle + s.ratio]},
        ModelError,
        r"constraint .* is no linear combination of angles",
    ),
    ({"constraints": lambda s: [s.a.speed - s.b.speed]}, ModelError, r"constraint .* is no linear combination of angles"),
    (
        {"modal_damping": lambda s: 2 * s.ratio},
        ModelError,
        r"modal damping is 2\*ratio; return one of the element's own parameters, or None",
    ),
    ({"modal_damping": lambda s: 0.05}, ModelError, r"modal damping is 0.05; return one of the element's own parameters"),
    # own states
    ({"slip": State("rad")}, ModelError, "has own states without a rate, or rates without a state; give one rate per State"),
    ({"rates": lambda s: {s.ratio: s.a.speed}}, ModelError, "has own states without a rate, or rates without a state"),
]


@pytest.mark.parametrize(("more", "kind", "words"), WRONG)
def test_a_mistake_in_a_law_is_named(more, kind, words):
    with pytest.raises(kind, match=f"^odd 'it': {words}"):
        template(more)


def test_a_quantity_may_not_have_the_name_of_a_channel_that_every_disk_has():
    class Flywheel(Element):
        flange = Flange()
        inertia = Param("kg*m^2", positive=True)

        @quantity("rad")
        def angle(self):
            return self.flange.angle / 2

        def inertias(self):
            return {self.flange: self.inertia}

    with pytest.raises(
        ModelError, match=r"^flywheel 'disk': names a quantity 'angle', which modelgen adds itself; rename the quantity"
    ):
        assemble(Driveline("line", [Flywheel("disk", inertia=1.0)]))


def test_a_derived_parameter_needs_what_it_follows_from():
    class Disk(Element):
        flange = Flange()
        known = Choice("size", "inertia")
        radius = Param("m", positive=True, when={"known": "size"})
        moment = Param("kg*m^2", positive=True, when={"known": "inertia"})
        weight = Derived("kg", lambda radius: [radius**2], of=("radius",), count=lambda element: 1)

        def inertias(self):
            return {self.flange: self.moment if self.known == "inertia" else self.weight[0] * self.radius**2}

    assert assemble(Driveline("line", [Disk("disk", radius=2.0)])).derived[0].name == "disk.weight"
    with pytest.raises(
        ModelError, match=r"^disk 'disk': weight follows from radius, which its switches leave out; change the switches"
    ):
        assemble(Driveline("line", [Disk("disk", known="inertia", moment=1.0)]))


def test_a_unit_or_a_number_may_come_as_zero():
    made = template({"torques": lambda s: {s.a: 0, s.b: 0.0}, "wave": law("N*m")(lambda s: sympy.Integer(0))})
    assert made.torques == {"a": 0, "b": 0}


def test_sums_of_angles_become_relative():
    made = template({})
    (relative,) = made.relatives
    assert (relative.name, relative.unit, relative.coefficients) == ("twist", "rad", {"a": 1, "b": -1})
    assert made.absolute_angles == ()


def test_a_common_factor_that_varies_is_no_part_of_a_relative_angle():
    # Written out, the viscous torque has a coefficient that varies with the twist: c(u) speed a - c(u) speed b.
    drag = law("N*m*s/rad")(lambda s: s.damping * (1 + s.twist**2))
    more = {
        "damping": Param("N*m*s/rad", default=2.0),
        "drag": drag,
        "torques": lambda s: {s.a: s.drag * s.b.speed - s.drag * s.a.speed, s.b: s.drag * s.a.speed - s.drag * s.b.speed},
    }
    made = template(more)
    assert [relative.coefficients for relative in made.relatives] == [{"a": 1, "b": -1}]
    assert made.absolute_angles == ()
    assert made.torques["a"] == -sympy.Symbol("drag", real=True) * made.relatives[0].rate


def test_an_unnamed_relative_displacement_has_its_own_unit():
    more = {
        "radius": Param("m", default=0.1),
        "contact": Param("N/m", default=5.0),
        "force": law("N")(lambda s: s.contact * (s.radius * s.a.angle - 2 * s.radius * s.b.angle)),
        "torques": lambda s: {s.a: -s.radius * s.force, s.b: 2 * s.radius * s.force},
    }
    assert sorted(relative.unit for relative in template(more).relatives) == ["m", "rad"]


def test_a_clock_that_a_law_runs_on_must_have_a_base():
    class Wobble(Element):
        flange = Flange()
        clock = Clock()
        height = Param("N*m", default=1.0)

        def torques(self):
            return {self.flange: self.height * sympy.sin(self.clock.angle / 2)}

    with pytest.raises(ModelError, match=r"^wobble 'push': clock is missing; name a base frequency of the driveline"):
        assemble(Driveline("line", [Inertia("disk", inertia=1.0), Wobble("push", "disk")], speed=1.0, reference="disk"))


def test_a_kinetic_energy_may_use_the_names_of_quantities():
    # The lever is a quantity; its change with angle gives the centrifugal torque J'(angle) speed^2 / 2 all the same.
    class Lever(Element):
        flange = Flange()
        mass = Param("kg", positive=True)
        arm = Param("m", positive=True)

        @quantity("m")
        def lever(self):
            return self.arm * (2 + sympy.cos(self.flange.angle))

        def kinetic_energy(self):
            return self.mass * (self.lever * self.flange.speed) ** 2 / 2

    model = lower(assemble(Driveline("line", [Lever("it", mass=3.0, arm=0.5)])))
    angle, speed = 0.7, 1.1
    now = model.evaluate(0.0, [angle, speed], model.parameters.vector())
    lever, slope = 0.5 * (2 + sympy.cos(angle)), -0.5 * sympy.sin(angle)
    # (m l^2) acceleration + m l l' speed^2 = 0
    assert now["it.acceleration"] == pytest.approx(float(-slope / lever * speed**2), rel=1e-14)
    assert now["total.kinetic_energy"] == pytest.approx(float(3 * lever**2 * speed**2 / 2), rel=1e-14)


def test_an_inertia_may_be_a_named_quantity():
    # The inertia that damping asks for must find it, written out in parameters.
    class Ring(Element):
        flange = Flange()
        mass = Param("kg", positive=True)
        radius = Param("m", positive=True)

        @quantity("kg*m^2")
        def moment(self):
            return self.mass * self.radius**2

        def inertias(self):
            return {self.flange: self.moment}

    line = Driveline(
        "line",
        [
            Ring("ring", mass=2.0, radius=3.0),
            Inertia("disk", inertia=1.0),
            Shaft("s", "ring", "disk", stiffness=8.0, damping_ratio=0.1),
        ],
    )
    model = lower(assemble(line))
    now = model.evaluate(0.0, [0.0] * 4, model.parameters.vector())
    assert now["s.viscous_coefficient"] == pytest.approx(2 * 0.1 * (8 * 18 / 19) ** 0.5, rel=1e-15)


@pytest.mark.parametrize(
    ("method", "answer", "words"),
    [
        ("torques", [1], r"torques answers list; return a dict such as \{self.flange: law\}"),
        ("torques", None, r"torques answers NoneType; return a dict"),
        ("inertias", (1,), r"inertias answers tuple; return a dict"),
        ("rates", 3.0, r"rates answers float; return a dict such as \{self.state: law\}"),
        ("constraints", sympy.Symbol("x"), r"constraints answers Symbol; return a list, such as \[law\]"),
        ("constraints", None, r"constraints answers NoneType; return a list"),
        ("constraints", 0, r"constraints answers int; return a list"),
    ],
)
def test_a_method_that_answers_another_kind_is_one_sentence(method: str, answer: object, words: str) -> None:
    with pytest.raises(ModelError, match=f"odd 'it': {words}"):
        template({method: lambda self: answer})
