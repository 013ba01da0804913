"""Natural frequencies and matrices of published drivelines, each with its source.

OT is openTorsion, github.com/Aalto-Arotor/openTorsion at commit 88ab7893 (MIT license); its figures are those of its tests and
notebooks. Figures with more digits were computed again from the same data, independently of this package.
"""

from __future__ import annotations

import numpy as np
import pytest

from modelgen.drivelines import load
from modelgen.elements import GearPair, Inertia, Shaft
from modelgen.equations import assemble
from modelgen.lowering import lower
from modelgen.model import Driveline
from modelgen.solvers.bound_model import operating_point


def chain(inertias, stiffnesses, name="chain"):
    """The operating point of disks joined in a row."""
    disks = [Inertia(f"disk_{n}", inertia=inertia) for n, inertia in enumerate(inertias)]
    shafts = [Shaft(f"shaft_{n}", f"disk_{n}", f"disk_{n + 1}", stiffness=k) for n, k in enumerate(stiffnesses)]
    return operating_point(lower(assemble(Driveline(name, [*disks, *shafts]))))


def test_matrices_of_two_and_three_inertias():
    # OT, opentorsion/tests/tests.py, test_mass_matrix, test_stiffness_matrix and test_stiffness_matrix_2: exact.
    k = 428400.0
    pair, three = chain([10, 10], [k]), chain([10, 10, 10], [k, k])
    assert pair.mass.tolist() == [[10, 0], [0, 10]]
    assert pair.stiffness.tolist() == [[k, -k], [-k, k]]
    assert three.stiffness.tolist() == [[k, -k, 0], [-k, 2 * k, -k], [0, -k, k]]
    assert not three.damping.any()


FRISWELL = [0.0035, 0.0035, 0.0035, 0.15, 0.05], [12000, 12000, 14000, 10000]
MWM = (
    [0.017, 0.009, 0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487, 2.075],
    [1106e3, 1631e3, 1253e3, 1253e3, 1678e3, 1253e3, 1253e3, 1976e3],
)
CHAINS = [
    # OT, tests.py, test_shaft: 176.1 Hz.
    pytest.param([211.4, 8.3], [9.775e6], [0, 176.0767468], 1e-9, id="two disks"),
    # Friswell, Penny, Garvey, Lees, Dynamics of Rotating Machines (2010), example 9.7.1, as in OT, tests.py, test_friswell_ex971.
    pytest.param(*FRISWELL, [0, 81.21, 141.21, 378.95, 536.36], 7e-5, id="friswell as printed"),
    pytest.param(*FRISWELL, [0, 81.20762902, 141.2140714, 378.9529539, 536.3632829], 1e-9, id="friswell"),
    # Thomson, Theory of Vibration with Applications, example 12.4-1: 123.666 and 202.658 rad/s.
    pytest.param([5, 11, 22], [1e5, 2e5], np.array([0, 123.6658, 202.6583]) / (2 * np.pi), 5e-7, id="thomson"),
    # Rao, Mechanical Vibrations, chapter 7 (compressor, turbine, generator): sqrt(0.5e6) and sqrt(1.5e6) rad/s, exact.
    pytest.param([8, 6, 4], [4e6, 2e6], np.sqrt([0, 0.5e6, 1.5e6]) / (2 * np.pi), 1e-12, id="rao"),
    # Mendes, Meirelles, Zampieri, Proc. IMechE K 222 (2008), doi 10.1243/14644193JMBD126, fig. 4; data as in OT, ICE_example.py.
    pytest.param(*MWM, [0, 216.584, 592.74, 984.923, 1171.017], 1e-5, id="six-cylinder diesel"),
    # Sopanen et al., doi 10.1109/TIE.2010.2087301, as in OT, modal_analysis_and_forced_response.ipynb: 58.34, 1034.115 rad/s.
    pytest.param(
        [1e7, 5770, 97030], [3.67e8, 5.496e9], np.array([0, 58.3401619, 1034.114719]) / (2 * np.pi), 1e-9, id="windmill"
    ),
]


