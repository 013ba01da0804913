"""Dimensions of expressions, function by function."""

from __future__ import annotations

import pytest
import sympy

from modelgen.equations.dimensions import DimensionCheck
from modelgen.errors import UnitError
from modelgen.model import PeriodicTable
from modelgen.units import NUMBER, dimension_of

ANGLE, LENGTH, SPEED, FORCE = sympy.symbols("angle length speed force", real=True)
CHECK = DimensionCheck(
    {ANGLE: NUMBER, LENGTH: dimension_of("m"), SPEED: dimension_of("m/s"), FORCE: dimension_of("N")}, "shaft 's'"
)
LAWFUL = [
    (FORCE * LENGTH, "J"),
    (FORCE * LENGTH / 2 + 3 * FORCE * LENGTH, "J"),
    (sympy.sqrt(FORCE * LENGTH) * sympy.sqrt(FORCE / LENGTH), "N"),
    (SPEED**3 / LENGTH, "m^2/s^3"),
    (sympy.sin(ANGLE) + sympy.exp(LENGTH / LENGTH) + sympy.pi, "1"),
    (sympy.atan2(LENGTH, 2 * LENGTH), "rad"),
    (sympy.Max(LENGTH, 2 * LENGTH, 0), "m"),
    (sympy.Min(0, FORCE), "N"),
    (sympy.Abs(FORCE), "N"),
    (sympy.sign(FORCE) * sympy.Heaviside(SPEED), "1"),
    (sympy.Mod(LENGTH, 3 * LENGTH), "m"),
    (sympy.Piecewise((FORCE, sympy.And(SPEED > 0, LENGTH < 2 * LENGTH)), (0, True)), "N"),
    (PeriodicTable(ANGLE, FORCE, 2 * FORCE), "N"),
    (PeriodicTable(ANGLE, FORCE, 2 * FORCE).diff(ANGLE), "N"),
    (ANGLE**ANGLE, "1"),
]


@pytest.mark.parametrize(("expression", "unit"), LAWFUL)
def test_dimensions_follow_through(expression, unit):
    assert CHECK.of(expression, "it") == dimension_of(unit)
    CHECK.require(expression, unit, "it")


def test_zero_has_every_dimension():
    for zero in (sympy.Integer(0), sympy.Float(0.0), 0 * FORCE):
        assert CHECK.of(zero, "it") is None
        CHECK.require(FORCE + zero, "N", "it")


@pytest.mark.parametrize(
    ("expression", "words"),
    [
        (FORCE + LENGTH, r"adds force \[kg\*m/s\^2\] and length \[m\]"),
        (FORCE + 1, r"adds .* and .*; check the units of its parameters"),
        (LENGTH + SPEED, r"; did you mean a speed where an angle stands, or an angle where a speed stands\?"),
        (sympy.Max(FORCE, SPEED), "compares"),
        (sympy.atan2(FORCE, SPEED), "compares"),
        (sympy.Mod(FORCE, SPEED), "compares"),
        (sympy.exp(FORCE), r"takes a function or power of force \[kg\*m/s\^2\]; make the argument a number"),
        (PeriodicTable(FORCE, 1, 2), r"takes a function or power of force"),
        (PeriodicTable(ANGLE, FORCE, SPEED), "tabulates force"),
        (PeriodicTable(ANGLE, FORCE, LENGTH).diff(ANGLE), "tabulates|adds"),
        (FORCE**ANGLE, "raises force .* to angle; only numbers may have such powers"),
    ],
)
def test_what_does_not_agree_is_named(expression, words):
    with pytest.raises(UnitError, match=f"^shaft 's': it .*{words}" if not words.startswith(("tabulates|", ";")) else words):
        CHECK.require(expression, "N", "it")


def test_long_expressions_are_shortened():
    long = sum(sympy.Symbol(f"force_{n}", real=True) for n in range(40))
    check = DimensionCheck(dict.fromkeys(long.free_symbols, dimension_of("N")), "shaft 's'")
    with pytest.raises(UnitError, match=r"^shaft 's': torque is force_\d.{40,60}\.\.\. \[kg\*m/s\^2\]; its unit is N\*m"):
        check.require(long, "N*m", "torque")
