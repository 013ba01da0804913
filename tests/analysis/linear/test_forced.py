"""Forced response: against settled time integration, closed forms, and its own sums over orders and over the cycle."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from modelgen import (
    Case,
    Driveline,
    Element,
    Flange,
    GearPair,
    GroundDamper,
    GroundSpring,
    HarmonicTorque,
    Inertia,
    Param,
    RigidGear,
    Shaft,
    State,
    assemble,
    load,
    lower,
    modal,
    operating_point,
    quantity,
    simulate,
)
from modelgen.analysis import forced
from modelgen.analysis.linear.excitation import exact_multiple, excitation
from modelgen.errors import BalanceError, CaseError

RPM = np.pi / 30


def two_disks(**shaft):
    """Disks of 3 and 1 kg*m^2, a first and a third order on the first one."""
    return Driveline(
        "two_disks",
        speed="1200 rpm",
        reference="engine",
        bases={"turn": 1},
        elements=(
            Inertia("engine", inertia=3.0),
            Inertia("load", inertia=1.0),
            Shaft("shaft", "engine", "load", stiffness=3e4, **shaft),
            HarmonicTorque("firing", "engine", cosine=[40.0, 0.0, 9.0], sine=[-5.0, 0.0, 2.0], base="turn"),
        ),
    )


def geared():
    """Two cylinders out of step, a mesh with an error, and a pump whose third order meets the engine's first: well damped."""
    rows = {"cosine": [40.0, 20.0], "sine": [-10.0, 15.0], "base": "firing"}
    return Driveline(
        "geared",
        speed="1200 rpm",
        reference="motor",
        bases={"firing": ("motor", "3/2"), "pump_turn": ("pump", 1)},
        elements=(
            *(Inertia(name, inertia=j) for name, j in (("motor", 1.0), ("pinion", 0.2), ("wheel", 0.8), ("pump", 1.2))),
            Shaft("input_shaft", "motor", "pinion", stiffness=2e4, damping_ratio=0.3),
            GearPair(
                "mesh", "pinion", "wheel", teeth_a=20, teeth_b=40, module="5 mm", mean_stiffness=2e7, damping_ratio=0.2,
                error_amplitude="5 um", error_phase=0.7,
            ),
            Shaft("output_shaft", "wheel", "pump", stiffness=9e4, damping_ratio=0.3),
            HarmonicTorque("first", "motor", mean=300.0, **rows),
            HarmonicTorque("second", "pinion", mean=100.0, phase="80 deg", **rows),
            HarmonicTorque("brake", "pump", mean=-800.0, sine=[60.0, 0.0, 25.0], base="pump_turn", phase=-0.4),
        ),
    ).balance("brake")  # fmt: skip


def read_amplitudes(times, values, omega):
    """Complex amplitudes by least squares, beside a mean and a drift: values = Re sum A e^(i w t)."""
    columns = [np.ones_like(times), times - times.mean(), *np.cos(np.outer(omega, times)), *np.sin(np.outer(omega, times))]
    found = np.linalg.lstsq(np.column_stack(columns), values, rcond=None)[0]
    return found[2 : 2 + len(omega)] - 1j * found[2 + len(omega) :]


@pytest.mark.parametrize("parameters", [{}, {"second.scale": 0.0}], ids=["all firing", "misfire"])
def test_it_equals_settled_time_integration(parameters) -> None:
    """At 20 speeds, phases and all: one source is missing in the second run."""
    model = lower(assemble(geared()))
    speeds = np.linspace(60, 200, 20 if not parameters else 3)
    result = forced(model, speeds, parameters)
    assert result.orders == (Fraction(1, 2), Fraction(3, 2), Fraction(3), Fraction(20))
    assert result.bases[1] == ("firing", "pump_turn")
    wait = np.log(1e8) / modal(model).decay_rates.min()
    lost = tuple(f"{name}.dissipated_power" for name in result.dampers)
    for k, speed in enumerate(speeds.tolist()):
        cycle = float(result.cycle) * 2 * np.pi / speed
        begin = np.ceil(wait / cycle) * cycle
        case = Case(
            model, end=begin + cycle, record_from=begin, samples=257, tolerance=1e-9, channels=(*result.channels, *lost),
            parameters={**parameters, "speed": speed},
        )  # fmt: skip
        solution = simulate(case)
        assert solution.succeeded
        seen = np.column_stack([solution[name] for name in result.channels])
        found = read_amplitudes(solution.times, seen, np.array([float(order) for order in result.orders]) * speed).T
        expected = result.amplitudes[k]
        size = np.abs(expected).max(axis=1)
        assert (size > 0).sum() >= len(size) - 1  # all but the missing source
        assert (np.abs(found - expected).max(axis=1)[size > 0] / size[size > 0]).max() < 1e-6
        mean_power = [np.trapezoid(solution[name], solution.times) / cycle for name in lost]
        assert result.power[k].sum(axis=1) == pytest.approx(mean_power, rel=1e-6)


