"""Variational equations against paper: matrix exponentials, volumes, and what jumps at an event."""

from __future__ import annotations

import math
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm

from modelgen.analysis.stability.coordinates import vibration_of
from modelgen.analysis.stability.propagators import complete_runs, propagators
from modelgen.analysis.stability.shooting import shoot
from modelgen.analysis.stability.variational import parts, saltation, variational_rate, variational_switching, with_tangents
from modelgen.drivelines import load
from modelgen.equations import assemble
from modelgen.errors import CaseError
from modelgen.lowering import lower
from modelgen.lowering.switching import Crossing, ModeVariable, Switching
from modelgen.solvers import Case
from modelgen.solvers.problem import InitialValueProblem, SolverOptions

MATRIX = np.array([[0.0, 1.0, 0.0], [-4.0, -0.3, 0.2], [0.1, 0.0, -2.0]])
VM, C = (SolverOptions(1e-10, backend=backend) for backend in ("vm", "auto"))


def linear(scale: float = 1.0) -> InitialValueProblem:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 3), ca.SX.sym("p")
    rhs = ca.Function("f", [t, x, p], [ca.densify(ca.DM(MATRIX) @ x) * p])
    return InitialValueProblem(rhs, ("a", "b", "c"), [1.0, 0.0, 2.0], [1.0], [1.0, scale, 3.0], 0.0, [1.0])


@pytest.mark.parametrize("options", [VM, C], ids=["vm", "lanes"])
def test_a_linear_system_is_its_matrix_exponential(options: SolverOptions) -> None:
    problem = linear(scale=5.0)
    found = propagators([problem, problem], 1.5, options)
    scaling = np.diag(problem.scale)
    wanted = np.linalg.solve(scaling, expm(1.5 * MATRIX)) @ scaling
    assert np.abs(found.matrices - wanted).max() < 1e-8
    assert found.ends[1] == pytest.approx(expm(1.5 * MATRIX) @ problem.x0, abs=1e-8)
    assert found.volumes == pytest.approx([1.5 * np.trace(MATRIX)] * 2, abs=1e-9)


def test_time_goes_on_where_a_stretch_begins() -> None:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p", 0)
    rhs = ca.Function("f", [t, x, p], [-2 * t * x])
    problem = InitialValueProblem(rhs, ("x",), [1.0], [], [1.0], 3.0, [3.5])
    found = propagators([problem], 0.5, VM)
    assert float(found.matrices[0, 0, 0]) == pytest.approx(math.exp(9.0 - 12.25), abs=1e-9)


def test_many_columns_are_told_apart() -> None:
    n = 20
    matrix = np.diag(np.linspace(-1, -0.1, n)) + np.diag(np.full(n - 1, 0.3), 1)
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", n), ca.SX.sym("p", 0)
    rhs = ca.Function("f", [t, x, p], [ca.densify(ca.DM(matrix) @ x)])
    problem = InitialValueProblem(rhs, tuple(f"x{k}" for k in range(n)), np.ones(n), [], np.ones(n), 0.0, [1.0])
    assert np.abs(propagators([problem], 1.0, VM).matrices[0] - expm(matrix)).max() < 1e-9


def test_wrong_tangents_and_a_run_that_blows_up() -> None:
    with pytest.raises(CaseError, match=r"tangents: have shape \(2, 1\); give columns of 3 entries"):
        with_tangents(linear(), np.ones((2, 1)), 1.0)
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p", 0)
    grows = InitialValueProblem(ca.Function("f", [t, x, p], [x**2]), ("x",), [1.0], [], [1.0], 0.0, [2.0])
    with pytest.raises(CaseError, match="variational equations: stopped at t = "):
        complete_runs([with_tangents(grows, np.ones((1, 1)), 2.0)], VM)


def test_without_tangents_the_state_and_the_volume_remain() -> None:
    rate = variational_rate(linear().rhs, 0)
    assert np.asarray(rate(0, [1, 0, 2, 0], [1, 0])).ravel() == pytest.approx([*MATRIX @ [1, 0, 2], np.trace(MATRIX)])


def test_the_rigid_pair_of_a_driveline_is_left_out() -> None:
    model = lower(assemble(load("fracturing-truck-commensurate")))
    vibration = vibration_of(Case(model, end=1.0, options={"events": "off"}))
    assert vibration.neutral_names == ("flywheel.angle_deviation", "flywheel.angle_deviation_rate")
    assert (len(vibration.kept), vibration.autonomous) == (30, False)
    z = vibration.problem.x0 + 0.1 * vibration.problem.scale
    rates = model.rhs(0.2, vibration.state(z) + np.eye(32)[0], vibration.point.p)[list(vibration.kept)]
    assert np.asarray(vibration.problem.rhs(0.2, z, vibration.problem.p)).ravel() == pytest.approx(rates, rel=1e-12)


# Events. A ball under gravity g bounces elastically from the floor, or a mass is pushed to the middle by a constant force a. From
# rest at height A both return after T(A); the monodromy matrix is [[1, 0], [a T'(A), 1]], because M f = f along the motion.


def bouncing(restitution: float = 1.0) -> InitialValueProblem:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p")
    floor = Switching(
        (),
        (Crossing("floor", -1, reset=0),),
        ca.Function("guards", [t, x, p], [x[0]], ["t", "x", "p"], ["guards"]),
        1,
        ca.Function("resets", [t, x, p], [ca.vertcat(x[0], -restitution * x[1])], ["t", "x", "p"], ["states"]),
    )
    rhs = ca.Function("fall", [t, x, p], [ca.vertcat(x[1], -p)])
    return InitialValueProblem(rhs, ("x", "v"), [2.0, 0.0], [9.0], [1.0, 1.0], 0.0, [1.0], floor)


