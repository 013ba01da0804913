"""What must not matter: the angle that the whole line has turned by, and the order in which its elements are written."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from modelgen.drivelines import load
from modelgen.elements import GearPair, GroundDamper, HarmonicTorque, Inertia, RigidGear, Shaft
from modelgen.equations import assemble
from modelgen.lowering import lower
from modelgen.model import Driveline


@pytest.mark.parametrize("turn", [1.0, -37.5, 1e6])
def test_turning_the_line_changes_nothing(bench, turn):
    model = bench.model
    for t, x in bench.states(3):
        turned = x.copy()
        turned[list(model.equations.rigid)] += turn
        assert np.array_equal(model.rhs(t, turned, bench.p), model.rhs(t, x, bench.p))


@pytest.fixture(scope="module")
def truck():
    return load("fracturing-truck")


def test_turning_the_truck_changes_nothing(truck):
    model = lower(assemble(truck))
    p = model.parameters.vector()
    assert len(model.equations.rigid) == 1
    x = np.random.default_rng(1).uniform(-1e-3, 1e-3, len(model.states))
    turned = x.copy()
    turned[list(model.equations.rigid)] += 1e6
    assert np.array_equal(model.rhs(0.37, turned, p), model.rhs(0.37, x, p))
    before, after = model.evaluate(0.37, x, p), model.evaluate(0.37, turned, p)
    angles = ("angle", "angle_deviation", "elastic_angle")
    assert all(after[name] == before[name] for name in model.outputs if name.rpartition(".")[2] not in angles)
    assert after["pump_free_end.angle"] - before["pump_free_end.angle"] == pytest.approx(1e6 * 26 / 46 * 17 / 108, rel=1e-12)


def line_of_everything():
    return Driveline(
        "everything",
        [
            Inertia("engine", inertia=2.0),
            Inertia("pinion", inertia=0.1),
            Inertia("wheel", inertia=0.5),
            Inertia("rotor", inertia=1.5),
            Inertia("fan", inertia=0.4),
            Shaft("input", "engine", "pinion", stiffness=900.0, damping_ratio=0.03),
            GearPair(
                "mesh", "pinion", "wheel", teeth_a=20, teeth_b=50, module=0.01, mean_stiffness=4e5, damping_ratio=0.1,
                stiffness_cosine=(3e4, 1e4), half_backlash=2e-4, error_amplitude=1e-4,
            ),
            Shaft("output", "wheel", "rotor", stiffness=700.0, damping_ratio=0.02),
            RigidGear("step_up", "rotor", "fan", teeth_a=31, teeth_b=17),
            GroundDamper("brake", "fan", damping=0.2),
            HarmonicTorque("firing", "engine", mean=20.0, sine=(3.0, 1.0), orders=(1, 3), base="firing_order"),
        ],
        speed=150.0,
        reference="engine",
        bases={"firing_order": ("engine", "1/2")},
    )  # fmt: skip


def physical_state(model, p, now):
    """The state of a model in which its inertias have the angles and speeds of another one's channels."""
    eq = model.equations
    speeds = model.mean_model.ratios_at(p).speed
    named = {node.group: node.name for node in reversed(eq.nodes) if node.ratio == 1}
    angle = [now[f"{named[g]}.angle_deviation"] for g in range(len(eq.groups))]
    speed = [now[f"{named[g]}.speed"] - speeds[g] for g in range(len(eq.groups))]
    return np.asarray(model.mean_model.coordinates(angle, speed, [], p)).ravel()


@pytest.mark.parametrize("make", [line_of_everything, lambda: load("fracturing-truck")], ids=["everything", "truck"])
@pytest.mark.parametrize("seed", [None, 3, 4])
def test_the_order_of_elements_changes_nothing(make, seed):
    line = make()
    elements = list(reversed(line.elements)) if seed is None else list(np.random.default_rng(seed).permutation(line.elements))
    other = replace(line, elements=elements)
    first, second = lower(assemble(line)), lower(assemble(other))
    p, q = first.parameters.vector(), second.parameters.vector()
    x = np.random.default_rng(2).uniform(-1e-3, 1e-3, len(first.states))
    before = first.evaluate(0.37, x, p)
    after = second.evaluate(0.37, physical_state(second, q, before), q)
    assert set(after) == set(before)
    for name, value in before.items():
        # Rounding of a sum of torques much larger than itself shows in the accelerations.
        assert after[name] == pytest.approx(value, rel=1e-9, abs=1e-8), name
