"""The model with its modes as flags: against comparisons, and against multipliers and impulses by hand; its sections."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

from modelgen.drivelines import load
from modelgen.elements import Brake, ElasticStop, GearPair, GroundSpring, HardStop, Inertia, RigidGear, Shaft
from modelgen.equations import assemble, system
from modelgen.errors import CaseError, LoweringError, ModelError
from modelgen.lowering import Section, lower
from modelgen.model import Driveline, Element, Flange, Guard, Modes, Multiplier, Param, State


@pytest.fixture(autouse=True)
def _vocabulary():
    """The classes made here are nobody else's."""
    before = dict(Element.vocabulary)
    yield
    Element.vocabulary.clear()
    Element.vocabulary.update(before)


DISKS = (Inertia("disk", inertia=2.0), Inertia("far", inertia=3.0))


def compiled(*elements, **more):
    return lower(assemble(Driveline("line", [*DISKS, *elements], **more)))


def meshed(**given):
    mesh = {"teeth_a": 20, "teeth_b": 30, "module": 0.01, "mean_stiffness": 1e4, "half_backlash": 0.01, **given}
    return compiled(GearPair("mesh", "disk", "far", **mesh), speed=3.0, reference="disk")


def with_modes(switched, p, *values):
    """The extended parameter vector in the named modes."""
    extended = switched.extended(p)
    for mode, value in zip(switched.switching.modes, values, strict=True):
        mode.put(extended, mode.values.index(value))
    return extended


# -- flags and comparisons -----------------------------------------------------------------------------------------------------

TRUCK = lower(assemble(load("fracturing-truck")))
MODELS = {
    "truck": (TRUCK, 0.01),
    "damper always": (meshed(damping="value", damping_coefficient=40.0), 0.2),
    "damper in contact": (meshed(damping="value", damping_coefficient=40.0, viscous="contact_only"), 0.2),
    "elastic stop": (compiled(ElasticStop("stop", "disk", "far", clearance=0.1, stiffness=50.0, damping_coefficient=3.0)), 0.3),
    "brake": (compiled(Shaft("s", "disk", "far", stiffness=9.0), Brake("b", "far", sliding_torque=1, holding_torque=2)), 0.3),
}


@pytest.mark.parametrize("name", MODELS)
def test_flags_and_comparisons_give_the_same_numbers(name):
    model, size = MODELS[name]
    switched, p = model.switched(), model.parameters.vector()
    rng, seen = np.random.default_rng(7), set()
    for _ in range(60):
        t, x = rng.uniform(0, 3), rng.uniform(-size, size, len(model.states))
        now = model.evaluate(t, x, p)
        modes = [mode.values[int(now[mode.name])] for mode in switched.switching.modes]
        seen.update(modes)
        extended = with_modes(switched, p, *modes)
        rate = model.rhs(t, x, p)
        assert np.asarray(switched.rhs_function(t, x, extended)).ravel() == pytest.approx(rate, rel=1e-13, abs=1e-13)
        outputs = np.asarray(switched.output_function(t, x, extended)).ravel()
        assert outputs == pytest.approx(list(now.values()), rel=1e-12, abs=1e-12)
        if not any(mode.memory for mode in switched.switching.modes):
            # No guard of the modes that hold is beyond its border, and each one that would lead away has its lawful sign.
            values = np.asarray(switched.switching.guards(t, x, extended)).ravel()
            for crossing, value in zip(switched.switching.crossings, values, strict=True):
                mode = switched.switching.modes[crossing.variable]
                if mode.values[crossing.leave] == now_mode(now, mode):
                    assert value * crossing.direction < 0
    assert len(seen) >= 2


def now_mode(now, mode):
    return mode.values[int(now[mode.name])]


def test_within_a_mode_the_law_goes_on_beyond_its_border():
    model = meshed()
    switched = model.switched()
    extended = with_modes(switched, model.parameters.vector(), "drive")
    x = np.array([0.0, 0.005, 0.0, 0.0])  # within the backlash, 5 mm before the driving flanks touch
    row = model.output_index("mesh.force")
    assert switched.output_function(0.0, x, extended)[row] == pytest.approx(1e4 * (0.005 - 0.01))
    assert model.evaluate(0.0, x, model.parameters.vector())["mesh.force"] == 0


