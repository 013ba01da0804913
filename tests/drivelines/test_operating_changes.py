"""A changed speed or tooth number in a model file moves all that depends on it, and the mean torques stay balanced."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen import Driveline, assemble, load, lower, operating_point
from modelgen.model.files import model_text, parse_model


def edited(old: str, new: str) -> Driveline:
    """The truck with one text of its model file replaced."""
    text = model_text(load("fracturing-truck"))
    assert text.count(old) == 1, old
    return parse_model(text.replace(old, new))


def facts(line: Driveline) -> tuple[dict[str, float], np.ndarray, float, dict[str, float]]:
    """Base frequencies [Hz], natural frequencies [Hz], drift [rad/s^2], output channels at rest."""
    model = lower(assemble(line))
    point = operating_point(model)
    hertz = model.mean_model.frequencies_at(point.p) / (2 * np.pi)
    bases = dict(zip((clock.name for clock in model.equations.clocks), hertz.tolist(), strict=True))
    return bases, point.frequencies(), point.drift, model.evaluate(0.0, point.start, point.p)


RATED = facts(load("fracturing-truck"))


def test_the_speed_moves_every_base_frequency_and_no_natural_one() -> None:
    speed = f"{load('fracturing-truck').speed!r} rad/s"
    bases, natural, drift, _ = facts(edited(speed, "1500 rpm"))
    assert {name: hertz / RATED[0][name] for name, hertz in bases.items()} == pytest.approx(dict.fromkeys(bases, 1500 / 1900))
    assert natural == pytest.approx(RATED[1], rel=1e-9, abs=1e-6)
    assert abs(drift) < 1e-9


def test_a_tooth_moves_what_turns_behind_it_and_the_balance_follows() -> None:
    bases, natural, drift, at_rest = facts(edited("teeth_b = 46", "teeth_b = 47"))
    assert bases["transmission_mesh.contact"] == pytest.approx(RATED[0]["transmission_mesh.contact"], rel=1e-12)
    for name in ("pump_mesh.contact", "pump_crank"):
        assert bases[name] == pytest.approx(RATED[0][name] * 46 / 47, rel=1e-12)
    assert np.abs(natural[1:] / RATED[1][1:] - 1).max() > 1e-3
    assert abs(drift) < 1e-9
    # The engine's mean torque is what it was; the pump's load is scaled to the new ratio.
    assert at_rest["coupling.torque"] == pytest.approx(RATED[3]["coupling.torque"], rel=1e-9)
    assert at_rest["propeller_shaft.torque"] == pytest.approx(RATED[3]["propeller_shaft.torque"] * 47 / 46, rel=1e-9)
    assert at_rest["transmission_mesh.radius_b"] == pytest.approx(RATED[3]["transmission_mesh.radius_b"] * 47 / 46, rel=1e-12)


def test_a_width_moves_the_mesh_stiffness_in_proportion() -> None:
    _, _, drift, at_rest = facts(load("fracturing-truck").change("transmission_mesh", face_width="121 mm"))
    assert at_rest["transmission_mesh.mesh_stiffness"] == pytest.approx(
        1.1 * RATED[3]["transmission_mesh.mesh_stiffness"], rel=1e-9
    )
    assert abs(drift) < 1e-9
