"""Mass-elastic tables: what they become, and what is said of those that cannot be read."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from modelgen import Driveline, assemble, lower, modal
from modelgen.elements import GroundSpring, Inertia, RigidGear, Shaft
from modelgen.errors import ModelFileError, ModelgenError, UnitError
from modelgen.exchange.mass_elastic import read_mass_elastic

TWO_DISKS = "name,J [kg*m^2],k [N*m/rad]\nengine,211.4,9.775e6\nload,8.3,\n"


def read(tmp_path: Path, text: str) -> Driveline:
    path = tmp_path / "table.csv"
    path.write_text(text, encoding="utf-8")
    return read_mass_elastic(path, "train")


def frequencies(line: Driveline) -> list[float]:
    return [float(each) for each in modal(lower(assemble(line))).frequencies]


def test_two_disks(tmp_path: Path) -> None:
    """176.1 Hz: the two-disk test of openTorsion."""
    line = read(tmp_path, TWO_DISKS)
    assert line.elements == (
        Inertia("engine", inertia=211.4),
        Inertia("load", inertia=8.3),
        Shaft("engine_to_load", "engine", "load", stiffness=9.775e6),
    )
    assert line.reference == "engine"
    assert frequencies(line)[1] == pytest.approx(176.0767, abs=1e-4)


@pytest.mark.parametrize(
    "text",
    [
        "Name;Inertia [kgm²];Torsional stiffness [MNm/rad]\nengine;211,4;9,775\nload;8,3;\n",
        "﻿# maker's table\nPART\tJ (g*m^2)\tSTIFFNESS (kN*m/rad)\nengine\t211400\t9775,0\n\nload\t8300\t\n",
        "name,J [kg*m^2],k [N*m/rad],to\nload,8.3,,\nengine,211.4,9.775e6,load\n",
        "name,J_referred [kg*m^2],k_referred [N*m/rad],ratio\nengine,211.4,9.775e6,1\nload,8.3,,1.0\n",
    ],
)
def test_the_same_train_in_other_hands(tmp_path: Path, text: str) -> None:
    assert frequencies(read(tmp_path, text))[1] == pytest.approx(176.0767, abs=1e-4)


def test_further_columns_are_left_out_and_named(tmp_path: Path) -> None:
    table = "No;Name;J [kgm2];GD2 [kgm2];k [MNm/rad];Remarks\n1;engine;211,4;845;9,775;as built\n2;load;8,3;33;;\n"
    line = read(tmp_path, table)
    assert frequencies(line)[1] == pytest.approx(176.0767, abs=1e-4)
    assert line.description == "Mass-elastic table table.csv. Columns that were not read: No, GD2, Remarks."


@pytest.mark.parametrize(("ratio", "teeth"), [("26/46", (13, 23)), ("13:23", (13, 23)), ("0.25", (1, 4)), ("2,5", (5, 2))])
def test_a_changed_ratio_becomes_a_gear_behind_the_shaft(tmp_path: Path, ratio: str, teeth: tuple[int, int]) -> None:
    """omega^2 = k (1/J_a + 1/(r^2 J_b)): the far inertia referred to the first shaft by r^2."""
    line = read(tmp_path, f"name;J [kg*m^2];k [N*m/rad];ratio\nengine;3;4e5;1\npump;9;;{ratio}\n")
    gear = line["engine_to_pump_gear"]
    assert isinstance(gear, RigidGear)
    assert (gear.values["teeth_a"], gear.values["teeth_b"]) == teeth
    r = teeth[0] / teeth[1]
    expected = math.sqrt(4e5 * (1 / 3 + 1 / (r**2 * 9))) / (2 * math.pi)
    assert frequencies(line) == [0.0, pytest.approx(expected, rel=1e-13)]


def test_rows_of_two_speeds_without_stiffness_are_the_wheels_of_a_gear(tmp_path: Path) -> None:
    text = "name,J [kg*m^2],k [N*m/rad],ratio\nmotor,2,1e5,1\npinion,0.1,,1\nwheel,0.8,5e5,1/3\nmill,40,,1/3\n"
    line = read(tmp_path, text)
    assert [element.name for element in line.elements if isinstance(element, RigidGear)] == ["pinion_to_wheel_gear"]
    referred = "name,J [kg*m^2],k [N*m/rad]\nmotor,2,1e5\ngear," + f"{0.1 + 0.8 / 9!r},{5e5 / 9!r}\nmill,{40 / 9!r},\n"
    assert frequencies(line)[1:] == pytest.approx(frequencies(read(tmp_path, referred))[1:], rel=1e-12)


def test_referred_values_are_those_of_the_reference_shaft(tmp_path: Path) -> None:
    line = read(tmp_path, "name,J_referred [kg*m^2],k_referred [N*m/rad],ratio\nmotor,2,1e5,1\nmill,5,2e5,1/2\nfan,1,,1/2\n")
    assert line["mill"].values["inertia"] == 20.0
    assert line["mill_to_fan"].values["stiffness"] == 8e5
    assert line["motor_to_mill"].values["stiffness"] == 1e5
    plain = read(tmp_path, "name,J [kg*m^2],k [N*m/rad]\nmotor,2,1e5\nmill,5,2e5\nfan,1,\n")
    assert frequencies(line)[1:] == pytest.approx(frequencies(plain)[1:], rel=1e-12)


def test_branches_ground_and_further_connections(tmp_path: Path) -> None:
    text = """name;J [kg*m^2];k [N*m/rad];damping [N*m*s/rad];to;shaft;diameter [mm]
