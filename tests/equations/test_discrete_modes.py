"""Modes and guards in the grammar: what regions imply, what is refused, and how they are printed."""

from __future__ import annotations

import pytest
import sympy

from modelgen.elements import Brake, GearPair, GroundSpring, HardStop, Inertia
from modelgen.equations import assemble, system
from modelgen.equations.template import build_template
from modelgen.errors import ModelError, ModelFileError, NamingError, UnitError
from modelgen.model import Driveline, Element, Flange, Guard, Modes, Multiplier, Param, State, quantity


@pytest.fixture(autouse=True)
def _vocabulary():
    """The classes made here are nobody else's."""
    before = dict(Element.vocabulary)
    yield
    Element.vocabulary.clear()
    Element.vocabulary.update(before)


def template(more):
    """The template of a spring with modes and more said about it."""

    class Sprung(Element):
        a, b = Flange(), Flange()
        stiffness = Param("N*m/rad", positive=True)
        gap = Param("rad", default=0.1)
        heat = State("J")
        side = Modes("free", "upper", "lower")

        @quantity("rad")
        def twist(self):
            return self.a.angle - self.b.angle

        @quantity("N*m")
        def torque(self):
            return self.stiffness * self.twist * (self.side.upper + self.side.lower)

        def torques(self):
            return {self.a: -self.torque, self.b: self.torque}

        def rates(self):
            return {self.heat: 0}

        def regions(self):
            return {self.side.upper: self.twist - self.gap, self.side.lower: -self.twist - self.gap}

    return build_template(type("Odd", (Sprung,), {"__module__": __name__, **more})("it", "x", "y", stiffness=3.0))


def test_regions_give_their_guards():
    found = template({})
    leads = [(each.leave, each.enter, each.direction) for each in found.guards]
    assert leads == [
        ("free", "upper", 1),
        ("upper", "free", -1),
        ("lower", "upper", 1),
        ("free", "lower", 1),
        ("lower", "free", -1),
    ]
    upper, lower = found.guards[0].expression, found.guards[3].expression
    assert [each.expression for each in found.guards] == [upper, upper, upper, lower, lower]
    twist, gap = sympy.Symbol("twist", real=True), sympy.Symbol("gap", real=True)
    assert (upper, lower) == (twist - gap, -twist - gap)
    assert not found.modes[0].memory
    # For reading and for proofs the law stands in cases, on the element's own words.
    stiffness = sympy.Symbol("stiffness", real=True, positive=True)
    assert found.law["definitions"]["torque"] == sympy.Piecewise(
        (stiffness * twist, twist >= gap), (stiffness * twist, -twist >= gap), (0, True)
    )


def guards(*given):
    return {"guards": lambda self: [each(self) for each in given], "regions": lambda self: {}}


def test_guards_make_memory_and_start_where_they_are_told():
    modes = Modes("free", "upper", start="upper")
    there = lambda s: Guard("there", s.twist - s.gap, 1, s.side.free, s.side.upper)  # noqa: E731
    back = lambda s: Guard("back", s.twist, -1, "upper", "side.free", reset={s.heat: 2 * s.heat})  # noqa: E731
    no_lower = {"torques": lambda s: {s.a: 0}, "torque": quantity("N*m")(lambda s: s.side.upper * s.stiffness)}
    found = template({"side": modes, **no_lower, **guards(there, back)})
    assert (found.modes[0].memory, found.modes[0].start, found.modes[0].regions) == (True, 1, {})
    assert [(each.variable, each.leave, each.enter) for each in found.guards] == [
        ("side", "free", "upper"),
        ("side", "upper", "free"),
    ]
    assert found.guards[1].resets[0].state == sympy.Symbol("heat", real=True)


def guard(**given):
    """A guard out of its place, as an element with regions may give it, beside its modes."""
    fields = {"name": "odd", "expression": lambda s: s.twist, **given}

    def made(self):
        values = {key: value(self) if callable(value) else value for key, value in fields.items()}
        return [Guard(**values)]

    return {"guards": made}


def hold(speed, multiplier=lambda s: s.grip, **more):
    return {"grip": Multiplier(), "holds": lambda s: {s.side.upper: (speed(s), multiplier(s))}, **more}


