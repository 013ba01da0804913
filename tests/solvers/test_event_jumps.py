"""Guards that fire again in a step, laws that jump in time, and modes that hold beside a jump: closed forms, every back end."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest
import sympy

from modelgen import (
    Brake,
    Case,
    Driveline,
    Element,
    Flange,
    GearPair,
    GroundSpring,
    Guard,
    HarmonicTorque,
    Inertia,
    Modes,
    Multiplier,
    Outcome,
    Param,
    Section,
    Solution,
    SteppedTorque,
    lower,
    quantity,
    simulate,
    system,
)
from modelgen.model import PeriodicTable
from modelgen.model.declarations import TIME
from modelgen.solvers.bound_model import operating_point
from modelgen.solvers.lanes import solve_lanes
from modelgen.solvers.problem import Budget, SolverOptions
from modelgen.solvers.simulate import initial_value_problem
from modelgen.solvers.time_breaks import time_breaks

EXPLICIT = ("rk4", "dopri5", "dop853")
EVERY = (*EXPLICIT, "verner65", "cvodes", "idas", "erk", "rosenbrock", "collocation")

pytestmark = pytest.mark.usefixtures("own_cache")


def both(case: Case) -> Iterator[Solution]:
    """The run on the virtual machine and in C."""
    for backend in ("vm", "c"):
        run = simulate(case.change(options={**case.options, "backend": backend}))
        assert run.succeeded, run.message
        yield run


TIMER = system({"c": 0, "n": 0}, {"c": 1, "n": 0}, guards=[Guard("tick", "c - 0.001", 1, reset={"c": 0, "n": "n + 1"})])


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("options", [{}, {"rule": "paper"}, {"fixed_step": 0.004}])
def test_a_timer_ticks_whatever_the_steps(method: str, options: dict[str, Any]) -> None:
    if method != "rk4" and "rule" in options:
        pytest.skip("the paper's rule belongs to step doubling")
    for samples in (2, 22):
        for run in both(Case(lower(TIMER), end=0.0105, samples=samples, solver=method, options=options)):
            assert run.events is not None
            assert run.events.times == pytest.approx(0.001 * np.arange(1, 11), abs=1e-15)
            assert run["n"][-1] == 10


def test_a_timer_ticks_in_lanes() -> None:
    model = lower(TIMER)
    problem = initial_value_problem(Case(model, end=0.0105, samples=2), operating_point(model))[0]
    for run in solve_lanes([problem] * 11, SolverOptions(tolerance=1e-6)).trajectories:
        assert run.events is not None
        assert run.events.times == pytest.approx(0.001 * np.arange(1, 11), abs=1e-15)


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("back", [1e-3, 0.25, 1 - 1e-6])
def test_a_reset_may_put_a_guard_back_on_its_own_side(method: str, back: float) -> None:
    # c runs up to 1 and is put back to a place just below it: the next firing comes 1 - back later.
    model = lower(system({"c": 0.5}, {"c": 1}, guards=[Guard("again", "c - 1", 1, reset={"c": repr(back)})]))
    period = 1 - back
    for run in both(Case(model, end=0.5 + 9.5 * period, samples=2, solver=method)):
        assert run.events is not None
        assert run.events.times == pytest.approx(0.5 + period * np.arange(10), abs=1e-12)


@pytest.mark.parametrize("backend", ["vm", "c"])
def test_ticks_closer_than_a_moment_are_chatter(backend: str) -> None:
    # A moment is 1e-10 of the horizon: a clock just slower than that ticks on, one just faster ends the run.
    for period, outcome in ((1.05e-10, Outcome.MAX_EVENTS), (0.95e-10, Outcome.EVENT_CHATTER)):
        ticks = Guard("tick", f"c - {period!r}", 1, reset={"c": 0})
        model = lower(system({"c": 0}, {"c": 1}, guards=[ticks], scales={"c": 1e-10}))
        budget = Budget(max_events=50, smallest_step=1e-15)
        run = simulate(Case(model, end=1.0, samples=2, options={"budget": budget, "backend": backend}))
        assert run.outcome is outcome, run.message


def torn(shape: str, **more: Any) -> Driveline:
    push = SteppedTorque("push", "a", shape=shape, after=20.0, at=0.5, **more)
    brake = Brake("brake", "a", sliding_torque=5.0, holding_torque=5.0)
    return Driveline("torn", elements=[Inertia("a", inertia=1.0), brake, push])


@pytest.mark.parametrize("method", [*EXPLICIT, "collocation"])
@pytest.mark.parametrize(("shape", "more", "speed"), [("step", {}, 15.0), ("ramp", {"duration": 1e-6}, 15 - 15e-6 + 5.625e-6)])
def test_a_torque_tears_a_stuck_brake_loose(method: str, shape: str, more: dict[str, Any], speed: float) -> None:
    case = Case(torn(shape, **more), start="zero", end=1.5, solver=method)
    runs = [simulate(case)] if method == "collocation" else both(case)
    for run in runs:
        assert run["a.speed"][-1] == pytest.approx(speed, abs=1e-10)
        assert run.events is not None
        assert [event.name for event in run.events] == ["brake.break_forward"]
        assert run.events.breaks == pytest.approx([0.5] if shape == "step" else [0.5, 0.500001], abs=1e-15)


class SquareTorque(Element):
    """A torque that changes its sign: at the start it has a value of its own, zero."""

    a = Flange()
    size, rate = Param("N*m"), Param("rad/s")

    def torques(self) -> Mapping[Any, Any]:
        return {self.a: self.size * sympy.sign(sympy.sin(self.rate * TIME))}


@pytest.mark.parametrize("method", [*EXPLICIT, "collocation"])
def test_a_run_that_starts_on_a_jump_begins_behind_it(method: str) -> None:
    """From rest a = 1 N*m less 0.5 N*m of friction; the torque turns after 0.05 s, and the shaft then sticks or goes back."""
    parts = [Inertia("a", inertia=1.0), Brake("b", "a", sliding_torque=0.5, holding_torque=0.5)]
    square = SquareTorque("q", "a", size=1.0, rate=20 * math.pi)
    case = Case(Driveline("x", elements=[*parts, square]), end=0.04, start="zero", solver=method)
    for run in [simulate(case)] if method == "collocation" else both(case):
        assert run["a.speed"][-1] == pytest.approx(0.5 * 0.04, abs=1e-10)


@pytest.mark.parametrize("method", EVERY)
def test_no_method_steps_across_a_jump_in_time(method: str) -> None:
    # A square wave and a table of straight lines: their integrals are known, and exact for every method between the breaks.
    t = sympy.Symbol("t")
    rates = {"saw": sympy.sign(sympy.sin(20 * t)), "table": PeriodicTable(3 * t, 1, 2, 5, 3)}
    run = simulate(Case(lower(system({"saw": 0, "table": 0}, rates)), end=1.5, samples=301, solver=method, tolerance=1e-6))
    assert run.succeeded, run.message
    half = math.pi / 20
    inside = run.times % (2 * half)
    assert run["saw"] == pytest.approx(np.where(inside < half, inside, 2 * half - inside), abs=1e-11)
    phase = 12 * run.times
    whole, part = np.floor(phase).astype(int), phase % 1
    corners = np.array([1.0, 2.0, 5.0, 3.0, 1.0])
    lines = np.concatenate([[0.0], np.cumsum((corners[:-1] + corners[1:]) / 2)])
    index = whole % 4
    exact = whole // 4 * lines[-1] + lines[index] + part * corners[index] + part**2 / 2 * (corners[index + 1] - corners[index])
    assert run["table"] == pytest.approx(exact / 12, abs=5e-6)


def test_breaks_are_found_however_a_law_is_written() -> None:
    t = sympy.Symbol("t")
    laws = {
        "piecewise": (sympy.Piecewise((0, t < sympy.Rational(3, 10)), (1, True)), [0.3]),
        "ramp": (sympy.Min(1, sympy.Max(0, (t - sympy.Rational(1, 4)) * 2)), [0.25, 0.75]),
        "corner": (sympy.Abs(t - sympy.Rational(1, 2)), [0.5]),
        "stairs": (sympy.floor(4 * t), [0.25, 0.5, 0.75]),
        "square": (sympy.sign(sympy.sin(10 * t)), [math.pi / 10, 2 * math.pi / 10, 3 * math.pi / 10]),
        "smooth": (sympy.sin(10 * t), []),
    }
    for law, expected in laws.values():
        model = lower(system({"x": 0}, {"x": law}))
        problem = initial_value_problem(Case(model, end=0.99), operating_point(model))[0]
        assert time_breaks(problem).until(1.0, 0.0) == pytest.approx(expected, abs=1e-14)


def test_outputs_at_a_break_and_next_to_it_are_all_there() -> None:
    model = lower(system({"x": 0}, {"x": sympy.Piecewise((1, sympy.Symbol("t") < 0.5), (-1, True))}))
    for run in both(Case(model, end=1.0, samples=5)):
        assert run["x"] == pytest.approx([0.0, 0.25, 0.5, 0.25, 0.0], abs=1e-14)


def test_a_section_that_a_torque_jumps_over_is_noted() -> None:
    torque = sympy.Piecewise((1, sympy.Symbol("t") < 0.5), (3, True))
    model = lower(system({"x": 0}, {"x": 1}, outputs={"torque": torque}))
    for run in both(Case(model, end=1.0, sections=(Section("torque", 2.0, 1), Section("torque", 2.0, -1)))):
        assert run.events is not None
        assert run.events.times == pytest.approx([0.5], abs=1e-14)


class TornClutch(Element):
    """Dry friction between two nodes, which sticks without slip."""

    a, b = Flange(), Flange()
    sliding = Param("N*m")
    holding = Param("N*m")
    smallest_slip = Param("rad/s", default=1e-11)
    contact = Modes("stick", "forward", "backward", continuous=False)
    friction = Multiplier("N*m")

    @quantity("rad/s")
    def slip(self) -> Any:
        return self.a.speed - self.b.speed

    @quantity("N*m")
    def torque(self) -> Any:
        return self.sliding * (self.contact.forward - self.contact.backward) + self.contact.stick * self.friction

    def torques(self) -> Mapping[Any, Any]:
        return {self.a: -self.torque, self.b: self.torque}

    def regions(self) -> Mapping[Any, Any]:
        return {self.contact.forward: self.slip - self.smallest_slip, self.contact.backward: -self.slip - self.smallest_slip}

    def holds(self) -> Mapping[Any, Any]:
        return {self.contact.stick: (self.slip, self.friction)}

    def guards(self) -> Iterator[Guard]:
        stick, forward, backward = self.contact
        at_rest = {self.a.speed - self.b.speed: 0}
        yield Guard("break_forward", self.friction - self.holding, +1, stick, forward, reset=at_rest)
        yield Guard("break_backward", self.friction + self.holding, -1, stick, backward, reset=at_rest)
        yield Guard("stick_forward", self.slip + self.smallest_slip, -1, forward, stick, reset=at_rest)
        yield Guard("stick_backward", self.slip - self.smallest_slip, +1, backward, stick, reset=at_rest)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(
    ("torques", "speeds"),
    [
        # Both hold 3: the first lets go at a push of 4.5, and relieves the second, which holds on.
        ((3.0, 3.0, 3.0, 3.0), (9.0, 1.5, 1.5)),
        # The second lets go at 3, the first at 5 and slides at 0.5: then the second holds again.
        ((0.5, 3.0, 1.0, 1.0), (11.5, 0.25, 0.25)),
        # Both slide.
        ((3.0, 3.0, 1.0, 1.0), (9.0, 2.0, 1.0)),
    ],
)
@pytest.mark.parametrize("sign", [1, -1])
def test_of_clutches_in_a_row_those_slip_that_must(
    torques: tuple[float, ...], speeds: tuple[float, ...], turned: bool, sign: int
) -> None:
    clutches = [TornClutch(f"c{n}", f"d{n}", f"d{n + 1}", sliding=torques[2 * n], holding=torques[2 * n + 1]) for n in (0, 1)]
    push = SteppedTorque("push", "d0", after=12.0 * sign, at=0.5)
    disks = [Inertia(f"d{n}", inertia=1.0) for n in range(3)]
    line = Driveline("row", elements=[*disks, *clutches[:: -1 if turned else 1], push])
    for run in both(Case(line, start="zero", end=1.5, samples=4)):
        assert [sign * run[f"d{n}.speed"][-1] for n in range(3)] == pytest.approx(speeds, abs=1e-9)
        assert run.events is not None
        assert run.events.times == pytest.approx(np.full(len(run.events), 0.5), abs=1e-9)


@pytest.mark.parametrize("inertia", [1e-6, 1e-12, 1e-18])
@pytest.mark.parametrize("turned", [False, True])
def test_a_held_speed_stays_held_beside_any_inertia(inertia: float, turned: bool) -> None:
    disks = [Inertia("m", inertia=1.0), Inertia("n", inertia=inertia)][:: -1 if turned else 1]
    clutch = TornClutch("clutch", "m", "n", sliding=1e4, holding=1e4)
    loads = [HarmonicTorque("push", "n", mean=7.3), GroundSpring("spring", "m", stiffness=1000.0)]
    for run in both(Case(Driveline("held", elements=[*disks, clutch, *loads]), start="zero", end=1.0, samples=101)):
        assert np.abs(run["clutch.slip"]).max() < 1e-14
        omega = math.sqrt(1000.0 / (1 + inertia))
        assert run["m.speed"] == pytest.approx(7.3 / 1000 * omega * np.sin(omega * run.times), abs=1e-5)


@pytest.mark.parametrize("method", ["rk4", "dopri5", "verner65", "dop853", "cvodes"])
def test_a_rectangular_mesh_with_a_damper_in_contact_only(method: str) -> None:
    line = Driveline("pair", speed="4000 rpm", reference="p", elements=[
        Inertia("p", inertia="0.002 kg*m^2"), Inertia("w", inertia="0.01 kg*m^2"),
        GearPair(
            "mesh", "p", "w", teeth_a=25, teeth_b=50, module="3 mm", mesh="rectangular", stiffness_high=5e8, stiffness_low=3e8,
            contact_ratio=1.6, damping_ratio=0.07, half_backlash="50 um", viscous="contact_only",
        ),
        HarmonicTorque("drive", "p", mean=5.0), HarmonicTorque("load", "w", mean=-10.0),
    ])  # fmt: skip
    case = Case(line, end=0.01, samples=501, channels=("mesh.deflection",))
    reference = simulate(case.change(solver="dop853", tolerance=1e-10))["mesh.deflection"]
    run = simulate(case.change(solver=method, tolerance=1e-8))
    assert run.succeeded, run.message
    assert np.abs(run["mesh.deflection"] - reference).max() < 2e-5 * np.ptp(reference)
