"""The compiled driveline: its numbers against SymPy's own, its strictness, its parameters by name, and its fingerprint."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
import sympy

from modelgen.drivelines import load
from modelgen.elements import GearPair, GroundDamper, GroundSpring, HarmonicTorque, Inertia, RigidGear, Shaft, SteppedTorque
from modelgen.equations import assemble
from modelgen.equations.template import build_template
from modelgen.errors import CaseError, ModelError, NamingError, UnitError
from modelgen.lowering import lower
from modelgen.model import Driveline, Element, Flange, NamedParameter, Param, State

SPEED = 12.0
ROWS = NamedParameter((3.0, -1.0, 0.5), "N*m")


def geared(**more):
    """Two disks and a third one behind a mesh, with everything that a law can depend on."""
    elements = [
        Inertia("engine", inertia=2.0),
        Inertia("pinion", inertia=0.2),
        Inertia("wheel", inertia="heavy"),
        Shaft("shaft", "engine", "pinion", stiffness=900.0, damping_ratio="zeta"),
        GearPair(
            "mesh", "pinion", "wheel", teeth_a=20, teeth_b=50, module=0.01, mean_stiffness=5e5, stiffness_cosine=(5e4, 2e4),
            stiffness_sine=(-3e4, 1e4), damping_ratio=0.08, error_amplitude=2e-4, error_phase=0.7, half_backlash=5e-5,
            viscous="contact_only",
        ),
        HarmonicTorque("firing", "engine", mean=5, sine="rows", cosine=(1.0, 2.0, 3), orders=(1, 2, 5), phase=0.3, base="cycle"),
        GroundDamper("drag", "wheel", damping=0.3),
        SteppedTorque("load", "wheel", shape="ramp", after=-6.0, at=0.1, duration=0.5),
    ]  # fmt: skip
    given = {
        "speed": SPEED,
        "reference": "engine",
        "bases": {"cycle": ("engine", "1/2")},
        "parameters": {"zeta": 0.05, "rows": ROWS, "light": "1.5 kg*m^2", "heavy": NamedParameter(expression="2*light")},
    }
    return Driveline("geared", elements, **{**given, **more})


@pytest.fixture(scope="module")
def model():
    return lower(assemble(geared()))


@pytest.fixture
def p(model):
    return model.parameters.vector()


def states(model, count, seed=3):
    rng = np.random.default_rng(seed)
    return [(rng.uniform(0, 3), rng.uniform(-0.02, 0.02, len(model.states))) for _ in range(count)]


# -- numbers -------------------------------------------------------------------------------------------------------------------


def by_sympy(element, values, angles, speeds, seen, clock, t):
    """Torques of one element on its targets, from its law as written, at 30 digits."""
    law, known = build_template(element).law, {sympy.Symbol("t", real=True): t}
    for key, param in element.declared(Param).items():
        if key in element.values:
            value = values.get(getattr(element.values[key], "name", None), element.values[key])
            rows = value if param.series else (value,)
            known.update(zip(param.symbols(len(rows) if param.series else None), map(sympy.Float, rows), strict=True))
    for flange, target in element.targets.items():
        symbols = getattr(element, flange)
        known.update({symbols.angle: angles[target], symbols.speed: speeds[target], symbols.inertia: seen[target]})
    for name in ("base", "contact"):
        if hasattr(element, name):
            known.update({getattr(element, name).angle: clock * t, getattr(element, name).frequency: clock})
    found = {}
    for flange, torque in law["torques"].items():
        for name, definition in reversed(law["definitions"].items()):
            torque = torque.xreplace({sympy.Symbol(name, real=True): definition})
        found[element.targets[flange]] = torque.xreplace({key: sympy.Float(value, 30) for key, value in known.items()}).evalf(30)
    return found


def test_accelerations_agree_with_the_laws_as_written(model, p):
    line = geared()
    line = replace(line, elements=[assembled_series(e) for e in line.elements])
    seen = {"engine": 2.0, "pinion": 0.2, "wheel": 3.0}
    values = {"zeta": 0.05, "rows": ROWS.value, "heavy": 3.0}
    for t, x in states(model, 10):
        now = model.evaluate(t, x, p)
        speeds = {name: now[f"{name}.speed"] for name in seen}
        # Angles from the states themselves: an absolute angle of many radians has lost the digits of a twist.
        twist, approach = x[1], x[2]
        radius = 0.1 * np.cos(np.radians(20))
        angles = {"engine": sympy.Float(0), "pinion": -sympy.Float(twist, 30)}
        angles["wheel"] = (radius * angles["pinion"] - approach) / (2.5 * radius)
        total, size = dict.fromkeys(seen, 0), dict.fromkeys(seen, 0)
        for element in line.elements[3:]:
            clock = {"mesh": 20 * SPEED, "firing": SPEED / 2}.get(element.name, 0)
            for target, torque in by_sympy(element, values, angles, speeds, seen, clock, t).items():
                total[target] += torque
                size[target] += abs(torque)
        for name in seen:
            assert now[f"{name}.acceleration"] == pytest.approx(
                float(total[name] / seen[name]), abs=1e-13 * float(size[name] / seen[name])
            )


def assembled_series(element):
    """The element with the series it shares written in, as the assembly does it."""
    return element.copy(sine=ROWS.value) if element.name == "firing" else element


def test_jacobian_agrees_with_differences(model, p):
    for t, x in states(model, 5):
        exact, h = model.jacobian(t, x, p), 1e-7
        columns = [(model.rhs(t, x + h * e, p) - model.rhs(t, x - h * e, p)) / (2 * h) for e in np.eye(len(x))]
        assert exact == pytest.approx(np.array(columns).T, abs=1e-6 * np.abs(exact).max())


def test_a_model_with_coupled_and_geared_inertia_solves_its_mass_matrix():
    class Differential(Element):
        """Two flanges that a planet couples: T = J (speed a + speed b)^2 / 2."""

        a, b = Flange(), Flange()
        planet = Param("kg*m^2", positive=True)

        def kinetic_energy(self):
            return self.planet * (self.a.speed + self.b.speed) ** 2 / 2

    del Element.vocabulary["differential"]
    line = Driveline(
        "coupled",
        [
            Inertia("left", inertia=1.0),
            Inertia("right", inertia=2.0),
            Inertia("far", inertia=0.5),
            Differential("planets", "left", "right", planet=0.7),
            RigidGear("gear", "right", "far", teeth_a=30, teeth_b=20),
            SteppedTorque("push", "left", before=3.0, after=3.0),
        ],
    )
    model = lower(assemble(line))
    now = model.evaluate(0.0, np.zeros(len(model.states)), model.parameters.vector())
    mass = np.array([[1.7, 0.7], [0.7, 2.7 + 1.5**2 * 0.5]])
    assert [now["left.acceleration"], now["right.acceleration"]] == pytest.approx(np.linalg.solve(mass, [3, 0]), rel=1e-14)


class ViscousCoupling(Element):
    """Two shafts that see each other's speed only."""

    a, b = Flange(), Flange()
    drag = Param("N*m*s/rad", positive=True)

    def torques(self):
        torque = self.drag * (self.a.speed - self.b.speed)
        return {self.a: -torque, self.b: torque}


