"""The equivalent system out, and in again: the same natural frequencies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from modelgen import (
    Driveline,
    GearPair,
    GroundDamper,
    GroundSpring,
    HarmonicTorque,
    Inertia,
    RigidGear,
    Shaft,
    assemble,
    load,
    lower,
    modal,
    operating_point,
)
from modelgen.errors import CaseError, ModelFileError
from modelgen.exchange.equivalent_system import EquivalentInertia, EquivalentTable, equivalent_table
from modelgen.exchange.mass_elastic import read_mass_elastic
from modelgen.model import Element, Flange, Param, quantity


def table_of(line: Driveline) -> tuple[EquivalentTable, np.ndarray, np.ndarray]:
    """Table, natural frequencies and damping ratios of a driveline."""
    model = lower(assemble(line))
    point = operating_point(model)
    found = modal(model, point=point)
    return equivalent_table(model, point), np.asarray(found.frequencies), np.asarray(found.damping_ratios)


def grounded() -> Driveline:
    """A branched train on ground with an elastic mesh, a rigid gear, and a loop of shafts."""
    return Driveline(
        "grounded",
        speed="600 rpm",
        reference="motor",
        elements=(
            HarmonicTorque("drive", "motor", mean=100.0),
            Inertia("motor", inertia=2.0),
            Inertia("pinion", inertia=0.1),
            Inertia("wheel", inertia=1.5),
            Inertia("mill", inertia=30.0),
            Inertia("fan", inertia=0.4),
            Shaft("coupling", "motor", "pinion", stiffness=2e5, damping="value", damping_coefficient=30.0),
            GearPair("mesh", "pinion", "wheel", teeth_a=21, teeth_b=64, module="5 mm", mean_stiffness="9e8 N/m"),
            Shaft("output", "wheel", "mill", stiffness=3e6, damping_ratio=0.01),
            Shaft("bypass", "mill", "wheel", stiffness=1e6),
            RigidGear("belt", "motor", "fan_shaft.a", teeth_a=3, teeth_b=1),
            Shaft("fan_shaft", b="fan", stiffness=1e4),
            GroundSpring("mounting", "mill", stiffness=5e4, damping=10.0),
            GroundDamper("air", "fan", damping=0.2),
        ),
    )


@pytest.mark.parametrize("name", ["fracturing-truck", "fracturing-truck-commensurate"])
def test_the_truck_out_and_in_again(tmp_path: Path, name: str) -> None:
    table, frequencies, damping = table_of(load(name))
    again = read_mass_elastic(table.write(tmp_path / "truck.csv"), "again")
    _, found, found_damping = table_of(again)
    assert found[1:] == pytest.approx(frequencies[1:], rel=1e-12)
    assert found_damping == pytest.approx(damping, rel=1e-9)
    assert (table.reference, table.remarks) == ("flywheel", ())
    assert len(table.shafts) == 15


def test_a_grounded_and_geared_network_out_and_in_again(tmp_path: Path) -> None:
    table, frequencies, damping = table_of(grounded())
    _, found, found_damping = table_of(read_mass_elastic(table.write(tmp_path / "grounded.csv"), "again"))
    assert found == pytest.approx(frequencies, rel=1e-12)
    assert found_damping == pytest.approx(damping, rel=1e-9)
    shafts = {each.elements: each for each in table.shafts}
    assert shafts["output", "bypass"].stiffness == pytest.approx(4e6 * (21 / 64) ** 2, rel=1e-13)
    assert shafts[("mounting",)].end == "ground"
    assert shafts[("mounting",)].stiffness == pytest.approx(5e4 * (21 / 64) ** 2, rel=1e-9)
    assert shafts[("air",)].damping == pytest.approx(0.2 * 9, rel=1e-9)


def test_the_truck_table_refers_by_the_square_of_the_ratio() -> None:
    table, _, _ = table_of(load("fracturing-truck"))
    bull = next(each for each in table.inertias if each.name == "bull_gear")
    r = 26 / 46 * 17 / 108
    assert (bull.inertia, bull.ratio, bull.referred) == (95.0, pytest.approx(r, rel=1e-14), pytest.approx(95 * r**2, rel=1e-14))
    propeller = next(each for each in table.shafts if each.elements == ("propeller_shaft",))
    assert propeller.stiffness == pytest.approx(5.5e5 * (26 / 46) ** 2, rel=1e-12)
    text = table.csv()
    assert text.startswith("# equivalent system of fracturing-truck, referred to flywheel\nname,J_referred [kg*m^2],ratio,to,")
    assert "\nbull_gear," in text
    assert ",221/2484," in text


def test_modal_damping_belongs_to_no_shaft(tmp_path: Path) -> None:
    table, frequencies, _ = table_of(load("fracturing-truck").change("shaft", damping="modal"))
    assert {each.damping for each in table.shafts} == {None}
    assert table.remarks == ("damping is modal and belongs to no single shaft: left out",)
    assert "# damping is modal" in table.csv()
    _, found, _ = table_of(read_mass_elastic(table.write(tmp_path / "truck.csv"), "again"))
    assert found[1:] == pytest.approx(frequencies[1:], rel=1e-12)


@pytest.mark.parametrize(
    ("reference", "expected"),
    [("motor", [(1.0, 3.0), (0.5, 1.0)]), ("wheel", [(1.0, 12.0), (1.0, 4.0)]), ("mill", [(2.0, 12.0), (1.0, 4.0)])],
)
def test_the_same_train_referred_to_each_of_its_shafts(reference: str, expected: list[tuple[float, float]]) -> None:
    elements = (
        Inertia("motor", inertia=1.0),
        Inertia("wheel", inertia=8.0),
        Inertia("mill", inertia=4.0),
        RigidGear("gear", "motor", "wheel", teeth_a=1, teeth_b=2),
        Shaft("output", "wheel", "mill", stiffness=1e4),
    )
    table, _, _ = table_of(Driveline("geared", reference=reference, elements=elements))
    assert table.reference == reference
    assert [(each.ratio, each.referred) for each in table.inertias] == expected


def test_a_ratio_that_no_teeth_make_is_written_and_then_asked_for(tmp_path: Path) -> None:
    inertias = EquivalentInertia("a", 1.0, 1.0, 1.0), EquivalentInertia("b", 1.0, 0.5, 2**-0.5)
    table = EquivalentTable("t", "a", inertias, ())
    with pytest.raises(ModelFileError, match=r"0.70710678.* is a decimal, but teeth are whole numbers; write it as a fraction"):
        read_mass_elastic(table.write(tmp_path / "t.csv"), "t")


class WeakeningJoint(Element):
    """A spring whose stiffness may be negative, and whose mass turns with the sum of both angles."""

    a, b = Flange(), Flange()
    stiffness = Param("N*m/rad")
    shared = Param("kg*m^2", default=0.0)

    @quantity("rad")
    def twist(self) -> object:
        return self.a.angle - self.b.angle

    def torques(self) -> dict[object, object]:
        return {self.a: -self.stiffness * self.twist, self.b: self.stiffness * self.twist}

    def kinetic_energy(self) -> object:
        return self.shared * (self.a.speed + self.b.speed) ** 2 / 2


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"stiffness": -10.0}, "system of 'joined': the stiffness of joint is -10 N[*]m/rad; choose an operating point"),
        ({"stiffness": 10.0, "shared": 0.1}, "inertia couples 'a' and 'b'; tabulate only inertias on single shafts"),
    ],
)
def test_what_is_no_equivalent_system(values: dict[str, float], words: str) -> None:
    line = Driveline(
        "joined",
        reference="a",
        elements=(
            Inertia("a", inertia=1.0),
            Inertia("b", inertia=2.0),
            WeakeningJoint("joint", "a", "b", **values),
            GroundSpring("mounting", "b", stiffness=1e3),
        ),
    )
    model = lower(assemble(line))
    with pytest.raises(CaseError, match=words):
        equivalent_table(model, operating_point(model))


def test_a_table_that_cannot_be_written(tmp_path: Path) -> None:
    table, _, _ = table_of(grounded())
    with pytest.raises(CaseError, match=r"none/table.csv: cannot be written: No such file"):
        table.write(tmp_path / "none" / "table.csv")
