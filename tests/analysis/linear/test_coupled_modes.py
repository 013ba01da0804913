"""Modes where matrices are not symmetric: laws on one flange, forces that circulate, gyroscopic coupling; and modes that grow.

What they are held against: eigenvalues of M^-1 K, or of the whole first-order matrix, of matrices that are written down here.
"""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from modelgen import (
    Driveline,
    Element,
    Flange,
    GroundDamper,
    GroundSpring,
    HarmonicTorque,
    Inertia,
    Param,
    Shaft,
    campbell,
    forced,
    lower,
    modal,
    operating_point,
    sensitivities,
)
from modelgen.analysis import phase_vectors
from modelgen.cli.modal import modal_data, modal_text
from modelgen.equations import assemble
from modelgen.errors import CaseError
from modelgen.reports.report import _modes as report_modes


class Follower(Element):
    """A drive that follows: torque on one flange, the reaction in the casing."""

    a, b = Flange(), Flange()
    stiffness = Param("N*m/rad")

    def torques(self):
        return {self.a: -self.stiffness * (self.a.angle - self.b.angle)}


class Circulation(Element):
    """Skew stiffness."""

    a, b = Flange(), Flange()
    stiffness = Param("N*m/rad")

    def torques(self):
        return {self.a: self.stiffness * self.b.angle, self.b: -self.stiffness * self.a.angle}


class Gyro(Element):
    """Skew damping, which takes no power."""

    a, b = Flange(), Flange()
    momentum = Param("N*m*s/rad")

    def torques(self):
        return {self.a: self.momentum * self.b.speed, self.b: -self.momentum * self.a.speed}


class Buckling(Element):
    """Negative stiffness to the casing."""

    flange = Flange()
    stiffness = Param("N*m/rad")

    def torques(self):
        return {self.flange: self.stiffness * self.flange.angle}


def compiled(*elements, **settings):
    return lower(assemble(Driveline("line", elements=elements, **settings)))


def disks(*names, inertia=0.5):
    return tuple(Inertia(name, inertia=inertia) for name in names)


def two_grounds(stiff_a=20.0, stiff_b=30.0):
    return (*disks("a", "b"), GroundSpring("g", "a", stiffness=stiff_a), GroundSpring("h", "b", stiffness=stiff_b))


def upper(matrix):
    values = np.linalg.eigvals(matrix)
    return values[values.imag > 1e-9 * np.abs(values)]


def first_order(mass, damping, stiffness):
    n = len(mass)
    return np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]])


def test_a_law_on_one_flange_alone_and_beside_a_shaft() -> None:
    follower, shaft = Follower("follower", "a", "b", stiffness=5.0), Shaft("shaft", "a", "b", stiffness=10.0)
    for elements, square in (((follower,), 10.0), ((follower, shaft), 50.0)):
        result = modal(compiled(*disks("a", "b"), *elements))
        assert result.rigid == 1
        assert result.frequencies == pytest.approx([0.0, np.sqrt(square) / 2 / np.pi], rel=1e-12)
        assert result.shapes[:, 0] == pytest.approx([1.0, 1.0], rel=1e-12)
        assert result.damped(1).ratio == 0.0
        assert result.growth.tolist() == [0.0, 0.0]
        assert result.remarks[0].startswith("the stiffness is not symmetric: ")
        assert result.remarks[0] in str(result)
        assert result.kinetic.sum(axis=0) == pytest.approx([1.0, 1.0])
        assert result.potential.sum(axis=0) == pytest.approx([0.0, 1.0])
    assert result.shapes[:, 1] == pytest.approx([1.0, -2 / 3], rel=1e-12)