class MaxwellShaft(Element):
    """A spring and a damper in series: the torque is a state of the element."""

    a, b = Flange(), Flange()
    stiffness = Param("N*m/rad", positive=True)
    viscosity = Param("N*m*s/rad", positive=True)
    torque = State("N*m", start=0.5)

    def rates(self):
        return {self.torque: self.stiffness * (self.a.speed - self.b.speed - self.torque / self.viscosity)}

    def torques(self):
        return {self.a: -self.torque, self.b: self.torque}


for _cls in (ViscousCoupling, MaxwellShaft):  # for these tests only
    del Element.vocabulary[_cls.kind]


def pair(*more, **given):
    return lower(assemble(Driveline("pair", [Inertia("left", inertia=2.0), Inertia("right", inertia=4.0), *more], **given)))


def test_shafts_that_see_only_speeds_turn_freely():
    model = pair(ViscousCoupling("coupling", "left", "right", drag=3.0), speed=10.0, reference="right")
    assert model.states == (
        "right.angle_deviation",
        "left.angle_deviation",
        "right.angle_deviation_rate",
        "left.angle_deviation_rate",
    )
    assert model.equations.rigid == (0, 1)
    p = model.parameters.vector()
    assert model.rhs(0.0, [5.0, -7.0, 0.0, 1.0], p).tolist() == [0.0, 1.0, 0.75, -1.5]
    assert model.evaluate(0.0, [0.0] * 4, p)["left.speed"] == 10.0


