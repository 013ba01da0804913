"""Campbell diagram: orders that excite, crossings with natural frequencies, margins."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from modelgen import (
    Driveline,
    Element,
    Flange,
    GearPair,
    HarmonicTorque,
    Inertia,
    Param,
    Shaft,
    assemble,
    load,
    lower,
    modal,
    quantity,
)
from modelgen.analysis import campbell
from modelgen.analysis.linear.campbell import order_lines
from modelgen.errors import CaseError

RPM = np.pi / 30


def two_disks(**torque):
    return Driveline(
        "two_disks",
        speed="1200 rpm",
        reference="engine",
        bases={"cycle": "1/2"},
        elements=(
            Inertia("engine", inertia=3.0),
            Inertia("load", inertia=1.0),
            Shaft("shaft", "engine", "load", stiffness=3e5),
            HarmonicTorque("firing", "engine", base="cycle", **torque),
        ),
    )


def test_crossings_are_where_order_times_speed_is_the_frequency() -> None:
    model = lower(assemble(two_disks(cosine=[10.0, 0.0, 0.0, 0.0, 0.0, 40.0, 0.0, 5.0])))
    result = campbell(model, np.linspace(20, 500, 9))
    natural = np.sqrt(3e5 * (1 / 3 + 1))
    assert [line.order for line in result.lines] == [Fraction(1, 2), Fraction(3), Fraction(4)]
    assert [line.torque for line in result.lines] == pytest.approx([10, 40, 5])
    assert result.lines[1].label == "cycle x 6"
    assert [each.speed for each in result.critical] == pytest.approx([natural / 4, natural / 3], rel=1e-12)
    assert [each.frequency for each in result.critical] == pytest.approx([natural / (2 * np.pi)] * 2, rel=1e-12)
    assert [each.mode for each in result.critical] == [1, 1]
    assert result.operating == (1200 * RPM, 1200 * RPM)
    assert [each.margin for each in result.critical] == pytest.approx([natural / n / (1200 * RPM) - 1 for n in (4, 3)], rel=1e-12)
    assert result.frequencies[:, 0].tolist() == [0.0] * 9
    assert result.within(0.3) == result.critical[:1]
    assert [each.line.order for each in result.within(1.0, share=0.5)] == [3]


def test_margins_to_a_range() -> None:
    model = lower(assemble(two_disks(cosine=[0.0] * 5 + [40.0, 0.0, 5.0])))
    third, fourth = (np.sqrt(4e5) / n for n in (3, 4))
    result = campbell(model, np.linspace(100, 300, 5), operating=[170.0, 250.0])
    margins = {each.line.order: each.margin for each in result.critical}
    assert margins == {3: 0.0, 4: pytest.approx(fourth / 170 - 1)}
    slower = campbell(model, np.linspace(100, 300, 5), operating=("1000 rpm", "1500 rpm"))
    assert [each.margin for each in slower.critical] == pytest.approx([each / (1500 * RPM) - 1 for each in (fourth, third)])


def test_engine_pump_and_mesh_orders_of_the_truck() -> None:
    model = lower(assemble(load("fracturing-truck")))
    lines = {line.order: line for line in order_lines(model, 1900 * RPM, None, highest_order=30)}
    assert lines[Fraction(3, 2)].sources == (("engine_half_order", 3),)
    assert lines[Fraction(26)].sources == (("transmission_mesh.contact", 1),)
    assert lines[Fraction(26, 46) * 17].sources == (("pump_mesh.contact", 1),)
    assert lines[Fraction(221, 2484) * 3].sources == (("pump_crank", 3),)
    # Its rows are zero for the third and the ninth order.
    assert Fraction(6) in lines
    assert Fraction(3) not in lines
    assert max(lines) <= 30


def test_a_mesh_that_varies_in_nothing_has_its_line_all_the_same() -> None:
    line = Driveline(
        "geared", speed="1200 rpm", reference="motor",
        elements=(
            Inertia("motor", inertia=1.0), Inertia("fan", inertia=2.0),
            GearPair("mesh", "motor", "fan", teeth_a=20, teeth_b=40, module="5 mm", mean_stiffness=2e7),
        ),
    )  # fmt: skip
    result = campbell(lower(assemble(line)))
    assert [(each.order, each.torque) for each in result.lines] == [(20, 0.0)]


@pytest.fixture
def stiffening_shaft():
    """A shaft whose stiffness grows with the twist; it leaves the vocabulary after the test."""

    class StiffeningShaft(Element):
        """T = k u + k3 u^3."""

        a, b = Flange(), Flange()
        stiffness = Param("N*m/rad", positive=True)
        cubic = Param("N*m/rad", positive=True)

        @quantity("rad")
        def twist(self):
            return self.a.angle - self.b.angle

        @quantity("N*m")
        def torque(self):
            return self.stiffness * self.twist + self.cubic * self.twist**3

        def torques(self):
            return {self.a: -self.torque, self.b: self.torque}

        def stored_energy(self):
            return self.stiffness * self.twist**2 / 2 + self.cubic * self.twist**4 / 4

    yield StiffeningShaft
    del Element.vocabulary["stiffening_shaft"]


def test_frequencies_that_rise_with_speed_are_crossed_where_they_are(stiffening_shaft) -> None:
    """A load that grows with the square of the speed twists the shaft into a stiffer part of its curve."""
    line = Driveline(
        "fan", speed="1200 rpm", reference="engine", bases={"firing": 3}, balanced=("drive",),
        elements=(
            Inertia("engine", inertia=3.0), Inertia("fan", inertia=1.0),
            stiffening_shaft("coupling", "engine", "fan", stiffness=2e4, cubic=5e5),
            HarmonicTorque("drive", "engine", mean=1.0, cosine=[0.01], base="firing"), HarmonicTorque("drag", "fan", mean=-1.0),
        ),
    )  # fmt: skip
    model = lower(assemble(line))

    def drag(speed: float) -> dict[str, float]:
        return {"drag.mean": -0.1 * speed**2}

    result = campbell(model, np.linspace(20, 120, 6), drag)
    assert np.all(np.diff(result.frequencies[:, 1]) > 0.05)
    (critical,) = result.critical
    there = modal(model, {"speed": critical.speed, **drag(critical.speed)}).frequencies[1]
    assert critical.frequency == pytest.approx(there, rel=1e-10)
    assert critical.frequency == pytest.approx(3 * critical.speed / (2 * np.pi), rel=1e-12)


def test_speeds_that_are_not_lawful() -> None:
    model = lower(assemble(two_disks(cosine=[10.0])))
    with pytest.raises(CaseError, match=r"speeds: are \[200, 100\]; give positive speeds, the lowest first"):
        campbell(model, [200, 100])
    with pytest.raises(CaseError, match="has no operating speed"):
        campbell(
            lower(
                assemble(
                    Driveline(
                        "one",
                        elements=(Inertia("a", inertia=1.0), Inertia("b", inertia=1.0), Shaft("s", "a", "b", stiffness=1.0)),
                    )
                )
            )
        )
