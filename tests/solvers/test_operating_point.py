"""Operating point: balance, static state, modal damping, scales."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from modelgen import (
    Case,
    Driveline,
    ElasticStop,
    GearPair,
    GroundDamper,
    HarmonicTorque,
    Inertia,
    Shaft,
    assemble,
    load,
    lower,
    operating_point,
    simulate,
)
from modelgen.errors import BalanceError, CaseError
from modelgen.lowering.parameters import MODAL
from modelgen.model.files import model_text, parse_model
from modelgen.solvers.scales import state_scales


def geared(load_torque: float, **mesh: object) -> Driveline:
    settings = {"teeth_a": 20, "teeth_b": 40, "module": "5 mm", "mean_stiffness": 6e8, "half_backlash": "80 um", **mesh}
    return Driveline(
        "geared",
        speed="1200 rpm",
        reference="motor",
        elements=(
            Inertia("motor", inertia=1.0),
            Inertia("pinion", inertia=0.05),
            Inertia("wheel", inertia=0.4),
            Inertia("pump", inertia=2.0),
            Shaft("input_shaft", "motor", "pinion", stiffness=5e4),
            GearPair("mesh", "pinion", "wheel", **settings),
            Shaft("output_shaft", "wheel", "pump", stiffness=8e4),
            HarmonicTorque("drive", "motor", mean=100.0),
            HarmonicTorque("brake", "pump", mean=load_torque),
        ),
    )


def test_static_state_carries_the_mean_torque_on_the_loaded_flank() -> None:
    model = lower(assemble(geared(-200.0)))
    point = operating_point(model)
    y = model.evaluate(0.0, point.start, point.p)
    radius = y["mesh.radius_a"]
    assert y["input_shaft.torque"] == pytest.approx(100.0, rel=1e-12)
    assert y["output_shaft.torque"] == pytest.approx(200.0, rel=1e-12)
    assert y["mesh.force"] == pytest.approx(100.0 / radius, rel=1e-12)
    assert y["mesh.deflection"] == pytest.approx(80e-6 + 100.0 / radius / 6e8, rel=1e-12)
    assert model.rhs(0.0, point.start, point.p) == pytest.approx(0.0, abs=1e-6)


def test_reversed_torque_loads_the_back_flank() -> None:
    line = geared(200.0).change("drive", mean=-100.0)
    model = lower(assemble(line))
    point = operating_point(model)
    assert model.evaluate(0.0, point.start, point.p)["mesh.deflection"] < -80e-6


def test_unbalanced_torque_is_refused_with_its_drift() -> None:
    model = lower(assemble(geared(-150.0)))
    # 25 N*m remain at the motor; the inertia there is 1.05 + 2.4/4 = 1.65 kg*m^2.
    with pytest.raises(BalanceError, match=r"leave 25 N\*m .* accelerate by 15.15 rad/s\^2; use balance"):
        operating_point(model)


def test_declared_drift_is_allowed_and_reported() -> None:
    line = geared(-150.0)
    model = lower(assemble(replace(line, drifts=True)))
    assert operating_point(model).drift == pytest.approx(25 / 1.65, rel=1e-9)


def test_balance_scales_the_load_at_any_ratio() -> None:
    model = lower(assemble(geared(-150.0).balance("brake")))
    for teeth in (40, 55):
        point = operating_point(model, {"mesh.teeth_b": teeth})
        assert model.evaluate(0.0, point.start, point.p)["brake.torque"] == pytest.approx(-100.0 * teeth / 20, rel=1e-12)
        assert point.drift == pytest.approx(0.0, abs=1e-10)


def test_balance_includes_drag_at_the_operating_speed() -> None:
    line = geared(-150.0).add(GroundDamper("bearing", "pump", damping=0.2)).balance("brake")
    model = lower(assemble(line))
    point = operating_point(model)
    y = model.evaluate(0.0, point.start, point.p)
    speed = 1200 * np.pi / 30 / 2
    assert y["brake.torque"] - 0.2 * speed == pytest.approx(-200.0, rel=1e-12)


def test_every_vector_is_in_balance() -> None:
    parts = [Inertia("m", inertia=1.0), Inertia("n", inertia=1.0), Shaft("s", "m", "n", stiffness=1.0)]
    torques = [HarmonicTorque("d", "m", mean=10.0), HarmonicTorque("l", "n", mean=-4.0)]
    line = Driveline("b", speed=10.0, reference="m", elements=[*parts, *torques])
    model = lower(assemble(line.balance("l")))
    rest = [0.0] * 4
    assert model.evaluate(0.0, rest, model.parameters.vector())["l.torque"] == pytest.approx(-10.0, rel=1e-14)
    assert model.evaluate(0.0, rest, model.parameters.vector({"d.mean": 7.0}))["l.torque"] == pytest.approx(-7.0, rel=1e-14)
    assert model.evaluate(0.0, rest, model.parameters.unbalanced())["l.torque"] == -4.0
    changed = model.with_values({"d.mean": 6.0})
    assert changed.parameters.vector().tolist() == operating_point(changed).p.tolist()
    for name in ("fracturing-truck", "fracturing-truck-idle", "two-disk-gear"):
        catalogued = lower(assemble(load(name)))
        plain = slice(0, catalogued.parameters.slices[MODAL].start)
        assert catalogued.parameters.vector()[plain].tolist() == operating_point(catalogued).p[plain].tolist()


def test_balance_without_a_mean_is_refused() -> None:
    model = lower(assemble(geared(0.0).balance("brake")))
    with pytest.raises(BalanceError, match="balanced loads have no mean torque"):
        operating_point(model)


@pytest.mark.parametrize("zeta", [0.01, 0.05])
def test_modal_damping_gives_every_elastic_mode_the_same_ratio(zeta: float) -> None:
    line = geared(-200.0).change("shaft", damping="modal", damping_ratio=zeta)
    model = lower(assemble(line))
    point = operating_point(model)
    from modelgen import modal

    result = modal(model, point=point)
    assert result.damping_ratios == pytest.approx(zeta, rel=1e-9)
    assert point.damping @ point.coordinates.rigid[:, 0] == pytest.approx(0.0, abs=1e-9 * np.abs(point.damping).max())


def test_scale_is_the_twist_under_the_largest_torque() -> None:
    model = lower(assemble(geared(-200.0)))
    point = operating_point(model)
    scale = dict(zip(model.states, state_scales(model, point, point.start), strict=True))
    assert scale["input_shaft.twist"] == pytest.approx(100 / 5e4, rel=1e-9)
    assert scale["output_shaft.twist"] == pytest.approx(200 / 8e4, rel=1e-9)
    assert all(value > 0 for value in scale.values())


def test_scale_exists_without_any_torque() -> None:
    model = lower(assemble(geared(0.0).change("drive", mean=0.0)))
    point = operating_point(model)
    assert np.all(state_scales(model, point, point.start) > 0)


def test_truck_is_balanced_and_at_rest_in_the_mean() -> None:
    model = lower(assemble(load("fracturing-truck")))
    point = operating_point(model)
    y = model.evaluate(0.0, point.start, point.p)
    assert abs(point.drift) < 1e-9
    # 6 x 1073.6 N*m at the engine; ratio 46/26 to the propeller shaft.
    assert y["coupling.torque"] == pytest.approx(6441.606, rel=1e-6)
    assert y["propeller_shaft.torque"] == pytest.approx(6441.606 * 46 / 26, rel=1e-6)


def test_static_start_is_an_equilibrium_of_a_steady_driveline() -> None:
    solution = simulate(Case(geared(-200.0), end=0.05, samples=51))
    assert np.ptp(solution["input_shaft.torque"]) < 1e-6 * 100
    assert np.ptp(solution["mesh.force"]) < 1e-6 * 100 / 0.047


def test_balance_does_not_turn_a_load_into_a_drive_unless_it_may() -> None:
    disks = [Inertia("m", inertia=1.0), Inertia("n", inertia=2.0), Shaft("s", "m", "n", stiffness=1.0)]
    torques = [HarmonicTorque("drive", "m", mean=-10.0), HarmonicTorque("load", "n", mean=-4.0)]
    line = Driveline("pair", speed=10.0, reference="m", elements=[*disks, *torques])
    words = r"balance would scale 'load' by -2.5, which turns the load into a drive; .*balance\(..., may_drive=True\)"
    with pytest.raises(BalanceError, match=words):
        operating_point(lower(assemble(line.balance("load"))))
    allowed = line.balance("load", may_drive=True)
    assert operating_point(lower(assemble(allowed))).p[-1] == -2.5
    assert "balance_may_drive = true" in model_text(allowed)
    assert parse_model(model_text(allowed)) == allowed
    # The other way round, a torque that is given as a drive may become the load.
    brake = line.change("drive", mean=10.0).change("load", mean=1.0).balance("load")
    assert operating_point(lower(assemble(brake))).p[-1] == -10.0


def test_inertias_too_far_apart_for_modes() -> None:
    elements = [Inertia("a", inertia=5e-324), Inertia("b", inertia=1e-3)]
    stop = ElasticStop("stop", "a", "b", clearance=1e-4, stiffness=100.0)
    point = operating_point(lower(assemble(Driveline("apart", elements=[*elements, stop], drifts=True))))
    with pytest.raises(CaseError, match=r"natural modes: its inertias, from .* kg\*m\^2, and its stiffnesses lie too far apart"):
        point.frequencies()