engine;3;1e5;20;gearbox;input;80
gearbox;1;;;;;
pump 1;2;5e4;;gearbox;;
pump 2;2;6e4;;gearbox;;
pump 2;;1e3;4;ground;mounting;
"""
    line = read(tmp_path, text)
    assert line["mounting"] == GroundSpring("mounting", "pump_2", stiffness=1e3, damping=4.0)
    assert line["input"] == Shaft("input", "engine", "gearbox", stiffness=1e5, damping="value", damping_coefficient=20.0)
    assert line["pump_1_to_gearbox"].targets == {"a": "pump_1", "b": "gearbox"}
    assert line["pump_1"].note == "pump 1"
    assert line.parameters["input_diameter"].value == pytest.approx(0.08)
    assert frequencies(line)[0] > 1.0


def test_a_plain_damping_is_a_ratio(tmp_path: Path) -> None:
    line = read(tmp_path, "name,J [kg*m^2],k [N*m/rad],damping\na,1,1e4,0.02\nb,1,,\n")
    assert modal(lower(assemble(line))).damping_ratios == pytest.approx([0.02], rel=1e-9)


HEAD = "name;J [kg*m^2];k [N*m/rad];ratio;to;damping [N*m*s/rad];diameter [mm];shaft\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name;J [kg*m^2]\na;1\n", r"line 1: has no column 'k', it has 'name', 'J'; write k \[N\*m/rad\] in the header"),
        ("name;J [kg*m^2];k [N*m/rad];rato\na;1;;\n", "line 1, column 'rato': is no known column; nearest is 'ratio'"),
        ("name;J;k [N*m/rad]\na;1;\n", r"line 1, column 'J': the header names no unit; write it as J \[kg\*m\^2\]"),
        ("name;J [kg*m];k [N*m/rad]\na;1;\n", "column 'J': 'kg\\*m' has the dimension .*'kg\\*m\\^2'"),
        ("name;J [kg*m^2];k [N*m/rad]\n", "has a header but no rows"),
        (HEAD + "a;x;1;1\nb;1;;1\n", "line 2, column 'J': 'x' is not a number"),
        (HEAD + "a;-1;1;1\nb;1;;1\n", "line 2, column 'J': is -1; give a positive value"),
        (HEAD + "a;0;1;1\nb;1;;1\n", "line 2, column 'J': is 0; give a positive value"),
        (HEAD + "a;;1;1\nb;1;;1\n", "line 2, column 'J': is empty; give the moment of inertia"),
        (HEAD + ";1;1;1\nb;1;;1\n", "line 2, column 'name': is empty; write a name of letters and digits"),
        (HEAD + "???;1;1;1\nb;1;;1\n", r"line 2, column 'name': '\?\?\?' cannot be a name"),
        (HEAD + "a;1;1;1\nwhile;1;;1\n", "line 3, column 'name': name 'while' is a keyword of C"),
        (HEAD + "ground;1;1;1\nb;1;;1\n", "line 2, column 'name': is 'ground', which is where no shaft turns"),
        (HEAD + "a;1;1;1\na;1;;1\n", "line 3, column 'name': 'a' is taken by line 2; rename one of them"),
        (HEAD + "a;1;0;1\nb;1;;1\n", "line 2, column 'k': is 0; give a positive value"),
        (HEAD + "a;1;;1;b\nb;1;;1\n", "line 2, column 'k': is empty between rows of the same speed; give the stiffness to 'b'"),
        (HEAD + "a;1;1;1\nb;1;7;1\n", "line 3, column 'k': is 7, but no row follows; leave it empty"),
        (HEAD + "a;1;1;1\nb;1;;\n", "line 3, column 'ratio': is empty; give the speed per speed of the reference shaft"),
        (HEAD + "a;1;1;1\nb;1;;0.5652\n", "column 'ratio': 0.5652 is a decimal, but teeth are whole numbers; .*, perhaps 13/23"),
        (HEAD + "a;1;1;1\nb;1;;-2\n", "column 'ratio': is -2; give a positive ratio such as 26/46: angles count forward"),
        (HEAD + "a;1;1;1\nb;1;;3/0\n", "column 'ratio': is 3/0; give a positive ratio"),
        (HEAD + "a;1;1;1\nb;1;;two\n", "column 'ratio': 'two' is not a number"),
        (HEAD + "a;1;1;2\nb;1;;2\n", "line 1, column 'ratio': no row has 1; ratios count from the reference shaft"),
        (HEAD + "a;1;1;1\nb;1;;1/9999991\n", "leads to 'b' by 1/9999991, more than 1000000 teeth"),
        (HEAD + "a;1;1;1;c\nb;1;;1\n", "line 2, column 'to': there is no row 'c'; known are a, b, ground"),
        (HEAD + "a;1;1;1;a\nb;1;;1\n", "line 2, column 'to': joins 'a' to itself; name another row"),
        (HEAD + "a;1;1;1;b\nb;1;;1\nc;1;;1\n", "line 4, column 'to': nothing joins 'c' to 'a'; give k in the row before"),
        (HEAD + "a;1;;1;ground\nb;1;;1\n", "line 2, column 'k': is empty on the way to ground"),
        (HEAD + "a;1;1;1;b;-3\nb;1;;1\n", "line 2, column 'damping': is -3; give zero or a positive value"),
        (HEAD + "a;1;;1;b;3\nb;1;;1/2\n", "line 2, column 'damping': is given without a stiffness"),
        (HEAD + "a;1;1;1;b\nb;1;;1;;;80\n", "line 3, column 'diameter': is 80, but no row follows"),
        (HEAD + "a;1;1;1;b;;0\nb;1;;1\n", "line 2, column 'diameter': is 0; give a positive value"),
        (HEAD + "a;1;1;1;b;;;b\nb;1;;1\n", "the name 'b' is given twice"),
        ("name;J [kg*m^2];k_referred [N*m/rad]\na;1;1\nb;1;\n", "column 'k_referred': stands beside physical inertias; refer"),
        ("name;J_referred [kg*m^2];k [N*m/rad]\na;1;1\nb;1;\n", "column 'k': stands beside referred inertias"),
    ],
)
def test_a_bad_table_is_refused_by_line_and_column(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(ModelgenError, match=words) as refused:
        read(tmp_path, text)
    assert isinstance(refused.value, (ModelFileError, UnitError)) or "given twice" in words or "keyword" in words
    assert str(refused.value).startswith(str(tmp_path / "table.csv"))