def test_campbell_has_the_same_frequencies() -> None:
    elements = (*disks("a", "b"), Shaft("s", "a", "b", stiffness=10.0), Follower("f", "a", "b", stiffness=5.0))
    drive = HarmonicTorque("d", "a", base="o", mean=0.0, cosine=[1.0])
    model = compiled(*elements, drive, speed="100 rpm", reference="a", bases={"o": ("a", 1)})
    result = campbell(model, [1.0, 20.0])
    assert result.frequencies[:, 1] == pytest.approx(np.sqrt(50) / 2 / np.pi, rel=1e-12)
    assert "the stiffness is not symmetric" in str(result)
    assert [(each.number, each.line.order) for each in result.critical] == [(1, Fraction(1))]
    answer = forced(model, [5.0])
    twist = np.linalg.solve(np.array([[15, -15], [-10, 10]]) - 25 * np.diag([0.5, 0.5]), [1.0, 0.0])
    assert abs(answer["s.twist"][0, 0]) == pytest.approx(abs(twist[0] - twist[1]), rel=1e-9)
    with pytest.raises(CaseError, match=r"phase vectors of 'line': rest on shapes .* the stiffness is not symmetric; ask forced"):
        phase_vectors(model)


def test_gyroscopic_coupling_belongs_to_the_conservative_problem() -> None:
    result = modal(compiled(*two_grounds(), Gyro("gyro", "a", "b", momentum=3.0)))
    wanted = upper(first_order(np.eye(2) / 2, np.array([[0, -3.0], [3.0, 0]]), np.diag([20.0, 30.0])))
    assert result.frequencies == pytest.approx(np.sort(wanted.imag) / 2 / np.pi, rel=1e-12)
    assert result.frequencies == pytest.approx([0.7265680, 1.7079283], rel=1e-6)
    assert result.damped_frequencies == pytest.approx(result.frequencies, rel=1e-12)
    assert [result.damped(k).ratio for k in (0, 1)] == [0.0, 0.0]
    assert "rates are coupled gyroscopically" in str(result)
    assert result.kinetic.sum(axis=0) == pytest.approx([1.0, 1.0])


def test_gyroscopic_terms_leave_rigid_rotation_alone() -> None:
    model = compiled(*disks("a", "b", "c"), Shaft("s", "a", "b", stiffness=10.0), Shaft("t", "b", "c", stiffness=20.0),
                     Gyro("gyro", "a", "c", momentum=1.0))  # fmt: skip
    result = modal(model)
    gyro = np.array([[0, 0, -1.0], [0, 0, 0], [1.0, 0, 0]])
    stiffness = np.array([[10.0, -10, 0], [-10, 30, -20], [0, -20, 20]])
    wanted = np.sort(upper(first_order(np.eye(3) / 2, gyro, stiffness)).imag)[-2:]
    assert result.rigid == 1
    assert result.frequencies == pytest.approx([0.0, *wanted / 2 / np.pi], rel=1e-9)


def test_two_free_disks_with_a_gyroscopic_coupling_alone_circle() -> None:
    result = modal(compiled(*disks("a", "b"), Gyro("gyro", "a", "b", momentum=3.0)))
    assert result.rigid == 1
    assert result.frequencies == pytest.approx([0.0, 6.0 / 2 / np.pi], rel=1e-12)


def test_forces_that_circulate_make_a_mode_grow() -> None:
    result = modal(compiled(*two_grounds(20.0, 20.0), Circulation("c", "a", "b", stiffness=3.0)))
    growing = np.sqrt(np.linalg.eigvals(-2 * np.array([[20.0, -3.0], [3.0, 20.0]])) + 0j)
    assert np.sort(result.growth) == pytest.approx([0.0, np.abs(growing.real[0])], rel=1e-12)
    assert result.frequencies == pytest.approx(np.abs(growing.imag) / 2 / np.pi, rel=1e-12)
    unstable = int(result.growth.argmax())
    assert result.damped(unstable).growth == pytest.approx(0.47302052, rel=1e-7)
    assert "unstable, grows with 0.473 1/s" in str(result.damped(unstable))
    assert "unstable" not in str(result.damped(1 - unstable))


def test_a_negative_stiffness_is_called_unstable_and_not_overdamped() -> None:
    model = compiled(*disks("a"), Buckling("k", "a", stiffness=2.5625))
    result = modal(model)
    rate = np.sqrt(2 * 2.5625)
    assert result.growth == pytest.approx([rate])
    assert result.damped(0).growth == pytest.approx(rate)
    assert "unstable, grows with 2.264 1/s" in str(result)
    assert "overdamped" not in str(result)
    text = modal_text(result)
    assert "mode 1 is unstable, it does not oscillate: it departs with the rate 2.26385 1/s" in text
    assert "overdamped" not in text
    assert "it departs with the rate" in modal_data(result, sensitivities(model))["remarks"][0]