def test_an_element_may_own_a_state():
    model = pair(MaxwellShaft("shaft", "left", "right", stiffness=8.0, viscosity=2.0))
    assert model.states[-1] == "shaft.torque"
    assert model.equations.states[-1].start == 0.5
    p, names = model.parameters.vector(), list(model.states)
    x = np.zeros(5)
    x[names.index("left.angle_deviation_rate")], x[names.index("shaft.torque")] = 0.3, 4.0
    now = dict(zip(names, model.rhs(0.0, x, p), strict=True))
    assert now["shaft.torque"] == pytest.approx(8 * (0.3 - 4 / 2))
    assert (now["left.angle_deviation_rate"], now["right.angle_deviation_rate"]) == pytest.approx((-2.0, 1.0))


def test_elastic_angle_leaves_out_the_turning_of_the_whole_line(model, p):
    # theta_i - r_i sum(J r theta) / sum(J r^2), with r the speed per speed of the reference shaft.
    (_, x), ratio, inertia = states(model, 1)[0], np.array([1, 1, 0.4]), np.array([2.0, 0.2, 3.0])
    now = model.evaluate(0.0, x, p)
    angle = np.array([now[f"{name}.angle_deviation"] for name in ("engine", "pinion", "wheel")])
    expected = angle - ratio * (inertia * ratio @ angle) / (inertia * ratio @ ratio)
    assert [now[f"{name}.elastic_angle"] for name in ("engine", "pinion", "wheel")] == pytest.approx(expected, abs=1e-17)
    mounted = pair(Shaft("s", "left", "right", stiffness=1.0), GroundSpring("mount", "left", stiffness=1.0))
    still = mounted.evaluate(0.0, [0.3, 0.1, 0, 0], mounted.parameters.vector())
    assert still["right.elastic_angle"] == still["right.angle_deviation"]


@pytest.mark.parametrize(("reference", "speeds"), [("engine", (12.0, 12.0, 4.8)), ("wheel", (30.0, 30.0, 12.0))])
def test_frequencies_follow_from_speed_ratio_and_order(reference, speeds):
    line = geared(reference=reference, bases={"cycle": ("wheel", "3/2"), "own": 5})
    model = lower(assemble(line))
    names = [clock.name for clock in model.equations.clocks]
    p = model.parameters.vector()
    found = dict(zip(names, model.mean_model.frequencies(p).full().ravel(), strict=True))
    assert found == pytest.approx({"cycle": 1.5 * speeds[2], "own": 5 * SPEED, "mesh.contact": 20 * speeds[1]}, rel=1e-14)
    faster = model.mean_model.frequencies(model.parameters.vector({"speed": 2 * SPEED, "mesh.teeth_b": 25})).full().ravel()
    scale = {"engine": (4, 2), "wheel": (2, 1)}[reference]  # of the wheel's speed and the pinion's
    assert faster == pytest.approx([scale[0] * found["cycle"], 2 * found["own"], scale[1] * found["mesh.contact"]], rel=1e-14)


# -- calls ---------------------------------------------------------------------------------------------------------------------


def test_fast_rhs_is_the_same_function_in_one_buffer(model, p):
    fast = model.fast_rhs(p)
    results = [(fast(t, x).copy(), model.rhs(t, x, p)) for t, x in states(model, 5)]
    assert all(np.array_equal(quick, strict) for quick, strict in results)
    assert fast(0.0, np.zeros(len(model.states))) is fast(1.0, np.ones(len(model.states)))


def test_fast_rhs_keeps_its_parameters_and_its_state_to_itself(model, p):
    fast = model.fast_rhs(p)
    (t, x), given = states(model, 1)[0], p.copy()
    before, kept = fast(t, x).copy(), x.copy()
    p[:] = 0
    assert np.array_equal(fast(t, x), before)
    assert np.array_equal(x, kept)
    assert np.array_equal(model.fast_rhs(given)(t, list(x)), before)


