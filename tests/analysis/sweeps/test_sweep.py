"""sweep: points, statistics, outcomes, engines and refusals by their words."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from modelgen import Case, Element, GearPair, Inertia, Param, Section, Shaft, lower, simulate, system
from modelgen.analysis import SweepResult, sweep
from modelgen.analysis.sweeps.batch import settled
from modelgen.analysis.sweeps.collect import collection_of
from modelgen.analysis.sweeps.points import points_of
from modelgen.analysis.sweeps.work import DEATHS, Work
from modelgen.errors import CaseError, ModelError, NamingError, UnitError
from modelgen.model import Driveline
from modelgen.solvers.problem import Budget

from .cases import COLLECT, small_case

OVER = {"zeta": [0.02, 0.05, 0.1], "speed": ["1000 rpm", "1200 rpm"]}


@pytest.fixture(scope="module")
def case() -> Case:
    return small_case()


@pytest.fixture(scope="module")
def result(case: Case) -> SweepResult:
    return sweep(case, OVER, COLLECT, workers=0)


def test_a_grid_has_one_dimension_per_name(result: SweepResult) -> None:
    assert result["shaft.torque.highest"].shape == (3, 2)
    assert result["zeta"][:, 0].tolist() == [0.02, 0.05, 0.1]
    assert result["speed"][0].tolist() == pytest.approx([1000 * np.pi / 30, 1200 * np.pi / 30])
    assert result.unit("shaft.torque.highest") == "N*m"
    assert result.unit("speed") == "rad/s"
    assert result.succeeded.all()
    assert result.messages == ("",) * 6


def test_every_point_is_what_simulate_says(case: Case, result: SweepResult) -> None:
    settled_case, _ = settled(case)
    for k, (zeta, speed) in enumerate(result.values.tolist()):
        one = settled_case.change(parameters={"zeta": zeta, "speed": speed})
        assert result.keys[k] == one.digest()
        solution = simulate(one)
        torque = solution["shaft.torque"]
        expected = [torque.max(), np.sqrt(np.mean(torque**2)), solution["shaft.twist"][-1]]
        assert result.table[k, :3].tolist() == pytest.approx(expected, rel=1e-9)
        assert result.table[k, 3] == pytest.approx(solution.statistics.steps, abs=2)


def test_statistics_are_what_they_say(case: Case) -> None:
    names = [f"shaft.torque.{each}" for each in ("highest", "lowest", "mean", "rms", "amplitude", "final")]
    result = sweep(case, {"zeta": [0.05]}, [*names, "shaft.torque", "rejected", "events"], workers=0)
    wave = result["shaft.torque"][0]
    assert wave.shape == (41,)
    expected = [wave.max(), wave.min(), wave.mean(), np.sqrt(np.mean(wave**2)), np.ptp(wave) / 2, wave[-1]]
    assert [float(result[name][0]) for name in names] == pytest.approx(expected, rel=1e-12)
    assert result["events"][0] == 0
    assert result.times.tolist() == case.times().tolist()


def test_worker_processes_give_the_same_bytes(case: Case, result: SweepResult, tmp_path: Path) -> None:
    many = {"zeta": np.linspace(0.02, 0.1, 21).tolist()}
    here, there = sweep(case, many, COLLECT, workers=0), sweep(case, many, COLLECT, workers=2, out=tmp_path / "s")
    assert here.csv_text() == there.csv_text()
    assert (tmp_path / "s" / "table.csv").read_text() == here.csv_text()


def test_on_the_virtual_machine_too(case: Case, result: SweepResult) -> None:
    slow = sweep(case.change(options={"backend": "vm"}), OVER, COLLECT, workers=0)
    assert slow.engine == {"solver": "rk4", "backend": "vm"}
    np.testing.assert_allclose(slow.table[:, :3], result.table[:, :3], rtol=1e-6)
    assert set(slow.keys).isdisjoint(result.keys)


def test_implicit_solvers_run_point_by_point(case: Case) -> None:
    found = sweep(case.change(solver="cvodes"), {"zeta": [0.02, 0.05]}, ["shaft.torque.highest"], workers=0)
    assert found.engine == {"solver": "cvodes", "backend": "vm"}
    assert found.succeeded.all()


def test_a_point_that_fails_is_an_outcome(case: Case) -> None:
    budget = case.change(options={"budget": Budget(max_steps=2000)})
    found = sweep(budget, {"shaft.stiffness": [3e4, 3e11]}, ["shaft.torque.highest"], workers=0)
    assert found.outcomes == ("SUCCESS", "MAX_STEPS")
    assert "the budget of 2000 steps is used up" in found.messages[1]
    assert np.isnan(found.table[1]).all()
    assert found.csv_text().splitlines()[2].startswith("1,300000000000.0,MAX_STEPS,,")


def test_a_point_that_cannot_start_is_an_outcome() -> None:
    line = small_case().model.equations.source
    assert line is not None
    geared = Driveline(
        "unbalanced", speed="1200 rpm", reference="a", elements=[Inertia("a", inertia=1.0), Inertia("b", inertia=1.0),
        Shaft("shaft", "a", "b", stiffness=1e4), *_torque()]
    )  # fmt: skip
    found = sweep(Case(geared, end=0.01, samples=5), {"push.mean": [0.0, 5.0]}, ["shaft.torque.highest"], workers=0)
    assert found.outcomes == ("SUCCESS", "BAD_INPUT")
    assert "not started: driveline 'unbalanced': mean torques leave 5 N*m" in found.messages[1]


def _torque() -> list[Element]:
    from modelgen import HarmonicTorque

    return [HarmonicTorque("push", "a", mean=0.0)]


def test_equations_given_directly_are_swept_in_this_process() -> None:
    import sympy

    x, k = sympy.symbols("x k")
    model = lower(system({x: 1.0}, {x: -k * x}, {k: 1.0}))
    found = sweep(Case(model, end=1.0, samples=11, start="zero"), {"k": [1.0, 2.0]}, ["x.final"], workers=2)
    assert found["x.final"].tolist() == pytest.approx([np.exp(-1), np.exp(-2)], rel=1e-6)


def test_random_and_sobol_points_follow_their_seed(case: Case) -> None:
    over = {"zeta": [0.01, 0.1], "shaft.stiffness": ["100 kN*m/rad", "300 kN*m/rad"]}
    for sampling in ("random", "sobol"):
        first, again, other = (points_of(case.model, over, sampling, 100, seed) for seed in (1, 1, 2))
        assert first.values.tolist() == again.values.tolist() != other.values.tolist()
        assert first.values.shape == (100, 2)
        assert (first.values.min(axis=0) >= [0.01, 1e5]).all()
        assert (first.values.max(axis=0) <= [0.1, 3e5]).all()
    # Of 64 Sobol' points, exactly 8 lie in each eighth of a range; random ones do not know of each other.
    sobol = points_of(case.model, over, "sobol", 64, 3).values[:, 0]
    assert np.histogram(sobol, bins=np.linspace(0.01, 0.1, 9))[0].tolist() == [8] * 8


def test_a_list_takes_values_side_by_side(case: Case) -> None:
    found = points_of(case.model, {"zeta": [0.01, 0.02], "torque.cosine[2]": [1.0, 2.0]}, "list")
    assert found.values.tolist() == [[0.01, 1.0], [0.02, 2.0]]
    assert found.shape == (2,)
    assert found.units == ("1", "N*m")


@pytest.mark.parametrize(
    ("over", "options", "error", "words"),
    [
        ({"zetta": [0.1]}, {}, NamingError, "parameter 'zetta': is not known; nearest is 'zeta'"),
        ({"zeta": []}, {}, CaseError, "sweep over 'zeta': has no values"),
        ({"zeta": [0.1, float("nan")]}, {}, CaseError, "value 2 is nan; give finite numbers"),
        ({"zeta": [0.1, -1.0]}, {}, ModelError, "parameter 'zeta': is -1.0; give zero or a positive value"),
        ({"zeta": ["1 kg"]}, {}, UnitError, "kg"),
        ({"zeta": [[1.0]]}, {}, CaseError, "sweep over 'zeta': holds"),
        ({"torque.cosine": [1.0]}, {}, CaseError, r"is a series of 2 numbers; sweep a row of it, such as torque.cosine\[1\]"),
        ({"torque.cosine[3]": [1.0]}, {}, NamingError, "has no such row"),
        ({}, {}, CaseError, "sweep, over: is {}; give values by name"),
        ({"zeta": [0.1], "speed": [100.0, 110.0]}, {"sampling": "list"}, CaseError, "a list needs as many of each name"),
        ({"zeta": [0.1, 0.2]}, {"sampling": "sobul", "count": 3}, CaseError, "nearest is 'sobol'"),
        ({"zeta": [0.1, 0.2]}, {"sampling": "random"}, CaseError, "sweep, count: is None; give the number of points"),
        ({"zeta": [0.2, 0.1]}, {"sampling": "random", "count": 3}, CaseError, "give the lowest and the highest value"),
        ({"zeta": [0.1]}, {"count": 3}, CaseError, "is given for a grid"),
        ({"zeta": [0.1]}, {"workers": -1}, CaseError, "sweep, workers: is -1"),
        ({"zeta": [0.1]}, {"client": "tcp://1"}, CaseError, "give a distributed.Client"),
        ({3: [0.1]}, {}, CaseError, "names 3; give values by the names of parameters"),
        ({"zeta": [0.1]}, {"out": 3}, CaseError, "is no name of a folder"),
        ({"zeta": [0.1]}, {"out": "a\0b"}, CaseError, "is no name of a folder"),
        (
            {"zeta": np.linspace(0.1, 0.2, 40000), "speed": np.linspace(90, 100, 40000)},
            {},
            CaseError,
            "sweep: has 1600000000 points; memory holds the results of",
        ),
    ],
)
def test_refused_points(case: Case, over: dict, options: dict, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        sweep(case, over, COLLECT, **options)


@pytest.mark.parametrize(
    ("collect", "words"),
    [
        (["shaft.tork.highest"], "nearest is 'shaft.torque'"),
        (["shaft.torque.heighest"], "has no statistic 'heighest'; nearest is 'highest'"),
        ([], "give names, such as"),
        ("steps", "give names, such as"),
        (["steps", "steps"], "names 'steps' twice"),
        (iter(["steps"]), "give names, such as"),
    ],
)
def test_refused_collections(case: Case, collect: list[str], words: str) -> None:
    with pytest.raises(CaseError, match=words):
        collection_of(case.model, collect, 10)


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"parameters": {"zetta": 1.0}}, NamingError, "nearest is 'zeta'"),
        ({"parameters": {"engine.inertia": float("nan")}}, CaseError, "give finite numbers"),
        ({"start": {"shaft.twst": 0.1}}, CaseError, "nearest is 'shaft.twist'"),
        ({"start": {"shaft.twist": float("inf")}}, CaseError, "holds a number that is not finite"),
        ({"seed": -1}, CaseError, "sweep, seed: is -1; give a whole number from 0 up"),
    ],
)
def test_what_is_wrong_with_every_point_is_refused(case: Case, changes: dict, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        sweep(case.change(**changes), {"zeta": [0.01, 0.1]}, COLLECT, sampling="random", count=3)


def test_numbers_too_large_are_the_outcome_of_their_point(case: Case) -> None:
    found = sweep(case, {"shaft.stiffness": [2e5, 1.5e308]}, ["steps"], workers=0)
    assert found.outcomes == ("SUCCESS", "BAD_INPUT")
    assert "give finite numbers" in found.messages[1]  # not a warning of NumPy, which depends on the process


def test_a_model_is_needed() -> None:
    with pytest.raises(CaseError, match="sweep: is asked of int; give a Driveline"):
        sweep(3, {"zeta": [0.1]}, COLLECT)  # type: ignore[arg-type]


def test_unknown_quantities_of_a_result(result: SweepResult) -> None:
    with pytest.raises(CaseError, match=r"no quantity 'shaft.torque.higest'; nearest is 'shaft.torque.highest'"):
        result["shaft.torque.higest"]


def test_batches_grow_to_a_good_time_and_shrink_at_the_end() -> None:
    work = Work(np.arange(1000), width=8, workers=2)
    first = work.take()
    assert first is not None
    sizes = [len(first)]
    work.took(first, 0.08)
    while (batch := work.take()) is not None:
        sizes.append(len(batch))
    assert sum(sizes) == 1000
    assert sizes[:2] == [8, 200]
    assert sizes[-1] <= 8


def test_a_point_that_kills_its_worker_is_found_and_marked() -> None:
    work, bad, deaths, done = Work(np.arange(512), width=256, workers=1), 77, 0, []
    while (batch := work.take()) is not None:
        if bad in batch:
            deaths += 1
            if work.died(batch) is not None:
                break
        else:
            done += batch.tolist()
    while (batch := work.take()) is not None:
        done += batch.tolist()
    assert sorted([*done, bad]) == list(range(512))
    assert deaths == 3 + DEATHS  # 256 points, then 32, 4 and 1


def test_elements_of_ones_own_stay_in_this_process() -> None:
    from modelgen.analysis.sweeps.job import portable

    class HeavyDisk(Inertia):
        weight = Param("kg", default=1.0)

    try:
        line = Driveline(
            "own", elements=[HeavyDisk("a", inertia=1.0), Inertia("b", inertia=1.0), Shaft("s", "a", "b", stiffness=1.0)]
        )
        assert not portable(Case(line, end=1.0))
        assert portable(small_case())
    finally:
        del Element.vocabulary[HeavyDisk.kind]


@pytest.mark.parametrize("backend", ["auto", "vm"])
def test_a_stopping_event_is_a_good_end(backend: str) -> None:
    case = small_case(sections=(Section("shaft.torque", 8.0, stop=True),), options={"backend": backend}, start="zero")
    found = sweep(case, {"zeta": [0.02, 0.1]}, ["shaft.torque.highest", "shaft.torque", "events"], workers=0)
    assert found.outcomes == ("EVENT", "EVENT")
    assert found["events"].tolist() == [1, 1]
    for wave, highest in zip(found["shaft.torque"], found["shaft.torque.highest"], strict=True):
        reached = np.isfinite(wave)
        assert 2 <= np.count_nonzero(reached) < 40
        assert not np.isfinite(wave[np.argmin(reached) :]).any()
        assert wave[reached].max() == highest < 8


def test_shares_of_modes() -> None:
    line = Driveline(
        "rattling",
        speed="600 rpm",
        reference="a",
        elements=[
            Inertia("a", inertia=1.0), Inertia("b", inertia=1.0), GearPair("mesh", "a", "b", teeth_a=20, teeth_b=20, module=0.004,
            half_backlash=1e-4, mesh="geometry", face_width=0.02),
        ],
    )  # fmt: skip
    case = Case(line, end=0.01, samples=21, options={"backend": "vm", "events": "on"})
    names = [f"{name}.share" for name in case.model.switching.value_names()]  # type: ignore[union-attr]
    found = sweep(case, {"mesh.half_backlash": [1e-4, 2e-4]}, [*names, "events"], workers=0)
    assert found.table[:, :-1].sum(axis=1).tolist() == pytest.approx([1.0, 1.0])
    with pytest.raises(CaseError, match='needs events to be located; give the case the option events "on"'):
        sweep(case.change(options={"events": "off"}), {"mesh.half_backlash": [1e-4]}, names, workers=0)


def test_netcdf_and_csv(result: SweepResult, tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray", reason="the extra xarray is not installed")
    pytest.importorskip("netCDF4", reason="the extra xarray is not installed")
    result.to_netcdf(tmp_path / "sweep.nc")
    with xarray.open_dataset(tmp_path / "sweep.nc") as data:
        assert data["shaft.torque.highest"].dims == ("zeta", "speed")
        assert data["shaft.torque.highest"].values.tolist() == result["shaft.torque.highest"].tolist()
        assert data["shaft.torque.highest"].attrs["units"] == "N*m"
        assert data["outcome"].values.ravel().tolist() == ["SUCCESS"] * 6
    rows = result.to_csv(tmp_path / "t.csv").read_text().splitlines()
    assert rows[0].startswith("point,zeta [1],speed [rad/s],outcome,shaft.torque.highest [N*m],")
    assert float(rows[3].split(",")[4]) == result.table[2, 0]


def test_a_script_without_a_main_guard_may_sweep(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    root = Path(__file__).parents[3]
    script.write_text(
        "from modelgen import Case, load\nfrom modelgen.analysis import sweep\n"
        "from modelgen.model.files import parse_model\nimport json, sys\n"
        f"line = parse_model(json.loads({json.dumps(json.dumps(_text()))}))\n"
        "case = Case(line, end=0.01, samples=5)\n"
        "print(len(sweep(case, {'zeta': [0.001 * k for k in range(1, 40)]}, ['steps'], workers=1)))\n"
    )
    done = subprocess.run(
        [sys.executable, "-W", "error", script], cwd=root, env=_env(root), capture_output=True, text=True, timeout=60
    )
    assert (done.stdout.strip(), done.stderr) == ("39", "")


def _text() -> str:
    from modelgen.model.files import model_text

    from .cases import two_disks

    return model_text(two_disks())


def _env(root: Path) -> dict[str, str]:
    import os

    return {**os.environ, "PYTHONPATH": str(root)}


def test_a_good_point_is_not_marked_by_kills_at_random() -> None:
    work = Work(np.arange(4), width=4, workers=2)
    batch = work.take()
    assert batch is not None
    assert work.died(batch) is None
    for _ in range(4):
        single = work.take()
        assert single is not None
        assert work.died(single) is None
    for _ in range(5):
        single = work.take()
        assert single is not None
        assert work.take() is None  # one suspect at a time
        work.disturbed()  # a worker without work was killed too
        assert work.died(single) is None
    for marked in (None, 0):  # the second and the third in a row since the last disturbance
        single = work.take()
        assert single is not None
        assert work.died(single) == marked
