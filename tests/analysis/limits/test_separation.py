"""Separation margins and critical speeds of a line with one known frequency."""

from __future__ import annotations

import pytest

from modelgen import Driveline, Inertia, Shaft, assemble, lower, modal
from modelgen.analysis.limits.check import check_limits
from modelgen.analysis.limits.rulebook import rule
from modelgen.analysis.limits.separation import critical_speed_ratios, separation_margins
from modelgen.analysis.linear.modal import ModalResult
from modelgen.errors import CaseError, UnitError


@pytest.fixture(scope="module")
def result() -> ModalResult:
    """Two disks at 176.0767 Hz (the two-disk test of openTorsion)."""
    elements = (Inertia("a", inertia=211.4), Inertia("b", inertia=8.3), Shaft("s", "a", "b", stiffness=9.775e6))
    return modal(lower(assemble(Driveline("two", elements=elements))))


def test_margins_from_below_from_above_and_inside(result: ModalResult) -> None:
    found = separation_margins(result, {"low": "160 Hz", "high": ("200 Hz", "220 Hz"), "range": (150.0, 180.0)})
    assert found == {
        "mode 1 (176.1 Hz) / low.separation_margin": pytest.approx(176.0767 / 160 - 1, rel=1e-5),
        "mode 1 (176.1 Hz) / high.separation_margin": pytest.approx(1 - 176.0767 / 200, rel=1e-5),
        "mode 1 (176.1 Hz) / range.separation_margin": 0.0,
    }
    verdicts = [row.verdict for row in check_limits(found, "api_617_separation").rows]
    assert verdicts == ["pass", "pass", "fail"]


def test_critical_speeds_per_order(result: ModalResult) -> None:
    found = critical_speed_ratios(result, {"order 6": 6, "order 4.5": 4.5}, "1800 rpm")
    assert found["mode 1 (176.1 Hz) / order 6.critical_speed_ratio"] == pytest.approx(176.0767 / 180, rel=1e-6)
    assert found["mode 1 (176.1 Hz) / order 4.5.critical_speed_ratio"] == pytest.approx(176.0767 / 135, rel=1e-6)
    verdicts = [row.verdict for row in check_limits(found, rule("kr_major_critical_propulsion").given(cylinders=6)).rows]
    assert verdicts == ["fail"]  # order 4.5 is neither n nor n/2


def test_a_rule_is_judged_for_the_modes_and_orders_of_its_text() -> None:
    """Korean Register 2025, Part 5, Ch. 4, 204: orders n and n/2 of the one-node mode (two-stroke engines: n)."""
    disks = [Inertia(name, inertia=1.0) for name in "abc"]
    shafts = [Shaft("s", "a", "b", stiffness=1e5), Shaft("t", "b", "c", stiffness=2e5)]
    modes = modal(lower(assemble(Driveline("three", elements=[*disks, *shafts]))))
    found = critical_speed_ratios(modes, {f"order {order}": order for order in (3, 4.5, 6)}, "1000 rpm")
    assert len(found) == 6
    limit = rule("kr_major_critical_propulsion").given(cylinders=6)
    four = check_limits(found, limit)
    first = f"mode 1 ({modes.frequencies[1]:.4g} Hz) / order"
    assert [row.element for row in four.rows] == [f"{first} 3", f"{first} 6"]
    assert four.remarks == (
        "rule 'kr_major_critical_propulsion' was judged for modes with 1 node and orders 6 and 3 only, of which its text speaks",
    )
    assert [row.element for row in check_limits(found, limit.given(strokes="two_stroke")).rows] == [f"{first} 6"]
    with pytest.raises(CaseError, match=r"speaks of modes with 1 node and orders 5 and 2\.5, of which there is no value"):
        check_limits(found, limit.given(cylinders=5))
    with pytest.raises(CaseError, match="needs cylinders"):
        check_limits(found, "kr_major_critical_propulsion")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (("80 Hz", "70 Hz"), "excitation 'x': runs from 80 to 70 Hz; give the lowest frequency first"),
        ((1.0, 2.0, 3.0), "excitation 'x': is .*; give a frequency, or a lowest and a highest one"),
        (0.0, "excitation 'x': is 0 Hz; give a positive value"),
    ],
)
def test_excitations_are_read_strictly(result: ModalResult, given: object, words: str) -> None:
    with pytest.raises(CaseError, match=words):
        separation_margins(result, {"x": given})


def test_a_speed_is_no_frequency(result: ModalResult) -> None:
    with pytest.raises(UnitError, match="'Hz' is ambiguous for an angular speed"):
        critical_speed_ratios(result, {"once": 1}, "30 Hz")