@pytest.mark.parametrize(("inertias", "stiffnesses", "frequencies", "tolerance"), CHAINS)
def test_chains(inertias, stiffnesses, frequencies, tolerance):
    found = chain(inertias, stiffnesses).frequencies()[: len(frequencies)]
    assert found[0] == pytest.approx(0, abs=1e-3)
    assert found[1:] == pytest.approx(frequencies[1:], rel=tolerance)


@pytest.mark.parametrize("count", [3, 20])
def test_equal_disks_in_a_row_have_the_closed_form(count):
    # Free-free chain: omega_j = 2 sqrt(k/J) sin(j pi / 2n).
    found = 2 * np.pi * chain([0.3] * count, [700.0] * (count - 1)).frequencies()
    assert found == pytest.approx(2 * np.sqrt(700 / 0.3) * np.sin(np.arange(count) * np.pi / (2 * count)), rel=1e-11, abs=1e-4)


@pytest.mark.parametrize(
    ("omega", "angles", "torques"),
    # Thomson, table 12.4-1: Holzer's table of the chain above; the book prints 0.9484 and 14.66e3, 0.799 and 52.32e3.
    [(20, [1, 0.98, 0.9484], [2000, 6312, 14658.27]), (40, [1, 0.92, 0.799], [8000, 24192, 52318.2])],
)
def test_holzer_table(omega, angles, torques):
    point = chain([5, 11, 22], [1e5, 2e5])
    dynamic = point.stiffness - omega**2 * point.mass
    # All disks but the last are in balance; the first turns by one.
    theta = np.append(1.0, np.linalg.solve(dynamic[:-1, 1:], -dynamic[:-1, 0]))
    assert theta == pytest.approx(angles, abs=5e-5)
    assert omega**2 * np.cumsum(point.mass @ theta) == pytest.approx(torques, rel=1e-4)


def test_gear_pair_with_constant_mesh_stiffness():
    # OT 0.3.2, opentorsion/elements/elastic_gear_element.py: K = k [[1, r], [r, r^2]], r = 3, k on the parent; undamped.
    # Its gears count angles in space, ours forward, so the sign of r is none of the frequencies' business.
    radius, stiffness = 0.1, 1e5
    inertias = zip(("motor", "pinion", "wheel", "load"), (0.5, 0.1, 0.2, 1.5), strict=True)
    line = Driveline(
        "elastic_gear",
        [
            *(Inertia(name, inertia=inertia) for name, inertia in inertias),
            Shaft("first", "motor", "pinion", stiffness=1e4),
            Shaft("second", "wheel", "load", stiffness=2e4),
            GearPair(
                "mesh", "pinion", "wheel", teeth_a=10, teeth_b=30, radii="given", base_radius_a=radius,
                mean_stiffness=stiffness / radius**2,
            ),
        ],
        speed=100.0,
        reference="motor",
    )  # fmt: skip
    found = 2 * np.pi * operating_point(lower(assemble(line))).frequencies()
    assert found == pytest.approx([0, 119.2600333, 344.7462133, 2366.486938], rel=1e-9, abs=1e-3)


TRUCKS = {
    # Fracturing truck, 16 degrees of freedom, mean mesh stiffness: eigenvalues of its data set, computed independently [Hz].
    "fracturing-truck": """
        0.0 45.23638068698135 75.25329616713125 124.14284494755074 145.97391454500968 293.5107629481439 384.35899260196334
        479.22604429427713 563.1051192457472 669.2084467750254 722.8428875877529 835.2921381173535 929.1500794337998
        957.435904889784 1026.709883645684 1210.742000466988
    """,
    "fracturing-truck-commensurate": """
        0.0 45.4786055135417 72.35786564592641 124.1514113383576 145.8328818122822 293.51093674570365 384.4795177489232
        479.2260664742861 563.2549692801817 669.2084542369372 722.8434277331779 835.2921460940084 946.198249896264
        957.4359427321169 1026.7098836815233 1276.356445280857
    """,
}


@pytest.mark.parametrize("name", TRUCKS)
def test_trucks(name):
    found = operating_point(lower(assemble(load(name)))).frequencies()
    expected = np.array(TRUCKS[name].split(), dtype=float)
    assert abs(found[0]) < 1e-3
    assert found[1:] == pytest.approx(expected[1:], rel=1e-5)
