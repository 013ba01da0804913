"""Right-hand sides that go wrong, for every solver and back end: a named outcome within the budget, and finite numbers."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from modelgen import ModelgenError
from modelgen.lowering.native.compiler import NoCompilerError, find_compiler
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import Budget, InitialValueProblem, SolverOptions
from modelgen.solvers.registry import SOLVERS, solve

from .conftest import Within

BUDGET = 1.5  # [s]
LEEWAY = 12.0  # [s]; what a compiler may take on a machine that does other things too

Rates = Callable[[Any, Any], Sequence[Any]]

FAULTS: dict[str, tuple[Rates, tuple[float, ...]]] = {
    "nan after a time": (lambda t, x: [ca.if_else(t > 1, math.nan, -x[0])], (1.0,)),
    "nan at once": (lambda t, x: [math.nan * x[0]], (1.0,)),
    "nan beyond a state": (lambda t, x: [ca.if_else(x[0] > 1.5, math.nan, 1.0)], (1.0,)),
    "inf after a time": (lambda t, x: [ca.if_else(t > 1, math.inf, -x[0])], (1.0,)),
    "minus inf at once": (lambda t, x: [-math.inf + x[0]], (1.0,)),
    "blow-up y' = y^2": (lambda t, x: [x[0] ** 2], (1.0,)),
    "blow-up of an oscillator": (lambda t, x: [x[1], x[0] ** 3], (1.0, 1.0)),
    "runaway": (lambda t, x: [60 * x[0]], (1.0,)),
    "exp of exp": (lambda t, x: [ca.exp(ca.exp(x[0]))], (1.0,)),
    "pole in time": (lambda t, x: [1 / (1 - t) ** 2], (0.0,)),
    "quotient 0 / 0": (lambda t, x: [ca.sin(x[0]) / x[0] / (x[0] - x[0])], (0.5,)),
    "root of a negative": (lambda t, x: [ca.sqrt(1 - t) - x[0]], (1.0,)),
    "logarithm of a negative": (lambda t, x: [ca.log(x[0]) - 1], (1.0,)),
    "arcsine beyond one": (lambda t, x: [ca.asin(x[0] + t)], (0.5,)),
    "power of a negative": (lambda t, x: [-(ca.fabs(x[0]) ** -0.5) - (x[0] - 0.2) ** 0.5], (1.0,)),
    "chattering friction": (lambda t, x: [x[1], -5 * ca.sign(x[1]) - x[0]], (1.0, 1.0)),
    "chattering switch": (lambda t, x: [ca.if_else(x[0] > 0.3, -5, 2)], (1.0,)),
    "stiffness 1e18 beside 1": (
        lambda t, x: [x[1], -1e18 * (x[0] - x[2]), x[3], 1e18 * (x[0] - x[2]) - x[2]],
        (1.0, 0.0, 1.0, 0.0),
    ),
    "rate of 1e300": (lambda t, x: [1e300 * (x[0] - 1) + 1], (1.0,)),
    "noise in the rate": (lambda t, x: [ca.sin(1e15 * x[0]) * 1e3], (1.0,)),
    "time that is noise": (lambda t, x: [ca.sin(1e12 * t * t)], (0.0,)),
    "denormal oscillator": (lambda t, x: [x[1], -5e-324 * x[0]], (1.0, 5e-324)),
}

SAMPLE = ("nan after a time", "blow-up of an oscillator", "logarithm of a negative", "chattering switch")

PAIRS = [(name, None) for name in SOLVERS] + [(name, "c") for name, each in SOLVERS.items() if "backend" in each.extra_options]
"""Every solver, those with a choice of back end on the virtual machine and in C."""


def problem_of(fault: str) -> InitialValueProblem:
    rates, start = FAULTS[fault]
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", len(start)), ca.SX.sym("p", 0)
    rhs = ca.Function("rhs", [t, x, p], [ca.densify(ca.vertcat(*rates(t, x)))])
    names = tuple(f"x{index}" for index in range(len(start)))
    return InitialValueProblem(rhs, names, start, (), np.ones(len(start)), 0.0, np.linspace(0.0, 2.0, 21))


def try_fault(problem: InitialValueProblem, name: str, backend: str | None) -> str:
    """The name of the outcome; every number is finite, the message is one sentence, and the budget was kept."""
    chosen = {"backend": backend or "vm"} if "backend" in SOLVERS[name].extra_options else {}
    began = time.perf_counter()
    try:
        run = solve(problem, name, SolverOptions(tolerance=1e-6, budget=Budget(max_seconds=BUDGET), **chosen))
    except ModelgenError:
        return "refused"
    assert time.perf_counter() - began < BUDGET + LEEWAY
    assert np.isfinite(run.states).all()
    assert np.isfinite(run.times).all()
    assert len(run.times) == len(run.states)
    assert run.message
    assert "\n" not in run.message
    if run.outcome is Outcome.SUCCESS:
        assert len(run.times) == 21
    else:
        assert run.outcome is not Outcome.SOLVER_ERROR, run.message
    return run.outcome.name


def try_faults(within: Within, faults: Sequence[str], pairs: Sequence[tuple[str, str | None]]) -> Counter[str]:
    endings: Counter[str] = Counter()
    for fault in faults:
        problem = problem_of(fault)
        for name, backend in pairs:
            with within(BUDGET + LEEWAY):
                endings[try_fault(problem, name, backend)] += 1
    print(f"\n{sum(endings.values())} runs: " + ", ".join(f"{number} {ending}" for ending, number in endings.most_common()))
    return endings


@pytest.fixture(scope="module")
def own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch_module: pytest.MonkeyPatch) -> Path:
    try:
        find_compiler()
    except NoCompilerError as reason:
        pytest.skip(str(reason))
    folder = tmp_path_factory.mktemp("native")
    folder.chmod(0o700)
    monkeypatch_module.setenv("MODELGEN_CACHE", str(folder))
    return folder


@pytest.fixture(scope="module")
def monkeypatch_module() -> Any:
    with pytest.MonkeyPatch.context() as patch:
        yield patch


@pytest.mark.slow
@pytest.mark.usefixtures("own_cache")
def test_a_sample_of_faults(within: Within) -> None:
    endings = try_faults(within, SAMPLE, PAIRS[: len(SOLVERS) + 1])
    assert endings["refused"] == 0
    # Two of them give no numbers by every solver, unless the machine is so busy that the budget of time comes first.
    assert endings["NON_FINITE_RATE"] + endings["MAX_TIME"] >= 2 * (len(SOLVERS) + 1)


@pytest.mark.proof
@pytest.mark.usefixtures("own_cache")
def test_every_fault(within: Within) -> None:
    endings = try_faults(within, list(FAULTS), PAIRS)
    assert sum(endings.values()) == len(FAULTS) * len(PAIRS) >= 20 * len(SOLVERS)
    assert endings["refused"] == 0