def test_closed_form_of_the_two_disk_line() -> None:
    """A_b = k T / (J_a J_b w^4 - ...): with u = theta_a - theta_b, u (k (1/J_a + 1/J_b) - w^2) = T / J_a."""
    result = forced(lower(assemble(two_disks())), ["600 rpm", "1200 rpm"])
    omega = np.outer(np.array([600, 1200]) * RPM, [1, 3])
    torque = np.array([40 + 5j, 9 - 2j])
    twist = torque / 3 / (3e4 * (1 / 3 + 1) - omega**2)
    assert result.orders == (1, 3)
    assert result["shaft.twist"] == pytest.approx(twist, rel=1e-11)
    assert result["shaft.torque"] == pytest.approx(3e4 * twist, rel=1e-11)
    # The momentum of both is that of the torque: -w^2 (J_a A_a + J_b A_b) = T.
    rolled = 3 * result["engine.angle_deviation"] + result["load.angle_deviation"]
    assert rolled == pytest.approx(-torque / omega**2, rel=1e-10)
    assert result.unit("shaft.twist") == "rad"


def test_power_fed_in_is_power_lost() -> None:
    result = forced(lower(assemble(geared())), np.linspace(60, 200, 5), channels=["motor.speed", "pinion.speed", "pump.speed"])
    torques = forced(lower(assemble(geared())), result.speeds, channels=["first.torque", "second.torque", "brake.torque"])
    fed = (torques.amplitudes * result.amplitudes.conj()).real.sum(axis=1) / 2
    # Order 20 comes from the mesh error, which does work of its own.
    assert fed[:, :3] == pytest.approx(result.power.sum(axis=1)[:, :3], rel=1e-9)
    assert result.power.min() >= 0


def test_the_sum_over_the_cycle_keeps_the_phases() -> None:
    result = forced(lower(assemble(two_disks())))
    turns, values = result.over_cycle("shaft.torque", points=32)
    first, third = result["shaft.torque"][0]
    expected = (first * np.exp(2j * np.pi * turns)).real + (third * np.exp(6j * np.pi * turns)).real
    assert values[0] == pytest.approx(expected, abs=1e-9)
    assert result.cycle == 1
    swing = result.swing("shaft.torque")
    assert swing.exact
    assert swing.peak[0] == pytest.approx(np.abs(expected).max(), rel=5e-3)
    # A root of a sum of squares would be wrong by 4 %.
    assert abs(swing.peak[0] - np.hypot(abs(first), abs(third))) > 0.03 * swing.peak[0]


def test_a_cycle_that_hardly_ever_ends_is_bounded_instead() -> None:
    line = two_disks()
    line = Driveline(
        "slow", speed=line.speed, reference="engine", bases={"turn": 1, "other": "99991/100000"},
        elements=(*line.elements, HarmonicTorque("second", "load", cosine=[7.0], base="other")),
    )  # fmt: skip
    result = forced(lower(assemble(line)))
    with pytest.raises(CaseError, match="the orders repeat only after 100000 turns"):
        result.over_cycle("shaft.twist")
    swing = result.swing("shaft.twist")
    assert not swing.exact
    parts = [np.ptp(result.over_cycle("shaft.twist", bases=[name])[1]) / 2 for name in ("turn", "other")]
    assert swing.half_pp[0] == pytest.approx(sum(parts), rel=1e-9)


