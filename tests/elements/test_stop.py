"""Stops: Newton's impact law at the hard one, spring and damper beyond the clearance of the elastic one."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.elements import ElasticStop, HardStop, Inertia
from modelgen.equations import assemble
from modelgen.errors import CaseError, ModelError
from modelgen.lowering import lower
from modelgen.model import Driveline
from modelgen.solvers import Case, simulate

DISKS = (Inertia("disk", inertia=2.0), Inertia("far", inertia=3.0))


def compiled(stop, speed=50.0):
    return lower(assemble(Driveline("stopped", [*DISKS, stop], speed=speed, reference="disk")))


@pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
def test_a_hard_stop_turns_the_relative_speed_round_and_keeps_momentum(restitution):
    model = compiled(HardStop("stop", "disk", "far", clearance=0.1, restitution=restitution))
    switched, p = model.switched(), model.parameters.vector()
    x = np.array([0.02, 0.1, 0.4, 0.7])
    assert model.states == ("disk.angle_deviation", "stop.twist", "disk.angle_deviation_rate", "stop.twist_rate")
    resets = np.asarray(switched.switching.resets(0.0, x, switched.extended(p)))
    before = model.evaluate(0.0, x, p)
    for after in resets.T:
        now = model.evaluate(0.0, after, p)
        assert now["stop.twist_rate"] == pytest.approx(-restitution * 0.7, abs=1e-15)
        momentum = [2 * each["disk.speed"] + 3 * each["far.speed"] for each in (before, now)]
        assert momentum[1] == pytest.approx(momentum[0], rel=1e-14)
        assert after[:2].tolist() == x[:2].tolist()
        # Carnot: what is lost is the relative energy times 1 - e^2, with the reduced inertia.
        lost = before["total.kinetic_energy"] - now["total.kinetic_energy"]
        assert lost == pytest.approx((1 - restitution**2) * 1.2 * 0.7**2 / 2, abs=1e-9)


def test_a_hard_stop_is_met_from_within():
    model = compiled(HardStop("stop", "disk", "far", clearance=0.1))
    switched = model.switched()
    assert [(each.name, each.direction, each.variable) for each in switched.switching.crossings] == [
        ("stop.upper", 1, None),
        ("stop.lower", -1, None),
    ]
    for twist, signs in ((0.0, [-1, 1]), (0.11, [1, 1]), (-0.11, [-1, -1])):
        guards = switched.switching.guards(0.0, [0.0, twist, 0.0, 0.0], switched.extended(model.parameters.vector()))
        assert np.sign(np.asarray(guards).ravel()).tolist() == signs


def test_no_run_starts_beyond_a_hard_stop():
    model = compiled(HardStop("stop", "disk", "far", clearance=0.1))
    for twist in (0.1, -0.1, 0.1 + 1e-15):
        assert simulate(Case(model, end=0.1, start={"stop.twist": twist})).succeeded
    for twist, name in ((0.11, "upper"), (-0.11, "lower")):
        with pytest.raises(
            CaseError, match=rf"case of 'stopped', start: lies 0\.01 beyond 'stop\.{name}'; start on the near side"
        ):
            simulate(Case(model, end=0.1, start={"stop.twist": twist}))


@pytest.mark.parametrize(
    ("twist", "side", "torque"),
    [(0.0, 0, 0.0), (0.09, 0, 0.0), (0.12, 1, 50 * 0.02 + 3 * 0.7), (-0.15, 2, -50 * 0.05 + 3 * 0.7)],
)
def test_an_elastic_stop(twist, side, torque):
    model = compiled(ElasticStop("stop", "disk", "far", clearance=0.1, stiffness=50.0, damping_coefficient=3.0))
    now = model.evaluate(0.0, [0.0, twist, 0.0, 0.7], model.parameters.vector())
    assert now["stop.side"] == side
    assert now["stop.torque"] == pytest.approx(torque, abs=1e-14)
    assert now["far.acceleration"] == pytest.approx(torque / 3, abs=1e-14)
    assert now["stop.dissipated_power"] == pytest.approx(3 * 0.7**2 if side else 0.0, abs=1e-14)
    assert model.switching.jumps


@pytest.mark.parametrize(
    ("stop", "given", "words"),
    [
        (HardStop, {"clearance": 0.0}, "clearance"),
        (HardStop, {"clearance": 0.1, "restitution": 1.1}, "restitution"),
        (HardStop, {"clearance": 0.1, "restitution": -0.1}, "restitution"),
        (ElasticStop, {"clearance": -0.1, "stiffness": 1.0}, "clearance"),
        (ElasticStop, {"clearance": 0.1}, "stiffness is missing"),
    ],
)
def test_wrong_values_are_refused(stop, given, words):
    with pytest.raises(ModelError, match=words):
        stop("stop", "disk", "far", **given)
