"""The flat symbolic equations against what lowering computes: two roads from the same laws to the same numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import sympy

from modelgen import (
    Driveline,
    Element,
    Equations,
    Flange,
    GearPair,
    GroundDamper,
    GroundSpring,
    HarmonicTorque,
    Inertia,
    Param,
    RigidGear,
    Shaft,
    State,
    SteppedTorque,
    assemble,
    load,
    lower,
    quantity,
)
from modelgen.equations.symbolic import coordinates, definitions, forces, linearized, mass_matrix, rates
from modelgen.errors import NamingError
from modelgen.lowering import Compiled
from modelgen.lowering.parameters import MODAL


def _own_elements() -> tuple[type[Element], ...]:
    class CubicShaft(Element):
        a, b = Flange(), Flange()
        stiffness = Param("N*m/rad", positive=True)
        cubic = Param("N*m/rad^3", nonnegative=True)

        @quantity("rad")
        def twist(self) -> Any:
            return self.a.angle - self.b.angle

        def torques(self) -> Mapping[Any, Any]:
            torque = self.stiffness * self.twist + self.cubic * self.twist**3
            return {self.a: -torque, self.b: torque}

    class SliderCrank(Element):
        crank = Flange()
        radius = Param("m", positive=True)
        mass = Param("kg", positive=True)

        def kinetic_energy(self) -> Any:
            return self.mass * (self.radius * sympy.sin(self.crank.angle) * self.crank.speed) ** 2 / 2

    class RelaxingShaft(Element):
        a, b = Flange(), Flange()
        stiffness = Param("N*m/rad", positive=True)
        relaxation = Param("s", positive=True)
        inner = State("N*m", scale=1.0)

        @quantity("rad/s")
        def slip(self) -> Any:
            return self.a.speed - self.b.speed

        def torques(self) -> Mapping[Any, Any]:
            return {self.a: -self.inner, self.b: self.inner}

        def rates(self) -> Mapping[Any, Any]:
            return {self.inner: self.stiffness * self.slip - self.inner / self.relaxation}

    for each in (CubicShaft, SliderCrank, RelaxingShaft):
        del Element.vocabulary[each.kind]  # these tests alone know them
    return CubicShaft, SliderCrank, RelaxingShaft


CubicShaft, SliderCrank, RelaxingShaft = _own_elements()


def _two(*elements: Element, **more: Any) -> Driveline:
    return Driveline("two", elements=(Inertia("engine", inertia=5.0), Inertia("load", inertia=2.0), *elements), **more)


def _gears(**switches: Any) -> Driveline:
    return _two(
        GearPair("mesh", "engine", "load", teeth_a=20, teeth_b=33, module="5 mm", mean_stiffness=3e8, **switches),
        speed=150.0,
        reference="engine",
    )


LINES = {
    "per_shaft": _two(Shaft("shaft", "engine", "load", stiffness=1e4, damping_ratio=0.05)),
    "value": _two(Shaft("shaft", "engine", "load", stiffness=1e4, damping="value", damping_coefficient=3.0)),
    "loss_factor": _two(
        Shaft("shaft", "engine", "load", stiffness=1e4, damping="loss_factor", loss_factor=0.1, reference_frequency=80.0)
    ),
    "modal": _two(Shaft("shaft", "engine", "load", stiffness=1e4, damping="modal", damping_ratio=0.05)),
    "ground": _two(
        Shaft("shaft", "engine", "load", stiffness=1e4),
        GroundSpring("wire", "load", stiffness=50.0, damping=0.2),
        GroundDamper("drag", "engine", damping=0.7),
    ),
    "cubic": _two(CubicShaft("shaft", "engine", "load", stiffness=1e2, cubic=4e3)),
    "own_state": _two(RelaxingShaft("shaft", "engine", "load", stiffness=1e2, relaxation=0.3)),
    "slider": _two(SliderCrank("slider", "load", radius=0.4, mass=3.0), Shaft("shaft", "engine", "load", stiffness=1e2)),
    "gears": _gears(damping_ratio=0.1, half_backlash=1e-4, stiffness_cosine=(4e7, 2e7), stiffness_sine=(1e7, 3e7)),
    "gears with error": _gears(damping_ratio=0.1, error_mean=2e-5, error_amplitude=3e-5, error_phase=0.7, damping="literal"),
    "gears in contact": _gears(damping="value", damping_coefficient=4e3, viscous="contact_only", half_backlash=1e-5),
    "rigid gears": Driveline(
        "rigid",
        speed=100.0,
        reference="motor",
        elements=[
            Inertia("motor", inertia=0.2),
            Inertia("pinion", inertia=0.1),
            Inertia("wheel", inertia=3.0),
            Inertia("drum", inertia=9.0),
            RigidGear("gear", "pinion", "wheel", teeth_a=19, teeth_b=71),
            Shaft("input", "motor", "pinion", stiffness=2e3, damping_ratio=0.04),
            Shaft("output", "wheel", "drum", stiffness=7e4, damping_ratio=0.03),
            HarmonicTorque("drive", "motor", mean=20.0, sine=[5.0, 0.0, 2.0], cosine=[1.0, 3.0, 0.5], base="half", phase=0.4),
            SteppedTorque("brake", "wheel", before=-10.0, after=-30.0, at=0.01, shape="ramp", duration=0.1),
        ],
        bases={"half": ("motor", "1/2")},
    ),
}


def numbers(model: Compiled, p: np.ndarray, t: float, x: np.ndarray) -> dict[sympy.Symbol, sympy.Float]:
    """What every symbol of the flat equations is at one instant; angles and speeds are those that lowering sees."""
    eq = model.equations
    n = len(eq.steps)
    deviation, rate = (np.asarray(each).ravel() for each in model.mean_model.angles(x, p))
    angles, speeds = coordinates(eq)
    known = {s: sympy.Float(value, 40) for s, value in zip(model.parameters.symbols, p.tolist(), strict=False)}
    # Uniform rotation to forty digits, where it cancels: lowering never adds it to a relative angle.
    mean = [each.xreplace(known) * known.get(eq.speed, 0) for each in eq.mean_speeds]
    known.update(
        zip(angles, (w * sympy.Float(t, 40) + value for w, value in zip(mean, deviation.tolist(), strict=True)), strict=True)
    )
    known.update(zip(speeds, (w + value for w, value in zip(mean, rate.tolist(), strict=True)), strict=True))
    known.update({sympy.Symbol(s.name, real=True): x[2 * n + k] for k, s in enumerate(s for s in eq.states if s.kind == "own")})
    modal = range(model.parameters.slices[MODAL].start, model.parameters.slices[MODAL].stop)
    known.update({sympy.Symbol(f"modal.damping[{k}]", real=True): p[row] for k, row in enumerate(modal, 1)})
    known[sympy.Symbol("t", real=True)] = t
    return {symbol: sympy.Float(value, 40) for symbol, value in known.items()}


def evaluated(matrix: sympy.Matrix, known: Mapping[sympy.Symbol, Any]) -> np.ndarray:
    return np.array([[float(entry.xreplace(known)) for entry in matrix.row(i)] for i in range(matrix.rows)])


def random_point(model: Compiled, seed: int) -> tuple[np.ndarray, float, np.ndarray]:
    """Parameters, a time and a state; the modal damping matrix is filled with any numbers, lowering takes it as given."""
    generator = np.random.default_rng(seed)
    p = model.parameters.vector()
    modal = model.parameters.slices[MODAL]
    p[modal] = generator.normal(size=modal.stop - modal.start)
    scale = [1e-4 if state.unit == "m" else 0.1 for state in model.equations.states]
    return p, float(generator.uniform(0, 0.5)), generator.normal(size=len(model.states)) * scale


def group_accelerations(model: Compiled, p: np.ndarray, t: float, x: np.ndarray) -> np.ndarray:
    """Second derivatives of the group angles, from the rates that lowering gives to the chosen states."""
    n = len(model.equations.steps)
    second = model.rhs(t, x, p)[n : 2 * n]
    state = np.concatenate([second, np.zeros(len(x) - n)])
    return np.asarray(model.mean_model.angles(state, p)[0]).ravel()


@pytest.mark.parametrize("name", LINES)
def test_equations_of_motion_agree_with_lowering(name: str) -> None:
    equations = assemble(LINES[name])
    model = lower(equations)
    mass, force, own = mass_matrix(equations), forces(equations), rates(equations)
    for seed in range(3):
        p, t, x = random_point(model, seed)
        known = numbers(model, p, t, x)
        expected = group_accelerations(model, p, t, x)
        found = np.linalg.solve(evaluated(mass, known), evaluated(force, known)).ravel()
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
        own_rates = model.rhs(t, x, p)[2 * len(equations.steps) :]
        np.testing.assert_allclose(evaluated(own, known).ravel(), own_rates, rtol=1e-12)


def test_the_truck_agrees_with_lowering() -> None:
    equations = assemble(load("fracturing-truck"))
    model = lower(equations)
    p, t, x = random_point(model, 1)
    known = numbers(model, p, t, x)
    expected = group_accelerations(model, p, t, x)
    found = np.linalg.solve(evaluated(mass_matrix(equations), known), evaluated(forces(equations), known)).ravel()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("name", LINES)
def test_linearization_agrees_with_the_linear_mean_model(name: str) -> None:
    equations = assemble(LINES[name])
    model = lower(equations)
    p, _, x = random_point(model, 5)
    deviation, rate = model.mean_model.angles(x, p)
    own = x[2 * len(equations.steps) :]
    # At t = 0 and with all clocks at zero, the mean model takes the values of the time quantities that are put in.
    clocks = np.zeros(len(equations.clocks))
    timed = model.mean_model.timed(clocks, 0.0, p)
    expected = [each.full() for each in model.mean_model.linear(deviation, rate, own, p, timed)]
    known = numbers(model, p, 0.0, x)
    for matrix, reference in zip(linearized(equations), expected, strict=True):
        np.testing.assert_allclose(evaluated(matrix, known), reference, rtol=0, atol=1e-12 * np.abs(reference).max(initial=1e-30))


@pytest.mark.parametrize("name", ["gears", "gears in contact", "cubic", "rigid gears"])
def test_named_and_written_out_are_the_same(name: str) -> None:
    equations = assemble(LINES[name])
    written: dict[sympy.Symbol, sympy.Expr] = {}
    for symbol, expression in definitions(equations):
        assert not expression.free_symbols - set(written) & {s for s, _ in definitions(equations)}, "uses what comes later"
        written[symbol] = expression.xreplace(written)
    assert forces(equations, named=True).xreplace(written) == forces(equations)
    for named, plain in zip(linearized(equations, named=True), linearized(equations), strict=True):
        assert named.xreplace(written) == plain


def test_a_nonlinear_law_keeps_its_quantities_in_the_tangent() -> None:
    equations = assemble(LINES["cubic"])
    stiffness, cubic = (s for p in equations.parameters if p.name.startswith("shaft.") for s in p.symbols)
    twist = sympy.Symbol("shaft.twist", real=True)
    tangent = stiffness + 3 * cubic * twist**2
    _, damping, k = linearized(equations, named=True)
    assert damping == sympy.zeros(2, 2)
    assert (k - tangent * sympy.Matrix([[1, -1], [-1, 1]])).applyfunc(sympy.expand) == sympy.zeros(2, 2)


def test_an_inertia_seen_through_a_rigid_gear() -> None:
    equations = assemble(LINES["rigid gears"])
    first, second = (sympy.Symbol(f"gear.teeth_{end}", positive=True, integer=True) for end in "ab")
    j = {name: sympy.Symbol(f"{name}.inertia", positive=True) for name in ("motor", "pinion", "wheel", "drum")}
    referred = j["pinion"] + j["wheel"] * first**2 / second**2
    assert mass_matrix(equations) == sympy.diag(j["motor"], referred, j["drum"])
    assert [str(symbol) for symbol in coordinates(equations)[0]] == ["theta_motor", "theta_pinion", "theta_drum"]


def test_equations_hand_on_what_is_computed_here() -> None:
    equations: Equations = assemble(LINES["per_shaft"])
    assert equations.mass_matrix() == mass_matrix(equations)
    assert equations.forces(named=True) == forces(equations, named=True)
    assert equations.linearized() == linearized(equations)


def test_a_parameter_named_like_an_angle_is_refused() -> None:
    line = _two(Shaft("shaft", "engine", "load", stiffness="theta_load"), parameters={"theta_load": "5 N*m/rad"})
    words = "driveline 'two': 'theta_load' would stand for an angle too; rename the parameter or state"
    with pytest.raises(NamingError, match=words):
        forces(assemble(line))
