"""Common periods, strobes and sections: against closed forms, and refusals by their words."""

from __future__ import annotations

from fractions import Fraction
from math import atan2, hypot, pi

import numpy as np
import pytest

from modelgen.analysis.nonlinear.common_period import strobe_of
from modelgen.analysis.nonlinear.motion import motion_of, vibrating_states
from modelgen.analysis.nonlinear.sections import poincare
from modelgen.analysis.nonlinear.strobes import Patience
from modelgen.analysis.nonlinear.surface import surface_section
from modelgen.drivelines import load
from modelgen.elements import GroundSpring, HarmonicTorque, Inertia, Shaft, SteppedTorque
from modelgen.equations import assemble
from modelgen.errors import CaseError
from modelgen.lowering import Compiled, lower
from modelgen.model import Driveline
from modelgen.solvers import Case, operating_point

from .gear_pair_oscillator import MEAN, SHAKING, ZETA, oscillator


def two_disks(*extra: object, damping: float = 0.0) -> Driveline:
    """Two disks that swing against each other with 1 rad/s."""
    shaft = Shaft("shaft", "a", "b", stiffness=0.5, damping="value", damping_coefficient=damping)
    return Driveline(
        "disks",
        speed=2.0,
        reference="a",
        bases={"one": 1, "third": Fraction(1, 3)},
        elements=[Inertia("a", inertia=1.0), Inertia("b", inertia=1.0), shaft, *extra],  # type: ignore[list-item]
    )


def compiled(line: Driveline) -> Compiled:
    return lower(assemble(line))


def test_the_common_period_is_exact() -> None:
    model = compiled(load("fracturing-truck-commensurate"))
    found = strobe_of(model, operating_point(model))
    assert {name: int(count) for name, count in found.cycles.items()} == {
        "engine_half_order": 6,
        "pump_crank": 1,
        "transmission_mesh.contact": 288,
        "pump_mesh.contact": 108,
    }
    assert found.complete
    assert found.turns == 12
    assert found.period == pytest.approx(12 * 60 / 1900, rel=1e-15)


def test_a_long_common_period_is_explained() -> None:
    model = compiled(load("fracturing-truck"))
    point = operating_point(model)
    with pytest.raises(CaseError, match=r"only after 2484 turns .*78\.44 s.*never one point.*base='pump_crank'.*after 46 turns"):
        strobe_of(model, point)
    found = strobe_of(model, point, base="pump_crank")
    assert not found.complete
    assert found.cycles["pump_mesh.contact"] == 108
    with pytest.raises(CaseError, match="nearest is 'pump_crank'"):
        strobe_of(model, point, base="pump_cranc")


def test_only_bases_that_something_runs_on_count() -> None:
    model = compiled(two_disks(HarmonicTorque("shake", "a", base="one", sine=[1.0])))
    assert dict(strobe_of(model, operating_point(model)).cycles) == {"one": 1}
    model = compiled(two_disks(*(HarmonicTorque(f"shake_{base}", "a", base=base, sine=[1.0]) for base in ("one", "third"))))
    assert strobe_of(model, operating_point(model)).turns == 3


def test_nothing_to_strobe_at() -> None:
    model = compiled(two_disks())
    with pytest.raises(CaseError, match="cut by a surface"):
        strobe_of(model, operating_point(model))
    model = compiled(two_disks(SteppedTorque("step", "a", after=1.0, at=1.0), SteppedTorque("back", "b", after=-1.0, at=1.0)))
    with pytest.raises(CaseError, match=r"quantity 'step\.torque' depends on time itself"):
        strobe_of(model, operating_point(model))


def test_rolling_is_no_vibration() -> None:
    free = compiled(two_disks())
    assert [free.states[k] for k in vibrating_states(free, operating_point(free))] == ["shaft.twist", "shaft.twist_rate"]
    held = compiled(two_disks(GroundSpring("seat", "a", stiffness=1.0)))
    assert len(vibrating_states(held, operating_point(held))) == 4
    with pytest.raises(CaseError, match=r"holds the rolling .*take a\.elastic_angle"):
        poincare(Case(free, end=1.0), ["a.angle_deviation"])


def test_the_rate_of_a_channel_is_exact() -> None:
    model = compiled(oscillator())
    point = operating_point(model)
    state, h = point.start + 0.1, 1e-6
    times = np.array([0.3 - h, 0.3, 0.3 + h])
    moved = np.array([state + model.rhs(0.3, state, point.p) * (t - 0.3) for t in times])
    values, rates = motion_of(model, times, moved, point.p, ["mesh.error", "mesh.force"])
    assert rates[1] == pytest.approx((values[2] - values[0]) / (2 * h), rel=1e-6)
    assert rates[1, 0] == pytest.approx(-SHAKING * np.sin(0.3), rel=1e-12)


def test_one_point_where_the_linear_response_stands() -> None:
    """Above the teeth's separation the motion is x = 1 + F_m + Re A e^(i w t), A = F_ah w^2 / (1 - w^2 + 2 i zeta w)."""
    w = 1.6
    found = poincare(
        Case(oscillator(speed=w), end=1.0, tolerance=1e-9), ["mesh.deflection", "mesh.approach"], count=16, still=1e-8
    )
    real, imaginary = 1 - w * w, 2 * ZETA * w
    size, phase = SHAKING * w * w / hypot(real, imaginary), -atan2(imaginary, real)
    assert (found.period, found.settled, found.complete) == (1, True, True)
    assert found.values[-1, 0] == pytest.approx(1 + MEAN + size * np.cos(phase), abs=1e-7)
    assert found.rates[-1, 0] == pytest.approx(-w * size * np.sin(phase), abs=1e-7)
    assert found.orbit_values[:, 0].max() == pytest.approx(1 + MEAN + size, abs=1e-5)
    assert found.orbit_values[0] == pytest.approx(found.orbit_values[-1], abs=1e-7)
    assert "16 points" in str(found)