def test_the_report_and_campbell_say_unstable() -> None:
    drive = HarmonicTorque("d", "a", base="o", mean=0.0, cosine=[1.0])
    elements = (*two_grounds(20.0, 20.0), Circulation("c", "a", "b", stiffness=3.0), drive)
    model = compiled(*elements, speed="100 rpm", reference="a", bases={"o": ("a", 1)}, drifts=True)
    rows = report_modes(SimpleNamespace(modes=modal(model)))
    assert sorted("unstable" in row.damping for row in rows) == [False, True]
    said = campbell(model, [5.0, 20.0]).remarks
    words = "is unstable from 47.7465 to 190.986 rpm, at 2 of 2 speeds: it grows with up to 0.473 1/s"
    assert any(words in each for each in said)


def test_an_overdamped_mode_is_none_that_grows() -> None:
    model = compiled(Inertia("a", inertia=1.0), GroundSpring("g", "a", stiffness=1.0), GroundDamper("d", "a", damping=10.0))
    assert modal(model).damped(0).growth == 0.0
    assert "overdamped" in str(modal(model))


@pytest.mark.parametrize("seed", range(20))
def test_any_matrices_give_the_eigenvalues_of_the_whole(seed: int) -> None:
    """A law of modes: whatever is coupled, the damped modes are the eigenvalues of the first-order matrix, once each."""
    rng = np.random.default_rng(seed)
    names = ("a", "b", "c")
    inertia = rng.uniform(0.2, 2.0, 3)
    model = compiled(
        *(Inertia(name, inertia=each) for name, each in zip(names, inertia, strict=True)),
        *(GroundSpring(f"g{n}", n, stiffness=k) for n, k in zip(names, rng.uniform(20, 60, 3), strict=True)),
        *(GroundDamper(f"d{n}", n, damping=c) for n, c in zip(names, rng.uniform(0.05, 0.3, 3), strict=True)),
        Shaft("s", "a", "b", stiffness=rng.uniform(5, 20)),
        Follower("f", "b", "c", stiffness=rng.uniform(1, 5)),
        *((Gyro("gyro", "a", "c", momentum=rng.uniform(0.5, 3)),) if seed % 2 else ()),
    )
    point, result = operating_point(model), modal(model)
    skew = (point.damping - point.damping.T) / 2
    for damping, found in ((skew, result.frequencies), (point.damping, result.damped_frequencies)):
        wanted = np.sort(upper(first_order(point.mass, damping, point.stiffness)).imag)
        assert np.sort(found * 2 * np.pi) == pytest.approx(wanted, rel=1e-9)
    assert sorted(result.pair.tolist()) == [0, 1, 2]
    assert modal(model, count=2).frequencies == pytest.approx(result.frequencies[:2])


@pytest.mark.parametrize("gyro", [False, True])
def test_slopes_are_those_of_the_frequencies(gyro: bool) -> None:
    elements = (*two_grounds(), Shaft("s", "a", "b", stiffness=10.0), Follower("f", "a", "b", stiffness=5.0))
    model = compiled(*elements, *((Gyro("gyro", "a", "b", momentum=1.5),) if gyro else ()))
    slopes = sensitivities(model)
    assert ("gyro.momentum" in slopes.parameters) == gyro
    for name, value in zip(slopes.parameters, slopes.values.tolist(), strict=True):
        if not value:
            continue
        h = 1e-5 * value
        up, down = (modal(model, {name: value + step}).frequencies for step in (h, -h))
        assert slopes[name] == pytest.approx((up - down) / (2 * h), rel=1e-5, abs=1e-9), name


def test_a_free_motion_that_is_pushed_is_refused() -> None:
    class Pushed(Element):
        a, b = Flange(), Flange()
        stiffness = Param("N*m/rad")

        def torques(self):
            return {self.a: self.stiffness * self.b.angle}

    with pytest.raises(CaseError, match="the stiffness is not symmetric: a motion that meets no stiffness is pushed by another"):
        modal(compiled(*disks("a", "b"), Pushed("p", "a", "b", stiffness=2.0)))
