"""``paper.md``: verdicts are computed from the angles, and say what cannot be decided."""

from __future__ import annotations

from dataclasses import replace

import pytest

from modelgen.analysis.time_domain.angles import AnglesResult, InertiaAngles, Swing
from modelgen.analysis.time_domain.window import Window
from modelgen.drivelines.claims import claims_of
from modelgen.reports.paper import DEFINITIONS, Reading, in_degrees, judge

CLAIMS = claims_of("fracturing-truck")
WINDOW = Window(0.0, 8.0, 8, "pump_crank", 1.0, True)


def reading(**degrees: float) -> Reading:
    """All angles of an inertia equal, in degrees."""
    swing = {name: Swing(value / 57.29577951308232, value / 57.29577951308232) for name, value in degrees.items()}
    inertias = {name: InertiaAngles(each, each, 1.0) for name, each in swing.items()}
    return Reading("per_shaft", "corrected", in_degrees(AnglesResult("truck", WINDOW, inertias, {}, {})))


def verdicts(*runs: Reading) -> dict[str, str]:
    assert CLAIMS is not None
    return {row.claim: row.verdict for row in judge(CLAIMS, list(runs))}


def test_the_order_of_places_is_judged_by_the_angles() -> None:
    same = verdicts(reading(flywheel=0.6, pump_free_end=0.5, damper=0.4))
    other = verdicts(reading(flywheel=0.6, pump_free_end=0.4, damper=0.5))
    assert same["where it is largest"] == f"holds under {len(DEFINITIONS)} of {len(DEFINITIONS)} definitions and readings"
    assert other["where it is largest"] == "does not hold"


def test_the_limit_is_judged_in_every_reading() -> None:
    over, under = reading(flywheel=0.6, pump_free_end=0.1), reading(flywheel=0.4, pump_free_end=0.1)
    claim = "the limit of 0.5° is exceeded"
    assert [verdicts(*runs)[claim] for runs in ((over,), (over, under), (under,))] == ["holds", "holds in part", "does not hold"]


def test_what_rests_on_unpublished_data_cannot_be_decided() -> None:
    found = verdicts(reading(flywheel=0.5863, pump_free_end=0.4))
    assert found["largest torsional angle"] == found["difference to a multibody model"] == "cannot be decided"


def test_degrees_are_referred_by_the_speed_ratio() -> None:
    angles = AnglesResult("truck", WINDOW, {"pump": InertiaAngles(Swing(0.1, 0.05), Swing(0.02, 0.01), 0.5)}, {}, {})
    found = in_degrees(angles)
    assert found["vibration angle, referred, 0-peak"]["pump"] == pytest.approx(
        2 * found["vibration angle, physical, 0-peak"]["pump"]
    )
    assert found["elastic angle, physical, half p-p"]["pump"] == pytest.approx(0.5729578)


def test_only_the_truck_of_the_paper_has_claims() -> None:
    assert claims_of("fracturing-truck-idle") is None
    assert CLAIMS is not None
    assert replace(CLAIMS, limit_deg=1.0).roles["engine_output"] == "flywheel"
