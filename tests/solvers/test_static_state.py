"""The static state under mean torques: what sticks, what plays, what is not convex, and what has no equilibrium at all."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import sympy

from modelgen import (
    Brake,
    Case,
    Driveline,
    ElasticStop,
    Element,
    Flange,
    GearPair,
    GroundSpring,
    HardStop,
    HarmonicTorque,
    Inertia,
    Param,
    Shaft,
    assemble,
    lower,
    modal,
    operating_point,
    quantity,
    simulate,
)  # fmt: skip
from modelgen.errors import BalanceError, CaseError
from modelgen.solvers import Outcome

A, B, C = (Inertia(name, inertia=0.5) for name in "ABC")


def shaft(name, a, b, stiffness=1e4):
    return Shaft(name, a, b, stiffness=stiffness)


def brake(name, at, limit, **more):
    return Brake(name, at, sliding_torque=limit, holding_torque=limit, **more)


def torque(name, at, mean):
    return HarmonicTorque(name, at, mean=mean)


def point_of(*elements, **more):
    return operating_point(lower(assemble(Driveline("held", elements=elements, **more))))


def test_a_holding_brake_carries_the_mean_torque_from_the_start():
    line = Driveline("held", elements=[A, B, shaft("k", "A", "B"), brake("brake", "B", 60.0), torque("push", "A", 30.0)])
    run = simulate(Case(line, end=0.5, start="static"))["k.torque"]
    assert np.abs(run - 30.0).max() < 1e-4  # 30 N*m throughout, not a swing from 15 to 45
    point = operating_point(lower(assemble(line)))
    assert point.holding == {"brake": pytest.approx(30.0)}
    assert point.drift == 0.0


def test_redundant_holders_share_by_least_squares_of_utilization():
    """min (x/20)^2 + (y/40)^2 with x + y = 30: x = 6, y = 24."""
    point = point_of(A, B, shaft("k", "A", "B"), brake("one", "B", 20.0), brake("two", "B", 40.0), torque("push", "A", 30.0))
    assert point.holding == pytest.approx({"one": 6.0, "two": 24.0})
    assert point.remarks == ("one, two stick redundantly: their torques are those of least squares of utilization",)


def test_what_slips_gives_its_limit_and_the_others_take_the_rest():
    parts = [A, B, C, shaft("k", "A", "B"), shaft("l", "B", "C")]
    point = point_of(*parts, brake("b1", "A", 5.0), brake("b2", "B", 40.0), brake("b3", "C", 40.0), torque("push", "A", 30.0))
    assert point.holding == pytest.approx({"b1": 5.0, "b2": 25.0, "b3": 0.0}, abs=1e-9)
    assert point.remarks == ("slipped before it came to rest: b1 (5 N*m)",)
    assert (point.angle[0] - point.angle[1]) * 1e4 == pytest.approx(25.0)


def test_a_brake_that_slips_in_the_mean_slides():
    parts = [A, B, shaft("k", "A", "B"), brake("drag", "B", 4.0), torque("push", "A", 4.0)]
    line = Driveline("driven", speed=10.0, reference="A", elements=parts)
    point = operating_point(lower(assemble(line)))
    assert point.holding == {}
    assert (point.angle[0] - point.angle[1]) * 1e4 == pytest.approx(4.0)


def test_too_weak_a_brake_is_named_with_the_torque_that_is_missing():
    with pytest.raises(CaseError, match=r"has no static equilibrium: 10 N[*]m along 'A.angle_deviation' remain"):
        point_of(A, B, shaft("k", "A", "B"), brake("brake", "B", 20.0), torque("push", "A", 30.0))


@pytest.mark.parametrize("seed", range(40))
def test_random_chains_of_brakes_meet_the_conditions_of_the_least_energy(seed):
    """Equilibrium at every node, torques within limits, and what slipped did so against its torque."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 7))
    names = [f"d{k}" for k in range(count)]
    push = rng.normal(size=count) * 30.0
    stiffness = 10.0 ** rng.uniform(2, 5, count - 1)
    limits = rng.uniform(1.0, 60.0, count)
    limits[rng.random(count) < 0.2] = 0.0
    limits[rng.integers(count)] = 300.0  # one holds in any case
    parts = [Inertia(name, inertia=float(rng.uniform(0.1, 2))) for name in names]
    parts += [shaft(f"s{k}", names[k], names[k + 1], float(stiffness[k])) for k in range(count - 1)]
    parts += [torque(f"t{k}", names[k], float(push[k])) for k in range(count)]
    parts += [brake(f"b{k}", names[k], float(limits[k])) for k in range(count) if limits[k]]
    order = rng.permutation(len(parts))
    model = lower(assemble(Driveline("chain", elements=[parts[k] for k in order])))
    point = operating_point(model)
    channels = model.evaluate(0.0, point.start, point.p)
    angle = np.array([channels[f"{name}.angle_deviation"] for name in names])
    inner = np.array([channels[f"s{k}.torque"] for k in range(count - 1)])
    held = np.array([point.holding.get(f"b{k}", 0.0) for k in range(count)])
    rest = push - held - np.append(inner, 0.0) + np.insert(inner, 0, 0.0)
    size = np.abs(push).sum()
    assert np.abs(rest).max() < 1e-8 * size
    assert np.all(np.abs(held) <= limits * (1 + 1e-9) + 1e-12)
    slipped = np.abs(angle) > 1e-9 * np.abs(angle).max()
    braked = slipped & (limits > 0)
    assert np.allclose(held[braked], (np.sign(angle) * limits)[braked], rtol=1e-6)


