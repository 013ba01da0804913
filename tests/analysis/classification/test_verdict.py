"""Verdicts on maps whose motion is known, and on evidence that agrees, decides or contradicts."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray

from modelgen.analysis.classification.sequence_tests import drift, line_share, zero_one
from modelgen.analysis.classification.verdict import classify
from modelgen.errors import CaseError

Array = NDArray[np.float64]


def logistic(r: float, count: int = 400) -> Array:
    """x -> r x (1 - x) after a long transient."""
    x, found = 0.4, []
    for k in range(5000 + count):
        x = r * x * (1 - x)
        if k >= 5000:
            found.append(x)
    return np.array(found)


def henon(count: int) -> Array:
    x, y, found = 0.1, 0.1, []
    for k in range(1000 + count):
        x, y = 1 - 1.4 * x * x + y, 0.3 * x
        if k >= 1000:
            found.append((x, y))
    return np.array(found)


def turning(count: int = 400, share: float = (5**0.5 - 1) / 2) -> Array:
    """A rotation by an irrational share of a turn, on a bent circle."""
    a = 2 * np.pi * share * np.arange(count)
    return np.column_stack([np.cos(a), np.sin(a) + 0.3 * np.cos(2 * a)])


# Doublings at r = 3, 1 + sqrt 6 = 3.4495, 3.5441, 3.5644, 3.5688; the window of period 3 begins at 1 + sqrt 8 = 3.8284.
@pytest.mark.parametrize(
    ("r", "period"),
    [(2.9, 1), (3.2, 2), (3.44, 2), (3.46, 4), (3.54, 4), (3.55, 8), (3.566, 16), (3.569, 32), (3.84, 3), (3.845, 6)],
)
def test_period_doublings_of_the_logistic_map(r: float, period: int) -> None:
    verdict = classify(logistic(r))
    assert (verdict.kind, verdict.period, verdict.name) == ("periodic", period, f"period {period}")
    assert [each.source for each in verdict.evidence if each.decided] == ["section"]


@pytest.mark.parametrize("r", [3.9, 3.95, 4.0])
def test_the_chaotic_logistic_map(r: float) -> None:
    verdict = classify(logistic(r))
    assert verdict.kind == "chaotic"
    assert {each.source for each in verdict.evidence if each.decided} == {"0-1 test", "spectrum"}


def test_chaos_of_henon_and_a_quasi_periodic_rotation() -> None:
    assert classify(henon(400)).name == "chaotic"
    assert classify(turning()).name == "quasi-periodic"
    assert zero_one(henon(400)) > 0.9 > 0.2 > zero_one(turning())
    assert line_share(turning()) > 0.95 > 0.75 > line_share(henon(400))


def test_too_few_points_are_undecided() -> None:
    verdict = classify(henon(60))
    assert verdict.name == "undecided"
    assert "too few for spectrum and 0-1 test" in str(verdict)


def test_a_decay_is_undecided_and_no_cloud() -> None:
    k = np.arange(150)
    decay = np.exp(-k / 200)[:, None] * turning(150)
    verdict = classify(decay)
    assert verdict.name == "undecided"
    assert "still changes" in str(verdict)
    assert drift(turning(), 1e-6) == 0.0


def test_noise_about_a_point_is_no_chaos() -> None:
    rng = np.random.default_rng(1)
    verdict = classify(1 + 1e-5 * rng.normal(size=(200, 2)))
    assert verdict.name == "undecided"
    assert "almost come back" in str(verdict)


def test_two_bands_of_chaos_are_not_called_quasi_periodic() -> None:
    assert classify(logistic(3.6)).name == "undecided"


@dataclass
class Exponents:
    sign: str
    exponents: Array = field(default_factory=lambda: np.array([0.3, -1.0]))
    half_width: Array = field(default_factory=lambda: np.array([0.1, 0.1]))
    flow: int | None = None


@dataclass
class Orbit:
    order: int
    proven: bool
    verdict: str = "as shooting found it"


def test_a_proof_comes_first() -> None:
    verdict = classify(logistic(3.2), orbit=Orbit(2, True), exponents=Exponents("negative"))
    assert verdict.name == "period 2"
    assert [each.source for each in verdict.evidence if each.decided] == ["orbit"]


def test_evidence_that_contradicts_decides_nothing() -> None:
    assert classify(logistic(3.2), exponents=Exponents("positive")).name == "undecided"
    assert classify(logistic(3.2), orbit=Orbit(4, True)).name == "undecided"
    assert classify(henon(400), orbit=Orbit(1, True)).name == "undecided"
    assert classify(henon(400), exponents=Exponents("negative")).name == "undecided"
    assert classify(turning(), exponents=Exponents("positive")).name == "undecided"


def test_exponents_and_spectrum_decide_together() -> None:
    verdict = classify(logistic(3.6), exponents=Exponents("positive"))
    assert verdict.name == "undecided"  # its spectrum has few lines
    verdict = classify(logistic(3.9), exponents=Exponents("positive"))
    assert {each.source for each in verdict.evidence if each.decided} == {"0-1 test", "spectrum", "exponents"}
    assert "largest 0.3 +- 0.1 1/s" in str(verdict)


def test_an_incomplete_strobe_shows_no_quasi_periodicity() -> None:
    assert classify(turning(), complete=False).name == "undecided"


def test_without_damping_there_is_no_attractor() -> None:
    assert "no attractor" in str(classify(henon(400), conservative=True))
    assert "no attractor" not in str(classify(henon(400)))


@pytest.mark.parametrize(
    ("points", "words"), [(np.zeros((15, 2)), "at least 16"), (np.zeros((20, 0)), "shape"), (np.full(20, np.nan), "not finite")]
)
def test_wrong_points(points: Array, words: str) -> None:
    with pytest.raises(CaseError, match=words):
        classify(points)
    with pytest.raises(CaseError, match="positive share"):
        classify(np.zeros(20), tolerance=0.0)


@dataclass
class Unsteady(Exponents):
    stationary: bool = False
    transient_chaos: bool = True
    beside: str = ""
    remarks: tuple[str, ...] = ("not stationary: 30 s of transient, then period 2 proven",)


def test_chaos_that_ends_is_transient() -> None:
    ends = np.concatenate([logistic(3.9, 300), logistic(3.2, 300)])
    verdict = classify(ends)
    assert (verdict.kind, verdict.period, verdict.name) == ("transient chaos", 2, "transient chaos, then period 2")
    assert "300 points wander" in str(verdict)
    assert classify(logistic(3.2)).kind == "periodic"
    late = classify(logistic(3.2), exponents=Unsteady("negative"))
    assert (late.kind, late.period) == ("transient chaos", 2)
    assert [each.source for each in late.evidence if each.decided] == ["exponents"]
    assert "30 s of transient" in str(late)


def test_a_stable_orbit_beside_what_looks_like_chaos_leaves_it_undecided() -> None:
    beside = Unsteady("undecided", stationary=True, transient_chaos=False, beside="a stable orbit, period 2 proven")
    verdict = classify(logistic(3.9), exponents=beside)
    assert verdict.name == "undecided"
    assert "a stable orbit, period 2 proven" in str(verdict)
