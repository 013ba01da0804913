"""Gear pair: every form of its mesh stiffness and damping, its error, its backlash, and its force."""

from __future__ import annotations

import math

import numpy as np
import pytest

from modelgen.elements import GearPair, HarmonicTorque, Inertia
from modelgen.equations import assemble
from modelgen.errors import ModelError
from modelgen.gears import mesh_stiffness_rows
from modelgen.lowering import lower
from modelgen.model import Driveline
from modelgen.solvers.bound_model import operating_point

Z_A, Z_B, MODULE, SPEED = 26, 46, 0.007, 30.0
J_A, J_B = 0.3, 2.0
R_A, R_B = (z * MODULE * math.cos(math.radians(20)) / 2 for z in (Z_A, Z_B))
PERIOD = 2 * math.pi / (Z_A * SPEED)
STIFF = {"mean_stiffness": 2e8}


def compiled(*more, speed=SPEED, **given):
    given = {"teeth_a": Z_A, "teeth_b": Z_B, **given}
    if given.get("radii") != "given":
        given.setdefault("module", MODULE)
    gears = [Inertia("pinion", inertia=J_A), Inertia("wheel", inertia=J_B), GearPair("mesh", "pinion", "wheel", **given)]
    return lower(assemble(Driveline("pair", [*gears, *more], speed=speed, reference="pinion")))


def channel(model, name, *, phase=0.0, deflection=0.0, rate=0.0):
    """A channel of the mesh at a phase [turns of the mesh] for a relative displacement along the line of action."""
    x = [0.0, deflection, 0.0, rate]
    assert model.states[1] == "mesh.approach"
    return model.evaluate(phase * PERIOD, x, model.parameters.vector())[f"mesh.{name}"]


def test_base_radii_follow_from_the_module_or_are_given():
    model = compiled(**STIFF)
    assert (channel(model, "radius_a"), channel(model, "radius_b")) == pytest.approx((R_A, R_B), rel=1e-15)
    model = compiled(radii="given", base_radius_a=0.1, **STIFF)
    assert (channel(model, "radius_a"), channel(model, "radius_b")) == pytest.approx((0.1, 0.1 * Z_B / Z_A), rel=1e-15)


def test_the_driven_gear_turns_forward_in_the_ratio_of_teeth():
    model = compiled(**STIFF)
    now = model.evaluate(0.0, np.zeros(4), model.parameters.vector())
    assert now["wheel.speed"] == pytest.approx(SPEED * Z_A / Z_B, rel=1e-15)


PHASES = np.array([0.0, 0.1, 0.37, 0.62, 0.999, 1.1, -0.9, 7.37])


def stiffnesses(model):
    return [channel(model, "mesh_stiffness", phase=phase) for phase in PHASES]


def test_fourier_rows():
    cosine, sine = (3e7, -1e7), (2e7, 4e6)
    found = stiffnesses(compiled(stiffness_cosine=cosine, stiffness_sine=sine, **STIFF))
    angle = 2 * np.pi * PHASES
    rows = sum(cosine[n - 1] * np.cos(n * angle) + sine[n - 1] * np.sin(n * angle) for n in (1, 2))
    assert found == pytest.approx(2e8 + rows, rel=1e-12)


def test_fourier_rows_of_chosen_orders():
    found = stiffnesses(compiled(stiffness_cosine=(3e7, -1e7), stiffness_orders=(2, 5), **STIFF))
    angle = 2 * np.pi * PHASES
    assert found == pytest.approx(2e8 + 3e7 * np.cos(2 * angle) - 1e7 * np.cos(5 * angle), rel=1e-12)


def test_table_joined_by_straight_lines():
    table = (2e8, 3e8, 2.5e8, 1e8)
    model = compiled(mesh="table", stiffness_table=table)
    expected = np.interp(PHASES % 1, np.arange(5) / 4, [*table, table[0]])
    assert stiffnesses(model) == pytest.approx(expected, rel=1e-11)
    assert model.mean_model.means_at(model.parameters.vector())[0] == pytest.approx(np.mean(table), rel=1e-15)