def meshes(half_backlash):
    mesh = {"module": "3 mm", "mean_stiffness": 3e8, "half_backlash": half_backlash, "damping_ratio": 0.05}
    parts = [Inertia("p", inertia=0.1), Inertia("i1", inertia=0.02), Inertia("i2", inertia=0.02), Inertia("w", inertia=0.5)]
    parts += [GearPair(f"m{k}", "p", f"i{k}", teeth_a=20, teeth_b=30, **mesh) for k in (1, 2)]
    parts += [GearPair(f"m{k + 2}", f"i{k}", "w", teeth_a=30, teeth_b=60, **mesh) for k in (1, 2)]
    parts += [torque("d", "p", 100.0), torque("l", "w", -300.0)]
    return Driveline("loop", speed="1000 rpm", reference="p", elements=parts)


@pytest.mark.parametrize("half_backlash", ["0 um", "1 um", "10 um", "40 um", "80 um", "3 mm"])
def test_a_loop_of_meshes_is_pressed_on_the_right_flanks(half_backlash):
    """100 N*m over two meshes of base radius 30 mm cos 20 deg: 1773.6 N on each."""
    model = lower(assemble(meshes(half_backlash)))
    point = operating_point(model)
    channels = model.evaluate(0.0, point.start, point.p)
    wanted = 100.0 / (2 * 0.03 * math.cos(math.radians(20)))
    assert [channels[f"m{k}.force"] for k in (1, 2, 3, 4)] == pytest.approx([wanted] * 4, rel=1e-9)


class Bistable(Element):
    """T = c u^3 - d u: two wells at u = +-sqrt(d/c)."""

    a, b = Flange(), Flange()
    c, d = Param("N*m/rad^3"), Param("N*m/rad")

    @quantity("rad")
    def twist(self):
        return self.a.angle - self.b.angle

    @quantity("N*m")
    def torque(self):
        return self.c * self.twist**3 - self.d * self.twist

    def torques(self):
        return {self.a: -self.torque, self.b: self.torque}


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_where_the_energy_is_not_convex_the_torques_are_raised_from_zero_and_it_is_said(sign):
    parts = [A, B, Bistable("n", "A", "B", c=1e3, d=10.0), torque("p", "A", 5.0 * sign), torque("q", "B", -5.0 * sign)]
    point = point_of(*parts)
    root = max(x.real for x in np.roots([1e3, 0.0, -10.0, -5.0]) if abs(x.imag) < 1e-9)
    assert point.angle[0] - point.angle[1] == pytest.approx(sign * root, rel=1e-9)
    assert "not convex" in point.remarks[0]
    assert "others may exist" in point.remarks[0]


class Receding(Element):
    """T = -c (u + 1)^2: it pushes in one direction, ever more."""

    a = Flange()
    c = Param("N*m/rad^2")

    def torques(self):
        return {self.a: self.c * (self.a.angle + 1) ** 2}


def test_parts_joined_by_hard_stops_alone_start_from_zero():
    stop = [A, B, HardStop("s", "A", "B", clearance=0.1), torque("p", "A", 5.0)]
    line = Driveline("stop", elements=stop, drifts=True)
    with pytest.raises(CaseError, match=r"has no static equilibrium: 2.5 N[*]m along 's.twist' remain"):
        operating_point(lower(assemble(line)))
    run = simulate(Case(line, end=0.05, start="zero"))
    assert run.outcome is Outcome.SUCCESS
    assert run["A.speed"][-1] == pytest.approx(5.0 / 0.5 * 0.05)  # free until the stop
    assert point_of(A, B, HardStop("s", "A", "B", clearance=0.1)).angle.tolist() == [0.0, 0.0]  # nothing needs a stiffness