def test_a_loss_factor_is_a_complex_stiffness_at_every_frequency() -> None:
    eta, k = 0.035, 3e4
    line = two_disks(damping="loss_factor", loss_factor=eta, reference_frequency="500 rad/s")
    result = forced(lower(assemble(line)), ["600 rpm", "1900 rpm"])
    omega = np.outer(np.array([600, 1900]) * RPM, [1, 3])
    twist = np.array([40 + 5j, 9 - 2j]) / 3 / (k * (1 + 1j * eta) * (1 / 3 + 1) - omega**2)
    assert result["shaft.twist"] == pytest.approx(twist, rel=1e-11)
    assert result["shaft.torque"] == pytest.approx(k * (1 + 1j * eta) * twist, rel=1e-11)
    assert result.power[:, 0] == pytest.approx(omega * eta * k * np.abs(twist) ** 2 / 2, rel=1e-9)
    viscous = forced(lower(assemble(line)), ["600 rpm", "1900 rpm"], complex_stiffness=False)
    c = eta * k / 500
    assert viscous["shaft.twist"] == pytest.approx(
        np.array([40 + 5j, 9 - 2j]) / 3 / ((k + 1j * omega * c) * (1 / 3 + 1) - omega**2), rel=1e-11
    )


def test_modal_damping_loses_power_that_no_element_owns() -> None:
    model = lower(assemble(two_disks(damping="modal", damping_ratio=0.04)))
    result = forced(model, ["1200 rpm"])
    omega = np.array([1, 3]) * 1200 * RPM
    natural = np.sqrt(3e4 * (1 / 3 + 1))
    twist = np.array([40 + 5j, 9 - 2j]) / 3 / (natural**2 - omega**2 + 2j * 0.04 * natural * omega)
    assert result["shaft.twist"][0] == pytest.approx(twist, rel=1e-10)
    # c = 2 zeta w J_a J_b / (J_a + J_b) across the shaft
    lost = dict(zip(result.dampers, result.power[0], strict=True))["modal_damping"]
    assert lost == pytest.approx(2 * 0.04 * natural * 0.75 * omega**2 * np.abs(twist) ** 2 / 2, rel=1e-9)


def test_shear_stress_from_diameters() -> None:
    model = lower(assemble(two_disks()))
    result = forced(model, diameters={"shaft": ("80 mm", "40 mm")}, channels=["shaft.twist"])
    factor = 16 * 0.08 / (np.pi * (0.08**4 - 0.04**4))
    assert result.channels == ("shaft.twist", "shaft.shear_stress")
    assert result["shaft.shear_stress"] == pytest.approx(factor * 3e4 * result["shaft.twist"], rel=1e-12)
    assert result.unit("shaft.shear_stress") == "Pa"
    for wrong in (0.0, (0.04, 0.08), "eighty", "80 kg"):
        with pytest.raises((CaseError, Exception), match="shaft 'shaft', diameter"):
            forced(model, diameters={"shaft": wrong})
    with pytest.raises(CaseError, match=r"no output 'shift.torque'; nearest is 'shaft.torque'"):
        forced(model, diameters={"shift": 0.08})


def test_parameters_may_follow_the_speed() -> None:
    model = lower(assemble(two_disks()))
    grown = forced(model, [100.0, 120.0], lambda speed: {"firing.scale": (speed / 100) ** 2})
    plain = forced(model, [100.0, 120.0])
    assert grown["shaft.twist"][0] == pytest.approx(plain["shaft.twist"][0], rel=1e-12)
    assert grown["shaft.twist"][1] == pytest.approx(1.44 * plain["shaft.twist"][1], rel=1e-12)
    # An order that is there at one speed only is zero at the other.
    ceasing = forced(model, [100.0, 120.0], lambda speed: {"firing.cosine[3]": 0.0, "firing.sine[3]": 0.0} if speed < 110 else {})
    assert ceasing.orders == (1, 3)
    assert ceasing["shaft.twist"][0, 1] == 0
    assert ceasing["shaft.twist"][1, 1] == pytest.approx(plain["shaft.twist"][1, 1])


