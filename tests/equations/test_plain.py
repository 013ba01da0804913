"""Plain systems: their right-hand sides against NumPy, their names, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy

from modelgen import Case, Guard, lower, simulate
from modelgen.equations import system
from modelgen.errors import LoweringError, ModelError, ModelFileError, ModelgenError, NamingError, UnitError

x, y, z, v, t = sympy.symbols("x y z v t")
mu, sigma, rho, beta = sympy.symbols("mu sigma rho beta", positive=True)


def check(equations: Any, reference: Any, points: np.ndarray, times: Any = (0.0,)) -> None:
    """The right-hand side agrees with ``reference(t, x)`` to 1e-14 of its largest entry."""
    model = lower(equations)
    p = model.parameters.vector()
    for point in points:
        for time in times:
            expected = np.asarray(reference(time, point))
            np.testing.assert_allclose(model.rhs(time, point, p), expected, rtol=0, atol=1e-14 * np.abs(expected).max())


def test_lorenz() -> None:
    # E. N. Lorenz, Deterministic Nonperiodic Flow, J. Atmos. Sci. 20 (1963), Eq. 25-27, with his constants.
    lorenz = system(
        states={x: 0.0, y: 1.0, z: 0.0},
        rates={x: sigma * (y - x), y: x * (rho - z) - y, z: x * y - beta * z},
        parameters={sigma: 10.0, rho: 28.0, beta: 8 / 3},
        name="lorenz",
    )

    def reference(_: float, s: np.ndarray) -> list[float]:
        return [10 * (s[1] - s[0]), s[0] * (28 - s[2]) - s[1], s[0] * s[1] - 8 / 3 * s[2]]

    check(lorenz, reference, np.random.default_rng(1).normal(size=(20, 3)) * 20)
    assert lorenz.name == "lorenz"


def test_van_der_pol_by_names_and_texts() -> None:
    by_symbols = system({x: 2.0, v: 0.0}, {x: v, v: mu * (1 - x**2) * v - x}, {mu: 5.0})
    by_names = system({"x": 2.0, "v": 0.0}, {"v": "mu*(1 - x**2)*v - x", "x": "v"}, {"mu": 5.0})

    def reference(_: float, s: np.ndarray) -> list[float]:
        return [s[1], 5 * (1 - s[0] ** 2) * s[1] - s[0]]

    for each in (by_symbols, by_names):
        check(each, reference, np.random.default_rng(2).normal(size=(20, 2)) * 3)


def test_hires() -> None:
    # Test Set for Initial Value Problem Solvers (Mazzia and Magherini, release 2.4), problem HIRES.
    s = sympy.symbols("y1:9")
    reaction = 280 * s[5] * s[7]
    right = [
        -1.71 * s[0] + 0.43 * s[1] + 8.32 * s[2] + 0.0007,
        1.71 * s[0] - 8.75 * s[1],
        -10.03 * s[2] + 0.43 * s[3] + 0.035 * s[4],
        8.32 * s[1] + 1.71 * s[2] - 1.12 * s[3],
        -1.745 * s[4] + 0.43 * s[5] + 0.43 * s[6],
        -reaction + 0.69 * s[3] + 1.71 * s[4] - 0.43 * s[5] + 0.69 * s[6],
        reaction - 1.81 * s[6],
        -reaction + 1.81 * s[6],
    ]
    start = [1.0, 0, 0, 0, 0, 0, 0, 0.0057]
    hires = system(dict(zip(s, start, strict=True)), dict(zip(s, right, strict=True)), name="hires")
    linear = np.array([
        [-1.71, 0.43, 8.32, 0, 0, 0, 0, 0],
        [1.71, -8.75, 0, 0, 0, 0, 0, 0],
        [0, 0, -10.03, 0.43, 0.035, 0, 0, 0],
        [0, 8.32, 1.71, -1.12, 0, 0, 0, 0],
        [0, 0, 0, 0, -1.745, 0.43, 0.43, 0],
        [0, 0, 0, 0.69, 1.71, -0.43, 0.69, 0],
        [0, 0, 0, 0, 0, 0, -1.81, 0],
        [0, 0, 0, 0, 0, 0, 1.81, 0],
    ])  # fmt: skip

    def reference(_: float, state: np.ndarray) -> np.ndarray:
        jump = 280 * state[5] * state[7] * np.array([0, 0, 0, 0, 0, -1, 1, -1])
        return linear @ state + jump + np.array([0.0007, 0, 0, 0, 0, 0, 0, 0])

    check(hires, reference, np.random.default_rng(3).uniform(0, 1, size=(20, 8)))
    model = lower(hires)
    assert [state.start for state in hires.states] == start
    assert model.jacobian(0.0, np.ones(8), model.parameters.vector())[5, 7] == -280.0


def test_rates_that_depend_on_time() -> None:
    # Dimensionless gear pair of the paper's symbols: x'' + 2 zeta x' + (1 + kappa cos(Omega t)) f(x) = F.
    names = "zeta kappa omega force"
    zeta, kappa, omega, force = sympy.symbols(names)
    gap = sympy.Piecewise((x - 1, x > 1), (x + 1, x < -1), (0, True))
    pair = system(
        {x: 0.5, v: 0.0},
        {x: v, v: force - 2 * zeta * v - (1 + kappa * sympy.cos(omega * t)) * gap},
        dict(zip(names.split(), (0.05, 0.1, 0.8, 0.2), strict=True)),
    )

    def reference(time: float, s: np.ndarray) -> list[float]:
        f = s[0] - np.clip(s[0], -1, 1)
        return [s[1], 0.2 - 0.1 * s[1] - (1 + 0.1 * np.cos(0.8 * time)) * f]

    check(pair, reference, np.random.default_rng(4).normal(size=(10, 2)) * 2, times=(0.0, 1.5, 7.0))


def test_names_units_scales_and_outputs_are_plain() -> None:
    mass, k = sympy.symbols("m k", positive=True)
    oscillator = system(
        states={x: "2 mm", "v": 0.0},
        rates={x: v, v: -k * x / mass},
        parameters={mass: "3 kg", k: 12.0},
        outputs={"energy": k * x**2 / 2 + mass * v**2 / 2, "late": t, "two": 2},
        units={"x": "m", "v": "m/s", k: "N/m", "energy": "J", "late": "s"},
        scales={x: 1e-3},
        name="oscillator",
    )
    model = lower(oscillator)
    assert model.states == ("x", "v")
    assert model.outputs == ("x", "v", "energy", "late", "two")
    assert model.units == ("m", "m/s", "J", "s", "1")
    assert [(s.start, s.scale) for s in oscillator.states] == [(0.002, 1e-3), (0.0, None)]
    assert model.parameters.names == ("m", "k")
    assert oscillator.parameters[0].unit == "kg"
    p = model.parameters.vector({"k": "8 N/m"})
    expected = {"x": 0.5, "v": 2.0, "energy": 7.0, "late": 4.0, "two": 2.0}
    assert model.evaluate(4.0, [0.5, 2.0], p) == expected
    with pytest.raises(ModelError, match=r"parameter 'm': is -1.0 .*; give a positive value"):
        model.parameters.vector({"m": -1.0})


def test_one_state_and_no_parameters() -> None:
    decay = lower(system({x: 1.0}, {x: -x}))
    assert decay.rhs(0.0, [3.0], decay.parameters.vector()).tolist() == [-3.0]


def test_a_plain_system_runs() -> None:
    circle = system({x: 1.0, y: 0.0}, {x: -y, y: x}, outputs={"radius": sympy.sqrt(x**2 + y**2)}, name="circle")
    solution = simulate(Case(lower(circle), end=2 * np.pi, tolerance=1e-10, start="zero"))
    assert solution.succeeded
    np.testing.assert_allclose([solution["x"][-1], solution["y"][-1]], [1.0, 0.0], atol=1e-7)
    np.testing.assert_allclose(solution["radius"], 1.0, atol=1e-7)
    assert str(circle) == "equations of 'circle': 2 states, 0 parameters, 3 outputs"


def test_a_symbol_counts_by_its_name() -> None:
    plain, real = sympy.Symbol("x"), sympy.Symbol("x", real=True)
    model = lower(system({plain: 1.0}, {real: -sympy.Symbol("k", positive=True) * plain * real}, {"k": 2.0}))
    assert model.rhs(0.0, [3.0], model.parameters.vector()).tolist() == [-18.0]


def test_what_lowering_cannot_do_is_refused_by_name() -> None:
    with pytest.raises(LoweringError, match="'gamma' has no numeric counterpart"):
        lower(system({x: 1.0}, {x: sympy.gamma(x)}))


state = sympy.Function("x")(t)
GOOD: dict[str, Any] = {"states": {x: 1.0, v: 0.0}, "rates": {x: v, v: -mu * x}, "parameters": {mu: 2.0}}
WRONG: list[tuple[dict[str, Any], type[ModelgenError], str]] = [
    ({"states": {}}, ModelError, "system 'system': has no states; give at least one state with its start"),
    ({"states": [x, v]}, ModelError, "its states are list; give a mapping from names to states"),
    ({"rates": {x: v}}, ModelError, r"state 'v' has no rate; give rates\['v'\], its time derivative"),
    ({"rates": {x: v, v: -x, "w": x}}, NamingError, "rate of 'w', which is not known"),
    (
        {"rates": {x: v, v: -mu * x + sympy.Symbol("xx")}},
        NamingError,
        "rate of 'v': uses 'xx', which is no state .*; nearest is 'x'",
    ),
    ({"rates": {x: v, v: "-mu*q"}}, NamingError, "rate of 'v': there is no 'q'"),
    ({"rates": {x: v, v: "-mu*x +"}}, ModelFileError, "rate of 'v': '-mu\\*x \\+' is no expression"),
    ({"rates": {x: v, v: state}}, ModelError, r"rate of 'v': uses x\(t\); write states as symbols"),
    ({"rates": {x: v, v: state.diff(t)}}, ModelError, r"rate of 'v': uses Derivative\(x\(t\), t\)"),
    ({"rates": {x: v, v: None}}, ModelError, "rate of 'v': is None; give a SymPy expression, a number, or a text"),
    ({"rates": {x: v, v: True}}, ModelError, "rate of 'v': is True; give a SymPy expression"),
    ({"rates": {x: v, v: float("nan")}}, UnitError, "rate of 'v': nan is not a finite number"),
    ({"rates": {x: v, v: sympy.Matrix([x])}}, ModelError, "rate of 'v': is Matrix"),
    ({"states": {x: 1.0, "x": 2.0, v: 0.0}}, NamingError, "state 'x' is given twice; give it once, by its symbol or by its name"),
    ({"parameters": {mu: 2.0, x: 3.0}}, NamingError, "parameter 'x' is a state already; rename it"),
    ({"outputs": {mu: x}}, NamingError, "output 'mu' is a parameter already; rename it"),
    ({"parameters": {mu: 2.0, t: 1.0}}, NamingError, "parameter 't' stands for time; rename it"),
    ({"states": {x: 1.0, v: 0.0, "time": 0.0}}, NamingError, "state 'time' stands for time"),
    ({"states": {x: 1.0, v: 0.0, "a b": 0.0}}, NamingError, "state 'a b' holds ' ' .*; write 'a_b'"),
    ({"states": {x: 1.0, v: 0.0, 3: 0.0}}, NamingError, "state 3 is not a text but int"),
    ({"states": {x: "fast", v: 0.0}}, UnitError, "start of state 'x': 'fast' is not a number with a unit"),
    ({"states": {x: None, v: 0.0}}, UnitError, "start of state 'x': None is not a number"),
    ({"states": {x: mu, v: 0.0}}, UnitError, "start of state 'x': mu is not a number; give a number or a text with a unit"),
    ({"states": {x: float("inf"), v: 0.0}}, UnitError, "start of state 'x': inf is not a finite number"),
    (
        {"states": {x: "2 s", v: 0.0}, "units": {x: "m"}},
        UnitError,
        "start of state 'x': 's' has the dimension .*; 'm' .* is asked for",
    ),
    ({"parameters": {mu: -2.0}}, ModelError, "parameter 'mu' is -2, but its symbol is declared positive"),
    ({"units": {"w": "m"}}, NamingError, "unit of 'w', which is not known"),
    ({"units": {x: "furlong"}}, UnitError, "unit 'furlong': is not an SI unit text"),
    ({"units": {x: 3}}, UnitError, "its unit is 3"),
    ({"outputs": {"w": x}, "units": {"w": "fur"}}, UnitError, "unit 'fur': is not an SI unit text"),
    ({"scales": {x: 0.0}}, ModelError, "the scale of 'x' is 0.0; give a positive number in the unit of the state"),
    ({"scales": {mu: 1.0}}, NamingError, "scale of 'mu', which is not known"),
    ({"outputs": {"w": sympy.Symbol("q")}}, NamingError, "output 'w': uses 'q', which is no state or parameter"),
    ({"name": "2nd"}, NamingError, "model name '2nd' starts with '2'"),
]


@pytest.mark.parametrize(("change", "error", "words"), WRONG)
def test_what_cannot_be_a_system_is_refused(change: dict[str, Any], error: type[ModelgenError], words: str) -> None:
    system(**GOOD)
    with pytest.raises(error, match=words):
        system(**{**GOOD, **change})


def test_a_rate_and_a_reset_of_zero_as_a_decimal_number() -> None:
    still = lower(system({"n": 0.0, "m": 1.0}, {"n": 0.0, "m": sympy.Float(0.0)}))
    assert still.rhs(0.0, [1.0, 2.0], []).tolist() == [0.0, 0.0]
    stop = Guard("stop", "h", direction=-1, reset={"v": 0.0})
    ball = lower(system({"h": 1.0, "v": 0.0}, {"h": "v", "v": -9.81}, guards=[stop]))
    assert ball.switching.resets(0.0, [0.0, -2.0], []).full().ravel().tolist() == [0.0, 0.0]
    with pytest.raises(LoweringError, match="lies beyond the range of double precision"):
        lower(system({"n": 0.0}, {"n": sympy.Float("1e-500")}))