def test_rectangular_stiffness_is_high_while_two_pairs_carry():
    model = compiled(mesh="rectangular", stiffness_high=3e8, stiffness_low=2e8, contact_ratio=1.6)
    assert stiffnesses(model) == [3e8, 3e8, 3e8, 2e8, 2e8, 3e8, 3e8, 3e8]
    assert model.mean_model.means_at(model.parameters.vector())[0] == pytest.approx(0.6 * 3e8 + 0.4 * 2e8, rel=1e-15)


@pytest.mark.parametrize("orders", [(), (1, 2, 5)])
def test_stiffness_from_the_teeth(orders):
    given = {"stiffness_orders": orders} if orders else {}
    model = compiled(mesh="geometry", face_width="110 mm", **given)
    steel = {"pressure_angle": math.radians(20), "young_modulus": 206e9, "poisson_ratio": 0.3, "shear_factor": 1.0}
    teeth = {"teeth_1": Z_A, "teeth_2": Z_B, "module": MODULE, "face_width": 0.11, "profile_shift_1": 0.0, "profile_shift_2": 0.0}
    mean, cosine, sine = mesh_stiffness_rows(**teeth, **steel, order=10)
    angle = 2 * np.pi * PHASES
    chosen = orders or range(1, 11)
    rows = sum(cosine[n - 1] * np.cos(n * angle) + sine[n - 1] * np.sin(n * angle) for n in chosen)
    assert stiffnesses(model) == pytest.approx(mean + rows, rel=1e-9)
    # Mean of the reference truck's first pair: 2.464683e9 N/m.
    assert mean == pytest.approx(2.464683e9, rel=2e-5)


def test_the_stated_mean_is_the_mean_over_time():
    for given in (
        {"stiffness_cosine": (3e7, -1e7), **STIFF},
        {"mesh": "table", "stiffness_table": (2e8, 3e8, 1e8)},
        {"mesh": "rectangular", "stiffness_high": 3e8, "stiffness_low": 2e8, "contact_ratio": 1.6},
    ):
        model = compiled(**given)
        stated = model.mean_model.means(model.parameters.vector())[0].full().ravel()[0]
        over_time = np.mean([channel(model, "mesh_stiffness", phase=phase) for phase in (np.arange(3000) + 0.5) / 3000])
        assert stated == pytest.approx(over_time, rel=1e-6)


def test_corrected_damping_uses_the_mass_on_the_line_of_action():
    model = compiled(damping_ratio=0.1, **STIFF)
    mass = J_A * J_B / (J_A * R_B**2 + J_B * R_A**2)
    assert channel(model, "mesh_damping") == pytest.approx(2 * 0.1 * math.sqrt(2e8 * mass), rel=1e-13)
    # It is the damping ratio of the two gears on their mesh alone.
    point = operating_point(model)
    shape = np.array([1 / J_A * R_A, -1 / J_B * R_B])
    omega = 2 * math.pi * point.frequencies()[-1]
    assert shape @ point.damping @ shape / (shape @ point.mass @ shape) == pytest.approx(2 * 0.1 * omega, rel=1e-9)


def test_literal_damping_is_equation_10_as_printed():
    model = compiled(damping="literal", damping_ratio=0.1, **STIFF)
    printed = 2 * 0.1 * math.sqrt(2e8 * J_A * J_B * R_A**2 * R_B**2 / (R_A**2 * J_A + R_B**2 * J_B))
    assert channel(model, "mesh_damping") == pytest.approx(printed, rel=1e-13)


def test_damping_follows_the_stiffness_in_time():
    model = compiled(stiffness_cosine=(1e8,), damping_ratio=0.1, **STIFF)
    high, low = (channel(model, "mesh_damping", phase=phase) for phase in (0.0, 0.5))
    assert high / low == pytest.approx(math.sqrt(3), rel=1e-12)


