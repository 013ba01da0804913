"""Channels of a solution: finite or named, within the memory and the budget of time."""

from __future__ import annotations

import pytest

from modelgen import Case, Driveline, GearPair, Inertia, Shaft, assemble, lower, modal, operating_point, simulate, system
from modelgen.errors import CaseError, ModelError
from modelgen.solvers import Budget, Outcome


def line(inertia=1.0, **shaft):
    disks = [Inertia("a", inertia=inertia), Inertia("b", inertia=1.0)]
    return Driveline("line", elements=[*disks, Shaft("coupling", "a", "b", **{"stiffness": 1e4, **shaft})])


def test_an_energy_beyond_double_precision_is_named():
    run = simulate(Case(line(), end=0.1, start={"coupling.twist": 1e160}))
    assert run.outcome is Outcome.NON_FINITE_STATE
    assert run.message.startswith("stopped at t = 0 s: channel 'coupling.stored_energy' became inf")
    assert len(run.times) == 0


@pytest.mark.parametrize("wrong", [{"inertia": 5e-324}, {"damping_ratio": 1e308}])
def test_matrices_beyond_double_precision_are_refused_before_anything_runs(wrong):
    with pytest.raises(CaseError, match="or what it is per inertia there, is beyond double precision; check inertias"):
        operating_point(lower(assemble(line(**wrong))))


def test_outputs_that_do_not_fit_are_refused_with_what_they_take():
    with pytest.raises(CaseError, match=r"case, samples: is 50000000, and \d+ values of each take [\d.e+]+ GB; .* GB are free"):
        simulate(Case(line(), end=0.1, samples=50_000_000, options={"budget": Budget(max_seconds=5.0)}))


def test_the_budget_of_time_covers_the_channels():
    run = simulate(Case(line(), end=1e-6, samples=400_000, options={"budget": Budget(max_seconds=1e-3)}))
    assert run.outcome is Outcome.MAX_TIME


def test_a_stiff_shaft_does_not_hide_the_others_modes():
    disks = [Inertia(name, inertia=1.0) for name in "abc"]
    shafts = [Shaft("s", "a", "b", stiffness=1e18), Shaft("t", "b", "c", stiffness=2e4)]
    model = lower(assemble(Driveline("x", elements=[*disks, *shafts])))
    assert operating_point(model).frequencies() == pytest.approx(modal(model).frequencies, rel=1e-12)
    assert operating_point(model).frequencies()[1] == pytest.approx(27.566444771, rel=1e-9)


@pytest.mark.parametrize("solver", ["cvodes", "rosenbrock", "collocation"])
def test_a_far_horizon_does_not_keep_a_stiff_method_from_its_start(solver):
    """Robertson's reaction to 1e11 s: 2.0833e-8, 8.3333e-14, 0.99999998 (Hairer, Wanner, Solving ODEs II, IV.10)."""
    rates = {"a": "-0.04*a + 1e4*b*c", "b": "0.04*a - 1e4*b*c - 3e7*b**2", "c": "3e7*b**2"}
    model = lower(system({"a": 1.0, "b": 0.0, "c": 0.0}, rates))
    run = simulate(Case(model, end=1e11, start="zero", solver=solver, tolerance=1e-8, samples=5))
    assert run.outcome is Outcome.SUCCESS
    assert run["c"][-1] == pytest.approx(0.9999999791666050, abs=1e-8)
    assert run["a"][-1] == pytest.approx(0.2083340149701255e-07, abs=1e-8)


def pair(**more):
    disks = [Inertia("a", inertia=1.0), Inertia("b", inertia=1.0)]
    mesh = {"teeth_a": 20, "teeth_b": 30, "module": 0.003, "mean_stiffness": 1e8, **more}
    return disks, GearPair("m", "a", "b", **mesh)


def test_a_mesh_that_would_pull_is_refused_with_its_least_stiffness():
    for rows, least in (([1.1e8], "-1e[+]07"), ([2e8], "-1e[+]08")):
        disks, mesh = pair(stiffness_cosine=rows)
        with pytest.raises(ModelError, match=f"its mesh stiffness falls to {least} N/m at 0.5000 of the mesh period"):
            lower(assemble(Driveline("p", speed=100.0, reference="a", elements=[*disks, mesh]))).parameters.vector()
    disks, mesh = pair(stiffness_cosine=[0.6e8, 0.6e8])
    lower(assemble(Driveline("p", speed=100.0, reference="a", elements=[*disks, mesh]))).parameters.vector()


@pytest.mark.parametrize("angle", ["90 deg", "170 deg"])
def test_a_pressure_angle_without_base_circles_is_refused(angle):
    disks, mesh = pair(pressure_angle=angle)
    with pytest.raises(ModelError, match="at which a gear has no base circle; give an angle of some 14 to 30 deg"):
        lower(assemble(Driveline("p", speed=100.0, reference="a", elements=[*disks, mesh]))).parameters.vector()


def test_a_mesh_of_constant_stiffness_needs_no_operating_speed():
    disks, mesh = pair(damping_ratio=0.05)
    model = lower(assemble(Driveline("p", elements=[*disks, mesh])))
    assert modal(model).frequencies[1] > 0
    with pytest.raises(ModelError, match="varies with a base frequency at these values, but there is no operating speed"):
        model.parameters.vector({"m.error_amplitude": 1e-5})
    disks, mesh = pair(stiffness_cosine=[1e7])
    with pytest.raises(ModelError, match=r"has base frequencies .* but no operating speed"):
        assemble(Driveline("p", elements=[*disks, mesh]))


def test_an_element_of_two_speeds_is_no_shaft():
    disks, mesh = pair()
    with pytest.raises(ModelError, match="'m' stands for a shaft, but its flanges turn at different speeds"):
        assemble(Driveline("p", elements=[*disks, mesh], speed=100.0, reference="m"))
