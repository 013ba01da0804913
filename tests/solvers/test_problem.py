"""What a solver may be given: anything that CasADi would broadcast, transpose or ignore without a word is refused."""

from __future__ import annotations

import math
from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from modelgen.errors import CaseError
from modelgen.solvers.problem import Budget, InitialValueProblem, SolverOptions

T, X, P = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 3)
RHS = ca.Function("rhs", [T, X, P], [P[:2] * X + P[2]])
LAWFUL = {
    "rhs": RHS,
    "names": ("a", "b"),
    "x0": [1.0, 2.0],
    "p": [1.0, 2.0, 3.0],
    "scale": [1.0, 1.0],
    "t0": 0.0,
    "times": [0.5, 1.0],
}

WRONG = [
    ("x0", 1.0, r"x0: has shape \(\), wanted \(2,\); nothing is broadcast"),
    ("x0", [1.0], r"x0: has shape \(1,\), wanted \(2,\)"),
    ("x0", [[1.0], [2.0]], r"x0: has shape \(2, 1\), wanted \(2,\)"),
    ("x0", [1.0, math.nan], "x0: entry 1 is nan"),
    ("x0", np.array([1j, 2.0]), "x0: holds complex128 values"),
    ("x0", ["one", "two"], "x0: is not an array of numbers but list"),
    ("p", [1.0], r"p: has shape \(1,\), wanted \(3,\)"),
    ("p", [1.0, 2.0, math.inf], "p: entry 2 is inf"),
    ("scale", [1.0, 0.0], "scale: that of 'b' is 0; every state needs a positive size"),
    ("scale", 1.0, r"scale: has shape \(\), wanted \(2,\)"),
    ("names", ("a",), "names: are 1, states are 2"),
    ("names", "ab", "names: are 2, states are 2"),
    ("t0", math.nan, "t0: is nan"),
    ("t0", "0", "t0: is '0'; give a finite number"),
    ("times", [], "times: is empty; give at least the end"),
    ("times", 1.0, r"times: has shape \(\)"),
    ("times", [-1.0, 1.0], "times: starts at -1 s, before t0 = 0 s; time runs forward"),
    ("times", [0.5, 0.5, 1.0], "times: entry 1 .* does not come after the one before"),
    ("times", [0.5, math.inf], "times: entry 1 is inf"),
    ("rhs", lambda t, x, p: x, "rhs: is a function; give a casadi.Function"),
    ("rhs", ca.Function("f", [X, P], [X]), "rhs: has 2 inputs and 1 outputs"),
    ("rhs", ca.Function("f", [T, X, P], [X.T]), "rhs: output is 1x2,2nz, wanted a dense column of 2"),
    ("rhs", ca.Function("f", [T, X, P], [ca.vertcat(X[0], ca.SX(1, 1))]), r"rhs: output is 2x1,1nz, wanted a dense column"),
    ("rhs", ca.Function("f", [T, X.T, P], [X]), "rhs: input x is not a dense column but 1x2,2nz"),
    ("rhs", ca.Function("f", [ca.SX.sym("t", 2), X, P], [X]), "rhs: input t is not a dense column but 2x1,2nz"),
    ("rhs", ca.Function("f", [T, ca.SX.sym("x", 0), P], [ca.SX(0, 1)]), "rhs: has no states"),
]


@pytest.mark.parametrize(("entry", "value", "words"), WRONG)
def test_wrong_problems_are_refused_by_words(entry: str, value: object, words: str) -> None:
    with pytest.raises(CaseError, match=words):
        InitialValueProblem(**(LAWFUL | {entry: value}))


def test_a_lawful_problem_keeps_copies_that_nobody_can_change() -> None:
    start = np.array([1.0, 2.0])
    problem = InitialValueProblem(**(LAWFUL | {"x0": start}))
    start[0] = 7.0
    assert problem.x0.tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match="read-only"):
        problem.x0[0] = 7.0
    assert problem.horizon == 1.0


def test_a_model_without_parameters_needs_none() -> None:
    for empty in (ca.SX.sym("p", 0), ca.SX.sym("p", 0, 0)):
        rhs = ca.Function("rhs", [T, X, empty], [X])
        assert InitialValueProblem(**(LAWFUL | {"rhs": rhs, "p": []})).p.size == 0


@pytest.mark.parametrize(
    ("record", "arguments", "words"),
    [
        (SolverOptions, {"tolerance": 0.0}, "tolerance: is 0.0; give a positive number"),
        (SolverOptions, {"tolerance": math.nan}, "tolerance: is nan; give a finite number"),
        (SolverOptions, {"tolerance": True}, "tolerance: is True"),
        (SolverOptions, {"tolerance": "1e-6"}, "tolerance: is '1e-6'"),
        (SolverOptions, {"tolerance": 1e-6, "first_step": -1.0}, "first_step: is -1.0"),
        (SolverOptions, {"tolerance": 1e-6, "largest_step": 0}, "largest_step: is 0"),
        (SolverOptions, {"tolerance": 1e-6, "fixed_step": math.inf}, "fixed_step: is inf"),
        (SolverOptions, {"tolerance": 1e-6, "fixed_step": 0.1, "largest_step": 0.1}, "fixed_step: is given beside"),
        (SolverOptions, {"tolerance": 1e-6, "rule": "papers"}, "rule: is 'papers'; known are smooth, paper"),
        (SolverOptions, {"tolerance": 1e-6, "extrapolate": 1}, "extrapolate: is 1; give True or False"),
        (SolverOptions, {"tolerance": 1e-6, "budget": 10.0}, "budget: is 10.0; give a Budget"),
        (Budget, {"max_steps": 0}, "max_steps: is 0"),
        (Budget, {"max_steps": 1.5}, "max_steps: is 1.5; give a whole number"),
        (Budget, {"max_seconds": -1}, "max_seconds: is -1"),
        (Budget, {"smallest_step": 2.0}, "smallest_step: is 2.0; it is a fraction of the horizon"),
        (Budget, {"bound": 1e200}, "bound: is 1e\\+200"),
    ],
)
def test_wrong_options_are_refused_by_words(record: Callable[..., object], arguments: dict[str, object], words: str) -> None:
    with pytest.raises(CaseError, match=words):
        record(**arguments)


def test_the_tolerance_must_be_given() -> None:
    with pytest.raises(TypeError, match="tolerance"):
        SolverOptions()