@pytest.mark.parametrize("call", ["rhs", "jacobian", "evaluate"])
@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"x": np.zeros(5)}, r"x: has the shape \(5,\); give a vector of 6"),
        ({"x": np.zeros((6, 1))}, r"x: has the shape \(6, 1\); give a vector of 6"),
        ({"x": 0.0}, r"x: has the shape \(\); give a vector of 6"),
        ({"x": [0, 0, 0, np.nan, 0, 0]}, "x: is not finite; give finite numbers"),
        ({"x": ["a"] * 6}, "x: does not hold plain numbers; give a vector of 6"),
        ({"x": [[1], [2, 3]]}, "x: does not hold plain numbers; give a vector of 6"),
        ({"t": np.inf}, "t: is not finite; give finite numbers"),
        ({"t": [0.0]}, r"t: has the shape \(1,\); give a scalar"),
        ({"t": None}, "t: is not finite|t: does not hold plain numbers"),
        ({"p": []}, r"p: has the shape \(0,\); give a vector of \d+"),
    ],
)
def test_calls_are_strict(model, p, call, change, words):
    arguments = {"t": 0.0, "x": np.zeros(6), "p": p, **change}
    with pytest.raises(CaseError, match=f"^driveline 'geared', {words}"):
        getattr(model, call)(**arguments)


def test_channels_over_a_trajectory(model, p):
    many = states(model, 7)
    times, rows = np.array([t for t, _ in many]), np.array([x for _, x in many])
    everything = model.channels(times, rows, p)
    assert tuple(everything) == model.outputs
    assert all(everything["mesh.force"][k] == model.evaluate(*many[k], p)["mesh.force"] for k in range(7))
    some = model.channels(times, rows, p, ["wheel.speed", "shaft.twist"])
    assert list(some) == ["wheel.speed", "shaft.twist"]
    assert np.array_equal(some["shaft.twist"], rows[:, 1])
    assert model.channels(times, rows, p, []) == {}
    assert model.channels([], np.zeros((0, 6)), p, ["wheel.speed"])["wheel.speed"].shape == (0,)


@pytest.mark.parametrize(
    ("times", "rows", "values", "words"),
    [
        ([0.0, 1.0], np.zeros((6, 2)), None, r"states: has the shape \(6, 2\); give 2 rows of 6 states"),
        ([[0.0, 1.0]], np.zeros((2, 6)), None, r"times: has the shape \(1, 2\); give one row of times"),
        ([0.0], [[np.nan] * 6], None, "states: is not finite; give finite numbers"),
        ([0.0], np.zeros((1, 6)), [1.0], r"p: has the shape \(1,\); give a vector of \d+"),
    ],
)
def test_channels_are_strict(model, p, times, rows, values, words):
    with pytest.raises(CaseError, match=f"^driveline 'geared', {words}"):
        model.channels(times, rows, p if values is None else values)


def test_names_are_looked_up_with_the_nearest_in_mind(model):
    assert model.units[model.output_index("mesh.force")] == model.unit("mesh.force") == "N"
    assert model.states[model.state_index("mesh.approach")] == "mesh.approach"
    with pytest.raises(CaseError, match=r"^driveline 'geared': no output 'mesh.forse'; nearest is 'mesh.force'"):
        model.unit("mesh.forse")
    with pytest.raises(CaseError, match=r"^driveline 'geared': no state 'shaft.twists'; nearest is 'shaft.twist'"):
        model.state_index("shaft.twists")


def test_expressions_are_handed_out_for_other_tools(model, p):
    e = model.expressions
    function = ca.Function("mine", [e["t"], e["x"], e["p"]], [e["ode"], e["outputs"]])
    (t, x), rows = states(model, 1)[0], len(model.outputs)
    assert np.array_equal(np.asarray(function(t, x, p)[0]).ravel(), model.rhs(t, x, p))
    assert function(t, x, p)[1].shape == (rows, 1)


# -- parameters ----------------------------------------------------------------------------------------------------------------


def value(model, name, **values):
    return model.parameters.value(model.parameters.vector(values), name)