def test_the_extended_vector_begins_with_the_models_own():
    model = meshed()
    p = model.parameters.vector()
    extended = model.extended(p)
    assert extended[: len(p)].tolist() == p.tolist()
    assert extended[len(p) :].tolist() == [1.0, 0.0, 0.0]
    assert model.switching.p_size == len(extended)
    assert model.switching.value_names() == ["mesh.flank.free", "mesh.flank.drive", "mesh.flank.coast"]
    assert [mode.of(extended) for mode in model.switching.modes] == [0]
    with pytest.raises(CaseError, match="p: has the shape"):
        model.extended(p[1:])


def test_what_must_and_what_should_be_located():
    assert (meshed().switching.required, meshed().switching.jumps) == (False, False)
    contact = meshed(viscous="contact_only").switching
    assert (contact.required, contact.jumps) == (False, True)
    brake = compiled(GroundSpring("wire", "disk", stiffness=1.0), Shaft("s", "disk", "far", stiffness=1.0), *two_brakes()[:1])
    assert brake.switching.required
    assert compiled(HardStop("stop", "disk", "far", clearance=0.1)).switching.required
    ends = system({"x": 0.0}, {"x": "1"}, guards=[Guard("end", "x - 1", 1, stops=True)])
    assert lower(ends).switching.required
    assert not lower(system({"x": 0.0}, {"x": "1"}, guards=[Guard("seen", "x - 1", 1)])).switching.required


def test_a_model_without_modes_has_no_switching():
    model = compiled(Shaft("shaft", "disk", "far", stiffness=7.0))
    assert model.switching is None
    assert model.switched() is None
    p = model.parameters.vector()
    assert model.extended(p).tolist() == p.tolist()


def test_channels_over_a_trajectory_follow_the_given_modes():
    model = meshed()
    switched, p = model.switched(), model.parameters.vector()
    rng = np.random.default_rng(3)
    times, states, modes = np.linspace(0, 1, 300), rng.uniform(-0.02, 0.02, (300, 4)), rng.integers(0, 3, (300, 1))
    found = switched.channels(times, states, modes, p, ["mesh.force", "mesh.flank"])
    assert list(found) == ["mesh.force", "mesh.flank"]
    assert found["mesh.flank"].tolist() == modes[:, 0].tolist()
    delta = states[:, 1] - 0.01 * np.array([0, 1, -1])[modes[:, 0]]
    assert found["mesh.force"] == pytest.approx(np.where(modes[:, 0] == 0, 0, 1e4 * delta), abs=1e-9)
    assert list(switched.channels(times[:0], states[:0], modes[:0], p)) == list(model.outputs)


def test_the_fingerprint_sees_guards():
    def ball(restitution, direction=-1):
        guard = Guard("bounce", "h", direction, reset={"v": f"-{restitution}*v"})
        return lower(system({"h": 1.0, "v": 0.0}, {"h": "v", "v": -9.81}, guards=[guard])).fingerprint

    assert ball(0.5) == ball(0.5)
    assert len({ball(0.5), ball(0.6), ball(0.5, 1)}) == 3


# -- sections ------------------------------------------------------------------------------------------------------------------


def test_sections_are_crossings_behind_the_models_own():
    model = meshed()
    p = model.parameters.vector()
    sections = [Section("disk.speed", 2.9, -1), Section("mesh.force", direction=0, stop=True)]
    switched = model.switched(sections)
    first, second = switched.switching.crossings[-2:]
    assert (first.name, first.direction, first.variable, first.reset, first.stops) == (
        "section disk.speed",
        -1,
        None,
        None,
        False,
    )
    assert (second.name, second.direction, second.stops) == ("section mesh.force", 0, True)
    x = np.array([0.3, 0.05, 0.2, 0.1])
    extended = model.extended(p, sections)
    assert extended[-2:].tolist() == [2.9, 0.0]
    values = np.asarray(switched.switching.guards(0.0, x, extended)).ravel()
    now = np.asarray(switched.output_function(0.0, x, extended)).ravel()
    assert values[-2:] == pytest.approx([now[model.output_index(n)] - v for n, v in (("disk.speed", 2.9), ("mesh.force", 0))])
    assert values[:-2] == pytest.approx(np.asarray(model.switching.guards(0.0, x, model.extended(p))).ravel())


def test_other_values_of_sections_build_nothing():
    model = meshed()
    first, second = (model.switched([Section("disk.speed", value)]) for value in (1.0, 2.0))
    assert first.rhs_function is second.rhs_function
    assert (first.tail[-1], second.tail[-1]) == (1.0, 2.0)