WRONG = [
    # regions
    ({"regions": lambda s: {}}, ModelError, "nothing leads into its modes 'side'; answer regions"),
    ({"regions": lambda s: {s.side.upper: s.twist}}, ModelError, "nothing leads into its mode side.lower; give it a guard or"),
    ({"regions": lambda s: {s.side.free: s.twist}}, ModelError, "region of side.free is given, the mode at rest; leave it out"),
    ({"regions": lambda s: {s.side.upper: s.torque}}, ModelError, "region of side.upper depends on modes itself"),
    (
        {"regions": lambda s: {s.side.upper: s.twist - s.stiffness, s.side.lower: s.twist}},
        UnitError,
        "region of side.upper adds",
    ),
    ({"regions": lambda s: {"side.uper": s.twist}}, NamingError, "names the mode 'side.uper'; nearest is 'side.upper'"),
    ({"regions": lambda s: {s.side.upper: sympy.Symbol("mine")}}, ModelError, "region of side.upper uses mine"),
    # guards
    (guard(direction=2), ModelError, r"guard 'odd' has the direction 2; give 1 \(rising\)"),
    (guard(direction=True), ModelError, "has the direction True"),
    (guard(name="two words"), NamingError, "guard 'two words'"),
    (guard(leave="free"), ModelError, "names one mode only; name the mode it leaves and the one it enters, or none"),
    (guard(leave="free", enter="free"), ModelError, "leaves and enters 'free'; leave both out"),
    (guard(leave="free", enter="uper"), NamingError, "guard 'odd' names the mode 'uper'; nearest is 'upper'"),
    (guard(expression=lambda s: s.gap), ModelError, "guard 'odd' never changes: gap; write it with time"),
    (guard(expression=lambda s: s.twist + s.heat), UnitError, "guard 'odd' adds"),
    (guard(expression=lambda s: sympy.Symbol("mine")), ModelError, "guard 'odd' uses mine"),
    (guard(reset=lambda s: {s.a.angle: 0}), ModelError, "guard 'odd' resets a.angle; set own states, flange speeds"),
    (guard(reset=lambda s: {s.a.speed**2: 0}), ModelError, "resets a.speed.*linear combinations"),
    (guard(reset=lambda s: {s.twist * s.a.speed: 0}), ModelError, "linear combinations"),
    (guard(reset=lambda s: {s.a.speed: s.twist}), UnitError, "reset of guard 'odd' adds"),
    ({"guards": lambda s: [s.twist]}, ModelError, r"guards\(\) gives twist; give Guard\(name, expression"),
    ({"guards": lambda s: [Guard("odd", s.twist)] * 2}, NamingError, "has two guards named 'odd'; rename one"),
    # held speeds
    (hold(lambda s: s.a.speed, lambda s: s.heat), ModelError, r"what side.upper holds has the multiplier heat; declare it"),
    (hold(lambda s: s.gap), ModelError, "what side.upper holds is gap; write it with flange speeds or own states"),
    (hold(lambda s: s.a.speed * s.side.free), ModelError, "write it with flange speeds or own states, without modes"),
    (hold(lambda s: s.a.speed + s.twist), UnitError, "what holds grip adds a.speed"),
    ({"grip": Multiplier()}, ModelError, r"the multiplier 'grip' holds 0 speeds; let holds\(\) use it once"),
]


@pytest.mark.parametrize(("more", "error", "words"), WRONG)
def test_wrong_modes_are_refused(more, error, words):
    with pytest.raises(error, match=words):
        template(more)


def test_a_mode_of_two_variables_needs_its_symbol():
    twice = {"other": Modes("free", "upper", "lower"), **guard(leave="free", enter="upper")}
    with pytest.raises(NamingError, match="names the mode 'free', which two variables have; give its symbol"):
        template(twice)
    across = guard(leave=lambda s: s.side.free, enter=lambda s: s.other.upper)
    with pytest.raises(ModelError, match="leads from modes 'side' to modes 'other'; stay with one of them"):
        template({"other": Modes("free", "upper", "lower"), **across})


def test_flags_may_not_be_asked_for_where_the_switches_leave_them_out():
    mesh = GearPair("mesh", "a", "b", teeth_a=20, teeth_b=30, module=0.005, mean_stiffness=1e8)
    assert build_template(mesh).modes[0].continuous
    assert not build_template(mesh.copy(viscous="contact_only")).modes[0].continuous


def test_the_record_lists_modes_guards_and_channels():
    line = Driveline(
        "braked",
        elements=[
            *(Inertia("disk", inertia=2.0), Inertia("far", inertia=3.0), GroundSpring("wire", "disk", stiffness=8.0)),
            *(Brake("brake", "disk", sliding_torque=1.0, holding_torque=1.5), HardStop("stop", "disk", "far", clearance=0.1)),
        ],
    )
    equations = assemble(line)
    assert equations.modes == {"brake.contact": ("stick", "forward", "backward")}
    assert [f"{name}.{each.name}" for name, each in equations.guards] == [
        *("brake.moved_forward", "brake.moved_backward", "brake.break_forward", "brake.break_backward"),
        *("brake.stick_forward", "brake.stick_backward", "stop.upper", "stop.lower"),
    ]
    assert ("brake.contact", "1") in [(each.name, each.unit) for each in equations.outputs]


