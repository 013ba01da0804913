"""The assembly against Lagrange: small drivelines derived again from energies alone, by SymPy's LagrangesMethod.

The elements' torques are not used, but for the applied ones: T - V and Rayleigh's function R = P/2 of the dissipated power P give
d/dt dL/dq' - dL/dq + dR/dq' = Q + lambda dg/dq, with a Lagrange multiplier for every rigid gear.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
import sympy
from sympy.physics.mechanics import LagrangesMethod, ReferenceFrame, dynamicsymbols

from modelgen.elements import (
    GearPair,
    GroundDamper,
    GroundSpring,
    HarmonicTorque,
    Inertia,
    RigidGear,
    Shaft,
    SteppedTorque,
)
from modelgen.equations import assemble
from modelgen.equations.template import build_template
from modelgen.lowering import lower
from modelgen.model import Driveline, Element, Flange, Param, quantity

OMEGA = 12.0  # rad/s of the reference shaft


class SliderCrank(Element):
    """A mass on a connecting rod: its inertia about the crank depends on the crank angle, T = m (lever * speed)^2 / 2."""

    flange = Flange()
    mass = Param("kg", positive=True)
    radius = Param("m", positive=True)
    rod = Param("m", positive=True)

    @quantity("m")
    def lever(self):
        """Travel of the mass per crank angle."""
        angle, r = self.flange.angle, self.radius
        sine, cosine = sympy.sin(angle), sympy.cos(angle)
        return -r * sine - r**2 * sine * cosine / sympy.sqrt(self.rod**2 - (r * sine) ** 2)

    def kinetic_energy(self):
        return self.mass * (self.lever * self.flange.speed) ** 2 / 2


class DraggedPendulum(Element):
    """Two masses on arms of a hinged pair: the inertia couples both flanges and depends on the angle between them."""

    a, b = Flange(), Flange()
    mass = Param("kg", positive=True)
    arm = Param("m", positive=True)

    def kinetic_energy(self):
        turn = sympy.cos(self.a.angle - self.b.angle)
        return self.mass * self.arm**2 * (self.a.speed**2 + self.b.speed**2 + self.a.speed * self.b.speed * turn) / 2


for _cls in (SliderCrank, DraggedPendulum):  # for these tests only
    del Element.vocabulary[_cls.kind]


@dataclass(frozen=True)
class Case:
    """A driveline whose elements are all joined to inertias; what the laws ask for besides is given here by hand."""

    elements: list[Element]
    seen: dict[str, float] = field(default_factory=dict)  # inertia rigidly on each inertia's node
    frequencies: dict[str, float] = field(default_factory=dict)  # of each element's clock [rad/s]


CHAIN = Case(
    [
        Inertia("engine", inertia=2.0),
        Inertia("flywheel", inertia=5.0),
        Inertia("load", inertia=3.0),
        Shaft("crank", "engine", "flywheel", stiffness=900.0, damping_ratio=0.05),
        Shaft("coupling", "flywheel", "load", stiffness=400.0, damping="loss_factor", loss_factor=0.1, reference_frequency=20.0),
        HarmonicTorque("firing", "engine", mean=50.0, sine=(20.0, 7.0), cosine=(5.0, -3.0), phase=0.4, scale=1.2, base="cycle"),
        SteppedTorque("step", "load", shape="ramp", after=-60.0, at=0.1, duration=2.0),
    ],
    seen={"engine": 2.0, "flywheel": 5.0},
    frequencies={"firing": OMEGA / 2},
)
TOOTH = {"teeth_a": 20, "teeth_b": 50, "module": 0.01, "pressure_angle": 0.35}
GEARED = Case(
    [
        Inertia("pinion", inertia=0.2),
        Inertia("wheel", inertia=3.0),
        GearPair(
            "mesh", "pinion", "wheel", **TOOTH, mean_stiffness=5e5, stiffness_cosine=(5e4, 2e4), stiffness_sine=(-3e4, 1e4),
            damping_ratio=0.08, error_mean=1e-4, error_amplitude=2e-4, error_phase=0.7, half_backlash=5e-5,
        ),
        HarmonicTorque("load", "wheel", mean=-30.0),
    ],
    seen={"pinion": 0.2, "wheel": 3.0},
    frequencies={"mesh": 20 * OMEGA},
)  # fmt: skip
BRANCHED = Case(
    [
        Inertia("engine", inertia=2.0),
        Inertia("splitter", inertia=0.5),
        Inertia("left", inertia=0.9),
        Inertia("right", inertia=0.7),
        Inertia("pump", inertia=1.5),
        Shaft("input", "engine", "splitter", stiffness=700.0, damping="value", damping_coefficient=3.0),
        GearPair("left_mesh", "splitter", "left", **TOOTH, mesh="table", stiffness_table=(4e5, 5e5, 7e5), damping="value",
                 damping_coefficient=40.0, error_amplitude=1e-4),
        GearPair("right_mesh", "splitter", "right", teeth_a=20, teeth_b=30, radii="given", base_radius_a=0.1, mesh="rectangular",
                 stiffness_high=6e5, stiffness_low=4e5, contact_ratio=1.6, damping="literal", damping_ratio=0.1),
        Shaft("output", "left", "pump", stiffness=300.0),
    ],
    seen={"splitter": 0.5, "right": 0.7, "left": 0.9, "pump": 1.5},
    frequencies={"left_mesh": 20 * OMEGA, "right_mesh": 20 * OMEGA},
)  # fmt: skip
RIGID = Case(
    [
        Inertia("engine", inertia=2.0),
        Inertia("first", inertia=0.3),
        Inertia("second", inertia=0.8),
        Inertia("third", inertia=0.6),
        Inertia("load", inertia=4.0),
        Shaft("input", "engine", "first", stiffness=500.0, damping_ratio=0.04),
        RigidGear("pair", "first", "second", teeth_a=17, teeth_b=43),
        RigidGear("ring", "second", "third", teeth_a=19, teeth_b=71, mesh="internal"),
        Shaft("output", "third", "load", stiffness=200.0, damping_ratio=0.06),
        GroundDamper("drag", "load", damping=1.3),
        SteppedTorque("push", "engine", before=3.0, after=25.0),
    ],
    seen={
        "engine": 2.0,
        "first": 0.3 + (17 / 43) ** 2 * (0.8 + (19 / 71) ** 2 * 0.6),
        "third": 0.6 + (71 / 19) ** 2 * (0.8 + (43 / 17) ** 2 * 0.3),
        "load": 4.0,
    },
)
GROUNDED = Case(
    [
        Inertia("rotor", inertia=1.5),
        Inertia("stator", inertia=9.0),
        Shaft("shaft", "rotor", "stator", stiffness=350.0, damping_ratio=0.02),
        GroundSpring("mount", "stator", stiffness=2000.0, damping=11.0),
        HarmonicTorque("shaker", "rotor", cosine=(4.0,), orders=(3,), base="cycle"),
    ],
    seen={"rotor": 1.5, "stator": 9.0},
    frequencies={"shaker": OMEGA / 2},
)
CRANKED = Case(
    [
        Inertia("flywheel", inertia=0.4),
        Inertia("crank", inertia=0.1),
        Inertia("cam", inertia=0.02),
        Shaft("shaft", "flywheel", "crank", stiffness=120.0, damping="value", damping_coefficient=0.5),
        SliderCrank("piston", "crank", mass=2.0, radius=0.15, rod=0.4),
        RigidGear("timing", "crank", "cam", teeth_a=18, teeth_b=36),
        SliderCrank("plunger", "cam", mass=1.0, radius=0.1, rod=0.3),
    ],
)
HINGED = Case(
    [
        Inertia("hub", inertia=0.7),
        Inertia("hinge", inertia=0.2),
        Shaft("spring", "hub", "hinge", stiffness=15.0, damping="value", damping_coefficient=0.2),
        DraggedPendulum("arms", "hub", "hinge", mass=1.1, arm=0.5),
        SteppedTorque("push", "hub", before=3.0, after=3.0),
    ],
)
CASES = {
    "chain": CHAIN,
    "geared": GEARED,
    "branched": BRANCHED,
    "rigid gears": RIGID,
    "grounded": GROUNDED,
    "slider crank": CRANKED,
    "coupled inertia": HINGED,
}


def lagrange(case, t, angles, speeds):
    """Accelerations of the inertias and the multipliers of the rigid gears, at one instant."""
    time = dynamicsymbols._t
    q = {e.name: dynamicsymbols(e.name) for e in case.elements if isinstance(e, Inertia)}
    rate = {name: angle.diff(time) for name, angle in q.items()}
    ground = ReferenceFrame("ground")
    frames = {name: ReferenceFrame(name) for name in q}
    for name, frame in frames.items():
        frame.set_ang_vel(ground, rate[name] * ground.z)
    kinetic = potential = dissipated = sympy.Integer(0)
    loads, constraints = [], []
    for element in case.elements:
        law = build_template(element).law
        known = {
            symbol: value
            for key, param in element.declared(Param).items()
            if key in element.values
            for symbol, value in values(element, key)
        }
        for flange, target in ((f, element.targets.get(f, element.name)) for f in element.declared(Flange)):
            symbols = getattr(element, flange)
            known.update(
                {symbols.angle: q[target], symbols.speed: rate[target], symbols.inertia: case.seen.get(target, sympy.nan)}
            )
        frequency = case.frequencies.get(element.name, 0)
        for clock in ("base", "contact"):
            if hasattr(element, clock):
                known.update({getattr(element, clock).angle: frequency * time, getattr(element, clock).frequency: frequency})
        known[sympy.Symbol("t", real=True)] = time
        known[sympy.Symbol("1 m^2", positive=True)] = 1

        def plain(expression, law=law, known=known):
            for name, definition in reversed(law["definitions"].items()):
                expression = sympy.sympify(expression).subs(sympy.Symbol(name, real=True), definition)
            return expression.subs(known)

        if isinstance(element, HarmonicTorque | SteppedTorque):
            target = element.targets["flange"]
            loads.append((frames[target], plain(next(iter(law["torques"].values()))) * ground.z))
            continue
        if isinstance(element, Inertia):
            kinetic += element.values["inertia"] * rate[element.name] ** 2 / 2
        if law["kinetic_energy"] is not None:
            kinetic += plain(law["kinetic_energy"])
        potential += plain(law["stored_energy"])
        dissipated += plain(law["dissipated_power"])
        constraints += [plain(each) for each in element.constraints()]
    for name, frame in frames.items():
        loads.append((frame, -sympy.diff(dissipated / 2, rate[name]) * ground.z))
    method = LagrangesMethod(kinetic - potential, list(q.values()), loads, frame=ground, hol_coneqs=constraints)
    method.form_lagranges_equations()
    at = {rate[name]: speeds[name] for name in q} | {q[name]: angles[name] for name in q}
    matrix = np.array(method.mass_matrix_full.subs(at).subs(time, t).evalf(), dtype=float)
    forcing = np.array(method.forcing_full.subs(at).subs(time, t).doit().evalf(), dtype=float).ravel()
    solved = np.linalg.solve(matrix, forcing)[len(q) :]
    return dict(zip(q, solved, strict=False)), solved[len(q) :]


def values(element, key):
    param, value = element.declared(Param)[key], element.values[key]
    rows = value if param.series else (value,)
    return zip(param.symbols(len(rows) if param.series else None), rows, strict=True)


@pytest.mark.parametrize("name", CASES)
def test_assembly_agrees_with_lagrange(name):
    case = CASES[name]
    reference = next(e.name for e in case.elements if isinstance(e, Inertia))
    line = Driveline("small", case.elements, speed=OMEGA, reference=reference, bases={"cycle": (reference, "1/2")})
    model = lower(assemble(line))
    p = model.parameters.vector()
    rng = np.random.default_rng(11)
    for _ in range(3):
        t, x = rng.uniform(0, 2), rng.uniform(-0.3, 0.3, len(model.states))
        now = model.evaluate(t, x, p)
        inertias = [e.name for e in case.elements if isinstance(e, Inertia)]
        angles, speeds = ({each: now[f"{each}.{what}"] for each in inertias} for what in ("angle", "speed"))
        expected, multipliers = lagrange(case, t, angles, speeds)
        size = max(map(abs, expected.values()))
        for each, acceleration in expected.items():
            assert now[f"{each}.acceleration"] == pytest.approx(acceleration, rel=1e-10, abs=1e-11 * size), each
        gears = [e for e in case.elements if isinstance(e, RigidGear)]
        for gear, multiplier in zip(gears, multipliers, strict=True):
            # Of its constraint n_a angle_a - n_b angle_b = 0: lambda n_a is the torque on a, so -lambda n_a is what it passes on.
            assert now[f"{gear.name}.torque"] == pytest.approx(-multiplier * gear.values["teeth_a"], rel=1e-9)