def relay() -> InitialValueProblem:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    side = ModeVariable("side", ("right", "left"), 0)
    there = (Crossing("to_left", -1, variable=0, leave=0, enter=1), Crossing("to_right", 1, variable=0, leave=1, enter=0))
    guards = ca.Function("guards", [t, x, p], [ca.vertcat(x[0], x[0])], ["t", "x", "p"], ["guards"])
    rhs = ca.Function("push", [t, x, p], [ca.vertcat(x[1], p[1] - p[0])])
    return InitialValueProblem(
        rhs, ("x", "v"), [1.0, 0.0], [1.0, 0.0], [1.0, 1.0], 0.0, [1.0], Switching((side,), there, guards, 2)
    )


@pytest.mark.parametrize("options", [VM, C], ids=["vm", "lanes"])
@pytest.mark.parametrize(
    ("problem", "period", "shear"),
    [(bouncing(), 2 * math.sqrt(2 * 2 / 9), 9 * math.sqrt(2 / (9 * 2))), (relay(), 4 * math.sqrt(2), 2 * math.sqrt(2))],
    ids=["ball", "relay"],
)
def test_monodromy_across_events(problem: InitialValueProblem, period: float, shear: float, options: SolverOptions) -> None:
    found = shoot(problem, period, False, options, lambda _: None)
    assert found.residual < 1e-9
    assert found.monodromy == pytest.approx(np.array([[1.0, 0.0], [shear, 1.0]]), abs=1e-8)


def chained(second: float) -> InitialValueProblem:
    """x falls with speed 1; at 1 the speed doubles, and at ``second``, which may lie above, it doubles again."""
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p", 3)
    speed = ModeVariable("speed", ("one", "two", "four"), 0, continuous=False)
    there = (Crossing("first", -1, variable=0, leave=0, enter=1), Crossing("second", -1, variable=0, leave=1, enter=2))
    guards = ca.Function("guards", [t, x, p], [ca.vertcat(x - 1, x - second)], ["t", "x", "p"], ["guards"])
    rhs = ca.Function("fall", [t, x, p], [-(p[0] + 2 * p[1] + 4 * p[2])])
    return InitialValueProblem(rhs, ("x",), [2.0], [1.0, 0.0, 0.0], [1.0], 0.0, [1.5], Switching((speed,), there, guards, 3))


@pytest.mark.parametrize("options", [VM, C], ids=["vm", "lanes"])
def test_events_that_set_off_each_other(options: SolverOptions) -> None:
    """At one place a deviation is stretched by the ratio of the speeds; beyond zero the jump is that of neither guard."""
    assert propagators([chained(1.0)], 1.5, options).matrices.ravel() == pytest.approx([4.0], rel=1e-9)
    with pytest.raises(CaseError, match=r"t = 1 s: 'first' sets off 'second', which lies beyond zero already"):
        propagators([chained(1.2)], 1.5, options)


def test_an_event_at_the_edge_of_a_batch_is_taken_once() -> None:
    """The second stretch claims to begin before the drop, the one before it has taken it: what came before counts."""
    problem = chained(-9.0)
    late = replace(problem, t0=1.0, x0=np.array([1.0]), times=np.array([1.25]))
    taken = np.array([0.0, 1.0, 0.0])
    alone, after = (propagators([late], 0.25, VM, before) for before in (None, (np.array([1.0]), taken)))
    assert after.matrices.ravel() == pytest.approx([1.0], rel=1e-9)
    assert after.modes[0].tolist() == [0.0, 1.0, 0.0]
    assert after.ends[0] == pytest.approx([0.5], rel=1e-9)
    assert alone.ends[0] == pytest.approx([0.5], rel=1e-9)


def test_meissner_equation() -> None:
    """N11: trace 2 cos w1T1 cos w2T2 - (w1/w2 + w2/w1) sin w1T1 sin w2T2 for w^2 = 1.5 over 1 and 0.5 over 2."""
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    stiffness = ModeVariable("stiffness", ("high", "low"), 0)
    guards = ca.Function("guards", [t, x, p], [t - 1], ["t", "x", "p"], ["guards"])
    rhs = ca.Function("meissner", [t, x, p], [ca.vertcat(x[1], -(1.5 * p[0] + 0.5 * p[1]) * x[0])])
    switching = Switching((stiffness,), (Crossing("drop", 1, variable=0, leave=0, enter=1),), guards, 2)
    problem = InitialValueProblem(rhs, ("x", "v"), [0.0, 0.0], [1.0, 0.0], [1.0, 1.0], 0.0, [3.0], switching)
    found = shoot(problem, 3.0, False, SolverOptions(1e-13, backend="auto"), lambda _: None)
    assert np.trace(found.monodromy) == pytest.approx(-2.0401319487728697, abs=1e-10)
    assert np.linalg.det(found.monodromy) == pytest.approx(1.0, abs=1e-10)


def test_what_an_impact_does_to_volumes() -> None:
    problem = bouncing(0.5)
    assert problem.switching is not None
    jump = saltation(problem.rhs, problem.switching, 0, 2)
    _, matrix, stretch = jump(0.0, [0.0, -2.0], [9.0], np.eye(2))
    assert float(stretch) == pytest.approx(math.log(abs(np.linalg.det(np.asarray(matrix)))))
    extended = variational_switching(problem.rhs, problem.switching, 2)
    assert extended.resets is not None
    after = np.asarray(extended.resets(0.0, [0.0, -2.0, 0.0, 1.0, 0.0, 0.0, 1.0], [9.0, 0.0])).ravel()
    assert parts(problem, after).tangents == pytest.approx(np.asarray(matrix))
    assert after[:2] == pytest.approx([0.0, 1.0])
