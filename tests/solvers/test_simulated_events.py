"""Events of cases: when they are located, what solutions hold of them, and what is refused; the idling truck against a peer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from modelgen import Case, Driveline, Inertia, Outcome, Solution, load, lower, operating_point, simulate
from modelgen.elements import Brake, GroundSpring
from modelgen.equations import assemble
from modelgen.errors import CaseError
from modelgen.lowering import Section
from modelgen.solvers.coordinates import ScaledProblem
from modelgen.solvers.simulate import initial_value_problem

BELT = Driveline(
    "belt",
    elements=[
        Inertia("disk", inertia=2.0),
        GroundSpring("wire", "disk", stiffness=8.0),
        Brake("brake", "disk", sliding_torque=1.0, holding_torque=1.5, other_speed=0.1),
    ],
)
CASE = Case(BELT, end=20.0, start="zero", samples=801, tolerance=1e-9)
DROP, OMEGA, SPEED = (1.5 - 1.0) / 8.0, 2.0, 0.1
PERIOD = (2 * np.pi - 2 * np.arctan(DROP * OMEGA / SPEED)) / OMEGA + 2 * DROP / SPEED


@pytest.fixture(scope="module")
def belt() -> Solution:
    return simulate(CASE)


def test_a_law_with_memory_is_run_with_events_by_itself(belt: Solution) -> None:
    log = belt.events
    assert log is not None
    gone = [event.time for event in log if event.leave == "stick"]
    assert np.diff(gone) == pytest.approx(np.full(len(gone) - 1, PERIOD), abs=1e-8)
    assert {event.name for event in log} == {"brake.break_backward", "brake.stick_backward"}
    assert log.counted() == {"brake.break_backward": 6, "brake.stick_backward": 6}
    assert belt.shares == log.share()
    assert sum(belt.shares.values()) == pytest.approx(1.0, abs=1e-12)


def test_channels_follow_the_modes(belt: Solution) -> None:
    stuck = belt["brake.contact"] == 0
    assert 0.3 < stuck.mean() < 0.5
    assert belt["brake.slip"][stuck] == pytest.approx(0.0, abs=1e-12)
    assert np.abs(belt["brake.torque"][~stuck]) == pytest.approx(1.0, abs=1e-12)
    assert np.abs(belt["brake.torque"][stuck]).max() <= 1.5 + 1e-6


def test_a_log_is_saved_and_loaded_without_loss(belt: Solution, tmp_path: Path) -> None:
    solution = simulate(CASE.change(sections=(Section("wire.torque", 0.75, 0),)))
    loaded = Solution.load(solution.save(tmp_path / "belt.npz"))
    one, other = solution.events, loaded.events
    assert one is not None
    assert other is not None
    for name in ("times", "which", "states", "counts", "shares"):
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes()
    assert (one.rows(), one.share(), one.start, str(one)) == (other.rows(), other.share(), other.start, str(other))
    assert loaded.case.sections == solution.case.sections
    assert loaded.case.data()["sections"] == solution.case.data()["sections"]
    without = simulate(Case(Driveline("disk", elements=[Inertia("disk", inertia=2.0)]), end=1.0))
    assert Solution.load(without.save(tmp_path / "disk.npz")).events is None
    assert str(one) in str(solution)


def test_sections_are_noted_and_change_nothing(belt: Solution) -> None:
    solution = simulate(CASE.change(sections=(Section("wire.torque", 0.75, 1), Section("wire.torque", 0.75, -1))))
    log = solution.events
    assert log is not None
    assert np.array_equal(solution.states, belt.states)
    rising, falling = (log.times[log.which == index] for index in (len(log.counts) - 2, len(log.counts) - 1))
    assert len(rising) == len(falling) + 1 == 6
    torque = np.interp(np.concatenate([rising, falling]), solution.times, solution["wire.torque"])
    assert torque == pytest.approx(np.full(11, 0.75), abs=2e-3)  # straight between outputs


def test_a_section_may_end_a_run() -> None:
    solution = simulate(CASE.change(sections=(Section("wire.torque", 0.75, 1, stop=True),)))
    assert solution.outcome is Outcome.EVENT
    assert solution.succeeded
    assert solution.times[-1] < 1.1
    assert "event 'section wire.torque' asked for it" in solution.message


def test_sections_and_events_are_part_of_the_digest() -> None:
    cases = [CASE, CASE.change(sections=(Section("wire.torque", 0.75),)), CASE.change(sections=(Section("wire.torque", 0.76),))]
    cases += [CASE.change(options={"events": "on"})]
    assert len({case.digest() for case in cases}) == 4


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"options": {"events": "off"}}, r"has events switched off, which the model needs \(modes with memory.*leave events"),
        ({"solver": "cvodes"}, r"solver 'cvodes' does not locate events, which the model needs .*take rk4, dopri5, dop853"),
        ({"options": {"events": "maybe"}}, r"events: is 'maybe'; known are auto, on, off"),
    ],
)
def test_events_that_cannot_be_left_out(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(CaseError, match=words):
        simulate(CASE.change(**changes))


@pytest.mark.parametrize(
    ("sections", "words"),
    [((1.0,), r"case, sections: hold a float"), ((Section("wire.tork"),), r"'wire.tork'.*nearest is 'wire.torque'")],
)
def test_wrong_sections_are_refused(sections: Any, words: str) -> None:
    with pytest.raises(CaseError, match=words):
        CASE.change(sections=sections)


def test_sections_need_a_solver_that_locates_them() -> None:
    disk = Case(Driveline("disk", elements=[Inertia("disk", inertia=2.0)]), end=1.0, solver="idas")
    with pytest.raises(CaseError, match=r"solver 'idas' does not locate events, which the sections of the case need"):
        simulate(disk.change(sections=(Section("disk.speed"),)))


def test_continuous_kinks_are_left_to_the_error_control_unless_asked_for() -> None:
    case = Case(load("fracturing-truck-idle"), end=0.02, samples=21, tolerance=1e-8)
    off, on = simulate(case), simulate(case.change(options={"events": "on"}))
    assert off.events is None
    assert on.events is not None
    assert len(on.events) > 10
    for name in ("transmission_mesh.force", "pump_mesh.force"):
        assert on[name] == pytest.approx(off[name], abs=1e-4 * np.ptp(off[name]))


def test_guards_that_never_fire_cost_the_rated_truck_no_evaluation() -> None:
    case = Case(load("fracturing-truck"), end=0.05, samples=11, tolerance=1e-5)
    off, on = simulate(case), simulate(case.change(options={"events": "on"}))
    assert on.events is not None
    assert len(on.events) == 0
    assert on.statistics.steps == off.statistics.steps
    assert on.statistics.evaluations == off.statistics.evaluations


@pytest.mark.slow
def test_the_idling_truck_against_casadis_rosenbrock_with_guards_in_both_directions() -> None:
    """Its integrator counts zero crossings from above, and lets a transition change the state: counts, and sums of times."""
    end = 1.0
    model = lower(assemble(load("fracturing-truck-idle")))
    case = Case(model, end=end, samples=2, tolerance=1e-9)
    point = operating_point(model)
    scaled = ScaledProblem(initial_value_problem(case, point)[0])
    switched = model.switched()
    assert switched is not None
    n, guards = scaled.size, switched.switching.guards
    t, y, number = ca.SX.sym("t"), ca.SX.sym("y", n), ca.SX.sym("number")
    notes, nothing = ca.SX.sym("notes", 4), ca.SX(0, 1)
    gap = guards(t, scaled.problem.x0 + scaled.problem.scale * y, switched.extended(point.p))[0]  # of the first mesh
    falling = ca.vertcat(1 - number, number)
    after = ca.vertcat(y, notes + ca.vertcat(falling, t * falling))
    empty = [ca.SX.sym(name, 0) for name in ("z", "p", "u")]
    arguments, names = [number, t, ca.vertcat(y, notes), *empty], ["index", "t", "x", "z", "p", "u"]
    transition = ca.Function("transition", arguments, [after, nothing], names, ["post_x", "post_z"])
    system = {
        "t": t,
        "x": ca.vertcat(y, notes),
        "ode": ca.vertcat(scaled.rate(t, y, scaled.parameters), ca.SX.zeros(4)),
        "zero": ca.vertcat(gap, -gap),
    }
    grid = np.linspace(0.0, end, 4001)
    options = {"abstol": 1e-8, "reltol": 0.0, "max_num_steps": 10**7, "transition": transition, "max_events": 10**6}
    peer = ca.integrator("peer", "rosenbrock", system, 0.0, grid.tolist(), options)
    noted = np.array(peer(x0=np.zeros(n + 4))["xf"])[n:]
    log = simulate(case.change(options={"events": "on"})).events
    assert log is not None
    for row, name in enumerate(["transmission_mesh.flank.drive-free", "transmission_mesh.flank.free-drive"]):
        index = [each.name for each in log.switching.crossings].index(name)
        own = log.times[log.which == index]
        counts, sums = np.diff(noted[row], prepend=0.0), np.diff(noted[2 + row], prepend=0.0)
        assert len(own) == counts.sum() > 500
        single = np.flatnonzero(counts == 1)
        assert len(single) > 0.9 * len(own)
        near = np.abs(own[:, None] - sums[single][None, :]).min(axis=0)
        assert near.max() < 1e-6


def test_a_solution_saved_before_there_were_events_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    solution = simulate(Case(Driveline("disk", elements=[Inertia("disk", inertia=2.0)]), end=1.0, samples=11))
    monkeypatch.setattr("modelgen.solvers.solution.FORMAT", 1)
    path = solution.save(tmp_path / "old.npz")
    monkeypatch.undo()
    assert Solution.load(path).events is None
    monkeypatch.setattr("modelgen.solvers.solution.FORMAT", 3)
    solution.save(path)
    monkeypatch.undo()
    with pytest.raises(CaseError, match=r"has format 3; this version reads formats 1 and 2"):
        Solution.load(path)
