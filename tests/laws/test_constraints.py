"""Linear constraints over any number of flanges: kept exactly, whatever the start, the order of elements and the reference."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh, null_space

from laws.joints import SYSTEMS, Joint3, PlanetarySet, System
from modelgen import (
    Case,
    Driveline,
    Element,
    Flange,
    GroundSpring,
    HarmonicTorque,
    Inertia,
    Param,
    RigidGear,
    Shaft,
    assemble,
    lower,
    modal,
    quantity,
    simulate,
)
from modelgen.errors import ModelError

ORDERS = range(10)


def frequencies_by_hand(system: System) -> np.ndarray:
    """Natural frequencies [Hz] of the node matrices on the null space of the constraints."""
    mass, _, stiffness, joints, _ = system.matrices()
    free = null_space(joints)
    squares = eigh(free.T @ stiffness @ free, free.T @ mass @ free, eigvals_only=True)
    return np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)


@pytest.mark.parametrize("name", SYSTEMS)
def test_frequencies_are_those_of_the_matrices(name):
    wanted = frequencies_by_hand(SYSTEMS[name])
    for seed in ORDERS:
        found = modal(lower(assemble(SYSTEMS[name].driveline(seed)))).frequencies
        assert np.abs(found - wanted).max() < 1e-10 * wanted.max() + 2e-6 * (wanted[0] < 1e-3)


def with_multipliers(system: System, end: float, count: int) -> np.ndarray:
    """Speeds of the nodes over time, integrated in node angles with Lagrange multipliers."""
    mass, damping, stiffness, joints, force = system.matrices()
    n, m = len(mass), len(joints)
    whole = np.block([[mass, joints.T], [joints, np.zeros((m, m))]])

    def rate(t: float, x: np.ndarray) -> np.ndarray:
        torque = force - damping @ x[n:] - stiffness @ x[:n]
        return np.concatenate([x[n:], np.linalg.solve(whole, np.concatenate([torque, np.zeros(m)]))[:n]])

    times = np.linspace(0.0, end, count)
    return solve_ivp(rate, (0, end), np.zeros(2 * n), "DOP853", times, rtol=1e-12, atol=1e-13).y[n:].T


@pytest.mark.parametrize("orders", [range(1), pytest.param(range(1, 10), marks=pytest.mark.slow)], ids=["one", "nine"])
@pytest.mark.parametrize("name", SYSTEMS)
def test_transients_are_those_with_multipliers(name, orders):
    system = SYSTEMS[name]
    wanted = with_multipliers(system, 0.2, 21)
    size = np.abs(wanted).max()
    for seed in orders:
        case = Case(system.driveline(seed), end=0.2, start="zero", samples=21, solver="dop853", tolerance=1e-12)
        run = simulate(case)
        found = np.stack([run[f"{node}.speed"] for node in system.inertias], axis=1)
        assert np.abs(found - wanted).max() < 1e-8 * size


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_constraint_and_its_rate_vanish_over_a_run(name):
    system = SYSTEMS[name]
    rng = np.random.default_rng(3)
    for seed in range(3):
        model = lower(assemble(system.driveline(seed)))
        start = {state: float(value) for state, value in zip(model.states, rng.normal(size=len(model.states)), strict=True)}
        run = simulate(Case(model, end=0.1, start=start, samples=11))
        for row in system.rows:
            for channel in ("angle", "speed", "acceleration"):
                terms = np.array([c * run[f"{node}.{channel}"] for node, c in row.items()])
                assert np.abs(terms.sum(axis=0)).max() <= 1e-12 * np.abs(terms).max()


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_torques_of_the_constraints_close_the_balance_of_every_node(name):
    """M angle'' = torques of springs and loads + those of the constraints, and these do no work."""
    system = SYSTEMS[name]
    mass, damping, stiffness, _, force = system.matrices()
    run = simulate(Case(system.driveline(), end=0.05, start="zero", samples=6))
    nodes = list(system.inertias)
    angle, speed, second = (np.array([run[f"{node}.{part}"] for node in nodes]) for part in ("angle", "speed", "acceleration"))
    rest = mass @ second - force[:, None] + damping @ speed + stiffness @ angle
    work = np.zeros(rest.shape[1])
    for joint in system.joints:
        flanges = joint.declared(Flange)
        for flange in flanges:
            node = joint.targets[flange]
            torque = run[f"{joint.name}.torque_{flange}"]
            rest[nodes.index(node)] -= torque
            work += torque * run[f"{node}.speed"]
        first = next(iter(flanges))
        assert run[f"{joint.name}.torque"] == pytest.approx(-run[f"{joint.name}.torque_{first}"])
    assert np.abs(rest).max() < 1e-9 * np.abs(force).max()
    assert np.abs(work).max() < 1e-9 * np.abs(force).max() * np.abs(speed).max()


def test_a_set_without_anything_else_turns_as_by_hand():
    """Sun 0.5, ring 2.0, carrier 0.5 kg*m^2, 10 N*m on the sun: the multiplier by hand gives 9.0909, -0.4545, 2.7273 rad/s."""
    for order in ("SRC", "RCS", "CSR", "CRS"):
        sizes = {"S": 0.5, "R": 2.0, "C": 0.5}
        parts = [Inertia(name, inertia=sizes[name]) for name in order]
        willis = PlanetarySet("set", "S", "R", "C", teeth_sun=1, teeth_ring=2)
        line = Driveline("willis", elements=[*parts, willis, HarmonicTorque("drive", "S", mean=10.0)])
        run = simulate(Case(line, end=0.5, start="zero"))
        assert [run[f"{name}.speed"][-1] for name in "SRC"] == pytest.approx([100 / 11, -5 / 11, 30 / 11], rel=1e-12)


class SunMesh(Element):
    """An elastic law over three flanges."""

    sun, planet, carrier = Flange(), Flange(), Flange()
    k = Param("N*m/rad", positive=True)

    @quantity("N*m")
    def load(self):
        return self.k * (self.sun.angle + self.planet.angle - self.carrier.angle)

    def torques(self):
        return {self.sun: -self.load, self.planet: -self.load, self.carrier: self.load}


class RingMesh(Element):
    """An elastic law that ties the planet to the carrier."""

    planet, carrier = Flange(), Flange()
    k = Param("N*m/rad", positive=True)

    @quantity("N*m")
    def load(self):
        return self.k * (self.planet.angle + self.carrier.angle)

    def torques(self):
        return {self.planet: -self.load, self.carrier: -self.load}


def test_elastic_laws_over_three_flanges_are_lawful_in_any_order():
    """Unit inertias, k = 100: K = k (g1 g1^T + g2 g2^T) with g1 = (1, 1, -1), g2 = (0, 1, 1)."""
    arms = np.array([[1.0, 1.0, -1.0], [0.0, 1.0, 1.0]])
    wanted = np.sqrt(np.maximum(np.linalg.eigvalsh(100 * arms.T @ arms), 0)) / (2 * np.pi)
    parts = [
        *(Inertia(name, inertia=1.0) for name in ("sun", "planet", "carrier")),
        SunMesh("sm", "sun", "planet", "carrier", k=100.0),
        RingMesh("rm", "planet", "carrier", k=100.0),
    ]
    for seed in ORDERS:
        mixed = [parts[k] for k in np.random.default_rng(seed).permutation(5)]
        for reference in (None, "sun", "planet", "carrier"):
            found = modal(lower(assemble(Driveline("p", elements=mixed, reference=reference)))).frequencies
            assert np.abs(found - wanted)[1:].max() < 1e-10 * wanted.max()
            assert found[0] == 0.0


def members(*more, **speed):
    parts = [Inertia(name, inertia=1.0) for name in ("S", "R", "C")]
    return Driveline("set", elements=[*parts, PlanetarySet("p", "S", "R", "C", teeth_sun=30, teeth_ring=70), *more], **speed)


def test_a_node_that_constraints_lock_is_refused_with_the_loop():
    """A second set on the same shafts leaves their rotation as one block; a pair that turns against each other takes it too."""
    second = PlanetarySet("q", *"CSR", teeth_sun=20, teeth_ring=41)
    assemble(members(second))
    for parts in ([second, Reverse("reverse", "S", "R")], [Reverse("reverse", "S", "R"), second]):
        with pytest.raises(ModelError, match=r"'[A-Z]' cannot turn") as refusal:
            assemble(members(*parts))
        assert {"'p'", "'q'", "'reverse'"} <= set(str(refusal.value).replace(",", " ").split())


class Reverse(Element):
    """Two shafts that turn against each other at the same speed."""

    a, b = Flange(), Flange()

    def constraints(self):
        return [self.a.angle + self.b.angle]


def test_speeds_that_are_missing_are_asked_for_by_name():
    with pytest.raises(ModelError, match=r"leaves 1 further mean speed free beside that of 'S'; give speeds = \{ R ="):
        assemble(members(speed="1500 rpm", reference="S"))
    with pytest.raises(ModelError, match="gives a mean speed to 'C', which follows from the others"):
        assemble(members(speeds={"S": "1500 rpm", "R": 0, "C": "450 rpm"}))
    model = lower(assemble(members(speeds={"S": "1500 rpm", "R": 0})))
    run = simulate(Case(model, end=1e-3, start="zero"))
    assert run["S.speed"][0] == pytest.approx(1500 * np.pi / 30)
    assert run["R.speed"][0] == 0.0
    assert run["C.speed"][0] == pytest.approx(450 * np.pi / 30)  # 30/(30 + 70) of the sun's
    run = simulate(Case(model, end=1e-3, start="zero", parameters={"speeds.R": "300 rpm"}))
    assert run["C.speed"][0] == pytest.approx((450 + 210) * np.pi / 30)


def test_values_that_break_the_choice_are_refused_by_name():
    model = lower(assemble(SYSTEMS["two sets on the same shafts"].driveline()))
    model.parameters.vector({"first.teeth_ring": 41})
    with pytest.raises(ModelError, match=r"planetary_set '(first|second)': its constraint no longer sees the angle"):
        model.parameters.vector({"first.teeth_ring": 60})


def test_constraints_that_say_the_same_share_their_torque():
    """Two equal sets take half each; a closed loop of rigid gears shares what nothing elastic tells apart, and all is finite."""
    sizes = {"S": 0.5, "R": 2.0, "C": 0.5}
    twins = [PlanetarySet("p", *"SRC", teeth_sun=1, teeth_ring=2), PlanetarySet("q", *"SRC", teeth_sun=2, teeth_ring=4)]
    parts = [Inertia(name, inertia=value) for name, value in sizes.items()]
    line = Driveline("twins", elements=[*parts, *twins, HarmonicTorque("d", "S", mean=10.0)])
    run = simulate(Case(line, end=0.5, start="zero"))
    for flange, torque in (("sun", -5 / 11), ("ring", -10 / 11), ("carrier", 15 / 11)):
        assert [run[f"{name}.torque_{flange}"][-1] for name in "pq"] == pytest.approx([torque, torque])
    ends = {"g1": "ab", "g2": "bd", "g3": "ac", "g4": "cd"}
    gears = [RigidGear(name, *joined, teeth_a=20, teeth_b=40) for name, joined in ends.items()]
    loop = Driveline("loop", elements=[*(Inertia(n, inertia=1.0) for n in "abcd"), *gears, HarmonicTorque("t", "a", mean=4.0)])
    model = lower(assemble(loop))
    run = simulate(Case(model, end=0.1, start="zero"))
    assert run["g1.torque"][-1] == pytest.approx(run["g3.torque"][-1])
    second = run["a.acceleration"][-1]
    assert second == pytest.approx(4.0 / (1 + 2 / 4 + 1 / 16))
    assert run["g1.torque"][-1] + run["g3.torque"][-1] == pytest.approx(4.0 - second)
    with pytest.raises(ModelError, match="rigid_gear 'g4': closes a loop whose gear ratios do not agree at these values"):
        model.parameters.vector({"g4.teeth_b": 41})


@pytest.mark.parametrize("name", ["planetary set, ring held", "open differential", "Ravigneaux set"])
def test_generated_c_has_the_same_constraints(name):
    if shutil.which("gcc") is None and shutil.which("clang") is None:
        pytest.skip("no C compiler")
    model = lower(assemble(SYSTEMS[name].driveline()))
    runs = [simulate(Case(model, end=0.05, start="zero", tolerance=1e-9, options={"backend": each})) for each in ("vm", "c")]
    assert np.abs(runs[0].states - runs[1].states).max() < 1e-12 * np.abs(runs[0].states).max()


@pytest.mark.parametrize("reference", [None, "A", "B", "C"])
@pytest.mark.parametrize("seed", range(6))
def test_elastic_members_beside_a_constraint_need_no_common_rotation(seed, reference):
    """Springs to ground and between members, and springs over three flanges, in any order: the frequencies of the matrices."""
    rng = np.random.default_rng(seed)
    stiffness, inertia = 10.0 ** rng.uniform(1, 3, 4), rng.uniform(0.5, 3.0, 3)
    names = "ABC"
    lever = Joint3("c", *names, one=1, two=1, three=-2)
    parts = [*(Inertia(n, inertia=j) for n, j in zip(names, inertia, strict=True)), lever]
    matrix = np.zeros((3, 3))
    grounded = rng.integers(3)
    members = [
        (GroundSpring("g", names[grounded], stiffness=stiffness[0]), np.eye(3)[grounded], stiffness[0]),
        (Shaft("s", "B", "C", stiffness=stiffness[1]), np.array([0.0, 1.0, -1.0]), stiffness[1]),
        (SunMesh("m", *names, k=stiffness[2]), np.array([1.0, 1.0, -1.0]), stiffness[2]),
        (RingMesh("r", "A", "C", k=stiffness[3]), np.array([1.0, 0.0, 1.0]), stiffness[3]),
    ]
    for element, row, k in members[: 2 + seed % 2] if seed < 4 else members[1:3]:
        parts.append(element)
        matrix += k * np.outer(row, row)
    free = null_space(np.array([[1.0, 1.0, -2.0]]))
    wanted = np.sqrt(eigh(free.T @ matrix @ free, free.T @ np.diag(inertia) @ free, eigvals_only=True)) / (2 * np.pi)
    for order in [rng.permutation(len(parts)) for _ in range(12)]:
        line = Driveline("lever", elements=[parts[k] for k in order], reference=reference)
        assert modal(lower(assemble(line))).frequencies == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_the_ring_that_a_spring_holds_has_no_mean_speed_in_any_order(seed):
    """Sun at the operating speed, ring on a spring to ground: the carrier's mean speed is that of the Willis equation."""
    parts = [Inertia(name, inertia=0.5) for name in "SRC"]
    parts += [PlanetarySet("set", *"SRC", teeth_sun=30, teeth_ring=70), GroundSpring("spring", "R", stiffness=1e4)]
    order = np.random.default_rng(seed).permutation(len(parts))
    line = Driveline("held", speed="1500 rpm", reference="S", drifts=True, elements=[parts[k] for k in order])
    run = simulate(Case(line, end=1e-3, start="zero"))
    assert run["C.speed"][0] == pytest.approx(450 * np.pi / 30)
    assert run["R.speed"][0] == pytest.approx(0.0, abs=1e-12)