def test_a_section_of_a_model_without_modes():
    model = lower(system({"x": 1.0}, {"x": "-x"}))
    switched = model.switched([Section("x", 0.25, -1)])
    assert switched.extended(np.array([])).tolist() == [0.25]
    assert float(switched.switching.guards(0.0, [1.0], [0.25])) == 0.75
    assert float(switched.switching.guard_rates(0.0, [1.0], [-1.0], [0.25])[1]) == -1.0
    assert float(switched.rhs_function(0.0, [3.0], [0.25])) == -3.0
    assert model.switching is None


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"channel": 3}, "section: its channel is 3; give the name of an output channel"),
        ({"value": float("nan")}, "section 'x': its value is nan; give a finite number"),
        ({"value": True}, "its value is True"),
        ({"value": "1"}, "its value is '1'"),
        ({"direction": 2}, r"its direction is 2; give 1 \(rising\)"),
        ({"direction": True}, "its direction is True"),
        ({"stop": 1}, "stop is 1; give True or False"),
    ],
)
def test_wrong_sections_are_refused(given, words):
    with pytest.raises(CaseError, match=words):
        Section(**{"channel": "x", **given})


def test_a_section_of_an_unknown_channel_is_refused():
    with pytest.raises(CaseError, match=r"no output 'disk\.sped'; nearest is 'disk\.speed'"):
        meshed().switched([Section("disk.sped")])


# -- held speeds: lambda from (G M^-1 G^T) lambda = ... by hand ----------------------------------------------------------------


def two_brakes():
    return [Brake(f"{disk}_brake", disk, sliding_torque=1.0, holding_torque=2.0) for disk in ("disk", "far")]


def test_the_held_torque_balances_what_acts_on_the_node():
    # One disk is held: its friction is the whole torque of the shaft on it, and the other disk swings.
    model = compiled(Shaft("shaft", "disk", "far", stiffness=9.0), *two_brakes())
    switched, p, row = model.switched(), model.parameters.vector(), model.output_index
    x = {"disk.angle_deviation": 0.0, "shaft.twist": 0.2, "disk.angle_deviation_rate": 0.0, "shaft.twist_rate": 0.4}
    x = np.array([x[name] for name in model.states])
    outputs = np.asarray(switched.output_function(0.0, x, with_modes(switched, p, "stick", "forward"))).ravel()
    assert outputs[row("disk_brake.torque")] == pytest.approx(-9.0 * 0.2, rel=1e-14)
    assert outputs[row("disk.acceleration")] == pytest.approx(0, abs=1e-15)
    assert outputs[row("far.acceleration")] == pytest.approx((9.0 * 0.2 - 1.0) / 3.0, rel=1e-14)
    # Both are held: each friction balances its own side of the shaft, and the rows do not mix.
    outputs = np.asarray(switched.output_function(0.0, x, with_modes(switched, p, "stick", "stick"))).ravel()
    assert outputs[[row("disk_brake.torque"), row("far_brake.torque")]] == pytest.approx([-1.8, 1.8], rel=1e-14)
    assert outputs[[row("disk.acceleration"), row("far.acceleration")]] == pytest.approx([0, 0], abs=1e-15)


def test_a_held_speed_is_seen_through_a_rigid_gear():
    # The brake sits on the far side of a gear: it holds the near side with i lambda, whatever the inertias are.
    ratio = 40 / 16
    gear = RigidGear("gear", "disk", "far", teeth_a=40, teeth_b=16)
    model = compiled(GroundSpring("wire", "disk", stiffness=5.0), gear, two_brakes()[1])
    switched = model.switched()
    extended = with_modes(switched, model.parameters.vector(), "stick")
    outputs = np.asarray(switched.output_function(0.0, [0.3, 0.0], extended)).ravel()
    assert outputs[model.output_index("far_brake.torque")] == pytest.approx(-5.0 * 0.3 / ratio, rel=1e-14)
    assert outputs[model.output_index("disk.acceleration")] == pytest.approx(0, abs=1e-15)


class Clutch(Element):
    """Two shafts that are held together while it is locked, with inertia that couples them."""

    a, b = Flange(), Flange()
    coupling = Param("kg*m^2", default=0.5)
    load = Param("N*m", default=1.0)
    lock = Modes("open", "locked")
    grip = Multiplier()

    def kinetic_energy(self):
        return self.coupling * self.a.speed * self.b.speed

    def torques(self):
        return {self.a: self.load - self.grip, self.b: self.grip}

    def regions(self):
        return {self.lock.locked: self.b.speed - self.a.speed}

    def holds(self):
        return {self.lock.locked: (self.a.speed - self.b.speed, self.grip)}

    def guards(self):
        meet = Guard("meet", self.a.speed - self.b.speed, 0, "open", "locked", reset={self.a.speed - self.b.speed: 0})
        return [meet, Guard("slip", self.grip - 10 * self.load, 1, "locked", "open")]


