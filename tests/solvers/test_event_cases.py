"""Problems with events whose answers are known: closed forms, and the Backlash example of the Modelica Standard Library."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

from modelgen.lowering.switching import Crossing
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.registry import solve

Hybrid = Callable[..., InitialValueProblem]

EXPLICIT = ("rk4", "dopri5", "dop853")


def run(problem: InitialValueProblem, method: str, tolerance: float) -> Trajectory:
    trajectory = solve(problem, method, SolverOptions(tolerance=tolerance))
    assert trajectory.outcome is Outcome.SUCCESS, trajectory.message
    assert trajectory.events is not None
    return trajectory


@pytest.mark.parametrize("method", EXPLICIT)
def test_bilinear_oscillator(hybrid: Hybrid, method: str) -> None:
    # x'' + w1^2 x = 0 for x > 0, w2 below: half a period of each, so w = 2 w1 w2/(w1 + w2) in all.
    problem = hybrid(
        lambda t, x, p: [x[1], -(p[0] * p[2] + p[1] * p[3]) * x[0]],
        lambda t, x, p: [x[0], x[0]],
        [Crossing("down", -1, 0, 0, 1), Crossing("up", 1, 0, 1, 0)],
        [0.0, 1.0],
        20.0,
        p=[1.0, 4.0],
        modes=[("side", ("right", "left"))],
    )
    log = run(problem, method, 1e-12).events
    period = 2 * np.pi / (2 * 1.0 * 2.0 / (1.0 + 2.0))
    assert log.times[log.which == 1] == pytest.approx(period * np.arange(1, 5), abs=2e-10)
    assert log.times[log.which == 0] == pytest.approx(np.pi + period * np.arange(0, 4), abs=2e-10)


def friction(hybrid: Hybrid, kinetic: float, static: float, belt: float, x0: list[float], end: Any) -> InitialValueProblem:
    """x'' + x = F on a belt of speed p[2]: sticks, or slides forward or backward. p = [kinetic, static, belt, flags]."""
    return hybrid(
        lambda t, x, p: [p[3] * p[2] + (1 - p[3]) * x[1], (1 - p[3]) * (-x[0] + p[0] * (p[5] - p[4]))],
        lambda t, x, p: [x[0] - p[1], -x[0] - p[1], x[1] - p[2], x[1] - p[2]],
        [
            Crossing("lets go backward", 1, 0, 0, 2),
            Crossing("lets go forward", 1, 0, 0, 1),
            Crossing("sticks from forward", -1, 0, 1, 0, reset=0),
            Crossing("sticks from backward", 1, 0, 2, 0, reset=0),
        ],
        x0,
        end,
        p=[kinetic, static, belt],
        modes=[("contact", ("stick", "forward", "backward"))],
        resets=lambda t, x, p: [[x[0], p[2]]],
        start=[0],
    )


@pytest.mark.parametrize("method", EXPLICIT)
def test_coulomb_friction_turns_by_equal_steps_and_rests(hybrid: Hybrid, method: str) -> None:
    # x'' + x = -f sign(x'): every half swing of pi takes 2 f off the amplitude, until |x| <= f at a turning point.
    trajectory = run(friction(hybrid, 0.1, 0.1, 0.0, [1.0, 0.0], np.linspace(0, 30, 31)), method, 1e-11)
    log = trajectory.events
    turns = np.isin(log.which, (2, 3))
    assert log.times[turns] == pytest.approx(np.pi * np.arange(1, 6), abs=1e-8)
    assert log.states[turns, 0] == pytest.approx([-0.8, 0.6, -0.4, 0.2, 0.0], abs=1e-9)
    assert trajectory.states[-1] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert log.share()["contact.stick"] == pytest.approx(1 - 5 * np.pi / 30, abs=1e-9)


@pytest.mark.parametrize("method", EXPLICIT)
def test_belt_stick_slip_cycle(hybrid: Hybrid, method: str) -> None:
    # T = (2 pi - 2 atan(d w/v))/w + 2 d/v with d = (Fs - Fk)/k = 0.3, v = 0.5, w = 1; amplitude about the slip center
    # sqrt(d^2 + v^2/w^2).
    kinetic, drop, speed = 1.0, 0.3, 0.5
    trajectory = run(friction(hybrid, kinetic, kinetic + drop, speed, [0.0, speed], np.linspace(0, 40, 8001)), method, 1e-11)
    log = trajectory.events
    gone, caught = log.times[log.which == 0], log.times[log.which == 3]
    assert np.diff(gone) == pytest.approx(np.full(len(gone) - 1, 6.4023463066), abs=1e-8)
    assert caught - gone[: len(caught)] == pytest.approx(np.full(len(caught), 5.2023463066), abs=1e-8)
    assert gone[1:] - caught[: len(gone) - 1] == pytest.approx(np.full(len(gone) - 1, 2 * drop / speed), abs=1e-8)
    assert np.abs(trajectory.states[trajectory.times > 5, 0] - kinetic).max() == pytest.approx(0.5830951895, abs=1e-5)
    assert log.states[log.which == 3, 0] == pytest.approx(np.full(len(caught), kinetic - drop), abs=1e-8)


# Modelica Standard Library, Modelica.Mechanics.Rotational.Examples.Backlash (commit b756f9d): inertia J on a spring-damper c, d
# with a total backlash of 45 degrees, released from 90 degrees. Values computed by DOP853 at 1e-11 with steps of at most 1e-5 s.
TIMES = [0.025, 0.03, 0.05, 0.075, 0.1, 0.15, 0.2, 0.25, 0.5, 0.75, 1.0]
LIMITED = [
    (0.46943524986637014, -66.19661797743325), (0.1384521599792013, -66.19661797743325),
    (-1.0783673695468787, -42.565055303323426), (-1.03320989924582, 41.57103538591583),
    (0.24983585509100603, 52.89371860980337), (0.4996040187824353, -42.26410203081257),
    (-0.9618360730247794, 12.002529669037859), (0.5808155701912038, 30.080457771170483),
    (-0.30995803600868727, -17.228425708538193), (-0.5354601289995387, -4.135609480068474),
    (-0.1555814131915813, -7.0229372733255255),
]  # fmt: skip
JUMPING = [
    (0.46943524986637014, -66.19661797743325), (0.1384521599792013, -66.19661797743325),
    (-1.0704440009626104, -42.01541575455935), (-1.0249997284804218, 41.08633536106939),
    (0.2425403885899934, 52.24986018932749), (0.5037329652460647, -41.23844929624445),
    (-0.9480093439648529, 10.281726464723905), (0.5285728707687494, 30.00437987216721),
    (-0.17668649055104918, -16.007805102178242), (-0.3523842489923012, -9.973106349283533),
    (0.1034750431114184, -6.213397128357607),
]  # fmt: skip
INERTIA, STIFFNESS, DAMPING, HALF = 5.0, 2e4, 50.0, np.pi / 8


def modelica_backlash(hybrid: Hybrid, limited: bool) -> InitialValueProblem:
    """Contact never pulls; where ``limited``, the damper's torque is at most the spring's."""

    def parts(x: Any, side: int) -> tuple[Any, Any, Any]:
        """Deflection beyond the gap, the spring's torque and the damper's, on one side of it."""
        depth = side * x[0] - HALF
        return depth, STIFFNESS * depth, DAMPING * side * x[1]

    def torque(x: Any, side: int, capped: Any, full: Any) -> Any:
        _, spring, damper = parts(x, side)
        return side * (full * (spring + damper) + capped * 2 * spring)

    def rates(t: Any, x: Any, p: Any) -> list[Any]:
        return [x[1], -(torque(x, 1, p[1], p[2]) + torque(x, -1, p[3], p[4])) / INERTIA]

    def guards(t: Any, x: Any, p: Any) -> list[Any]:
        values = []
        for side in (1, -1):
            depth, spring, damper = parts(x, side)
            touching = ca.fmin(depth, (spring + damper) / STIFFNESS)
            values += [touching, touching, touching, (spring - damper) / STIFFNESS, (spring - damper) / STIFFNESS]
        return values

    crossings = []
    for side, (capped, full) in enumerate([(1, 2), (3, 4)]):
        enters = capped if limited else full
        crossings += [
            Crossing(f"touches {side}", 1, 0, 0, enters), Crossing(f"leaves {side}", -1, 0, full, 0),
            Crossing(f"leaves capped {side}", -1, 0, capped, 0), Crossing(f"uncapped {side}", 1, 0, capped, full),
            Crossing(f"capped {side}", -1, 0, full, capped) if limited else Crossing(f"not watched {side}", -1),
        ]  # fmt: skip
    modes = [("contact", ("free", "right capped", "right", "left capped", "left"))]
    return hybrid(rates, guards, crossings, [np.pi / 2, 0.0], TIMES, modes=modes, scale=[1.0, 50.0])


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize(("limited", "expected"), [(True, LIMITED), (False, JUMPING)], ids=["limited", "jumping"])
def test_backlash_of_the_modelica_library(
    hybrid: Hybrid, method: str, limited: bool, expected: list[tuple[float, float]]
) -> None:
    trajectory = run(modelica_backlash(hybrid, limited), method, 1e-12)
    error = np.abs(trajectory.states - expected).max(axis=0)
    assert error[0] < 1e-8 * np.pi / 2
    assert error[1] < 1e-8 * 70.0
    # From rest, J x'' + d x' + c x = 0 holds until the force is zero, where x'' is: tan(w t) = w/decay.
    decay = DAMPING / (2 * INERTIA)
    speed = np.sqrt(STIFFNESS / INERTIA - decay**2)
    assert trajectory.events.times[0] == pytest.approx(np.arctan(speed / decay) / speed, abs=1e-12)
    assert trajectory.events[0].name == "leaves 0"