def test_an_undamped_motion_does_not_come_to_rest() -> None:
    shaken = two_disks(HarmonicTorque("shake", "a", base="one", sine=[0.1]))
    found = poincare(Case(shaken, end=1.0, start={"shaft.twist": 1.0}), ["shaft.twist"], count=20, transient=40)
    # The own frequency is 1 rad/s, the strobe at 2 rad/s: the free vibration repeats every second strobe.
    assert found.period == 2
    assert found.values[0, 0] - found.values[1, 0] == pytest.approx(found.values[2, 0] - found.values[1, 0], rel=1e-3)


def test_a_strobe_at_one_of_two_bases_shows_a_curve() -> None:
    two = (HarmonicTorque(f"shake_{base}", "a", base=base, sine=[0.1]) for base in ("one", "third"))
    case = Case(two_disks(*two, damping=0.2), end=1.0, tolerance=1e-8)
    whole = poincare(case, ["shaft.twist"], count=16)
    assert whole.period == 1
    part = poincare(case, ["shaft.twist"], count=48, transient=100, base="one")
    assert not part.complete
    assert part.period == 3  # three points of the curve, because 3 turns bring both together again
    assert np.diff(part.times) == pytest.approx(pi, rel=1e-9)


def test_crossings_of_a_free_vibration() -> None:
    """twist = cos t passes zero upward at 3 pi/2 + 2 pi k with the rate 1."""
    case = Case(two_disks(), end=40.0, tolerance=1e-10, start={"shaft.twist": 1.0})
    found = surface_section(case, ("shaft.twist", 0.0), ["shaft.twist"], count=16)
    assert found.times == pytest.approx(1.5 * pi + 2 * pi * np.arange(6), rel=1e-10)
    assert found.values[:, 0] == pytest.approx(0.0, abs=1e-11)
    assert found.rates[:, 0] == pytest.approx(1.0, rel=1e-8)
    both = surface_section(case, ("shaft.twist", 0.0), direction=0, count=16)
    assert np.diff(both.times) == pytest.approx(pi, rel=1e-9)
    with pytest.raises(CaseError, match=r"passes 2 rad upward 0 times up to 40 s; choose a level within its range"):
        surface_section(case, ("shaft.twist", 2.0))


def test_crossings_closer_than_any_sample_are_found() -> None:
    """twist = cos t is above 1 - 1e-8 for 0.28 ms around every whole turn of 6.3 s."""
    level, half = 1 - 1e-8, np.arccos(1 - 1e-8)
    case = Case(two_disks(), end=20.0, tolerance=1e-11, start={"shaft.twist": 1.0}, samples=11)
    found = surface_section(case, ("shaft.twist", level), ["shaft.twist"], direction=0, count=16)
    wanted = np.sort([half, *(2 * pi * k + side * half for k in (1, 2, 3) for side in (-1, 1))])
    assert found.times == pytest.approx(wanted, abs=2e-5)
    assert found.values[:, 0] == pytest.approx(level, abs=1e-12)


def test_a_section_counts_from_where_the_record_begins() -> None:
    case = Case(two_disks(), end=40.0, record_from=5.0, tolerance=1e-10, start={"shaft.twist": 1.0})
    found = surface_section(case, ("shaft.twist", 0.0), ["shaft.twist"], direction=-1, count=16)
    assert found.times == pytest.approx(0.5 * pi + 2 * pi * np.arange(1, 7), rel=1e-10)
    assert found.orbit_values[0, 0] == pytest.approx(0.0, abs=1e-9)
    assert found.orbit_values.max() == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize(
    ("surface", "direction", "words"),
    [
        ("shaft.twist", 1, r"give \(channel, level\)"),
        (("shaft.twist", float("nan")), 1, "has the level nan; give a finite number"),
        (("shaft.twist", "0.1"), 1, "has the level '0.1'"),
        (("shaft.twst", 0.0), 1, "nearest is 'shaft.twist'"),
        (("shaft.twist", 0.0), 2, "is 2; give 1"),
    ],
)
def test_surfaces_that_cannot_be(surface: object, direction: int, words: str) -> None:
    with pytest.raises(CaseError, match=words):
        surface_section(Case(two_disks(), end=4.0), surface, direction=direction)  # type: ignore[arg-type]


def test_a_section_needs_a_solver_that_locates_events() -> None:
    with pytest.raises(CaseError, match="solver 'cvodes' does not locate events, which the sections of the case need; take rk4"):
        surface_section(Case(two_disks(), end=4.0, solver="cvodes"), ("shaft.twist", 0.0))


@pytest.mark.parametrize(
    ("options", "words"),
    [({"count": 3}, "count: is 3"), ({"transient": -1}, "transient: is -1"), ({"still": 2.0}, "share of the states' scales")],
)
def test_wrong_patience(options: dict[str, float], words: str) -> None:
    with pytest.raises(CaseError, match=words):
        Patience(**options)  # type: ignore[arg-type]


def test_wrong_sections() -> None:
    case = Case(two_disks(), end=1.0)
    with pytest.raises(CaseError, match="asked of int; give a Driveline"):
        poincare(3)  # type: ignore[arg-type]
    with pytest.raises(CaseError, match="no output"):
        poincare(case, ["shaft.twisst"])
    with pytest.raises(CaseError, match="give 1 "):
        surface_section(case, ("shaft.twist", 0.0), direction=2)
