"""simulate and Case: the same answer whatever the start of the clock, and refusals by their words."""

from __future__ import annotations

import contextlib
from pathlib import Path

import numpy as np
import pytest

from modelgen import Case, Driveline, Inertia, Outcome, Shaft, Solution, crosscheck, load, simulate
from modelgen.errors import CaseError, ModelError, NamingError
from modelgen.solvers.crosscheck import exponential_growth

TWO = Driveline(
    "two_disks",
    elements=(
        Inertia("engine", inertia=5.0),
        Inertia("load", inertia=2.0),
        Shaft("shaft", "engine", "load", stiffness=1e4, damping_ratio=0.02),
    ),
)
FREE = Case(TWO, end=0.5, start={"shaft.twist": 0.01}, samples=501, tolerance=1e-9)


def test_free_vibration_equals_the_exact_solution() -> None:
    solution = simulate(FREE)
    omega = np.sqrt(1e4 * (1 / 5 + 1 / 2))
    decay, damped = 0.02 * omega, omega * np.sqrt(1 - 0.02**2)
    t = solution.times
    exact = 0.01 * np.exp(-decay * t) * (np.cos(damped * t) + decay / damped * np.sin(damped * t))
    assert solution["shaft.twist"] == pytest.approx(exact, abs=1e-10)
    assert solution.outcome is Outcome.SUCCESS


@pytest.mark.parametrize("solver", ["rk4", "cvodes"])
def test_a_million_radians_of_rolling_change_no_twist(solver: str) -> None:
    case = Case(load("fracturing-truck"), end=0.05, samples=501, solver=solver)
    still, turned = (simulate(case.change(start={"flywheel.angle_deviation": angle})) for angle in (0.0, 1e6))
    twists = [name for name in still.channels if name.endswith(".twist")]
    assert len(twists) == 13
    for name in twists:
        assert np.abs(still[name] - turned[name]).max() <= 1e-9 * np.ptp(still[name])
    assert turned["flywheel.angle_deviation"][0] == 1e6


@pytest.mark.parametrize("solver", ["rk4", "cvodes"])
def test_a_case_gives_the_same_bytes_every_time(solver: str) -> None:
    case = Case(load("fracturing-truck"), end=0.02, samples=101, solver=solver)
    first, second = simulate(case), simulate(case)
    assert first.states.tobytes() == second.states.tobytes()


def test_solution_saves_and_loads_without_loss(tmp_path: Path) -> None:
    solution = simulate(FREE)
    loaded = Solution.load(solution.save(tmp_path / "run.npz"))
    assert loaded.states.tobytes() == solution.states.tobytes()
    assert {k: v.tobytes() for k, v in loaded.channels.items()} == {k: v.tobytes() for k, v in solution.channels.items()}
    assert (loaded.units, loaded.outcome, loaded.message) == (solution.units, solution.outcome, solution.message)
    assert loaded.statistics == solution.statistics
    assert loaded.case.start == {"shaft.twist": 0.01}
    assert [path.name for path in tmp_path.iterdir()] == ["run.npz"]


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 no zip", b"\x93NUMPY"])
def test_a_file_that_is_no_solution_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "run.npz"
    path.write_bytes(content)
    with pytest.raises(CaseError, match="is no saved solution"):
        Solution.load(path)


def test_every_bit_flip_of_a_saved_solution_is_noticed_or_harmless(tmp_path: Path) -> None:
    solution = simulate(FREE.change(samples=5))
    path = solution.save(tmp_path / "run.npz")
    good = path.read_bytes()
    rng = np.random.default_rng(7)
    for position in rng.integers(0, len(good), 60):
        bad = bytearray(good)
        bad[position] ^= 1 << int(rng.integers(8))
        path.write_bytes(bytes(bad))
        with contextlib.suppress(CaseError):
            assert Solution.load(path).states.tobytes() == solution.states.tobytes()


def test_a_case_is_known_by_its_digest() -> None:
    same = Case(TWO, end=0.5, start={"shaft.twist": 0.01}, samples=501, tolerance=1e-9)
    assert FREE.digest() == same.digest()
    for other in (
        {"end": 0.6},
        {"tolerance": 1e-8},
        {"parameters": {"shaft.stiffness": 2e4}},
        {"start": "zero"},
        {"solver": "cvodes"},
    ):
        assert FREE.change(**other).digest() != FREE.digest()


