"""Units at the border and dimensions inside: values exact, foreign text refused by its words and never evaluated."""

from __future__ import annotations

import math
import time

import pytest

from modelgen.errors import UnitError
from modelgen.units import NUMBER, Dimension, dimension_of, read_any, read_quantity


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("35 kN*m/deg", "N*m/rad", 35e3 * 180 / math.pi),
        ("1900 rpm", "rad/s", 1900 * math.pi / 30),
        ("60 turn/s", "rad/s", 120 * math.pi),
        ("75 um", "m", 75e-6),
        ("20 deg", "rad", math.pi / 9),
        ("206 GPa", "Pa", 206e9),
        ("1 kg*mm^2", "kg*m^2", 1e-6),
        ("3 lbf*ft", "N*m", 3 * 4.4482216152605 * 0.3048),
        ("2 N*m/(rad/s)", "N*m*s/rad", 2.0),
        ("10 percent", "1", 0.1),
        ("-1.5e-3 m", "m", -1.5e-3),
    ],
)
def test_a_text_becomes_its_si_value(text: str, unit: str, value: float) -> None:
    assert read_quantity(text, unit, "test") == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("5 Nm", "N*m", 5.0),
        ("3 kNm", "N*m", 3e3),
        ("0.6 MNm/rad", "N*m/rad", 0.6e6),
        ("5 mNm", "N*m", 5e-3),
        ("5 dNm", "N*m", 0.5),
        ("120 cNm", "N*m", 1.2),
        ("5 Nmm", "N*m", 5e-3),
        ("5 N·m/rad", "N*m/rad", 5.0),
        ("1 Nm/°", "N*m/rad", 180 / math.pi),
        ("5 Nms/rad", "N*m*s/rad", 5.0),
        ("5 Nm·s/rad", "N*m*s/rad", 5.0),
        ("5 Nm s/rad", "N*m*s/rad", 5.0),
        ("2 rad/Nm", "rad/(N*m)", 2.0),
        ("2 kgm2", "kg*m^2", 2.0),
        ("2 kgm²", "kg*m^2", 2.0),
        ("2 kg·m²", "kg*m^2", 2.0),
        ("2 kg m^2", "kg*m^2", 2.0),
        ("2 kg⋅m2", "kg*m^2", 2.0),
        ("2 kgcm2", "kg*m^2", 2e-4),
        ("2 tm2", "kg*m^2", 2e3),
        ("9.81 m·s⁻²", "m/s^2", 9.81),
        ("40 µm", "m", 40e-6),  # the micro sign
        ("40 μm", "m", 40e-6),  # the Greek letter
        ("1500 U/min", "rad/s", 50 * math.pi),
        ("1500 1/min", "rad/s", 50 * math.pi),
        ("1500 min⁻¹", "rad/s", 50 * math.pi),
        ("1500 min-1", "rad/s", 50 * math.pi),
        ("1500 r/min", "rad/s", 50 * math.pi),
    ],
)
def test_units_as_engineers_write_them(text: str, unit: str, value: float) -> None:
    """``Nm`` is a torque here, never the count of a yarn."""
    assert read_quantity(text, unit, "test") == pytest.approx(value, rel=1e-14)


def test_such_units_of_whatever_dimension() -> None:
    assert read_any("5 kNm", "test") == (5000.0, "kg*m^2/s^2")
    assert read_any("3 kgm2", "test") == (3.0, "kg*m^2")
    assert read_any("1500 U/min", "test")[0] == pytest.approx(50 * math.pi, rel=1e-14)


@pytest.mark.parametrize("value", [0.1, 1 / 3, 6.5e6, 1e-300, 5e-324, 123456789.123456789])
def test_a_unit_as_declared_costs_no_digit(value: float) -> None:
    assert read_quantity(f"{value!r} N*m/rad", "N*m/rad", "test") == value


@pytest.mark.parametrize(
    ("text", "unit", "words"),
    [
        ("5 Nm", "m", r"'Nm' has the dimension .*'m' .* is asked for"),
        ("5 N/m", "N*m", "is asked for"),
        ("10 Hz", "rad/s", "is ambiguous for an angular speed; write rad/s, rpm or turn/s"),
        ("5", "N*m", r'has no unit; write "5.0 N\*m"'),
        ("1e999 N*m", "N*m", "is not a finite number"),
        ("five N*m", "N*m", "is not a number with a unit"),
        ("7 kgm", "m", r"has the dimension \[mass\] \* \[length\]"),
        ("7 knm", "N*m", "is not a known unit"),
        ("1,5 Nm", "N*m", "has a comma in its number; write a decimal point"),
        ("3,000 rpm", "rad/s", "has a comma in its number"),
        ("1.234,5 N*m", "N*m", "has a comma in its number"),
        ("5 NM", "N*m", "is not a known unit"),
        ("1 degC", "1", r"\[temperature\]"),
        ("1 9^9^9^9*m", "m", "is not a known unit"),
        ("1 m^999999999", "m", "is not a known unit"),
        ("1 m**9**9**9", "m", "is not a known unit"),
        ("1 __import__('os')", "m", "is not a known unit"),
        ("1 m.__class__", "m", "is not a known unit"),
        ("1 " + "m*" * 100 + "m", "m", "is not a"),
    ],
)
def test_foreign_text_is_refused_at_once(text: str, unit: str, words: str) -> None:
    begun = time.monotonic()
    with pytest.raises(UnitError, match=words):
        read_quantity(text, unit, "test")
    assert time.monotonic() - begun < 2  # the first text loads pint


def test_any_quantity_gets_an_si_unit() -> None:
    assert read_any("2 kN*m", "test") == (2000.0, "kg*m^2/s^2")
    assert read_any("0.5", "test") == (0.5, "1")
    assert read_any("3 N*m/rad", "test") == (3.0, "N*m/rad")
    value, unit = read_any("1500 rpm", "test")
    assert (value, unit) == (pytest.approx(50 * math.pi), "rad/s")


def test_dimensions_multiply_and_print() -> None:
    assert dimension_of("N*m/rad") == dimension_of("J") == dimension_of("W*s")
    assert dimension_of("rad") == NUMBER
    assert str(dimension_of("N*s/m")) == "kg/s"
    assert (dimension_of("m") / dimension_of("s")) ** 2 == dimension_of("m^2/s^2")
    assert Dimension().is_number


@pytest.mark.parametrize("unit", ["", "Nm", "N m", "*m", "m^", "m^x", "deg"])
def test_a_declared_unit_must_be_si(unit: str) -> None:
    with pytest.raises(UnitError, match="unit"):
        dimension_of(unit)