def test_parameters_are_set_by_name(model):
    table = model.parameters
    assert value(model, "shaft.stiffness", **{"shaft.stiffness": 7.0}) == 7.0
    assert value(model, "shaft.stiffness", **{"shaft.stiffness": "7 kN*m/rad"}) == 7000.0
    assert value(model, "speed", speed="60 rpm") == pytest.approx(2 * np.pi)
    assert table.vector()[table.slices["rows"]].tolist() == [3.0, -1.0, 0.5]
    assert table.vector({"rows": [1, 2, 3]})[table.slices["rows"]].tolist() == [1.0, 2.0, 3.0]
    assert table.vector({"rows[2]": "1 kN*m"})[table.slices["rows"]].tolist() == [3.0, 1000.0, 0.5]
    assert table.vector({"firing.cosine[3]": 9})[table.slices["firing.cosine"]].tolist() == [1.0, 2.0, 9.0]
    labels = table.labels()
    assert len(labels) == len(set(labels)) == table.size
    assert {"zeta", "rows[3]", "mesh.teeth_a", "firing.cosine[1]"} <= set(labels)
    assert "heavy" in table.names


def test_expressions_follow_what_they_depend_on(model):
    assert value(model, "heavy") == 3.0
    assert value(model, "heavy", light=4.0) == 8.0
    assert value(model, "heavy", light=4.0, heavy=1.0) == 1.0


def test_derived_parameters_follow_the_teeth():
    gear = GearPair("mesh", "a", "b", teeth_a=26, teeth_b=46, module=0.007, mesh="geometry", face_width=0.11)
    model = lower(
        assemble(Driveline("pair", [Inertia("a", inertia=1.0), Inertia("b", inertia=1.0), gear], speed=1.0, reference="a"))
    )
    wide = value(model, "mesh.geometry_rows", **{"mesh.face_width": 0.22})
    assert wide == pytest.approx(2 * value(model, "mesh.geometry_rows"), rel=1e-12)
    with pytest.raises(
        NamingError,
        match=r"^parameter 'mesh.geometry_rows': is derived from others; set mesh.teeth_a or mesh.teeth_b or mesh.module or",
    ):
        model.parameters.vector({"mesh.geometry_rows": 1.0})
    with pytest.raises(ModelError, match="gear"):
        model.parameters.vector({"mesh.profile_shift_a": 50.0})


@pytest.mark.parametrize(
    ("values", "kind", "words"),
    [
        ({"zetta": 1.0}, NamingError, "parameter 'zetta': is not known; nearest is 'zeta'"),
        ({"shaft.stifness": 1.0}, NamingError, "parameter 'shaft.stifness': is not known; nearest is 'shaft.stiffness'"),
        ({"rows[4]": 1.0}, NamingError, r"parameter 'rows\[4\]': has no such row; it has 3; rows count from 1"),
        ({"rows[0]": 1.0}, NamingError, r"parameter 'rows\[0\]': has no such row; it has 3; rows count from 1"),
        ({"zeta[1]": 1.0}, NamingError, r"parameter 'zeta\[1\]': has no such row"),
        ({"rows": [1.0, 2.0]}, CaseError, "parameter 'rows': got 2 values; it has 3"),
        ({"rows": 1.0}, CaseError, "parameter 'rows': got 1 values; it has 3"),
        ({"zeta": [0.1, 0.2]}, CaseError, "parameter 'zeta': got 2 values; it has 1"),
        ({"zeta": np.nan}, CaseError, "parameter 'zeta': nan is not finite; give finite numbers"),
        ({"zeta": None}, CaseError, "parameter 'zeta': None is not finite; give finite numbers"),
        ({"zeta": {}}, CaseError, "parameter 'zeta': {} is not a number; give a number"),
        (
            {"shaft.stiffness": 10**400},
            CaseError,
            "parameter 'shaft.stiffness': 1000.* is not a number; give a number in N.m/rad",
        ),
        ({"shaft.stiffness": "5"}, UnitError, "parameter 'shaft.stiffness': 5.0 has no unit"),
        ({"shaft.stiffness": "5 kg"}, UnitError, "parameter 'shaft.stiffness': 'kg' has the dimension"),
        ({"shaft.stiffness": 0.0}, ModelError, "parameter 'shaft.stiffness': is 0.0 N.m/rad; give a positive value"),
        # limits of those that share a parameter, of its rows, and of what follows from it
        ({"zeta": -0.1}, ModelError, "parameter 'zeta': is -0.1; give zero or a positive value"),
        ({"light": -1.0}, ModelError, r"parameter 'heavy': is -2.0 kg\*m\^2; give a positive value"),
        ({"mesh.teeth_a": 20.5}, ModelError, "parameter 'mesh.teeth_a': is 20.5; give a whole number"),
        ({"speed": "-1 rpm"}, ModelError, "parameter 'speed': is -0.10471975511965977 rad/s; give a positive value"),
    ],
)
def test_unlawful_values(model, values, kind, words):
    with pytest.raises(kind, match=f"^{words}"):
        model.parameters.vector(values)