def test_error_and_its_rate():
    model = compiled(error_mean=1e-5, error_amplitude=3e-5, error_phase=0.8, **STIFF)
    for phase in PHASES:
        angle = 2 * math.pi * phase + 0.8
        assert channel(model, "error", phase=phase) == pytest.approx(1e-5 + 3e-5 * math.sin(angle), abs=1e-16)
        assert channel(model, "error_rate", phase=phase) == pytest.approx(3e-5 * Z_A * SPEED * math.cos(angle), abs=1e-12)
        delta = channel(model, "deflection", phase=phase, deflection=2e-4)
        assert delta == pytest.approx(2e-4 - 1e-5 - 3e-5 * math.sin(angle), abs=1e-16)


@pytest.mark.parametrize(
    ("deflection", "penetration"),
    [(3e-4, 2e-4), (1e-4, 0), (5e-5, 0), (0, 0), (-1e-4, 0), (-2.5e-4, -1.5e-4)],
)
def test_backlash(deflection, penetration):
    model = compiled(half_backlash=1e-4, **STIFF)
    assert channel(model, "penetration", deflection=deflection) == pytest.approx(penetration, abs=1e-19)
    assert channel(model, "force", deflection=deflection) == pytest.approx(2e8 * penetration, abs=1e-10)


@pytest.mark.parametrize("viscous", ["always", "contact_only"])
def test_without_backlash_an_unloaded_mesh_has_its_stiffness(viscous):
    point = operating_point(compiled(viscous=viscous, **STIFF))
    gear = np.array([R_A, -R_B])
    assert point.stiffness == pytest.approx(2e8 * np.outer(gear, gear), rel=1e-12)


@pytest.mark.parametrize(
    ("deflection", "rate", "always", "contact_only"),
    # c = 5e4 N*s/m, k = 2e8 N/m, half backlash 1e-4 m.
    [
        (2e-4, 0.1, 2e4 + 5e3, 2e4 + 5e3),
        (2e-4, -0.1, 2e4 - 5e3, 2e4 - 5e3),
        (2e-4, -1.0, 2e4 - 5e4, 0),  # parting faster than the elastic force: flanks do not pull
        (0.0, 0.1, 5e3, 0),  # in the gap
        (-2e-4, -0.1, -2e4 - 5e3, -2e4 - 5e3),
        (-2e-4, 1.0, -2e4 + 5e4, 0),
    ],
)
def test_viscous_force_always_or_in_contact_only(deflection, rate, always, contact_only):
    for viscous, force in (("always", always), ("contact_only", contact_only)):
        model = compiled(half_backlash=1e-4, damping="value", damping_coefficient=5e4, viscous=viscous, **STIFF)
        assert channel(model, "force", deflection=deflection, rate=rate) == pytest.approx(force, rel=1e-12, abs=1e-9)


def test_force_drives_b_and_holds_a_back():
    model = compiled(**STIFF)
    now = model.evaluate(0.0, [0.0, 1e-4, 0.0, 0.0], model.parameters.vector())
    assert now["pinion.acceleration"] == pytest.approx(-R_A * 2e4 / J_A)
    assert now["wheel.acceleration"] == pytest.approx(R_B * 2e4 / J_B)


def test_the_static_mesh_lies_on_the_loaded_flank():
    torque = 200.0
    loads = [HarmonicTorque("drive", "pinion", mean=torque), HarmonicTorque("load", "wheel", mean=-torque * Z_B / Z_A)]
    model = compiled(*loads, half_backlash=1e-4, **STIFF)
    point = operating_point(model)
    assert point.start[1] == pytest.approx(1e-4 + torque / R_A / 2e8, rel=1e-9)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            {"mesh": "table", "stiffness_table": (1.0,), "stiffness_orders": (1,)},
            "stiffness_orders is given, but mesh='table' does not",
        ),
        (
            {"mesh": "table", "stiffness_table": (1.0,), **STIFF},
            "mean_stiffness is given, but mesh='table' does not use it; drop it or",
        ),
        ({"mesh": "table", "stiffness_table": (1.0, 0.0)}, "'mesh', stiffness_table.2.: is 0 N/m; give a positive value"),
        (
            {"radii": "given", "base_radius_a": 0.1, "mesh": "geometry", "face_width": 0.1},
            "geometry_rows follows from module, which its",
        ),
        (
            {"stiffness_cosine": (1.0, 2.0), "stiffness_sine": (1.0,), **STIFF},
            "has 2 cosine and 1 sine rows for 2 orders; give one",
        ),
    ],
)
def test_parameters_that_do_not_fit(given, words):
    with pytest.raises(ModelError, match=f"^gear_pair .*{words}"):
        compiled(**given)