@pytest.mark.slow
def test_a_law_without_rest_leaves_the_numbers_by_name():
    away = Driveline("away", elements=[A, Receding("n", "A", c=1.0)])
    with pytest.raises(CaseError, match=r"has no static equilibrium: 1 N[*]m along 'n.relative' remain"):
        operating_point(lower(assemble(away)))
    assert simulate(Case(away, end=0.01, start={"n.relative": 0.1})).outcome is Outcome.SUCCESS
    assert simulate(Case(away, end=20.0, start="zero")).outcome is Outcome.DIVERGED


def test_a_flank_that_nothing_presses_stays_where_it_is():
    gear = GearPair("m", "B", "C", teeth_a=20, teeth_b=20, module=0.003, mean_stiffness=1e8, half_backlash=1e-4)
    parts = [A, B, C, shaft("k", "A", "B"), gear, GroundSpring("g", "A", stiffness=1e3), torque("p", "A", 5.0)]
    point = point_of(*parts, speed=1.0, reference="A")
    deflection = (point.angle[1] - point.angle[2]) * 0.03 * math.cos(math.radians(20))
    assert abs(deflection) <= 1e-4 * (1 + 1e-9)


def test_loads_that_ground_holds_are_not_blamed_for_their_torque():
    parts = [A, B, shaft("k", "A", "B"), GroundSpring("g", "B", stiffness=1e3), torque("p", "A", 5.0), torque("q", "B", -3.0)]
    with pytest.raises(BalanceError, match="ground holds every shaft at rest in the mean"):
        operating_point(lower(assemble(Driveline("x", elements=parts, speed=1.0, reference="A").balance("q"))))


def test_unbalanced_torques_at_speed_are_still_refused_from_zero():
    line = Driveline("x", elements=[A, B, shaft("k", "A", "B"), torque("p", "A", 5.0)], speed=1.0, reference="A")
    with pytest.raises(BalanceError, match=r"mean torques leave 5 N[*]m"):
        simulate(Case(line, end=0.1, start="zero"))


def test_a_stiffness_of_which_nothing_is_left_beside_the_inertias() -> None:
    line = Driveline(
        "denormal",
        drifts=True,
        elements=[
            *(Inertia(name, inertia=inertia) for name, inertia in (("first", 40.0), ("second", 7.5))),
            HardStop("stop", "first", "second", clearance=4e-4),
            GroundSpring("spring", "second", stiffness=5e-324),
            HarmonicTorque("push", "second", mean=750.0),
        ],
    )
    model = lower(assemble(line))
    with pytest.raises(CaseError, match=r"has no static equilibrium: .* remain, and nothing takes them; start from"):
        operating_point(model)
    run = simulate(Case(model, end=1e-3, start="zero"))
    assert run.outcome is Outcome.SUCCESS
    assert run["second.speed"][-1] == pytest.approx(750.0 / 7.5 * 1e-3, rel=1e-9)


def stop(name, a, b):
    return ElasticStop(name, a, b, clearance=0.01, stiffness=1e4)


MESH = {"module": "3 mm", "mean_stiffness": 1e8, "half_backlash": "50 um", "damping_ratio": 0.05}


def flanks(name, a, b):
    return GearPair(name, a, b, teeth_a=20, teeth_b=20, **MESH)


@pytest.mark.parametrize("join", [stop, flanks, shaft], ids=["stop", "flanks", "shaft"])
@pytest.mark.parametrize("seed", range(4))
def test_what_has_slipped_to_its_limit_holds_from_the_start(join, seed):
    """31 N*m push A over a brake that holds 15 and slides at 10; the run starts at rest and stays there, in every order."""
    a, b = (Inertia(name, inertia=1.0) for name in "AB")
    held = Brake("a", "A", sliding_torque=10.0, holding_torque=15.0)
    parts = [a, b, held, join("s", "A", "B"), torque("p", "A", 31.0), GroundSpring("g", "B", stiffness=1e3)]
    order = np.random.default_rng(seed).permutation(len(parts))
    run = simulate(Case(Driveline("limit", elements=[parts[k] for k in order]), end=0.1))
    assert run.outcome is Outcome.SUCCESS
    assert run.events.counted() == {}
    assert run["a.torque"] == pytest.approx(np.full(len(run.times), 15.0), rel=1e-6)
    assert np.ptp(run["A.angle"]) < 1e-9
    assert abs(run["B.angle"][0]) == pytest.approx(16.0 / 1e3, rel=1e-6)


