"""Sensitivities against central differences of the whole chain from parameters by name to frequencies, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen import (
    Driveline,
    Element,
    Flange,
    GearPair,
    HarmonicTorque,
    Inertia,
    NamedParameter,
    Param,
    Shaft,
    assemble,
    load,
    lower,
    modal,
    quantity,
)
from modelgen.analysis import sensitivities
from modelgen.errors import CaseError


def central_difference(model, name, value, base=None):
    """Slope of all frequencies with one parameter, through everything that follows from it."""
    h = 1e-4 * abs(value) or 1e-4
    ends = [modal(model, {**(base or {}), name: value + step}).frequencies for step in (-h, h, -h / 2, h / 2)]
    coarse, fine = (ends[1] - ends[0]) / (2 * h), (ends[3] - ends[2]) / h
    return (4 * fine - coarse) / 3


def agrees(model, result, names, base=None) -> None:
    for name in names:
        value = result.values[result.parameters.index(name)]
        expected = central_difference(model, name, value, base)
        assert result[name] == pytest.approx(expected, abs=1e-6 * max(np.abs(expected).max(), 1e-12)), name


def test_shared_parameters_and_expressions() -> None:
    """One stiffness for two shafts, one inertia as an expression of it and a length."""
    line = Driveline(
        "shared",
        elements=(
            Inertia("a", inertia=2.0), Inertia("b", inertia="disk"), Inertia("c", inertia="disk"),
            Shaft("first", "a", "b", stiffness="rod"), Shaft("second", "b", "c", stiffness="rod"),
        ),
        parameters={
            "radius": NamedParameter(0.2, "m"),
            "density": NamedParameter(40.0, "kg/m^4"),
            "rod": NamedParameter(3e4, "N*m/rad"),
            "disk": NamedParameter(unit="kg*m^2", expression="density * radius**6"),
        },
    )  # fmt: skip
    model = lower(assemble(line))
    result = sensitivities(model)
    agrees(model, result, ["rod", "radius", "density", "a.inertia"])
    assert result.relative[1, result.parameters.index("rod")] == pytest.approx(0.5, rel=1e-12)
    by_radius, by_density = (result.relative[:, result.parameters.index(name)] for name in ("radius", "density"))
    assert by_radius == pytest.approx(6 * by_density, rel=1e-12)
    assert set(result.methods) == {"derivative"}
    # The inertia set by hand no longer follows the radius, and the radius no longer matters.
    by_hand = sensitivities(model, {"disk": 0.01})
    assert by_hand["radius"] == pytest.approx(0, abs=1e-12)
    agrees(model, by_hand, ["disk"], {"disk": 0.01})


def from_teeth() -> Driveline:
    """Four disks and a mesh whose stiffness follows from its teeth."""
    return Driveline(
        "teeth", speed="1200 rpm", reference="motor",
        elements=(
            *(Inertia(name, inertia=j) for name, j in (("motor", 1.0), ("pinion", 0.2), ("wheel", 0.8), ("fan", 1.2))),
            Shaft("input_shaft", "motor", "pinion", stiffness=2e6),
            GearPair("mesh", "pinion", "wheel", teeth_a=26, teeth_b=46, module="7 mm", mesh="geometry", face_width="60 mm"),
            Shaft("output_shaft", "wheel", "fan", stiffness=4e6),
            HarmonicTorque("drive", "motor", mean=260.0), HarmonicTorque("drag", "fan", mean=-460.0),
        ),
    )  # fmt: skip


def test_derived_parameters_by_differences_and_said_so() -> None:
    model = lower(assemble(from_teeth()))
    result = sensitivities(model)
    names = [f"mesh.{name}" for name in ("module", "face_width", "profile_shift_a", "poisson_ratio", "shear_factor")]
    agrees(model, result, [*names, "input_shaft.stiffness", "wheel.inertia"])
    method = dict(zip(result.parameters, result.methods, strict=True))
    assert {method[name] for name in names} == {"differences"}
    assert method["input_shaft.stiffness"] == "derivative"
    assert result.whole == ("mesh.teeth_a", "mesh.teeth_b")
    unit = dict(zip(result.parameters, result.units, strict=True))
    assert unit["input_shaft.stiffness"] == "N*m/rad"
    # Springs and inertias together only set the unit of time.
    springs = [k for k, name in enumerate(result.parameters) if name.endswith((".stiffness", ".young_modulus"))]
    inertias = [k for k, name in enumerate(result.parameters) if name.endswith(".inertia")]
    assert result.relative[1:, springs].sum(axis=1) == pytest.approx(0.5, rel=1e-6)
    assert result.relative[1:, inertias].sum(axis=1) == pytest.approx(-0.5, rel=1e-9)
    assert np.all(result.slopes[0] == 0)


def test_every_form_of_mesh_stiffness() -> None:
    settings = {
        "fourier": {"mean_stiffness": 2e7, "stiffness_cosine": [3e6]},
        "table": {"stiffness_table": [2.0e7, 2.4e7, 1.8e7]},
        "rectangular": {"stiffness_high": 3e7, "stiffness_low": 1.6e7, "contact_ratio": 1.6},
    }
    for form, values in settings.items():
        line = Driveline(
            "geared", speed="1200 rpm", reference="motor",
            elements=(
                *(Inertia(name, inertia=j) for name, j in (("motor", 1.0), ("pinion", 0.2), ("fan", 1.2))),
                Shaft("shaft", "motor", "pinion", stiffness=2e4),
                GearPair("mesh", "pinion", "fan", teeth_a=20, teeth_b=40, module="5 mm", mesh=form, **values),
                HarmonicTorque("drive", "motor", mean=100.0), HarmonicTorque("drag", "fan", mean=-200.0),
            ),
        )  # fmt: skip
        model = lower(assemble(line))
        result = sensitivities(model)
        agrees(model, result, [name for name in result.parameters if name.startswith("mesh.") and result[name].any()])
        assert np.count_nonzero(result.slopes[2]) >= 5


@pytest.fixture
def stiffening_shaft():
    """A shaft whose stiffness grows with the twist; it leaves the vocabulary after the test."""

    class StiffeningShaft(Element):
        """T = k u + k3 u^3."""

        a, b = Flange(), Flange()
        stiffness = Param("N*m/rad", positive=True)
        cubic = Param("N*m/rad", nonnegative=True)

        @quantity("rad")
        def twist(self):
            return self.a.angle - self.b.angle

        @quantity("N*m")
        def torque(self):
            return self.stiffness * self.twist + self.cubic * self.twist**3

        def torques(self):
            return {self.a: -self.torque, self.b: self.torque}

    yield StiffeningShaft
    del Element.vocabulary["stiffening_shaft"]


def stiffening(shaft, cubic=5e5):
    return Driveline(
        "fan", speed="1200 rpm", reference="engine", balanced=("drive",),
        elements=(
            Inertia("engine", inertia=3.0), Inertia("fan", inertia=1.0),
            shaft("coupling", "engine", "fan", stiffness=2e4, cubic=cubic),
            HarmonicTorque("drive", "engine", mean=1.0), HarmonicTorque("drag", "fan", mean=-900.0),
        ),
    )  # fmt: skip


def test_a_stiffness_that_depends_on_the_load(stiffening_shaft) -> None:
    """The drag twists the coupling: the frequency depends on it through the static angle, by differences."""
    model = lower(assemble(stiffening(stiffening_shaft)))
    result = sensitivities(model)
    agrees(model, result, ["drag.mean", "coupling.stiffness", "coupling.cubic", "engine.inertia"])
    method = dict(zip(result.parameters, result.methods, strict=True))
    assert method["drag.mean"] == "differences"
    assert result["drag.mean"][1] < -1e-3


def test_a_parameter_at_its_limit_of_zero(stiffening_shaft) -> None:
    model = lower(assemble(stiffening(stiffening_shaft, cubic=0.0)))
    result = sensitivities(model)
    # k = k1 + 3 k3 u^2 with u = T / k1 to the first order in k3.
    torque = 900.0 * 1.0
    slope = 3 * (torque / 2e4) ** 2 / 2e4 / 2 * result.frequencies[1]
    assert result["coupling.cubic"][1] == pytest.approx(slope, rel=1e-9)


def test_repeated_modes_split() -> None:
    """Three equal blades: of the two equal modes, one keeps still when the third blade becomes stiffer."""
    blades = [Inertia(f"blade_{n}", inertia=0.5) for n in range(3)]
    stems = [Shaft(f"stem_{n}", "hub", f"blade_{n}", stiffness=2e4) for n in range(3)]
    model = lower(assemble(Driveline("rotor", elements=(Inertia("hub", inertia=2.0), *blades, *stems))))
    result = sensitivities(model)
    assert result.repeated == ((1, 2),)
    still, moved = result["stem_2.stiffness"][1:3]
    assert still == pytest.approx(0, abs=1e-12)
    h = 2e4 * 1e-5
    ends = [modal(model, {"stem_2.stiffness": 2e4 + step}).frequencies for step in (-h, h)]
    # Stiffer, the mode that moves is the upper one; softer, the lower one.
    assert moved == pytest.approx((ends[1][2] - ends[0][1]) / (2 * h), rel=1e-6)


def test_the_lowest_only_and_wrong_names() -> None:
    model = lower(assemble(from_teeth()))
    result = sensitivities(model, count=3)
    assert result.slopes.shape == (3, len(result.parameters))
    name, slope = result.largest(1, 1)[0]
    assert slope == result.relative[1, result.parameters.index(name)]
    assert abs(slope) == np.abs(result.relative[1]).max()
    with pytest.raises(CaseError, match=r"no parameter 'output_shaft.stifness'; nearest is 'output_shaft.stiffness'"):
        result["output_shaft.stifness"]
    with pytest.raises(CaseError, match=r"'mesh.teeth_a' is a whole number"):
        result["mesh.teeth_a"]


@pytest.mark.slow
def test_every_parameter_of_the_truck() -> None:
    model = lower(assemble(load("fracturing-truck")))
    result = sensitivities(model)
    moving = [name for name in result.parameters if result[name].any()]
    assert len(moving) > 40
    agrees(model, result, moving)