@pytest.mark.parametrize(("ratio", "words"), [(0.9, "is 0.9; give 1 or more"), (2.4, "is 2.4; give 2 or less")])
def test_two_levels_need_a_contact_ratio_between_one_and_two(ratio: float, words: str) -> None:
    with pytest.raises(ModelError, match=words):
        compiled(mesh="rectangular", stiffness_high=3e8, stiffness_low=2e8, contact_ratio=ratio)
    model = compiled(mesh="rectangular", stiffness_high=3e8, stiffness_low=2e8, contact_ratio=1.5)
    with pytest.raises(ModelError, match=words.partition("; ")[2].replace("1 ", "1.0 ").replace("2 ", "2.0 ")):
        model.parameters.vector({"mesh.contact_ratio": ratio})


# -- modes of the flanks -------------------------------------------------------------------------------------------------------


def test_flanks_that_part_swing_back_without_a_force():
    # Still pressed in by 1 um, but parting so fast that the damper would pull: the force is zero, and the flanks are free.
    gap, depth, k, c = 1e-4, 1e-6, 2e8, 5e4
    model = compiled(half_backlash=gap, damping="value", damping_coefficient=c, viscous="contact_only", **STIFF)
    for rate in (-2 * k * depth / c, -0.5 * k * depth / c, 0.3):
        for side in (1, -1):
            seen = {name: channel(model, name, deflection=side * (gap + depth), rate=side * rate) for name in ("flank", "force")}
            pushes = k * depth + c * rate > 0
            assert seen["flank"] == (0 if not pushes else 1 if side > 0 else 2)
            assert seen["force"] == pytest.approx(side * (k * depth + c * rate) if pushes else 0.0, rel=1e-9)
            assert channel(model, "penetration", deflection=side * (gap + depth)) == pytest.approx(side * depth, rel=1e-9)


@pytest.mark.parametrize("viscous", ["always", "contact_only"])
def test_the_border_belongs_to_the_contact(viscous):
    model = compiled(half_backlash=2.0**-13, viscous=viscous, **STIFF)
    found = [channel(model, "flank", deflection=delta) for delta in (-(2.0**-13), -(2.0**-14), 2.0**-14, 2.0**-13)]
    assert found == [2, 0, 0, 1]
    assert [each.continuous for each in model.switching.modes] == [viscous == "always"]


def test_guards_of_the_flanks_are_their_distances():
    gap = 1e-4
    model = compiled(half_backlash=gap, error_amplitude=3e-5, **STIFF)
    p = model.switched().extended(model.parameters.vector())
    t, x = 0.3 * PERIOD, [0.0, 2e-4, 0.0, 0.1]
    delta = 2e-4 - 3e-5 * math.sin(0.6 * math.pi)
    guards = np.asarray(model.switching.guards(t, x, p)).ravel()
    assert guards == pytest.approx([delta - gap] * 3 + [-delta - gap] * 2, rel=1e-12)
    rates = np.asarray(model.switching.guard_rates(t, x, [0.0, 0.1, 0.0, 0.0], p)).ravel()[5:]
    rate = 0.1 - 3e-5 * 2 * math.pi / PERIOD * math.cos(0.6 * math.pi)
    assert rates == pytest.approx([rate] * 3 + [-rate] * 2, rel=1e-12)