def test_an_expression_that_has_no_value_is_refused_when_it_gets_none():
    parameters = {"x": 2.0, "unit": "1 kg*m^2", "root": NamedParameter(expression="sqrt(x - 1)*unit")}
    model = lower(assemble(Driveline("one", [Inertia("disk", inertia="root")], parameters=parameters)))
    assert value(model, "root", x=5.0) == 2.0
    with pytest.raises(CaseError, match=r"^parameter 'root': nan is not finite"):
        model.parameters.vector({"x": 0.0})
    with pytest.raises(NamingError, match=r"^parameter 'rot': is not known; nearest is 'root'"):
        value(model, "rot")


# -- identity and speed --------------------------------------------------------------------------------------------------------


def test_the_fingerprint_is_of_what_is_computed_not_of_values(model):
    other = geared(
        parameters={"zeta": 0.2, "rows": ROWS, "light": "9 kg*m^2", "heavy": NamedParameter(expression="2*light")}, speed=99.0
    )
    assert lower(assemble(other)).fingerprint == model.fingerprint
    assert len(model.fingerprint) == 64
    assert lower(assemble(other.change("mesh", viscous="always"))).fingerprint != model.fingerprint
    assert lower(assemble(other.change("firing", orders=(1, 2, 6)))).fingerprint != model.fingerprint
    assert lower(assemble(other.add(GroundSpring("mount", "wheel", stiffness=1.0)))).fingerprint != model.fingerprint
    renamed = replace(other, elements=[*other.elements[:-1], other.elements[-1].copy("step")])
    assert lower(assemble(renamed)).fingerprint != model.fingerprint


def test_the_fingerprint_is_the_same_in_every_process():
    script = (
        "from modelgen.drivelines import load; from modelgen.equations import assemble; from modelgen.lowering import lower;"
        "print(lower(assemble(load('fracturing-truck'))).fingerprint)"
    )
    found = {lower(assemble(load("fracturing-truck"))).fingerprint}
    for seed in ("1", "2"):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        done = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, env=environment, timeout=60, check=True
        )
        found.add(done.stdout.strip())
    assert len(found) == 1


def test_two_hundred_inertias_within_three_seconds():
    disks = [Inertia(f"disk_{n}", inertia=1.0 + 0.01 * n) for n in range(200)]
    shafts = [Shaft(f"shaft_{n}", f"disk_{n}", f"disk_{n + 1}", stiffness=100.0 + n, damping_ratio=0.02) for n in range(199)]
    loads = [HarmonicTorque(f"load_{n}", f"disk_{n}", sine=(1.0, 0.5, 0.2), base="cycle") for n in range(0, 200, 10)]
    start = time.process_time()
    line = Driveline("row_of_disks", [*disks, *shafts, *loads], speed=10.0, reference="disk_0", bases={"cycle": 1})
    model = lower(assemble(line))
    rates = model.rhs(0.1, np.full(400, 1e-3), model.parameters.vector())
    assert time.process_time() - start < 3
    assert np.all(np.isfinite(rates))


def test_what_is_printed(model):
    assert str(model).startswith("compiled 'geared': 6 states, ")
    assert model.name == "geared"


def test_a_torque_without_waves_needs_no_operating_speed() -> None:
    def line(cosine: float) -> Driveline:
        torque = HarmonicTorque("load", "disk", mean=-2.0, cosine=[cosine], orders=[6])
        return Driveline("still", elements=[Inertia("disk", inertia=1.0), torque], drifts=True)

    model = lower(assemble(line(0.0)))
    rates = model.rhs(1.7, np.zeros(2), model.parameters.vector({}))
    assert np.asarray(rates).ravel().tolist() == [0.0, -2.0]
    with pytest.raises(ModelError, match="base is missing; name a base frequency of the driveline"):
        assemble(line(3.0))
