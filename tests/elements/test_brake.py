"""Coulomb brake: its torque in every mode, its guards and their signs, and what it sets."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.analysis.linear.modal import modal
from modelgen.elements import Brake, GroundSpring, Inertia
from modelgen.equations import assemble
from modelgen.errors import ModelError
from modelgen.lowering import lower
from modelgen.model import Driveline
from modelgen.solvers.bound_model import operating_point

J, K = 2.0, 8.0
STICK, FORWARD, BACKWARD = range(3)


def compiled(**given):
    brake = Brake("brake", "disk", **{"sliding_torque": 1.0, "holding_torque": 1.5, **given})
    return lower(assemble(Driveline("braked", [Inertia("disk", inertia=J), GroundSpring("wire", "disk", stiffness=K), brake])))


def at(model, angle, speed, mode):
    """Channels, guards by name and states after resets by name, in a mode."""
    switched = model.switched()
    p = switched.extended(model.parameters.vector())
    switched.switching.modes[0].put(p, mode)
    x = [angle, speed]
    outputs = dict(zip(model.outputs, np.asarray(switched.output_function(0.0, x, p)).ravel().tolist(), strict=True))
    guards = np.asarray(switched.switching.guards(0.0, x, p)).ravel()
    columns = np.asarray(switched.switching.resets(0.0, x, p))
    crossings = switched.switching.crossings
    resets = {each.name.split(".")[1]: columns[:, each.reset] for each in crossings if each.reset is not None}
    return outputs, {each.name.split(".")[1]: value for each, value in zip(crossings, guards, strict=True)}, resets


@pytest.mark.parametrize(("mode", "torque"), [(FORWARD, 1.0), (BACKWARD, -1.0)])
def test_sliding(mode, torque):
    outputs, _, _ = at(compiled(), 0.1, 0.3, mode)
    assert outputs["brake.torque"] == torque
    assert outputs["disk.acceleration"] == pytest.approx((-K * 0.1 - torque) / J, rel=1e-14)
    assert outputs["brake.dissipated_power"] == pytest.approx(torque * 0.3)


@pytest.mark.parametrize(("angle", "breaks"), [(0.15, None), (0.2, "break_backward"), (-0.2, "break_forward"), (-0.15, None)])
def test_it_sticks_up_to_the_holding_torque(angle, breaks):
    outputs, guards, _ = at(compiled(), angle, 0.0, STICK)
    assert outputs["brake.torque"] == pytest.approx(-K * angle, rel=1e-14)
    assert outputs["disk.acceleration"] == 0
    beyond = {"break_forward": guards["break_forward"] > 0, "break_backward": guards["break_backward"] < 0}
    assert [name for name, broken in beyond.items() if broken] == ([breaks] if breaks else [])


def test_signs_of_the_guards():
    model = compiled(smallest_slip=1e-6, other_speed=0.3)
    for speed, name, mode, sign in (
        (0.4, "moved_forward", STICK, 1),
        (0.3, "moved_forward", STICK, -1),
        (0.2, "moved_backward", STICK, -1),
        (0.3, "moved_backward", STICK, 1),
        (0.3, "stick_forward", FORWARD, 1),
        (0.3 - 2e-6, "stick_forward", FORWARD, -1),
        (0.3, "stick_backward", BACKWARD, -1),
        (0.3 + 2e-6, "stick_backward", BACKWARD, 1),
    ):
        _, guards, _ = at(model, 0.0, speed, mode)
        assert np.sign(guards[name]) == sign, (speed, name)


def test_sticking_and_breaking_away_begin_at_the_other_sides_speed():
    _, _, resets = at(compiled(other_speed=0.3), 0.1, 0.3 - 1e-9, FORWARD)
    assert set(resets) == {"break_forward", "break_backward", "stick_forward", "stick_backward"}
    for after in resets.values():
        assert after == pytest.approx([0.1, 0.3], rel=1e-15)


def test_without_a_motion_the_mode_is_that_of_the_slip():
    model = compiled(other_speed=0.3)
    p = model.parameters.vector()
    now = {speed: model.evaluate(0.0, [0.1, speed], p) for speed in (0.0, 0.3, 0.5)}
    assert [each["brake.contact"] for each in now.values()] == [BACKWARD, STICK, FORWARD]
    assert [each["brake.torque"] for each in now.values()] == pytest.approx([-1.0, -0.8, 1.0])
    # The moving side puts power in, and what the slip takes of it is heat.
    assert now[0.5]["brake.dissipated_power"] == pytest.approx(0.2)
    assert now[0.5]["total.supplied_power"] == pytest.approx(-0.3)


def test_at_an_operating_speed_it_drags():
    disk = Inertia("disk", inertia=J)
    brake = Brake("brake", "disk", sliding_torque=1.0, holding_torque=1.5)
    model = lower(assemble(Driveline("braked", [disk, brake], speed=10.0, reference="disk", drifts=True)))
    assert operating_point(model).drift == pytest.approx(-1.0 / J)


@pytest.mark.parametrize("name", ["sliding_torque", "holding_torque", "smallest_slip"])
def test_wrong_values_are_refused(name):
    with pytest.raises(ModelError, match=rf"brake 'brake', {name}: .*-1"):
        compiled(**{name: -1.0})


def test_a_brake_that_holds_less_than_it_slides_with_is_refused():
    words = r"brake: holding_torque 0\.5 N\*m is below sliding_torque 1 N\*m; what breaks away must be able to slip"
    model = compiled()
    with pytest.raises(ModelError, match=words):
        model.parameters.vector({"brake.holding_torque": 0.5})
    with pytest.raises(ModelError, match=words):
        operating_point(compiled(holding_torque=0.5))
    model.parameters.vector({"brake.sliding_torque": 1.5})


def test_modes_say_that_a_brake_holds_nothing_in_them():
    result = modal(compiled())
    assert result.frequencies == pytest.approx([np.sqrt(K / J) / (2 * np.pi)])
    assert result.released == ("brake",)
    assert "brake: taken as slipping; what sticks would hold its node" in str(result)
