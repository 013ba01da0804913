"""Nodes of modes, their numbers and names, and orders in words."""

from __future__ import annotations

import numpy as np
import pytest

from modelgen import Driveline, HarmonicTorque, Inertia, RigidGear, Shaft, assemble, campbell, load, lower, modal
from modelgen.analysis.linear.campbell import order_lines
from modelgen.plots import plot


def test_the_modes_of_a_train_without_branches_have_1_2_3_nodes() -> None:
    """Sturm: the k-th vibrating mode of a chain has k nodes; the truck is a chain through its gears."""
    result = modal(lower(assemble(load("fracturing-truck"))))
    assert result.nodes.tolist() == list(range(16))
    assert [result.name(mode) for mode in range(3)] == ["rigid", "mode 1", "mode 2"]
    assert [result.number(mode) for mode in range(3)] == [None, 1, 2]


def test_an_inertia_that_stands_still_is_a_node() -> None:
    """Equal ends on a middle disk: in mode 1 the middle stands still, mode 2 has a node in either shaft."""
    disks = [Inertia(name, inertia=1.0) for name in "abc"]
    shafts = [Shaft("s", "a", "b", stiffness=1e4), Shaft("t", "b", "c", stiffness=1e4)]
    result = modal(lower(assemble(Driveline("three", elements=[*disks, *shafts]))))
    assert abs(result.shapes[1, 1]) < 1e-9
    assert result.nodes.tolist() == [0, 1, 2]


def test_shapes_are_drawn_at_the_nodes_that_they_belong_to() -> None:
    """Behind a rigid gear of 1:2 the far disk swings most; drawn by group it would stand where the wheel is."""
    line = Driveline("geared", reference="a", speed="1000 rpm", elements=[
        *(Inertia(name, inertia=j) for name, j in (("a", 1.0), ("b", 1.0), ("c", 1.0), ("d", 5.0))),
        Shaft("s1", "a", "b", stiffness=1e4), RigidGear("g", "b", "c", teeth_a=20, teeth_b=40),
        Shaft("s2", "c", "d", stiffness=1e4)])  # fmt: skip
    result = modal(lower(assemble(line)))
    figure = plot(result, driveline=line)
    for mode, axes in zip((1, 2), figure.axes, strict=False):
        (drawn,) = [np.asarray(row.get_ydata()) for row in axes.lines if row.get_marker() == "o"]
        names = [label.get_text() for label in figure.axes[-1].get_xticklabels()]
        shape = dict(zip(result.names, result.referred[:, mode], strict=True))
        largest = max(shape.values(), key=abs)
        assert drawn == pytest.approx([shape[name] / largest for name in names], abs=1e-12)
        assert axes.get_title("left").startswith(f"mode {mode}: f = {result.frequencies[mode]:.4g} Hz, ζ = 0 %")


def six_cylinders() -> Driveline:
    """Six throws that fire 120 degrees of crank apart, 60 of their base: order 1.5 cancels in the sum, order 3 adds up."""
    throws = [Inertia(f"throw_{n}", inertia=0.1) for n in range(6)]
    cranks = [Shaft(f"crank_{n}", f"throw_{n}", f"throw_{n + 1}", stiffness=1e6) for n in range(5)]
    firing = [
        HarmonicTorque(f"firing_{n}", f"throw_{n}", base="half", phase=f"{60 * n} deg", orders=[3, 6], cosine=[500.0, 100.0])
        for n in range(6)
    ]
    return Driveline("six", speed="1500 rpm", reference="throw_0", bases={"half": "1/2"}, elements=[
        *throws, *cranks, *firing, Inertia("load", inertia=10.0), Shaft("shaft", "throw_5", "load", stiffness=1e5)])  # fmt: skip


def test_orders_rank_by_the_vector_sum_of_all_sources() -> None:
    model = lower(assemble(six_cylinders()))
    base, minor, major = order_lines(model, 1500 * np.pi / 30, None)
    assert (base.name, base.torque) == ("order 0.5 (half x 1)", 0.0)
    assert (minor.name, major.name) == ("order 1.5 (half x 3)", "order 3 (half x 6)")
    assert minor.torque == pytest.approx(500.0)
    assert major.torque == pytest.approx(100.0)
    assert minor.vector_sum == pytest.approx(0.0, abs=1e-9)
    assert major.vector_sum == pytest.approx(600.0)


def test_critical_speeds_bear_the_number_of_their_mode() -> None:
    result = campbell(lower(assemble(six_cylinders())), ["500 rpm", "4000 rpm"])
    assert {each.number for each in result.critical} <= set(range(1, 7))
    assert all(each.number == each.mode for each in result.critical)  # one rigid mode before them
    assert "mode 1 (" in str(result)
