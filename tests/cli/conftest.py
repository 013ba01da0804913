"""Two small drivelines as model files, and the command line called in this process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from modelgen.cli.commands import commands

SMALL = """
format = 1
name = "small"
description = "A motor drives a fan through a coupling and a gear pair. Data made up for tests."

[operation]
speed = "1500 rpm"
reference = "motor"
balance = ["load"]

[bases.motor_order]
shaft = "motor"
order = 2

[[limits]]
rule = "syt_5211_angle"

[parameters]
zeta = 0.2
xi = 0.1
drive_mean = { value = "100 N*m", note = "made up" }
drive_cosine = { unit = "N*m", values = [30.0, 10.0] }

[elements.motor]
kind = "inertia"
inertia = "0.3 kg*m^2"
note = "estimate | of ours"

[elements.pinion]
kind = "inertia"
inertia = "0.05 kg*m^2"

[elements.fan]
kind = "inertia"
inertia = "1.5 kg*m^2"

[elements.coupling]
kind = "shaft"
a = "motor"
b = "pinion"
stiffness = "20 kN*m/rad"
damping_ratio = "zeta"

[elements.mesh]
kind = "gear_pair"
a = "pinion"
b = "fan"
teeth_a = 20
teeth_b = 40
module = "3 mm"
mesh = "geometry"
face_width = "25 mm"
half_backlash = "40 um"
damping_ratio = "xi"

[elements.drive]
kind = "harmonic_torque"
flange = "motor"
base = "motor_order"
mean = "drive_mean"
cosine = "drive_cosine"

[elements.load]
kind = "harmonic_torque"
flange = "fan"
mean = "-150 N*m"
"""

TWO_DISKS = """
format = 1
name = "two-disks"
[operation]
speed = "1200 rpm"
reference = "engine"
[bases.firing]
order = 3
[parameters]
shaft_diameter = "80 mm"
[elements.engine]
kind = "inertia"
inertia = "3 kg*m^2"
[elements.load]
kind = "inertia"
inertia = "1 kg*m^2"
[elements.shaft]
kind = "shaft"
a = "engine"
b = "load"
stiffness = "300 kN*m/rad"
damping = "value"
damping_coefficient = "20 N*m*s/rad"
[elements.shaking]
kind = "harmonic_torque"
flange = "engine"
base = "firing"
cosine = { unit = "N*m", values = [40.0, 10.0] }
"""

Invoke = Callable[..., Result]


@pytest.fixture(scope="session")
def invoke() -> Invoke:
    """``invoke("check", path)`` runs a command in this process; its result holds exit code, stdout and stderr."""

    def call(*arguments: object) -> Result:
        result = CliRunner().invoke(commands, [str(each) for each in arguments], prog_name="modelgen")
        # Only the ways out that a person may meet; anything else is a fault of the program.
        assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
        return result

    return call


@pytest.fixture(scope="session")
def two_disks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The model file of two disks on a shaft, of which everything is known: 100.658 Hz, orders 3 and 6 of the engine."""
    path = tmp_path_factory.mktemp("models") / "two_disks.toml"
    path.write_text(TWO_DISKS, encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The model file of a small geared driveline."""
    path = tmp_path_factory.mktemp("models") / "small.toml"
    path.write_text(SMALL, encoding="utf-8")
    return path