# -- printed -------------------------------------------------------------------------------------------------------------------


def test_modes_are_printed():
    disks = [Inertia("disk", inertia=2.0), Inertia("far", inertia=3.0)]
    mesh = GearPair("mesh", "disk", "far", teeth_a=20, teeth_b=30, module=0.005, mean_stiffness=1e8)
    brake = Brake("brake", "disk", sliding_torque=1.0, holding_torque=1.5)
    text = assemble(Driveline("braked", [*disks, mesh, brake], speed=1.0, reference="disk", drifts=True)).markdown()
    assert r"Modes `flank`: `drive` where $\delta \geq b$, `coast` where $\delta \leq - b$, else `free`." in text
    assert "Modes `contact`: `stick`, `forward`, `backward`. A run is taken to begin in `stick`" in text
    assert r"| `break_forward` | `stick` to `forward` | $\text{friction} - \text{holding torque}$ rises through zero |" in text
    assert r"In the mode `contact.stick` $\text{friction}$ keeps $\text{slip}$ as it is." in text
    assert r"\text{sliding torque} & \text{if } \text{forward}" in text
    assert r"| $\text{friction}$ | `friction` | N·m | torque that keeps it from slipping |" in text
    assert "`holding_torque`" in text


def test_a_plain_system_prints_its_guards():
    ball = system(
        {"h": 1.0, "v": 0.0}, {"h": "v", "v": -9.81}, guards=[Guard("bounce", "h", -1, reset={"v": "-v/2"}, stops=True)]
    )
    assert r"| `bounce` | the run ends | $h$ falls through zero | $v = - \frac{v}{2}$ |" in ball.markdown()
    assert r"\texttt{bounce} & the run ends & $h$ falls through zero" in ball.latex()


# -- plain systems -------------------------------------------------------------------------------------------------------------


def test_a_plain_system_by_texts_and_by_symbols():
    x, v, touch = sympy.symbols("x v stop.touch")
    given = {"states": {"x": 0.0, "v": 1.0}, "parameters": {"k": 50.0, "gap": 1.0}}
    by_text = system(
        **given,
        rates={"x": "v", "v": "-x - k*stop.touch*(x - gap)"},
        modes={"stop": ("free", "touch")},
        regions={"stop.touch": "x - gap"},
    )
    k, gap = sympy.symbols("k gap")
    by_symbols = system(
        **given,
        rates={x: v, v: -x - k * touch * (x - gap)},
        modes={"stop": Modes("free", "touch")},
        regions={touch: x - gap},
    )
    for part in ("rates", "modes", "guards"):
        assert getattr(by_text.templates[0], part) == getattr(by_symbols.templates[0], part)
    assert by_text.modes == {"stop": ("free", "touch")}
    assert [each.name for each in by_text.outputs] == ["x", "v", "stop"]


def plain(**given):
    return system({"x": 0.0, "v": 1.0}, {"x": "v", "v": "-x"}, {"k": 1.0}, **given)


TWO = {"modes": {"stop": ("free", "touch")}}


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ({"modes": ["stop"]}, ModelError, "its modes are list; give a mapping"),
        ({"modes": {"stop": "free"}}, ModelError, "modes 'stop': are 'free'; give their names"),
        ({"modes": {"x": ("free", "touch")}}, NamingError, "mode 'x' is a state already"),
        (TWO, ModelError, "nothing leads into its modes 'stop'"),
        ({**TWO, "regions": ["x"]}, ModelError, "its regions are list"),
        ({**TWO, "regions": {"stop.touch": "x - gap"}}, NamingError, "region of stop.touch: there is no 'gap'"),
        ({**TWO, "regions": {"stop.touch": "__import__('os')"}}, ModelFileError, "region of stop.touch"),
        ({**TWO, "regions": {"stop.touch": "stop.free - 1"}}, ModelError, "depends on modes itself"),
        ({"guards": Guard("odd", "x")}, ModelError, r"its guards are Guard; give a list of Guard\(...\)"),
        ({"guards": ["x"]}, ModelError, r"guards\(\) gives 'x'"),
        ({"guards": [Guard("odd", "x - y")]}, NamingError, "guard 'odd': there is no 'y'"),
        ({"guards": [Guard("odd", "x", reset={"k": 1})]}, NamingError, "guard 'odd' resets 'k'; "),
        ({"guards": [Guard("odd", "k")]}, ModelError, "guard 'odd' never changes: k"),
        ({"guards": [Guard("odd", "x", leave="free", enter="touch")]}, NamingError, "names the mode 'free'"),
    ],
)
def test_wrong_plain_modes_are_refused(given, error, words):
    with pytest.raises(error, match=words):
        plain(**given)