def test_parameters_change_by_name_and_unit() -> None:
    stiff = simulate(FREE.change(parameters={"shaft.stiffness": "40 kN*m/rad"}))
    soft = simulate(FREE)
    crossings = [np.sum(np.diff(np.sign(s["shaft.twist"])) != 0) for s in (stiff, soft)]
    assert crossings[0] == pytest.approx(2 * crossings[1], abs=1)


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"end": -1.0}, CaseError, "must follow each other"),
        ({"end": float("nan")}, ModelError, "finite"),
        ({"samples": 1}, CaseError, "samples: is 1"),
        ({"start": "statik"}, CaseError, "start: is 'statik'; give \"static\""),
        ({"start": {"shaft.twst": 1.0}}, CaseError, "nearest is 'shaft.twist'"),
        ({"start": {"shaft.twist": float("nan")}}, CaseError, "nan"),
        ({"parameters": {"shaft.stifness": 1.0}}, NamingError, "nearest is 'shaft.stiffness'"),
        ({"parameters": {"shaft.stiffness": -1.0}}, ModelError, "give a positive value"),
        ({"parameters": {"shaft.stiffness": "3 N/m"}}, ModelError, "is asked for"),
        ({"parameters": {"shaft.stiffness": [1.0, 2.0]}}, CaseError, "got 2 values; it has 1"),
        ({"solver": "rk5"}, CaseError, "nearest is 'rk4'"),
        ({"options": {"rules": "paper"}}, CaseError, "nearest is 'rule'"),
        ({"channels": ("shaft.tork",)}, CaseError, "no output 'shaft.tork'; nearest is 'shaft.torque'"),
        ({"tolerance": 0.0}, CaseError, "tolerance"),
        ({"inputs": {"throttle": 1.0}}, CaseError, "has no inputs"),
    ],
)
def test_a_wrong_case_is_refused_by_words(changes: dict, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        simulate(FREE.change(**changes))


def test_a_channel_that_is_not_there_names_the_nearest() -> None:
    with pytest.raises(CaseError, match=r"nearest is 'shaft.twist"):
        simulate(FREE)["shaft.twisst"]


def test_a_loaded_case_cannot_run_without_its_model(tmp_path: Path) -> None:
    loaded = Solution.load(simulate(FREE).save(tmp_path / "run.npz"))
    with pytest.raises(CaseError, match="has no compiled model"):
        simulate(loaded.case)


def test_a_failed_run_is_a_named_outcome_with_what_was_reached() -> None:
    from modelgen.solvers import Budget

    solution = simulate(FREE.change(options={"budget": Budget(max_steps=20)}))
    assert solution.outcome is Outcome.MAX_STEPS
    assert not solution.succeeded
    assert 0 < len(solution.times) < 501
    assert np.all(np.isfinite(solution.states))


def test_crosscheck_falls_with_the_tolerance() -> None:
    result = crosscheck(FREE, ("rk4", "cvodes"), {"rk4": [1e-5, 1e-7], "cvodes": [1e-6, 1e-8, 1e-10]})
    for solver in ("rk4", "cvodes"):
        worst = [run.worst for run in result.runs if run.solver == solver]
        assert worst == sorted(worst, reverse=True)
        assert worst[-1] < 1e-6
    assert "does not grow exponentially" in result.sentence()


def test_crosscheck_refuses_what_is_not_there() -> None:
    with pytest.raises(CaseError, match="nearest is 'cvodes'"):
        crosscheck(FREE, ("rk4", "cvode"), [1e-6])
    with pytest.raises(CaseError, match="no output"):
        crosscheck(FREE, ("rk4",), [1e-6], channels=["shaft.tork"])


def test_exponential_divergence_is_recognized() -> None:
    t = np.linspace(0, 10, 4001)
    rate, until = exponential_growth(t, 1e-12 * np.exp(2.0 * t) * (1 + 0.3 * np.sin(40 * t)))
    assert rate == pytest.approx(2.0, rel=0.05)
    assert until == pytest.approx(np.log(1e10) / 2, rel=0.05)
    assert exponential_growth(t, 1e-9 * (1 + t))[0] == 0.0


@pytest.mark.slow
@pytest.mark.parametrize(("start", "bound"), [("static", 1e-6), ("zero", 1e-5)])
def test_truck_by_two_solvers_over_a_second(start: str, bound: float) -> None:
    case = Case(load("fracturing-truck"), end=1.0, samples=20001, start=start)
    result = crosscheck(case, ("rk4", "cvodes"), {"rk4": [1e-8], "cvodes": [1e-10]}, reference=("rk4", 1e-9))
    assert result.worst_relative_difference < bound
    assert all(run.outcome is Outcome.SUCCESS for run in result.runs)


@pytest.mark.slow
def test_truck_by_all_six_solvers() -> None:
    """Five over a second; collocation, some 200 s of computing per second of the truck, over a hundredth."""
    case = Case(load("fracturing-truck"), end=1.0, samples=20001)
    tolerances = {"cvodes": [1e-10], "idas": [1e-10], "erk": [1e-8], "rosenbrock": [1e-8]}
    result = crosscheck(case, tuple(tolerances), tolerances, reference=("rk4", 1e-8))
    assert result.worst_relative_difference < 1e-6
    short = crosscheck(case.change(end=0.01, samples=201), ("collocation",), [1e-8], reference=("rk4", 1e-9))
    assert short.worst_relative_difference < 1e-6


@pytest.mark.parametrize("backend", ["c", "auto"])
def test_generated_c_gives_what_the_virtual_machine_gives(backend: str) -> None:
    case = Case(load("fracturing-truck"), end=0.02, samples=201, tolerance=1e-9)
    machine, native = simulate(case), simulate(case.change(options={"backend": backend}))
    assert native.outcome is Outcome.SUCCESS
    for name in machine.channels:
        if name.endswith((".twist", ".force", ".deflection")):
            assert np.abs(native[name] - machine[name]).max() < 1e-9 * np.ptp(machine[name])
    assert native.statistics.steps == pytest.approx(machine.statistics.steps, rel=0.01)


def test_a_backend_that_is_not_there_is_refused_by_words() -> None:
    with pytest.raises(CaseError, match="backend: is 'gpu'; known are vm, c, auto"):
        simulate(FREE.change(options={"backend": "gpu"}))
    with pytest.raises(CaseError, match="has no use for backend"):
        simulate(FREE.change(solver="cvodes", options={"backend": "c"}))
