"""Evidence on motions whose kind is known: two disks on a shaft, damped and not, and points that fall into known groups."""

from __future__ import annotations

import math

import numpy as np
import pytest

from modelgen.analysis.classification.groups import groups
from modelgen.analysis.classification.motion_evidence import ENERGY, REACHED, MotionEvidence, motion_evidence
from modelgen.elements import HarmonicTorque, Inertia, Shaft
from modelgen.equations import assemble
from modelgen.errors import CaseError
from modelgen.lowering import lower
from modelgen.model import Driveline
from modelgen.solvers import Case

STIFFNESS, DAMPING, MASSES = 3e5, 20.0, (3.0, 1.0)
REDUCED = 1 / (1 / MASSES[0] + 1 / MASSES[1])
PERIOD = 1 / 60


@pytest.fixture(scope="module")
def found() -> list[MotionEvidence]:
    line = Driveline(
        "two-disks",
        speed="1200 rpm",
        reference="engine",
        elements=[
            Inertia("engine", inertia=MASSES[0]),
            Inertia("load", inertia=MASSES[1]),
            Shaft("shaft", "engine", "load", stiffness=STIFFNESS, damping="value", damping_coefficient=DAMPING),
            HarmonicTorque("shaking", "engine", cosine=[40.0, 10.0], base="firing"),
        ],
        bases={"firing": ("engine", 3)},
    )
    settings = [{"shaft.damping_coefficient": 0.0}, {"shaft.damping_coefficient": DAMPING}]
    case = Case(lower(assemble(line)), end=1.0)
    return motion_evidence(case, settings, ["shaft.twist"], count=120, transient=80, revolutions=60)


def test_a_damped_motion_is_proven_from_every_start(found: list[MotionEvidence]) -> None:
    damped = found[1]
    assert [each.name for each in damped.verdicts] == ["period 1", "period 1"]
    assert damped.orbit is not None
    assert damped.orbit.proven
    assert max(damped.away) < REACHED
    rate = DAMPING / (2 * REDUCED)
    assert np.abs(damped.orbit.multipliers) == pytest.approx([math.exp(-rate * PERIOD)] * 2, abs=1e-9)
    assert damped.exponents is not None
    assert damped.exponents.complete
    assert damped.exponents.exponents.sum() == pytest.approx(-2 * rate, rel=1e-6)
    assert (damped.undamped, damped.groups("shaft.twist"), damped.period) == (False, (1, 1), pytest.approx(PERIOD))
    assert damped.spread("shaft.twist") == pytest.approx((0.0, 0.0), abs=1e-8)
    assert damped.swing("shaft.twist")[0] == pytest.approx(damped.swing("shaft.twist")[1], rel=1e-4)
    assert min(damped.dissipated()) > 0


def test_an_undamped_motion_keeps_its_start_and_its_energy(found: list[MotionEvidence]) -> None:
    free = found[0]
    assert free.undamped
    assert all(each.conservative and each.name != "chaotic" for each in free.verdicts)
    # Shooting begins at the damped orbit; its undamped neighbor exists, neither attracting nor repelling.
    assert free.orbit is not None
    assert (free.orbit.found, free.orbit.stability) == (True, "undecided")
    assert min(free.away) > 10 * REACHED
    assert free.dissipated() == (0.0, 0.0)
    assert free.exponents is not None
    assert free.exponents.sign != "positive"
    assert free.sections[0].channels[-2] == ENERGY
    for first, second in free.stored():
        assert second == pytest.approx(first, rel=0.2)
    assert min(free.spread("shaft.twist")) > 0


def test_nothing_to_ask(found: list[MotionEvidence]) -> None:
    with pytest.raises(CaseError, match="no starts or no settings"):
        motion_evidence(found[0].case, [])


def test_groups_of_points() -> None:
    rng = np.random.default_rng(3)
    cloud = rng.normal(size=(150, 2))
    centers = np.array([[0.0, 0.0], [40.0, 0.0], [0.0, 40.0]])
    three = np.concatenate([center + cloud for center in centers])
    assert (groups(cloud), groups(three)) == (1, 3)
    assert groups(np.concatenate([cloud, [[60.0, 60.0]]])) == 1  # a straggler makes no group
    assert groups(np.array([[0.0, 0.0], [1.0, 1.0]]), fewest=1) == 2
    assert groups(np.array([[0.0, 0.0], [1e-9, 1e-9]]), closeness=1e-6, fewest=1) == 1
