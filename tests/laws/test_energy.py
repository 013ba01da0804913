"""Energy: what flows in at the flanges is stored, or turned into heat, or came from outside; for every element."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from modelgen.elements import GearPair, GroundDamper, GroundSpring, Inertia, RigidGear, Shaft
from modelgen.equations import assemble
from modelgen.lowering import lower
from modelgen.model import Driveline

ROUNDING = 1e-12


def test_the_book_closes_at_random_states(bench):
    for t, x in bench.states(20):
        books = bench.books(t, x)
        left = books["rate"] + books["dissipated"] - books["supplied"] - books["explicit"]
        assert left == pytest.approx(0, abs=ROUNDING * sum(map(abs, books.values())))


def test_the_book_closes_in_every_mode_also_beyond_its_border(bench):
    # Within a mode a law must be a law by itself: a step of a solver reaches beyond the border before it finds the event.
    if not bench.model.equations.modes:
        return
    switched = bench.model.switched()
    (mode,) = switched.switching.modes
    for value in range(len(mode.values)):
        p = switched.extended(bench.p)
        mode.put(p, value)
        for t, x in bench.states(10):
            _, rate, *_, dissipated, supplied, explicit = book = bench.switched_book(t, x, p).full().ravel()
            left = rate + dissipated - supplied - explicit
            assert left == pytest.approx(0, abs=ROUNDING * np.abs(book).sum()), mode.values[value]


def test_flange_power_is_stored_or_lost_or_supplied(bench):
    # The same law seen from the element alone: the torques it puts on its disks against its own energies.
    if bench.element.inertias() or bench.element.kinetic_energy() is not None:
        return  # what turns with a disk shares its torque: the book of the whole bench holds for it
    for t, x in bench.states(10):
        now = bench.model.evaluate(t, x, bench.p)
        applied = now["push.torque"] * now[f"{bench.disks[0]}.speed"]
        accelerating = [bench.inertia(disk) * now[f"{disk}.acceleration"] * now[f"{disk}.speed"] for disk in bench.disks]
        books = bench.books(t, x)
        outward = sum(accelerating) - applied
        inward = books["stored rate"] + books["dissipated"] - (books["supplied"] - applied) - books["explicit"]
        assert outward + inward == pytest.approx(0, abs=ROUNDING * (sum(map(abs, accelerating)) + sum(map(abs, books.values()))))


def test_no_element_makes_heat_from_nothing(bench):
    assert min(bench.books(t, x)["dissipated"] for t, x in bench.states(200)) >= 0


def test_energy_is_accounted_for_while_it_moves(still_bench):
    bench, (_, start) = still_bench, still_bench.states(1)[0]
    books = [bench.books(t, start) for t in np.linspace(0, 10, 40)]
    varies = len({each["stored"] for each in books}) > 1
    explicit = any(abs(each["explicit"]) > ROUNDING * each["energy"] for each in books)
    if varies and not explicit:
        pytest.skip("its stiffness jumps with time, and a jump brings energy in an instant that no integral sees")
    energy, received = run(bench, start)
    assert energy - received == pytest.approx(energy[0], rel=1e-6)
    if not explicit and not any(each["supplied"] for each in books):
        losses = [bench.books(t, x)["dissipated"] for t, x in bench.states(20)]
        if any(losses):
            assert np.all(np.diff(energy) < 1e-7 * energy[0])
            assert energy[-1] < energy[0]
        else:
            assert energy == pytest.approx(energy[0], rel=1e-6)


def run(bench, start):
    """Energy along a motion over a few of its fastest periods, and the energy received meanwhile."""
    fast, p, n = bench.model.fast_rhs(bench.p), bench.p, len(start)

    def rate(t, y):
        books = bench.books(t, y[:n])
        return [*fast(t, y[:n]), books["supplied"] + books["explicit"] - books["dissipated"]]

    fastest = np.abs(np.linalg.eigvals(bench.model.jacobian(0.0, start, p))).max()
    end = min(10 / max(fastest, 1e-3), 1.0)
    found = solve_ivp(rate, (0, end), [*start, 0.0], "DOP853", np.linspace(0, end, 21), rtol=1e-8, atol=1e-9)
    assert found.success
    return np.array([bench.books(t, y[:n])["energy"] for t, y in zip(found.t, found.y.T, strict=True)]), found.y[-1]


@pytest.mark.parametrize("damped", [False, True])
def test_a_whole_driveline_keeps_or_loses_its_energy(damped):
    zeta, xi, drag = (0.05, 0.1, 0.3) if damped else (0.0, 0.0, 0.0)
    line = Driveline(
        "mixed",
        [
            Inertia("engine", inertia=2.0),
            Inertia("pinion", inertia=0.1),
            Inertia("wheel", inertia=0.5),
            Inertia("rotor", inertia=1.5),
            Inertia("fan", inertia=0.4),
            Shaft("input", "engine", "pinion", stiffness=900.0, damping_ratio=zeta),
            GearPair(
                "mesh",
                "pinion",
                "wheel",
                teeth_a=20,
                teeth_b=50,
                module=0.01,
                mean_stiffness=4e5,
                damping_ratio=xi,
                half_backlash=2e-4,
            ),
            Shaft("output", "wheel", "rotor", stiffness=700.0, damping_ratio=zeta),
            RigidGear("step_up", "rotor", "fan", teeth_a=31, teeth_b=17),
            GroundSpring("mount", "fan", stiffness=50.0, damping=drag),
            GroundDamper("brake", "engine", damping=drag),
        ],
        speed=1.0,
        reference="engine",
    )
    model = lower(assemble(line))
    p = model.parameters.vector()
    fast = model.fast_rhs(p)
    start = np.random.default_rng(5).uniform(-0.05, 0.05, len(model.states))
    found = solve_ivp(lambda t, x: fast(t, x).copy(), (0, 1), start, "DOP853", np.linspace(0, 1, 21), rtol=1e-11, atol=1e-12)
    assert found.success
    parts = model.channels(found.t, found.y.T, p, ["total.kinetic_energy", "total.stored_energy"])
    energy = sum(parts.values())
    if damped:
        assert np.all(np.diff(energy) < 0)
        assert energy[-1] < 0.8 * energy[0]
    else:
        assert energy == pytest.approx(energy[0], rel=1e-8)
