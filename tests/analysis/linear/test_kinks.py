"""Laws with a kink or a jump where the driveline rests are named; smooth ones, and kinks elsewhere, are not."""

from __future__ import annotations

import pytest
import sympy

from modelgen import (
    Driveline,
    ElasticStop,
    Element,
    Flange,
    GroundSpring,
    HarmonicTorque,
    Inertia,
    Param,
    Shaft,
    campbell,
    forced,
    load,
    lower,
    modal,
    sensitivities,
)
from modelgen.equations import assemble

SAID = "the law of law has a kink at the operating point: what is linear takes one slope there"


class Law(Element):
    """Torque on one flange by its angle less ``at``."""

    flange = Flange()
    stiffness = Param("N*m/rad")
    at = Param("rad", default=0.0)

    def of(self, x):
        return self.stiffness * sympy.Max(0, x)

    def torques(self):
        return {self.flange: -self.of(self.flange.angle - self.at)}


class Folded(Law):
    def of(self, x):
        return self.stiffness * sympy.Abs(x)


class Choice(Law):
    def of(self, x):
        return sympy.Piecewise((2 * self.stiffness * x, x >= 0), (self.stiffness * x, True))


class Jump(Law):
    def of(self, x):
        return self.stiffness * sympy.sign(x)


class Root(Law):
    """Hertz: the slope begins at zero, as a root does."""

    def of(self, x):
        return self.stiffness * sympy.Max(0, x) ** sympy.Rational(3, 2)


class Smooth(Law):
    def of(self, x):
        return self.stiffness * sympy.tanh(1000 * x)


class Same(Law):
    """Two branches that meet without a kink."""

    def of(self, x):
        return sympy.Piecewise((self.stiffness * x, x >= 0), (self.stiffness * sympy.sin(x), True))


def compiled(law, **settings):
    elements = (Inertia("a", inertia=0.5), Inertia("b", inertia=0.5), Shaft("s", "a", "b", stiffness=10.0))
    return lower(assemble(Driveline("line", elements=[*elements, GroundSpring("g", "a", stiffness=10.0), law], **settings)))


@pytest.mark.parametrize("law", [Law, Folded, Choice, Jump])
def test_a_law_that_rests_on_its_kink_is_named(law: type[Law]) -> None:
    result = modal(compiled(law("law", "b", stiffness=1e6)))
    assert result.remarks[0].startswith(SAID)
    assert SAID in str(result)


@pytest.mark.parametrize("law", [Root, Smooth, Same])
def test_a_law_with_one_slope_is_not(law: type[Law]) -> None:
    assert modal(compiled(law("law", "b", stiffness=1e3))).remarks == ()


def test_a_kink_elsewhere_is_none_here() -> None:
    for at in (1e-5, -1e-5):
        assert modal(compiled(Law("law", "b", stiffness=1e-3, at=at))).remarks == ()


def test_a_stop_with_clearance_rests_inside_and_one_without_is_a_spring() -> None:
    for clearance, highest in ((1e-5, None), (0.0, 1e6)):
        result = modal(compiled(ElasticStop("law", "a", "b", stiffness=1e6, clearance=clearance)))
        assert result.remarks == ()
        if highest:
            assert result.frequencies[-1] == pytest.approx((highest * 4) ** 0.5 / 6.283185307, rel=1e-4)


def test_every_linear_question_says_so() -> None:
    drive = {"speed": "100 rpm", "reference": "a", "bases": {"o": ("a", 1)}, "drifts": True}
    elements = [Inertia("a", inertia=0.5), Inertia("b", inertia=0.5), Shaft("s", "a", "b", stiffness=10.0),
                HarmonicTorque("d", "a", base="o", mean=0.0, cosine=[1.0]),
                Law("law", "b", stiffness=1e6)]  # fmt: skip
    model = lower(assemble(Driveline("line", elements=elements, **drive)))
    for answer in (modal(model), campbell(model, [5.0, 20.0]), forced(model, [5.0]), sensitivities(model)):
        assert any(SAID in each for each in answer.remarks)
    assert SAID in str(campbell(model, [5.0, 20.0]))
    assert SAID in str(forced(model, [5.0]))


def test_the_catalogue_rests_on_no_kink() -> None:
    for name in ("fracturing-truck", "two-disk-gear"):
        assert modal(lower(assemble(load(name)))).remarks == ()
