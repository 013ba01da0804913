"""Which back end runs: short runs on the virtual machine, long ones in C, and what happens without a compiler."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from modelgen.errors import LoweringError
from modelgen.solvers import explicit
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Budget, InitialValueProblem, SolverOptions
from modelgen.solvers.registry import solve


def oscillator(end: float) -> InitialValueProblem:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p")
    rhs = ca.Function("oscillator", [t, x, p], [ca.vertcat(x[1], -(p**2) * x[0])])
    return InitialValueProblem(rhs, ("x", "v"), [1.0, 0.0], [10.0], [1.0, 10.0], 0.0, np.linspace(0.0, end, 11))


LONG = 400.0  # s: more steps than the virtual machine is given


def test_a_short_run_builds_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(explicit, "solve_native", lambda *_: pytest.fail("C for a handful of steps"))
    run = solve(oscillator(1.0), "rk4", SolverOptions(tolerance=1e-8))
    assert run.statistics.backend == "vm"


@pytest.mark.usefixtures("compiled_here")
def test_a_long_run_is_that_of_c() -> None:
    seen: list[float] = []
    options = SolverOptions(tolerance=1e-8, progress=seen.append)
    found, expected = (solve(oscillator(LONG), "rk4", each) for each in (options, SolverOptions(tolerance=1e-8, backend="c")))
    assert found.statistics.backend == "c"
    assert np.array_equal(found.states, expected.states)
    assert seen == sorted(seen)


def test_without_a_compiler_the_virtual_machine_goes_on_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> None:
        raise LoweringError("native code", "there is no C compiler", "install one")

    monkeypatch.setattr(explicit, "solve_native", none)
    monkeypatch.setattr(explicit, "SHORT", 1e6)
    run = solve(oscillator(5.0), "rk4", SolverOptions(tolerance=1e-8))
    assert run.outcome is Outcome.SUCCESS
    assert run.statistics.backend == "vm, for want of a compiler"


def test_a_small_budget_of_steps_is_kept() -> None:
    run = solve(oscillator(LONG), "rk4", SolverOptions(tolerance=1e-8, budget=Budget(max_steps=50)))
    assert run.outcome is Outcome.MAX_STEPS
    assert "50 steps" in run.message


@pytest.fixture
def compiled_here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MODELGEN_CACHE", str(tmp_path / "cache"))
