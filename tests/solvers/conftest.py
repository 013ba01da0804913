"""Small ordinary differential equations for the tests of solvers: each is one line of CasADi."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from modelgen.lowering.native.compiler import NoCompilerError, find_compiler
from modelgen.lowering.switching import Crossing, ModeVariable, Switching
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


def switched_problem(
    rates: Rates,
    guards: Rates,
    crossings: Sequence[Crossing],
    x0: Sequence[float],
    times: Any,
    *,
    modes: Sequence[tuple[str, Sequence[str]]] = (),
    p: Sequence[float] = (),
    resets: Callable[[Any, Any, Any], Sequence[Sequence[Any]]] | None = None,
    scale: Any = None,
    start: Sequence[int] | None = None,
) -> InitialValueProblem:
    """A problem with events; the flags of all modes stand behind the given parameters."""
    variables, first = [], len(p)
    for index, (name, values) in enumerate(modes):
        variables.append(ModeVariable(name, tuple(values), first, 0 if start is None else start[index]))
        first += len(values)
    t, x, parameters = ca.SX.sym("t"), ca.SX.sym("x", len(x0)), ca.SX.sym("p", first)
    arguments = [t, x, parameters]
    rhs = ca.Function("rhs", arguments, [ca.densify(ca.vertcat(*rates(*arguments)))])
    after = None
    if resets is not None:
        after = ca.Function("resets", arguments, [ca.horzcat(*(ca.vertcat(*column) for column in resets(*arguments)))])
    values = np.concatenate([np.asarray(p, dtype=float), np.zeros(first - len(p))])
    for variable in variables:
        variable.put(values, variable.start)
    surfaces = ca.Function("guards", arguments, [ca.densify(ca.vertcat(*guards(*arguments)))])
    switching = Switching(tuple(variables), tuple(crossings), surfaces, first, after)
    names = tuple(f"x{index}" for index in range(len(x0)))
    sizes = np.ones(len(x0)) if scale is None else scale
    return InitialValueProblem(rhs, names, x0, values, sizes, 0.0, np.atleast_1d(times), switching)


@pytest.fixture(scope="session")
def hybrid() -> Callable[..., InitialValueProblem]:
    """hybrid(rates, guards, crossings, x0, times, modes=(), p=(), resets=None, ...): a problem with events."""
    return switched_problem


@pytest.fixture(scope="module")
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A cache of native libraries for one file of tests, which is skipped where there is no compiler."""
    try:
        find_compiler()
    except NoCompilerError as reason:
        pytest.skip(str(reason))
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("native")
        folder.chmod(0o700)
        patch.setenv("MODELGEN_CACHE", str(folder))
        yield folder
