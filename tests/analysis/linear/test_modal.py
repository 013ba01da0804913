"""Modes on drivelines whose answers are known on paper: rigid, repeated, damped, geared, in a gap; energies and participation."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen import (
    Driveline,
    Element,
    Flange,
    GearPair,
    GroundDamper,
    GroundSpring,
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
)
from modelgen.analysis.linear.modal import damped_pairs
from modelgen.errors import CaseError


def compiled(*elements, **settings):
    return lower(assemble(Driveline("line", elements=elements, **settings)))


def chain(inertias, stiffnesses, **shaft):
    return (
        *(Inertia(f"disk_{n}", inertia=inertia) for n, inertia in enumerate(inertias)),
        *(Shaft(f"shaft_{n}", f"disk_{n}", f"disk_{n + 1}", stiffness=k, **shaft) for n, k in enumerate(stiffnesses)),
    )


def test_the_rigid_mode_is_exactly_zero_next_to_any_other() -> None:
    # Stiffness and inertia over nine decades: eigenvalues of K and M would leave a rigid mode of some rad/s.
    result = modal(compiled(*chain([1e-3, 50.0, 1e-3], [1e9, 1e2])))
    assert result.frequencies[0] == 0.0
    assert result.rigid == 1
    # To 1e-9 the soft end on a wall, and the stiff end against the rest.
    assert result.frequencies[1:] * 2 * np.pi == pytest.approx(
        [np.sqrt(1e2 * (1 / 1e-3 + 1 / 50.001)), np.sqrt(1e9 * (1 / 1e-3 + 1 / 50))], rel=1e-9
    )


def test_rigid_gears_are_one_mode_with_the_ratios_of_the_teeth() -> None:
    model = compiled(
        *(Inertia(name, inertia=1.0) for name in ("motor", "pinion", "wheel", "fan")),
        Shaft("input", "motor", "pinion", stiffness=1e4),
        RigidGear("gear", "pinion", "wheel", teeth_a=20, teeth_b=50),
        Shaft("output", "wheel", "fan", stiffness=1e4),
    )
    result = modal(model)
    assert result.names == ("motor", "pinion", "wheel", "fan")
    assert result.ratio == pytest.approx([1, 1, 0.4, 0.4], rel=1e-15)
    assert result.shapes[:, 0] == pytest.approx(result.ratio, rel=1e-12)
    assert result.referred[:, 0] == pytest.approx(1, rel=1e-12)
    # The shapes tell every node, though pinion and wheel are one degree of freedom.
    assert result.shapes[2] == pytest.approx(0.4 * result.shapes[1], rel=1e-12)
    assert len(result.frequencies) == 3


def test_a_flank_in_its_gap_leaves_two_rigid_modes() -> None:
    model = compiled(
        *(Inertia(name, inertia=1.0) for name in ("motor", "pinion", "wheel")),
        Shaft("input", "motor", "pinion", stiffness=1e4),
        GearPair("mesh", "pinion", "wheel", teeth_a=20, teeth_b=40, module="5 mm", mean_stiffness=1e8, half_backlash="0.1 mm"),
        speed=100.0,
        reference="motor",
    )
    result = modal(model)
    assert result.rigid == 2
    assert result.frequencies[:2].tolist() == [0.0, 0.0]
    assert result.frequencies[2] * 2 * np.pi == pytest.approx(np.sqrt(2e4), rel=1e-12)


def test_a_grounded_driveline_has_no_rigid_mode() -> None:
    result = modal(compiled(Inertia("disk", inertia=2.0), GroundSpring("spring", "disk", stiffness=800.0)))
    assert result.rigid == 0
    assert result.frequencies * 2 * np.pi == pytest.approx([20.0], rel=1e-14)


def test_repeated_modes_are_told_and_stay_orthogonal() -> None:
    """Three equal blades on a hub: two modes in which the hub stands still share the frequency of a blade."""
    blades = [Inertia(f"blade_{n}", inertia=0.5) for n in range(3)]
    stems = [Shaft(f"stem_{n}", "hub", f"blade_{n}", stiffness=2e4) for n in range(3)]
    model = compiled(Inertia("hub", inertia=2.0), *blades, *stems)
    result = modal(model)
    assert result.repeated == ((1, 2),)
    assert result.frequencies[1:3] * 2 * np.pi == pytest.approx([200.0, 200.0], rel=1e-12)
    assert result.shapes[0, 1:3] == pytest.approx(0, abs=1e-9)
    mass = operating_point(model).mass
    gram = result.shapes.T @ mass @ result.shapes
    assert gram == pytest.approx(np.diag(result.modal_inertia), abs=1e-9)


def test_shares_are_those_of_the_two_disk_line() -> None:
    """One elastic mode: J_b/(J_a + J_b) of the kinetic energy in disk a, all potential energy in the shaft."""
    result = modal(compiled(*chain([3.0, 1.0], [1e4])))
    assert result.elements == ("disk_0", "disk_1", "shaft_0")
    assert result.kinetic[:, 1] == pytest.approx([0.25, 0.75, 0], abs=1e-14)
    assert result.potential[:, 1] == pytest.approx([0, 0, 1], abs=1e-14)


@pytest.mark.parametrize("name", ["fracturing-truck", "fracturing-truck-commensurate"])
def test_participation_sums_to_one(name: str) -> None:
    result = modal(lower(assemble(load(name))))
    assert result.kinetic.sum(axis=0) == pytest.approx(1, abs=1e-12)
    assert result.potential.sum(axis=0) == pytest.approx([0] + [1] * 15, abs=1e-12)
    assert result.kinetic.min() >= 0
    assert result.potential.min() >= -1e-12
    # The stiffest mode lives in the meshes and the gears.
    last = dict(zip(result.elements, result.potential[:, -1], strict=True))
    assert last["pump_mesh"] > 0.9


def test_shares_of_two_inertias_on_one_node_are_told_apart() -> None:
    model = compiled(
        Inertia("disk", inertia=2.0), Inertia("ring", "disk", inertia=1.0), Inertia("load", inertia=1.0),
        Shaft("shaft", "disk", "load", stiffness=1e4),
    )  # fmt: skip
    kinetic = dict(zip(modal(model).elements, modal(model).kinetic[:, 1], strict=True))
    assert kinetic["disk"] == pytest.approx(2 * kinetic["ring"], rel=1e-12)


def test_damped_modes_of_a_line_with_drag() -> None:
    # One disk on a spring to ground: s = -zeta w +- i w sqrt(1 - zeta^2).
    model = compiled(Inertia("disk", inertia=2.0), GroundSpring("spring", "disk", stiffness=800.0, damping=16.0))
    result = modal(model)
    assert result.damping_ratios == pytest.approx([0.2], rel=1e-12)
    assert result.decay_rates == pytest.approx([4.0], rel=1e-12)
    assert result.damped_frequencies * 2 * np.pi == pytest.approx([20 * np.sqrt(1 - 0.04)], rel=1e-12)


def test_drag_on_a_free_line_makes_no_mode_of_its_rolling() -> None:
    model = compiled(*chain([3.0, 1.0], [1e4], damping_ratio=0.02), GroundDamper("bearing", "disk_1", damping=0.5))
    result = modal(model)
    matrix = np.array([[0, 1, -1], [-1e4 / 3, 0, 0], [1e4, 0, 0]])
    c = 2 * 0.02 * np.sqrt(1e4 * 0.75)
    matrix[1:, 1:] = [[-c / 3, c / 3], [c, -c - 0.5]]
    values = np.linalg.eigvals(matrix)
    assert len(result.damping_ratios) == 1
    assert result.decay_rates == pytest.approx([-values[values.imag > 0][0].real], rel=1e-9)


def test_overdamped_motion_is_no_mode() -> None:
    model = compiled(Inertia("disk", inertia=2.0), GroundSpring("spring", "disk", stiffness=800.0, damping=160.0))
    result = modal(model)
    assert result.damped_frequencies.size == 0
    assert result.frequencies * 2 * np.pi == pytest.approx([20.0])


def test_damped_shapes_solve_the_quadratic_problem() -> None:
    model = lower(assemble(load("fracturing-truck")))
    point, result = operating_point(model), modal(model)
    s = -result.decay_rates + 2j * np.pi * result.damped_frequencies
    for value, shape in zip(s, result.damped_shapes.T, strict=True):
        terms = [point.stiffness @ shape, value * point.damping @ shape, value**2 * point.mass @ shape]
        assert np.abs(sum(terms)).max() < 1e-8 * max(np.abs(term).max() for term in terms)
    assert damped_pairs(point).damping_ratios == pytest.approx(result.damping_ratios, rel=1e-9)


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

        def torques(self):
            return {self.a: -self.torque_state, self.b: self.torque_state}

        def rates(self):
            return {self.torque_state: self.stiffness * self.rate - self.torque_state / self.relaxation}

    yield MaxwellShaft
    del Element.vocabulary["maxwell_shaft"]


def test_own_states_take_part_in_damped_modes(maxwell_shaft) -> None:
    k, tau, stiff = 5e3, 2e-3, 1e4
    model = compiled(*chain([3.0, 1.0], [stiff]), maxwell_shaft("rubber", "disk_0", "disk_1", stiffness=k, relaxation=tau))
    # u'' = -(4/3) (c u + T), T' = k u' - T / tau
    values = np.linalg.eigvals([[0, 1, 0], [-stiff * 4 / 3, 0, -4 / 3], [0, k, -1 / tau]])
    vibrating = values[values.imag > 0][0]
    result = modal(model)
    assert result.decay_rates == pytest.approx([-vibrating.real], rel=1e-9)
    assert result.damped_frequencies * 2 * np.pi == pytest.approx([vibrating.imag], rel=1e-9)


def test_the_lowest_modes_only() -> None:
    model = lower(assemble(load("fracturing-truck")))
    every, some = modal(model), modal(model, count=4)
    assert not some.complete
    assert every.complete
    assert some.frequencies.tolist() == every.frequencies[:4].tolist()
    assert some.kinetic.sum(axis=0) == pytest.approx(1)


def test_parameters_by_name() -> None:
    model = compiled(*chain([3.0, 1.0], [1e4]))
    stiff = modal(model, {"shaft_0.stiffness": "40 kN*m/rad"})
    assert stiff.frequencies[1] == pytest.approx(2 * modal(model).frequencies[1], rel=1e-12)


@pytest.mark.parametrize("count", [0, -1, 2.0, True])
def test_a_count_that_is_none_is_refused(count: object) -> None:
    with pytest.raises(CaseError, match=r"modal, count: is .*; give a whole number from 1 up"):
        modal(compiled(*chain([3.0, 1.0], [1e4])), count=count)


def test_plain_equations_have_no_modes() -> None:
    import sympy

    from modelgen import system

    x = sympy.Symbol("x")
    with pytest.raises(CaseError, match="has no inertias that could vibrate"):
        modal(lower(system({"x": 1.0}, {x: -x}, {})))


def test_the_table_in_words() -> None:
    text = str(modal(compiled(*chain([3.0, 1.0], [1e4]))))
    assert "all 2, 1 rigid" in text
    assert "disk_1 75%, shaft_0 100%" in text
