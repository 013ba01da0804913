"""Bifurcation diagrams and frequency sweeps of the dimensionless gear pair: separation, hysteresis, coexisting motions."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.analysis.nonlinear.bifurcation import BifurcationResult, bifurcation
from modelgen.analysis.nonlinear.frequency_sweep import FrequencySweepResult, frequency_sweep
from modelgen.elements import Inertia
from modelgen.errors import CaseError, Interrupted, NamingError
from modelgen.model import Driveline
from modelgen.solvers import Case

from .gear_pair_oscillator import JOINS, PARTS, oscillator

TURN = 2 * np.pi
CHANNEL = "mesh.deflection"


@pytest.fixture(scope="module")
def case() -> Case:
    return Case(oscillator(), end=1.0, tolerance=1e-7)


@pytest.fixture(scope="module")
def both(case: Case) -> BifurcationResult:
    return bifurcation(case, "speed", [0.68, 0.74, 0.80, 0.86, 0.92], [CHANNEL], direction="both", count=16)


def test_both_branches_of_a_hysteresis(both: BifurcationResult) -> None:
    assert both.branches == ("forward", "backward")
    assert both.coexisting().tolist() == [0.74, 0.80]
    for name in both.branches:
        assert [column.value for column in both.branch(name)] == [0.68, 0.74, 0.80, 0.86, 0.92]
    # Upward the teeth stay in contact: the motion is the linear one, symmetric about its mean.
    w, forward = 0.80, both.branch("forward")[2]
    answer = 1.1 + (0.05 * w * w / complex(1 - w * w, 0.1 * w)).real
    assert forward.points[-1, 0] == pytest.approx(answer, abs=1e-5)
    assert both.branch("backward")[2].points[-1, 0] < 0.95
    assert all(column.settled and column.period == 1 for column in both.columns)
    assert str(both) == (
        "bifurcation diagram of 'oscillator' over speed: 5 values from 0.68 to 0.92 rad/s, 2 branches, periods 1"
    )


def test_ctrl_c_keeps_the_columns_that_are_done(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("modelgen.analysis.nonlinear.bifurcation.BATCH", 2)

    def press(done: float) -> None:
        if done > 0.5:
            raise KeyboardInterrupt

    values = [0.74, 0.80, 0.95, 1.0, 1.05]
    with pytest.raises(Interrupted, match="what was computed") as stopped:
        bifurcation(case, "speed", values, [CHANNEL], count=16, progress=press)
    kept = stopped.value.result
    assert [column.value for column in kept.columns] == [0.74, 0.80]
    assert kept.missing == 3
    assert str(kept).endswith("; interrupted: 3 columns were not run")
    with pytest.raises(Interrupted, match="what was computed") as stopped:
        bifurcation(case, "speed", values[:3], [CHANNEL], direction="backward", count=16, progress=press)
    assert [column.value for column in stopped.value.result.columns] == [0.95]
    with pytest.raises(KeyboardInterrupt) as early:
        bifurcation(case, "speed", values, [CHANNEL], count=16, progress=lambda done: press(1))
    assert not isinstance(early.value, Interrupted)


def test_many_starts_find_what_coexists(case: Case) -> None:
    starts = [{"mesh.approach": 1.0}, {"mesh.approach": 0.85, "mesh.approach_rate": 0.2}]
    found = bifurcation(case, "speed", [0.74, 0.95], [CHANNEL], starts=starts, count=16)
    assert found.branches == ("start 1", "start 2")
    alone = bifurcation(case, "speed", [0.95], [CHANNEL], count=16)
    assert found.branch("start 2")[-1].points[-1] == pytest.approx(alone.columns[0].points[-1], abs=1e-5)
    assert found.coexisting().tolist() == [0.74]


def test_a_column_that_does_not_settle_says_so() -> None:
    undamped = Case(oscillator(zeta=0.0), end=1.0, tolerance=1e-6, start={"mesh.approach": 1.5})
    found = bifurcation(undamped, "mesh.damping_coefficient", [0.0, 0.4], [CHANNEL], count=16, transient=20)
    loose, damped = found.columns
    assert (loose.settled, loose.period, damped.settled, damped.period) == (False, 0, True, 1)
    assert loose.transient == 20
    assert loose.residual > 1e-2
    assert "1 of 2 columns did not come to stand still" in str(found)


def test_further_parameters_follow(case: Case) -> None:
    found = bifurcation(case, "speed", [1.6], [CHANNEL], also=lambda speed: {"mesh.error_amplitude": 0.05 / speed**2}, count=16)
    assert np.ptp(found.columns[0].sequence) < np.inf
    answer = 1.1 + (0.05 / complex(1 - 1.6**2, 0.16)).real
    assert found.columns[0].points[-1, 0] == pytest.approx(answer, abs=1e-5)


def test_a_run_that_fails_is_a_column(case: Case) -> None:
    from modelgen.solvers.problem import Budget

    short = case.change(options={"budget": Budget(max_steps=50)})
    found = bifurcation(short, "speed", [0.7, 0.8], [CHANNEL], count=16)
    assert [column.settled for column in found.columns] == [False, False]
    assert "budget of 50 steps" in found.columns[0].message


def test_refusals(case: Case) -> None:
    with pytest.raises(NamingError, match="'sped': is not known; nearest is 'speed'"):
        bifurcation(case, "sped", [1.0])
    with pytest.raises(CaseError, match="no values"):
        bifurcation(case, "speed", [])
    with pytest.raises(CaseError, match="direction"):
        bifurcation(case, "speed", [1.0], direction="upward")
    with pytest.raises(CaseError, match='leave them out, or take "independent"'):
        bifurcation(case, "speed", [1.0, 1.1], direction="forward", starts=["zero"])
    with pytest.raises(CaseError, match="starts: has 'middle'"):
        bifurcation(case, "speed", [1.0], starts=["middle"])
    with pytest.raises(CaseError, match="is a series"):
        bifurcation(case, "mesh.stiffness_cosine", [1.0])


@pytest.fixture(scope="module")
def swept(case: Case) -> FrequencySweepResult:
    return frequency_sweep(case, [0.68, 0.72, 0.76, 0.80, 0.84, 0.9, 1.0, 1.2, 1.38, 1.44, 1.5], transient=600)


def test_onset_of_tooth_separation(swept: FrequencySweepResult) -> None:
    at = {(each.direction, each.kind): each.frequency * TURN for each in swept.changes}
    assert at["forward", "parts"] == pytest.approx(PARTS, rel=1e-3)
    assert at["forward", "joins"] == pytest.approx(JOINS, rel=1e-3)
    assert at["backward", "parts"] == pytest.approx(JOINS, rel=1e-3)
    low = [point.separated for point in swept.forward if point.speed < PARTS]
    assert low == [0.0] * len(low)


def test_rms_is_that_of_the_linear_branch(swept: FrequencySweepResult) -> None:
    for point in swept.forward:
        if point.speed < PARTS or point.speed > JOINS:
            w = point.speed
            # The approach is the deflection and the error together.
            size = abs(0.05 * w * w / complex(1 - w * w, 0.1 * w) + 0.05)
            assert point.rms[0] == pytest.approx(size / np.sqrt(2), rel=1e-4)


def test_jumps_hold_under_halved_steps(case: Case, swept: FrequencySweepResult) -> None:
    assert [jump.direction for jump in swept.jumps] == ["forward", "backward"]
    speeds = [0.68, 0.70, 0.72, 0.78, 0.82, 0.84]
    for step in (0.1, 0.05):
        found = frequency_sweep(case.change(options={"largest_step": step}), speeds, transient=600)
        for jump, again in zip(swept.jumps, found.jumps, strict=True):
            assert again.frequency == pytest.approx(jump.frequency, rel=1e-3)
    up, down = (jump.frequency * TURN for jump in swept.jumps)
    assert PARTS < up < 0.84
    assert 0.68 < down < 0.72
    assert "jumps: forward at 0.1318" in str(swept)


def test_sweeps_that_cannot_be(case: Case) -> None:
    with pytest.raises(CaseError, match="at least three"):
        frequency_sweep(case, [1.0, 1.1])
    with pytest.raises(CaseError, match="has no gear pair 'mash'; nearest is 'mesh'"):
        frequency_sweep(case, [1.0, 1.1, 1.2], "mash")
    with pytest.raises(CaseError, match="such as 1e-4"):
        frequency_sweep(case, [1.0, 1.1, 1.2], close=0.5)
    alone = Case(Driveline("alone", speed=1.0, reference="a", elements=[Inertia("a", inertia=1.0)]), end=1.0)
    with pytest.raises(CaseError, match="no elastic gear pair"):
        frequency_sweep(alone, [1.0, 1.1, 1.2])