def test_sources_add_up() -> None:
    """The answer to all sources is the sum of the answers to each, and to a misfire it is that sum less one."""
    model = lower(assemble(geared()))
    names = ("first", "second", "brake")
    silent = {f"{name}.{row}": [0.0] * n for name, n in zip(names, (2, 2, 3), strict=True) for row in ("cosine", "sine")}
    silent = {key: value for key, value in silent.items() if key != "brake.cosine"}
    whole = forced(model)
    parts = [forced(model, None, {k: v for k, v in silent.items() if not k.startswith(name)}) for name in names]
    total = np.zeros_like(whole.amplitudes)
    for part in parts:
        at = [whole.orders.index(order) for order in part.orders]
        total[:, :, at] += part.amplitudes * np.where([order == 20 for order in part.orders], 1 / 3, 1)
    assert total == pytest.approx(whole.amplitudes, rel=1e-9, abs=1e-15)


def test_a_gear_carries_what_its_shafts_carry() -> None:
    """Without inertia to speak of on the wheel, the rigid gear passes on the torque of the output shaft."""
    line = Driveline(
        "rigid", speed="1000 rpm", reference="motor", bases={"turn": 1},
        elements=(
            Inertia("motor", inertia=1.0), Inertia("pinion", inertia=0.1), Inertia("wheel", inertia=1e-9),
            Inertia("fan", inertia=2.0),
            Shaft("input", "motor", "pinion", stiffness=1e4), RigidGear("gear", "pinion", "wheel", teeth_a=20, teeth_b=50),
            Shaft("output", "wheel", "fan", stiffness=3e4), HarmonicTorque("firing", "motor", cosine=[50.0], base="turn"),
        ),
    )  # fmt: skip
    result = forced(lower(assemble(line)))
    assert result.gears == ("gear.torque",)
    assert result["gear.torque"] == pytest.approx(0.4 * result["output.torque"], rel=1e-5)


def test_mesh_stiffness_that_varies_excites_at_rest_and_is_told() -> None:
    """The mean force F0 bends the varying mesh by F0 / k(t): the response to that, and a word about the rest."""
    line = geared().change("mesh", error_amplitude=0.0, stiffness_cosine=[2e5])
    model = lower(assemble(line))
    result, point = forced(model), operating_point(model)
    assert result.parametric == pytest.approx({"mesh": 0.01}, rel=1e-6)
    force, radius = result.mean_of("mesh.force")[0], 0.05 * np.cos(np.radians(20))
    at_mesh = result.orders.index(Fraction(20))
    change = 2e5 * force / 2e7
    pull = np.array([0.0, -radius, 2 * radius, 0.0]) * change
    omega = 20 * result.speeds[0]
    answer = np.linalg.solve(point.stiffness + 1j * omega * point.damping - omega**2 * point.mass, pull)
    assert result["pump.angle_deviation"][0, at_mesh] == pytest.approx(answer[3], rel=1e-3)
    assert forced(lower(assemble(geared()))).parametric == {}


@pytest.fixture
def maxwell_shaft():
    """An element with a state of its own; it leaves the vocabulary after the test."""

    class MaxwellShaft(Element):
        """A spring in series with a damper: T' = k u' - T / tau."""

        a, b = Flange(), Flange()
        stiffness = Param("N*m/rad", positive=True)
        relaxation = Param("s", positive=True)
        torque_state = State("N*m")

        @quantity("rad/s")
        def rate(self):
            return self.a.speed - self.b.speed

        @quantity("N*m")
        def torque(self):
            return self.torque_state

        def torques(self):
            return {self.a: -self.torque, self.b: self.torque}

        def rates(self):
            return {self.torque_state: self.stiffness * self.rate - self.torque_state / self.relaxation}

    yield MaxwellShaft
    del Element.vocabulary["maxwell_shaft"]


def test_own_states_answer_too(maxwell_shaft) -> None:
    k, tau = 2e4, 3e-3
    line = two_disks().add(maxwell_shaft("rubber", "engine", "load", stiffness=k, relaxation=tau))
    result = forced(lower(assemble(line)))
    omega = np.array([1, 3]) * 1200 * RPM
    complex_stiffness = k * 1j * omega * tau / (1 + 1j * omega * tau)
    twist = np.array([40 + 5j, 9 - 2j]) / 3 / ((3e4 + complex_stiffness) * (1 / 3 + 1) - omega**2)
    assert result["shaft.twist"][0] == pytest.approx(twist, rel=1e-11)
    assert result["rubber.torque"][0] == pytest.approx(complex_stiffness * twist, rel=1e-11)