def test_a_relative_speed_is_held_over_a_full_mass_matrix():
    # M = [[2, c], [c, 3]], f = (T - lambda, lambda), equal accelerations: lambda = T (3 - c)/(2 + 3 - 2c + ...) by elimination.
    model = compiled(Clutch("clutch", "disk", "far"))
    mass = np.array([[2.0, 0.5], [0.5, 3.0]])
    g = np.array([1.0, -1.0])
    inverse = np.linalg.inv(mass)
    grip = (g @ inverse @ [1.0, 0.0]) / (g @ inverse @ g)
    expected = inverse @ (np.array([1.0, 0.0]) - g * grip)
    assert expected[0] == pytest.approx(1.0 / mass.sum(), rel=1e-14)  # both turn as one body
    switched = model.switched()
    outputs = np.asarray(
        switched.output_function(0.0, [0.1, 0.2, 0.3, 0.4], with_modes(switched, model.parameters.vector(), "locked"))
    ).ravel()
    assert outputs[[model.output_index(f"{disk}.acceleration") for disk in ("disk", "far")]] == pytest.approx(expected, rel=1e-13)


def test_an_impulse_keeps_momentum_over_a_full_mass_matrix():
    model = compiled(Clutch("clutch", "disk", "far"))
    switched, p = model.switched(), model.parameters.vector()
    x = np.array([0.1, 0.2, 0.3, 0.7])
    after = np.asarray(switched.switching.resets(0.0, x, with_modes(switched, p, "open")))[:, 0]
    speeds = [np.asarray(model.mean_model.angles(each, p)[1]).ravel() for each in (x, after)]
    mass = np.array([[2.0, 0.5], [0.5, 3.0]])
    assert speeds[1][0] == pytest.approx(speeds[1][1], abs=1e-15)
    assert (mass @ speeds[1]).sum() == pytest.approx((mass @ speeds[0]).sum(), rel=1e-14)
    assert after[:2].tolist() == x[:2].tolist()


class Warm(Element):
    """An own state that is set by an event, and one that is held."""

    flange = Flange()
    heat, level = State("J", start=2.0), State("J")
    phase = Modes("rising", "held")
    feed = Multiplier("W")

    def torques(self):
        return {}

    def rates(self):
        return {self.heat: 3 * self.phase.rising * self.feed_unit() + self.feed, self.level: self.feed_unit()}

    def feed_unit(self):
        return self.flange.inertia * self.flange.speed**2 * sympy.Abs(self.flange.speed)

    def holds(self):
        return {self.phase.held: (self.heat - self.level, self.feed)}

    def guards(self):
        yield Guard(
            "full", self.heat - 2 * self.level, -1, "rising", "held", reset={self.heat: self.level, self.level: self.heat}
        )


def test_own_states_are_held_and_set_from_their_values_before():
    model = compiled(Shaft("shaft", "disk", "far", stiffness=1.0), Warm("warm", "disk"))
    switched, p = model.switched(), model.parameters.vector()
    x = np.array([0.0, 0.0, 0.5, 0.0, 7.0, 4.0])
    assert model.states[4:] == ("warm.heat", "warm.level")
    flow = 2.0 * 0.5**3
    rising, held = (switched.rhs_function(0.0, x, with_modes(switched, p, each)) for each in ("rising", "held"))
    assert np.asarray(rising).ravel()[4:] == pytest.approx([3 * flow, flow])
    assert np.asarray(held).ravel()[4:] == pytest.approx([flow, flow])
    after = np.asarray(switched.switching.resets(0.0, x, with_modes(switched, p, "rising"))).ravel()
    assert after.tolist() == [0.0, 0.0, 0.5, 0.0, 4.0, 7.0]


def test_speeds_that_are_held_twice_are_refused():
    third = Brake("third", "far", sliding_torque=1.0, holding_torque=2.0)
    model = compiled(Shaft("shaft", "disk", "far", stiffness=9.0), *two_brakes(), third)
    with pytest.raises(ModelError, match="speeds held by disk_brake, far_brake, third depend on each other"):
        _ = model.switching


def test_a_multiplier_that_no_linear_equation_gives_is_refused():
    class Odd(Clutch):
        def torques(self):
            return {self.a: self.grip**2 / self.load, self.b: self.grip}

    with pytest.raises(LoweringError, match="the multipliers of odd do not follow; let torques and rates be linear in them"):
        compiled(Odd("odd", "disk", "far"))
