"""openTorsion as a referee: random geared chains, by two programs that share nothing but NumPy; skipped where it is absent.

openTorsion (Aalto University, MIT license) counts the angles of rigid gears in space, this package forward in each shaft's own
sense: amplitudes differ in sign behind each gear, frequencies do not.
"""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from modelgen import Driveline, GroundDamper, HarmonicTorque, Inertia, RigidGear, Shaft, assemble, lower, modal
from modelgen.analysis import forced

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    opentorsion = pytest.importorskip("opentorsion", reason="the referee openTorsion is not installed")

SPEED, ORDER = 90.0, 3


def random_chain(seed: int):
    """A chain of 3 to 12 disks in which some neighbors are joined by a rigid gear instead of a shaft, in both programs' words."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 13))
    inertias, drag = rng.uniform(0.05, 20.0, count), rng.uniform(0.1, 2.0, count)
    meshed = [bool(rng.random() < 0.3) and n > 0 for n in range(count - 1)]
    meshed = [each and not (n and meshed[n - 1]) for n, each in enumerate(meshed)]
    ours = [Inertia(f"disk_{n}", inertia=float(j)) for n, j in enumerate(inertias)]
    ours += [GroundDamper(f"drag_{n}", f"disk_{n}", damping=float(c)) for n, c in enumerate(drag)]
    disks = [opentorsion.Disk(n, I=float(j), c=float(c)) for n, (j, c) in enumerate(zip(inertias, drag, strict=True))]
    shafts, gears = [], []
    for n, mesh in enumerate(meshed):
        if mesh:
            a, b = (int(z) for z in rng.integers(17, 90, 2))
            ours.append(RigidGear(f"gear_{n}", f"disk_{n}", f"disk_{n + 1}", teeth_a=a, teeth_b=b))
            parent = opentorsion.Gear(n, 0.0, a)
            gears += [parent, opentorsion.Gear(n + 1, 0.0, b, parent=parent)]
        else:
            k, c = float(10 ** rng.uniform(4, 6.5)), float(rng.uniform(1, 50))
            ours.append(Shaft(f"shaft_{n}", f"disk_{n}", f"disk_{n + 1}", stiffness=k, damping="value", damping_coefficient=c))
            shafts.append(opentorsion.Shaft(n, n + 1, k=k, c=c, I=0))
    ours += [
        HarmonicTorque("shake", "disk_0", cosine=[0.0] * (ORDER - 1) + [100.0], base="turn"),
        HarmonicTorque("drive", "disk_0", mean=1.0),
    ]
    line = Driveline("chain", speed=SPEED, reference="disk_0", bases={"turn": 1}, elements=tuple(ours)).balance("drive")
    return lower(assemble(line)), opentorsion.Assembly(shafts, disk_elements=disks, gear_elements=gears or None)


@pytest.mark.parametrize("seed", range(10))
def test_a_random_geared_chain(seed: int) -> None:
    model, theirs = random_chain(seed)
    result = modal(model)
    squares, _ = theirs.undamped_modal_analysis()
    expected = np.sort(np.sqrt(np.abs(np.real(squares)))) / (2 * np.pi)
    assert len(result.frequencies) == len(expected)
    assert result.rigid == 1
    assert result.frequencies[1:] == pytest.approx(expected[1:], rel=1e-9)

    _, damped, ratios = (np.asarray(each) for each in theirs.modal_analysis())
    upper = np.argsort(damped)[len(damped) - len(result.damped_frequencies) :]
    assert result.damped_frequencies * 2 * np.pi == pytest.approx(damped[upper], rel=1e-9)
    assert result.damping_ratios == pytest.approx(ratios[upper], rel=1e-8, abs=1e-12)

    omega = np.array([ORDER * SPEED])
    force = np.zeros((len(expected), 1), dtype=complex)
    force[0] = 100.0
    answer, _ = theirs.ss_response(force, omega)
    ours = forced(model, channels=["disk_0.angle_deviation"])["disk_0.angle_deviation"][0, 0]
    assert ours == pytest.approx(answer[0, 0], rel=1e-9)
