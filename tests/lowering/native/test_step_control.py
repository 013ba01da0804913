"""Step sizes: portable C, generated C and the virtual machine take the steps of one rule, written out here once more.

The rule is that of Gustafsson's proportional-integral controller (Hairer, Norsett, Wanner, Solving ODEs I, II.4) on step
doubling of the classical Runge-Kutta method: safety 0.9, growth at most 5, shrinking at most to 0.2, shares 0.85 and 0.2 of the
two errors.
"""

from __future__ import annotations

import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from modelgen import Compiled, lower, system
from modelgen.lowering.native.compiler import NoCompilerError, find_compiler
from modelgen.lowering.native.portable_files import DefaultCase, portable_files
from modelgen.solvers.problem import InitialValueProblem, SolverOptions
from modelgen.solvers.registry import solve

END, TOLERANCE = 4.0, 1e-7
Step = tuple[float, int]

PRINTER = """
#include <stdio.h>
#include "pulses.h"
int main(void) {
  static pulses_run run;
  pulses_init(&run, 0.0, 0, 0);
  pulses_begin(&run, %r, %r);
  while (run.time < run.end && pulses_advance(&run) == pulses_OK) printf("%%.17g %%d\\n", run.time, (int)run.rejected);
  return 0;
}
"""


@pytest.fixture(scope="module")
def pulses() -> Compiled:
    """A slow decay that is hit by short pulses: steps grow as fast as they may, and are cut as far as they may."""
    pulse = "60*exp(-((t - {0})/{1})**2)"
    rate = f"-x + {pulse.format(1.0, 0.01)} - {pulse.format(2.5, 0.002)}"
    return lower(system({"x": 1.0, "y": 0.0}, {"x": rate, "y": "x - 30*y"}, name="pulses"))


@pytest.fixture(scope="module")
def expected(pulses: Compiled) -> list[Step]:
    """Time and rejections so far at the end of every step, by the rule itself."""

    def f(t: float, x: np.ndarray) -> np.ndarray:
        return pulses.rhs(t, x, [])

    def gain(t: float, h: float, x: np.ndarray) -> np.ndarray:
        k1 = f(t, x)
        k2 = f(t + h / 2, x + h / 2 * k1)
        k3 = f(t + h / 2, x + h / 2 * k2)
        return h / 6 * (k1 + 2 * k2 + 2 * k3 + f(t + h, x + h * k3))

    t, x, rejected, before, steps = 0.0, np.array([1.0, 0.0]), 0, 1.0, []
    slope = f(t, x)
    unit = min(0.01 / np.abs(slope).max(), END)
    bend = f(t + unit, x + unit * slope) - slope
    size = max(unit * np.abs(slope).max(), unit * np.abs(bend).max())
    h = unit * min(100.0, (0.01 * TOLERANCE / size) ** 0.2)
    while t < END:
        growth = 5.0
        while True:
            left = END - t
            until = END if h >= left else t + (left / 2 if 2 * h > left else h)
            h = until - t
            whole, first = gain(t, h, x), gain(t, h / 2, x)
            both = first + gain(t + h / 2, h / 2, x + first)
            error = np.abs(both - whole).max() / TOLERANCE
            if error <= 1:
                break
            rejected, growth = rejected + 1, 1.0
            h *= max(0.2, 0.9 * error**-0.2)
        t, x = until, x + both + (both - whole) / 15
        steps.append((t, rejected))
        error = max(error, 1e-10)
        h *= min(growth, max(0.2, 0.9 * error ** (-0.85 / 5) * before ** (0.2 / 5)))
        before = error
    return steps


def test_the_case_reaches_every_bound_of_the_rule(expected: list[Step]) -> None:
    times = np.array([0.0, *(time for time, _ in expected)])
    ratios = np.diff(times)[1:] / np.diff(times)[:-1]
    assert expected[-1][1] > 5
    assert np.abs(ratios - 0.2).min() < 1e-9  # one rejection that asked for less
    assert np.count_nonzero(np.abs(ratios - 5.0) < 1e-9) >= 1


@pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc")
def test_the_portable_solver_takes_the_steps_of_the_rule(pulses: Compiled, expected: list[Step], tmp_path: Path) -> None:
    case = DefaultCase((), (1.0, 0.0), (1.0, 1.0), END, 11, TOLERANCE)
    for name, text in portable_files(pulses, case).items():
        (tmp_path / name).write_text(text)
    (tmp_path / "steps.c").write_text(PRINTER % (END, TOLERANCE))
    order = ["gcc", "-std=c99", "-O1", "-ffp-contract=off", "steps.c", "pulses.c", "-o", "steps", "-lm"]
    subprocess.run(order, cwd=tmp_path, check=True)
    printed = subprocess.run([tmp_path / "steps"], capture_output=True, text=True, check=True).stdout.split()
    times, rejected = np.array(printed[::2], dtype=float), [int(each) for each in printed[1::2]]
    assert rejected == [count for _, count in expected]
    assert times == pytest.approx([time for time, _ in expected], rel=2e-4)


@pytest.mark.parametrize("backend", ["vm", "c"])
def test_the_solvers_take_the_steps_of_the_rule(pulses: Compiled, expected: list[Step], backend: str) -> None:
    if backend == "c":
        try:
            find_compiler()
        except NoCompilerError as reason:
            pytest.skip(str(reason))
    problem = InitialValueProblem(pulses.rhs_function, ("x", "y"), [1.0, 0.0], [], [1.0, 1.0], 0.0, [END])
    cost = solve(problem, "rk4", SolverOptions(tolerance=TOLERANCE, backend=backend)).statistics
    sizes = np.diff([0.0, *(time for time, _ in expected)])
    assert (cost.steps, cost.rejected) == (len(expected), expected[-1][1])
    assert cost.largest_step == pytest.approx(sizes.max(), rel=2e-4)
    assert cost.smallest_step is not None
    assert math.isclose(cost.smallest_step, sizes.min(), rel_tol=2e-4)
