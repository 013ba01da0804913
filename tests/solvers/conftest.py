"""Small ordinary differential equations for the tests of solvers: each is one line of CasADi."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np
import pytest

from modelgen.solvers.problem import InitialValueProblem

Rates = Callable[[Any, Any, Any], Sequence[Any]]


def initial_value_problem(
    rates: Rates, x0: Sequence[float], times: Any, *, p: Sequence[float] = (), scale: Any = None, t0: float = 0.0
) -> InitialValueProblem:
    t, x, parameters = ca.SX.sym("t"), ca.SX.sym("x", len(x0)), ca.SX.sym("p", len(p))
    rhs = ca.Function("rhs", [t, x, parameters], [ca.vertcat(*rates(t, x, parameters))])
    names = tuple(f"x{index}" for index in range(len(x0)))
    return InitialValueProblem(rhs, names, x0, p, np.ones(len(x0)) if scale is None else scale, t0, np.atleast_1d(times))


@pytest.fixture(scope="session")
def ode() -> Callable[..., InitialValueProblem]:
    """ode(rates, x0, times, p=(), scale=ones, t0=0): a problem from the rates as a function of t, x, p."""
    return initial_value_problem
