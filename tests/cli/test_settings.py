"""Options of the command line become the driveline itself."""

from __future__ import annotations

from pathlib import Path

import pytest

from modelgen.drivelines import load
from modelgen.errors import CaseError, ModelgenError
from modelgen.model import Driveline
from modelgen.reports.settings import common_ratio, common_switch, settle


@pytest.fixture
def line(small: Path) -> Driveline:
    return load(small)


def test_nothing_given_nothing_changed(line: Driveline) -> None:
    assert settle(line) == line


def test_a_shared_parameter_keeps_its_unit_and_note(line: Driveline) -> None:
    named = settle(line, ["drive_mean = 0.2 kN*m"]).parameters["drive_mean"]
    assert (named.value, named.unit, named.note) == (200.0, "N*m", "made up")


def test_a_value_of_one_element_and_of_a_kind(line: Driveline) -> None:
    changed = settle(line, ["fan.inertia=2 kg*m^2"])
    assert [changed[name].values["inertia"] for name in ("motor", "fan")] == [0.3, 2.0]
    changed = settle(line, ["inertia.inertia=2 kg*m^2"])
    assert [changed[name].values["inertia"] for name in ("motor", "fan")] == [2.0, 2.0]


def test_a_switch_of_an_element(line: Driveline) -> None:
    assert settle(line, ["mesh.viscous=contact_only"])["mesh"].choices["viscous"] == "contact_only"


def test_a_switch_takes_its_parameters_along(line: Driveline) -> None:
    """The ratio that the old form used goes, what the new one needs comes with it."""
    changed = settle(line, ["coupling.damping_coefficient=30 N*m*s/rad"], damping="value")["coupling"]
    assert changed.choices["damping"] == "value"
    assert changed.values["damping_coefficient"] == 30.0
    assert "damping_ratio" not in changed.values


def test_named_damping_reaches_every_element_of_the_kind(line: Driveline) -> None:
    changed = settle(line, damping="modal", mesh_damping="literal")
    assert (common_switch(changed, "shaft"), common_switch(changed, "gear_pair")) == ("modal", "literal")


def test_what_set_names_is_the_more_particular(line: Driveline) -> None:
    assert settle(line, ["coupling.damping=modal"], damping="per_shaft")["coupling"].choices["damping"] == "modal"


def test_speed_with_its_unit(line: Driveline) -> None:
    for changed in (settle(line, speed="3000 rpm"), settle(line, ["speed=3000 rpm"])):
        assert changed.speed == pytest.approx(314.159265358979)


def test_both_readings_of_the_mesh_damping(line: Driveline) -> None:
    scaled = settle(line, mesh_reading="scaled")
    assert scaled.parameters["xi"].expression == "0.1*zeta/0.035"
    back = settle(scaled, mesh_reading="fixed").parameters["xi"]
    assert (back.value, back.expression) == (0.1, None)
    kept = settle(line, ["xi=0.07"], mesh_reading="fixed").parameters["xi"]
    assert (kept.value, kept.expression) == (0.07, None)


def test_what_elements_have_in_common(line: Driveline) -> None:
    assert common_ratio(line, "shaft") == "zeta"
    assert common_ratio(line, "rigid_gear") is None
    assert common_switch(line, "rigid_gear") is None
    other = line.add(line["coupling"].copy("second", damping_ratio=0.5))
    assert common_ratio(other, "shaft") is None


def test_a_reading_without_gears(line: Driveline) -> None:
    disks = Driveline("disks", elements=(line["motor"],))
    with pytest.raises(CaseError, match="does not share one damping ratio among its shafts"):
        settle(disks, mesh_reading="scaled")


RECTANGLE = {"mesh": "rectangular", "stiffness_high": "4e8 N/m", "stiffness_low": "3e8 N/m", "contact_ratio": "1.6"}


def test_set_takes_what_change_takes(line: Driveline) -> None:
    """Numbers, switches with the parameters that they need, rows of a series, orders, names of shared parameters."""
    for changes in (
        RECTANGLE,
        {"mesh": "fourier", "mean_stiffness": "4e8 N/m", "half_backlash": "xi"},
        {"viscous": "contact_only"},
    ):
        given = [f"mesh.{key}={value}" for key, value in changes.items()]
        assert settle(line, given)["mesh"] == line.change("mesh", **changes)["mesh"]
    wavy = line.change("mesh", mesh="fourier", mean_stiffness=4e8, stiffness_cosine=[1e7, 2e7])
    row = settle(wavy, ["mesh.stiffness_cosine[1]=30 N/um"])
    assert row["mesh"].values["stiffness_cosine"] == pytest.approx((3e7, 2e7))
    assert row == wavy.change("mesh", **{"stiffness_cosine[1]": "30 N/um"})
    assert settle(line, ["load.orders=1,3", "load.cosine=5 N*m, 7 N*m", "load.base=motor_order"])["load"].harmonics == {
        "orders": (1, 3)
    }
    assert settle(line, ["drive_cosine[2]=0.02 kN*m"]).parameters["drive_cosine"].value == (30.0, 20.0)
    assert settle(line, ["drive_cosine[2]=0.02 kN*m"]) == line.set(**{"drive_cosine[2]": "0.02 kN*m"})


@pytest.mark.parametrize(
    ("assignment", "words"),
    [
        ("drive_cosine[3]=1 N*m", r"has no row drive_cosine\[3\]; 'drive_cosine' has 2 rows; rows count from 1"),
        ("drive_mean[1]=1 N*m", r"has no row drive_mean\[1\]; 'drive_mean' has 0 rows"),
        ("drive_cosine=1 N*m", r"a series of 2 numbers; change it in the model file, or a row of it, such as drive_cosine\[1\]"),
        ("drive.cosine[1]=1 N*m", r"cosine is the driveline's parameter 'drive_cosine'; change drive_cosine\[1\]"),
        ("load.cosine[1]=1 N*m", r"has no row 'cosine\[1\]'; 'cosine' has 0 rows"),
        ("mesh.mesh=rectangular", "stiffness_high is missing"),
    ],
)
def test_rows_and_switches_that_are_not_there(line: Driveline, assignment: str, words: str) -> None:
    with pytest.raises(ModelgenError, match=words):
        settle(line, [assignment])
