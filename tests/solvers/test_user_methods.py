"""A method of the user is a file of numbers: it runs by every back end, and nothing else is touched."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from modelgen import (
    Case,
    Compiled,
    Driveline,
    HardStop,
    HarmonicTorque,
    Inertia,
    Shaft,
    assemble,
    crosscheck,
    load,
    lower,
    operating_point,
    simulate,
)
from modelgen.errors import CaseError, LoweringError
from modelgen.lowering.methods import read_tableau
from modelgen.solvers.lanes import solve_lanes
from modelgen.solvers.problem import SolverOptions
from modelgen.solvers.registry import every_solver, solver_named
from modelgen.solvers.simulate import initial_value_problem

pytestmark = pytest.mark.usefixtures("own_cache")

# Bogacki and Shampine, Appl. Math. Lett. 2 (1989) 321-325.
PAIR = """
name = "bogacki_shampine"
order = 3
error_orders = [2]
locates_events = true
crosscheck_tolerance = 1e-9
c = ["0", "1/2", "0.75"]
a = [[], ["1/2"], ["0", "3/4"]]
b = ["2/9", "1/3", "4/9"]
errors = [["-5/72", "1/12", "1/9", "-1/8"]]
"""
# Kutta's rule of three eighths (1901), without an error of its own.
RULE = """
name = "three_eighths"
description = "Kutta's rule of three eighths"
order = 4
locates_events = true
c = ["0", "1/3", "2/3", "1"]
a = [[], ["1/3"], ["-1/3", "1"], ["1", "-1", "1"]]
b = ["1/8", "3/8", "3/8", "1/8"]
"""
ORDERS = {"bogacki_shampine": 3, "three_eighths": 5}  # doubled and extrapolated: one more
Files = dict[str, Path]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    made = tmp_path / "methods"
    made.mkdir()
    (made / "bogacki_shampine.toml").write_text(PAIR, encoding="utf-8")
    (made / "three_eighths.toml").write_text(RULE, encoding="utf-8")
    monkeypatch.setenv("MODELGEN_METHODS", str(made))
    return made


def two_disks() -> Compiled:
    parts = [Inertia("a", inertia=2.0), Inertia("b", inertia=3.0), Shaft("s", "a", "b", stiffness=120.0, damping_ratio=0.02)]
    parts.append(HarmonicTorque("t", "a", base="turn", sine=[5.0]))
    return lower(assemble(Driveline("two", elements=parts, speed=9.0, reference="a", bases={"turn": 1})))


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("name", ORDERS)
def test_its_order_is_that_of_its_table_by_every_back_end(name: str) -> None:
    model = two_disks()
    case = Case(model, end=1.0, start={"s.twist": 0.05}, samples=2)
    exact = simulate(case.change(solver="dop853", tolerance=1e-13)).states[-1]
    for backend in ("vm", "c"):
        sizes, errors = [0.02, 0.01, 0.005], []
        for size in sizes:
            run = simulate(case.change(solver=name, options={"backend": backend, "fixed_step": size}))
            errors.append(np.abs(run.states[-1] - exact).max())
        assert np.polyfit(np.log(sizes), np.log(errors), 1)[0] == pytest.approx(ORDERS[name], abs=0.25)


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("name", ORDERS)
def test_it_takes_the_same_steps_on_the_virtual_machine_in_c_and_in_lanes(name: str) -> None:
    model = two_disks()
    runs = [simulate(Case(model, end=1.0, start="zero", solver=name, options={"backend": each})) for each in ("vm", "c")]
    case = Case(model, end=1.0, start="zero", solver=name)
    problems = [initial_value_problem(case, operating_point(model))[0]] * 3
    lanes = solve_lanes(problems, SolverOptions(case.tolerance), method=name).trajectories
    assert {run.statistics.steps for run in (*runs, *lanes)} == {runs[0].statistics.steps}
    for trajectory in lanes:
        assert trajectory.states == pytest.approx(runs[1].states, rel=1e-12, abs=1e-14)
    assert runs[1]["s.twist"] == pytest.approx(runs[0]["s.twist"], rel=1e-10, abs=1e-14)


@pytest.mark.slow
@pytest.mark.usefixtures("folder")
def test_it_locates_events_and_stands_in_a_cross_check() -> None:
    parts = [Inertia("a", inertia=0.4), Inertia("b", inertia=0.6), HardStop("s", "a", "b", clearance=0.1, restitution=0.7)]
    line = Driveline("ball", elements=[*parts, HarmonicTorque("p", "a", mean=5.0)], drifts=True)
    for name in ORDERS:
        for backend in ("vm", "c"):
            case = Case(line, end=0.6, start="zero", options={"backend": backend}, tolerance=1e-8)
            known, found = simulate(case), simulate(case.change(solver=name))
            assert len(found.events.times) == len(known.events.times) > 2
            assert found.events.times == pytest.approx(known.events.times, abs=1e-7)
    gear = Case(load("two-disk-gear"), end=0.02)
    result = crosscheck(gear, ("dop853", *ORDERS), {"dop853": (1e-10,), **dict.fromkeys(ORDERS, (1e-08,))})
    assert result.worst_relative_difference < 1e-5
    assert solver_named("bogacki_shampine").crosscheck_tolerance == 1e-9
    assert list(every_solver())[-2:] == ["bogacki_shampine", "three_eighths"]


def test_a_changed_table_is_another_method(folder: Path) -> None:
    case = Case(two_disks(), end=0.1, solver="three_eighths")
    before = case.digest()
    assert before == case.change().digest()
    (folder / "three_eighths.toml").write_text(RULE.replace("crosscheck", "#").replace("true", "false"), encoding="utf-8")
    assert case.digest() != before


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"2/9"', '"2/8"', r"bogacki_shampine': b: the condition of order 1"),
        ("order = 3", "order = 4", r"the condition of order 4 for the tree"),
        ("error_orders = [2]", "error_orders = [3]", r"errors, row 0: the condition of order 3"),
        ("locates_events", "finds_events", r"has the key 'finds_events'; nearest is 'locates_events'"),
        ("order = 3", 'order = "3"', r"order is '3'; give a int"),
        ("order = 3", "order = 30", r"is of order 30 with 3 stages; known are orders 1 to 10"),
        ('c = ["0", "1/2", "0.75"]', "", r"has no c; a table needs"),
        ('"0.75"', "0.75", r", c: holds 0.75; give numbers as texts"),
        ('"0.75"', '"1e999999999"', r", c: holds '1e999999999'"),
        ('"0.75"', '"3/0"', r", c: holds no number"),
        ('"0.75"', '"."', r", c: holds '.'"),
        ('"bogacki_shampine"', '"another"', r"holds the method 'another'; give the file the name of its method"),
        ("order = 3", "order = = 3", r"is no TOML file"),
        ("crosscheck_tolerance = 1e-9", "crosscheck_tolerance = 0.0", r"crosscheck_tolerance is 0.0; give a number"),
    ],
)
def test_a_wrong_table_is_one_sentence(folder: Path, old: str, new: str, words: str) -> None:
    (folder / "bogacki_shampine.toml").write_text(PAIR.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(LoweringError, match=words):
        read_tableau("bogacki_shampine")


def test_names_and_folders(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(CaseError, match=r"none named 'three_eights'; nearest is 'three_eighths'"):
        solver_named("three_eights")
    (folder / "rk4.toml").write_text(RULE.replace("three_eighths", "rk4"), encoding="utf-8")
    with pytest.raises(LoweringError, match=r"the name 'rk4' belongs to the package"):
        every_solver()
    (folder / "rk4.toml").rename(folder / "cvodes.toml")
    with pytest.raises(LoweringError, match=r"'cvodes': has the name of a solver of the package"):
        every_solver()
    monkeypatch.setenv("MODELGEN_METHODS", str(folder / "nowhere"))
    with pytest.raises(LoweringError, match=r"\$MODELGEN_METHODS: '.*nowhere' is no folder"):
        every_solver()