def test_the_brake_beyond_a_stop_holds_what_comes_through_it():
    parts = [Inertia("n0", inertia=4.4), Inertia("n1", inertia=4.6), stop("s", "n0", "n1")]
    parts += [GroundSpring("g", "n1", stiffness=1e3)]
    parts += [Brake("b0", "n0", sliding_torque=1.478, holding_torque=1.4987322064810704)]
    parts += [Brake("b1", "n1", sliding_torque=3.5346, holding_torque=4.2217)]
    parts += [torque("t0", "n0", -59.10187439005183), torque("t1", "n1", 53.96306782350774)]
    run = simulate(Case(Driveline("two", elements=parts), end=0.05))
    assert run["b0.torque"][[0, -1]] == pytest.approx(-1.4987322064810704, rel=1e-6)
    assert run["b1.torque"][[0, -1]] == pytest.approx(53.96306782350774 - 59.10187439005183 + 1.4987322064810704, rel=1e-6)
    assert run.events.counted() == {}


@pytest.mark.parametrize("seed", range(12))
def test_a_brake_at_its_limit_is_no_knife_edge(seed):
    rng = np.random.default_rng(seed)
    limit, stiffness = float(rng.uniform(1, 20)), float(10 ** rng.uniform(2, 5))
    parts = [*(Inertia(name, inertia=float(10 ** rng.uniform(-1, 1))) for name in "AB"), shaft("s", "A", "B", stiffness)]
    parts += [Brake("a", "A", sliding_torque=0.9 * limit, holding_torque=limit), GroundSpring("g", "B", stiffness=1e3)]
    parts += [torque("p", "A", limit + float(rng.uniform(1, 60)))]
    run = simulate(Case(Driveline("edge", elements=parts), end=0.05, tolerance=1e-9))
    assert run.events.counted() == {}
    assert run["a.torque"][0] == pytest.approx(limit, rel=1e-6)


class Arm(Element):
    """Gravity on an arm: a periodic law of the angle of a shaft."""

    shaft = Flange()
    k = Param("N*m")

    def torques(self):
        return {self.shaft: -self.k * sympy.sin(self.shaft.angle)}


@pytest.mark.parametrize("push", [0.5, -0.3, 0.9])
def test_a_law_of_an_angle_that_does_not_turn_holds_it(push):
    model = lower(assemble(Driveline("arm", elements=[A, Arm("arm", "A", k=1.0), torque("push", "A", push)])))
    run = simulate(Case(model, end=1.0))
    assert run["A.angle"] == pytest.approx(np.full(len(run.times), math.asin(push)), abs=1e-9)
    stiffness = math.sqrt(1 - push**2)
    assert modal(model).frequencies == pytest.approx([math.sqrt(stiffness / 0.5) / (2 * math.pi)])


def test_more_torque_than_an_arm_can_hold_has_no_equilibrium():
    with pytest.raises(CaseError, match="has no static equilibrium"):
        point_of(A, Arm("arm", "A", k=1.0), torque("push", "A", 1.5))


@pytest.mark.parametrize("k", [1e-6, 100.0, 1e4])
def test_a_law_that_averages_to_nothing_over_a_turn_is_in_balance(k):
    parts = [A, B, shaft("s", "A", "B"), Arm("arm", "A", k=k)]
    model = lower(assemble(Driveline("turned", speed="10 rpm", reference="A", elements=parts)))
    assert modal(model).frequencies == pytest.approx([0.0, math.sqrt(1e4 * 4) / (2 * math.pi)])
    with pytest.raises(BalanceError, match=r"mean torques leave"):
        point_of(*parts, torque("push", "B", 1e-3 * k), speed="10 rpm", reference="A")


@pytest.mark.slow
def test_what_is_free_in_play_stays_where_it_is_in_every_order():
    a, b = (Inertia(name, inertia=1.0) for name in ("n0", "n1"))
    parts = [a, b, brake("b0", "n0", 10.0), stop("s", "n0", "n1"), torque("t", "n0", 5.3)]
    for order in itertools.permutations(parts):
        point = point_of(*order)
        assert point.holding == {"b0": pytest.approx(5.3)}
        assert np.abs(point.angle).max() < 1e-15