def test_a_driveline_that_nothing_shakes_rests() -> None:
    line = Driveline(
        "still", speed="1000 rpm", reference="a",
        elements=(Inertia("a", inertia=1.0), Inertia("b", inertia=1.0), Shaft("s", "a", "b", stiffness=1e4)),
    )  # fmt: skip
    result = forced(lower(assemble(line)))
    assert result.orders == ()
    assert result["s.torque"].shape == (1, 0)
    assert result.swing("s.torque").peak.tolist() == [0.0]


def test_the_truck_at_every_speed() -> None:
    result = forced(lower(assemble(load("fracturing-truck"))), ["1800 rpm", "1900 rpm"], highest_order=24)
    assert max(result.orders) <= 24
    assert result.orders[0] == Fraction(221, 2484)
    assert set(result.gears) == {"transmission_mesh.force", "pump_mesh.force"}
    assert result.referred_ratio["pump_free_end"] == pytest.approx(26 / 46 * 17 / 108)
    assert "2 speeds from 1800 to 1900 rpm" in str(result)


def test_periodic_tables_are_resolved_and_rows_are_exact() -> None:
    model = lower(assemble(geared()))
    shaking = excitation(model, operating_point(model))
    motor = model.equations.groups.index("motor")
    firing = shaking.orders.index(Fraction(3))
    assert shaking.amplitudes[motor, firing] == pytest.approx(20 - 15j, rel=1e-13)
    table = geared().change("mesh", mesh="table", stiffness_table=[2.0e7, 2.2e7, 2.2e7, 2.0e7], error_amplitude=0.0)
    rows = excitation(lower(assemble(table)), operating_point(lower(assemble(table))))
    first, third = (rows.by_flange[:, rows.orders.index(Fraction(20 * n))] for n in (1, 3))
    # Linear interpolation of n samples: harmonics fall with the square of the order.
    ratio = np.abs(third[np.abs(first) > 1]) / np.abs(first[np.abs(first) > 1])
    assert ratio == pytest.approx(1 / 9, rel=1e-3)


@pytest.mark.parametrize(
    ("value", "fraction"),
    [(0.5, "1/2"), (26 / 46 * 17 / 108, "221/2484"), (31 / 17 * 23 / 101 * 7 / 43, "4991/73831"), (1e-3, "1/1000"), (48.0, "48")],
)
def test_multiples_are_exact(value: float, fraction: str) -> None:
    assert exact_multiple(value) == Fraction(fraction)


def test_speeds_and_names_that_are_not_lawful() -> None:
    model = lower(assemble(two_disks()))
    for wrong in ([], [-1.0], [100.0, 90.0], ["fast"], object(), [float("nan")]):
        with pytest.raises(Exception, match="driveline 'two_disks', speeds"):
            forced(model, wrong)
    with pytest.raises(CaseError, match=r"no output 'shaft.tork'; nearest is 'shaft.torque'"):
        forced(model, channels=["shaft.tork"])
    with pytest.raises(CaseError, match=r"no channel 'shaft.twyst'; nearest is 'shaft.twist'"):
        forced(model)["shaft.twyst"]
    with pytest.raises(CaseError, match="has no operating speed"):
        forced(lower(assemble(Driveline("d", elements=(Inertia("a", inertia=1.0), GroundSpring("s", "a", stiffness=1.0))))))
    unbalanced = two_disks().add(GroundDamper("drag", "load", damping=1.0))
    with pytest.raises(BalanceError, match="mean torques leave"):
        forced(lower(assemble(unbalanced)))


def test_an_order_on_an_undamped_mode_is_refused_with_its_speed() -> None:
    critical = np.sqrt(3e4 * (1 / 3 + 1)) / 3
    with pytest.raises(CaseError, match=r"driveline 'two_disks' at 636.62 rpm: 200 rad/s is the frequency of an undamped mode"):
        forced(lower(assemble(two_disks())), [critical])
