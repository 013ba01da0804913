"""Radau IIA collocation of order 5: CasADi's fixed-step integrator, with its step sizes chosen by step doubling.

Part of ``solvers``. CasADi's plugin takes a number of finite elements and knows no tolerance. Here one element is one step of the
loop that the adaptive Runge-Kutta method uses too, so that tolerance, dense outputs, budgets and outcomes mean the same; with
``fixed_step``, the elements are two of half that size each. Stiffly accurate and L-stable (Hairer and Wanner, Solving Ordinary
Differential Equations II, IV.5), and dear: three implicit systems of 3 nx equations per step.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import casadi as ca

from modelgen.solvers.coordinates import scaled_rate, symbols_for
from modelgen.solvers.march import march
from modelgen.solvers.method import Method
from modelgen.solvers.outcome import Outcome
from modelgen.solvers.problem import InitialValueProblem, SolverOptions, Trajectory
from modelgen.solvers.step_doubling import step_doubling
from modelgen.solvers.watch import Watch

STAGES = 3
ORDER = 2 * STAGES - 1
UNSEEN = (4 - math.sqrt(6)) / 20  # of the step lies before its first slope: half of the first of Radau's points
EVALUATIONS = 3 * STAGES * 3 + 3  # about three Newton iterations for each of the three systems; CasADi does not count them
NEWTON_ITERATIONS = 10


def radau_element(rate: ca.Function, tolerance: float) -> ca.Function:
    """One collocation element, as CasADi's integrator: x0 = 0, p = [t, h, y, q] -> what y gains over the step, ``xf``.

    ``qf`` (3 nx) holds three integrals, each equal to ``xf`` if and only if the collocation equations are solved: with u the
    polynomial of the element and s its time, those of u', s u' + u and s^2 u' + 2 s u (by parts; the quadrature is exact).
    """
    n, m = rate.numel_in(1), rate.numel_in(2)
    symbols = symbols_for(rate)
    tau, gain, p = symbols.sym("tau"), symbols.sym("gain", n), symbols.sym("p", 2 + n + m)
    t, h, y, q = p[0], p[1], p[2 : 2 + n], p[2 + n :]
    newton = {
        "abstol": 1e-3 * tolerance,
        "abstolStep": 1e-3 * tolerance,
        "max_iter": NEWTON_ITERATIONS,
        "line_search": False,  # it gives up where plain Newton converges, on stiff problems
        "error_on_fail": False,  # it would print every argument; the step looks at the integrals instead
        "show_eval_warnings": False,
    }
    options: dict[str, Any] = {
        "number_of_finite_elements": 1,
        "collocation_scheme": "radau",
        "interpolation_order": STAGES,
        "rootfinder": "newton",
        "rootfinder_options": newton,
        "show_eval_warnings": False,
    }
    slope = h * rate(t + h * tau, y + gain, q)
    checks = ca.vertcat(slope, tau * slope + gain, tau**2 * slope + 2 * tau * gain)
    system = {"t": tau, "x": gain, "p": p, "ode": slope, "quad": checks}
    return ca.integrator("element", "collocation", system, 0.0, 1.0, options)


@functools.lru_cache(maxsize=16)
def radau_step(rate: ca.Function, tolerance: float, extrapolate: bool = True) -> ca.Function:
    """One step-doubling step (t, h, [y, y'], q) -> (nodes, measures, whole, halves); see ``step_doubling``."""
    element = radau_element(rate, tolerance)
    n = rate.numel_in(1)

    def increment(f: Callable[[Any, Any], Any], time: Callable[[Fraction], Any], h: Any, y: Any, slope: Any, q: Any) -> Any:
        result = element(x0=ca.DM.zeros(n), p=ca.vertcat(time(Fraction(0)), h, y, q))
        defect = ca.norm_inf(result["qf"] - ca.repmat(result["xf"], STAGES))
        return ca.if_else(defect <= tolerance, result["xf"], math.nan)  # NaN: the iteration did not converge

    return step_doubling(rate, increment, ORDER, extrapolate, unseen=UNSEEN, inline=False)


def solve_collocation(problem: InitialValueProblem, options: SolverOptions) -> Trajectory:
    """Integrate by collocation elements of error-controlled or fixed size."""
    watch = Watch(options)  # building the step counts
    step = radau_step(scaled_rate(problem.rhs), options.tolerance, options.extrapolate)
    return march(problem, options, Method(step, ORDER + 1, EVALUATIONS, floor_outcome=Outcome.NEWTON_FAILED), watch)
