"""Applied torques: rows on a base frequency as Eq. 22 writes them, steps and ramps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from modelgen.elements import HarmonicTorque, Inertia, SteppedTorque
from modelgen.equations import assemble
from modelgen.errors import ModelError
from modelgen.lowering import lower
from modelgen.model import Driveline
from modelgen.solvers.bound_model import operating_point

SPEED = 20.0


def compiled(torque, **more):
    return lower(
        assemble(Driveline("disk", [Inertia("disk", inertia=2.0), torque], speed=SPEED, reference="disk", drifts=True, **more))
    )


def torque_at(model, *times, **values):
    p = model.parameters.vector(values)
    return [model.evaluate(t, np.zeros(2), p)["load.torque"] for t in times]


TIMES = (0.0, 0.013, 1.7, 83.1)


def test_rows_are_sines_a_and_cosines_b():
    a, b, mean = (3.0, -1.0, 0.5), (0.2, 4.0, -2.0), 7.0
    model = compiled(HarmonicTorque("load", "disk", mean=mean, sine=a, cosine=b, base="half"), bases={"half": "1/2"})
    for t, found in zip(TIMES, torque_at(model, *TIMES), strict=True):
        angle = SPEED / 2 * t
        rows = sum(a[h - 1] * math.sin(h * angle) + b[h - 1] * math.cos(h * angle) for h in (1, 2, 3))
        assert found == pytest.approx(mean + rows, abs=1e-11)


def test_rows_for_chosen_orders():
    model = compiled(HarmonicTorque("load", "disk", sine=(3.0, 5.0), orders=(2, 7), base="turn"), bases={"turn": 1})
    for t, found in zip(TIMES, torque_at(model, *TIMES), strict=True):
        assert found == pytest.approx(3 * math.sin(2 * SPEED * t) + 5 * math.sin(7 * SPEED * t), abs=1e-11)


def test_phase_is_an_angle_of_the_base_and_scale_a_factor_on_everything():
    a, b = (3.0, -1.0), (0.2, 4.0)
    model = compiled(HarmonicTorque("load", "disk", mean=2.0, sine=a, cosine=b, phase="30 deg", base="turn"), bases={"turn": 1})
    for t, found in zip(TIMES, torque_at(model, *TIMES, **{"load.scale": 1.5, "load.phase": 0.9}), strict=True):
        angle = SPEED * t + 0.9
        rows = sum(a[h - 1] * math.sin(h * angle) + b[h - 1] * math.cos(h * angle) for h in (1, 2))
        assert found == pytest.approx(1.5 * (2.0 + rows), abs=1e-11)


def test_a_constant_torque_needs_no_base_and_no_speed():
    model = lower(assemble(Driveline("disk", [Inertia("disk", inertia=2.0), HarmonicTorque("load", "disk", mean=3.0)])))
    assert model.rhs(0.0, [0.0, 0.0], model.parameters.vector()).tolist() == [0.0, 1.5]


def test_the_mean_is_what_the_operating_point_sees():
    torque = HarmonicTorque("load", "disk", mean=3.0, sine=(50.0,), scale=2.0, base="turn")
    assert operating_point(compiled(torque, bases={"turn": 1})).drift == pytest.approx(2 * 3 / 2)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (
            {"sine": (1.0, 2.0), "cosine": (1.0,)},
            "has 1 cosine and 2 sine rows for 2 orders; give one cosine and one sine per order",
        ),
        ({"sine": (1.0, 2.0), "orders": (1, 2, 3)}, "has 0 cosine and 2 sine rows for 3 orders"),
    ],
)
def test_rows_of_unlike_length(rows, words):
    with pytest.raises(ModelError, match=rf"^harmonic_torque 'load': {words}"):
        compiled(HarmonicTorque("load", "disk", base="turn", **rows), bases={"turn": 1})


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((1, 1), r"orders are \(1, 1\)"),
        ((0,), r"orders are \(0,\)"),
        ((1.5,), r"orders are \(1.5,\)"),
        ((True,), r"orders are \(True,\)"),
        (3, "orders are 3"),
        ("12", "orders are '12'"),
        ((1001,), r"orders are \(1001,\)"),
    ],
)
def test_unlawful_orders(given, words):
    with pytest.raises(ModelError, match=f"^harmonic_torque 'load': {words}; give different whole numbers from 1 to 1000"):
        HarmonicTorque("load", "disk", sine=(1.0,), orders=given, base="turn")


def test_step_at_a_given_time():
    model = compiled(SteppedTorque("load", "disk", before=1.0, after=5.0, at=0.5))
    assert torque_at(model, 0.0, 0.499999, 0.5, 3.0) == [1.0, 1.0, 5.0, 5.0]


def test_ramp_in_a_straight_line():
    model = compiled(SteppedTorque("load", "disk", shape="ramp", before=1.0, after=5.0, at=0.5, duration=2.0))
    assert torque_at(model, 0.0, 0.5, 1.0, 1.5, 2.5, 9.0) == pytest.approx([1.0, 1.0, 2.0, 3.0, 5.0, 5.0], abs=1e-14)


def test_the_static_start_sees_the_torque_before_the_step():
    assert operating_point(compiled(SteppedTorque("load", "disk", before=1.0, after=5.0))).drift == pytest.approx(0.5)
