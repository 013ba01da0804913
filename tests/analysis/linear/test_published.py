"""Published linear cases: modes, matrices, absorber, wind turbine, and the six-cylinder diesel with its gas torques.

OT is openTorsion, github.com/Aalto-Arotor/openTorsion at commit 88ab7893 (MIT license): facts and figures only. Figures with
more digits were computed again from the same data, independently of this package.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from scipy.linalg import expm

from modelgen import (
    Driveline,
    GroundDamper,
    GroundSpring,
    HarmonicTorque,
    Inertia,
    RigidGear,
    Shaft,
    assemble,
    lower,
    modal,
    operating_point,
)
from modelgen.analysis import campbell, forced, frequency_response

RPM = np.pi / 30


def chain(inertias, stiffnesses, **shaft):
    return (
        *(Inertia(f"disk_{n}", inertia=inertia) for n, inertia in enumerate(inertias)),
        *(Shaft(f"shaft_{n}", f"disk_{n}", f"disk_{n + 1}", stiffness=k, **shaft) for n, k in enumerate(stiffnesses)),
    )


FRISWELL = [0.0035, 0.0035, 0.0035, 0.15, 0.05], [12000.0, 12000.0, 14000.0, 10000.0]
DIESEL = (
    [0.017, 0.009, 0.0467, 0.0327, 0.0467, 0.0467, 0.0327, 0.0487, 2.075],
    [1106e3, 1631e3, 1253e3, 1253e3, 1678e3, 1253e3, 1253e3, 1976e3],
)
CHAINS = [
    # OT, opentorsion/tests/tests.py, test_shaft: 176.1 Hz, to its one decimal and as computed again.
    pytest.param([211.4, 8.3], [9.775e6], [0, 176.1], {"abs": 0.05}, id="two disks as printed"),
    pytest.param([211.4, 8.3], [9.775e6], [0, 176.0767468], {"rel": 1e-9}, id="two disks"),
    # Friswell, Penny, Garvey, Lees, Dynamics of Rotating Machines (2010), example 9.7.1, as in OT, test_friswell_ex971.
    pytest.param(*FRISWELL, [0, 81.21, 141.21, 378.95, 536.36], {"abs": 0.005}, id="friswell as printed"),
    pytest.param(*FRISWELL, [0, 81.20762902, 141.2140714, 378.9529539, 536.3632829], {"rel": 1e-9}, id="friswell"),
    # Thomson, Theory of Vibration with Applications, example 12.4-1: 123.6658 and 202.6583 rad/s.
    pytest.param([5.0, 11.0, 22.0], [1e5, 2e5], np.array([0, 123.6658, 202.6583]) / (2 * np.pi), {"rel": 1e-6}, id="thomson"),
    # Rao, Mechanical Vibrations, ch. 7 (compressor, turbine, generator): sqrt(0.5e6), sqrt(1.5e6) rad/s, exact.
    pytest.param([8.0, 6.0, 4.0], [4e6, 2e6], np.sqrt([0, 0.5e6, 1.5e6]) / (2 * np.pi), {"rel": 1e-13}, id="rao"),
    # Mendes, Meirelles, Zampieri, Proc. IMechE K 222 (2008), doi 10.1243/14644193JMBD126, fig. 4; data as in OT, ICE_example.py.
    pytest.param(
        *DIESEL,
        [0, 216.5836052, 592.7404802, 984.922964, 1171.017408, 1415.995017, 1660.043912, 1794.38758, 2993.473563],
        {"rel": 1e-9},
        id="six-cylinder diesel",
    ),
    # Sopanen et al., doi 10.1109/TIE.2010.2087301, as in OT, modal_analysis_and_forced_response.ipynb: 58.34, 1034.115 rad/s.
    pytest.param(
        [1e7, 5770.0, 97030.0],
        [3.67e8, 5.496e9],
        np.array([0, 58.3401619, 1034.114719]) / (2 * np.pi),
        {"rel": 1e-9},
        id="windmill",
    ),
]


@pytest.mark.parametrize(("inertias", "stiffnesses", "frequencies", "tolerance"), CHAINS)
def test_modes_of_chains(inertias, stiffnesses, frequencies, tolerance) -> None:
    result = modal(lower(assemble(Driveline("chain", elements=chain(inertias, stiffnesses)))))
    assert result.frequencies[0] == 0.0
    assert result.frequencies[1:] == pytest.approx(frequencies[1:], **tolerance)


@pytest.mark.parametrize(
    ("omega", "angles", "torques"),
    # Thomson, table 12.4-1: Holzer's table of the three disks; the book prints 0.9484 and 14.66e3, 0.799 and 52.32e3.
    [(20.0, [1, 0.98, 0.9484], [2000, 6312, 14658.27]), (40.0, [1, 0.92, 0.799], [8000, 24192, 52318.2])],
)
def test_holzer_table_by_forcing_the_last_disk(omega, angles, torques) -> None:
    point = operating_point(lower(assemble(Driveline("thomson", elements=chain([5.0, 11.0, 22.0], [1e5, 2e5])))))
    unit = frequency_response(point.mass, point.damping, point.stiffness, np.array([omega]), np.array([0.0, 0.0, 1.0]))[:, 0].real
    theta = unit / unit[0]
    assert theta == pytest.approx(angles, abs=5e-5)
    assert [1e5 * (theta[0] - theta[1]), 2e5 * (theta[1] - theta[2]), -1 / unit[0]] == pytest.approx(torques, rel=1e-4)


def test_state_space_of_the_geared_line() -> None:
    """OT, tests.py, test_state_space and test_continuous_2_discrete; OT counts gears' angles in space, so the last one turns."""
    line = Driveline(
        "geared",
        elements=(
            *(Inertia(f"node_{n}", inertia=j) for n, j in enumerate([1.0, 0.1, 0.1, 1.0])),
            *(GroundDamper(f"drag_{n}", f"node_{n}", damping=c) for n, c in enumerate([0.5, 0.1, 0.1, 1.0])),
            Shaft("first", "node_0", "node_1", stiffness=400.0, damping="value", damping_coefficient=1.0),
            Shaft("second", "node_2", "node_3", stiffness=800.0, damping="value", damping_coefficient=0.5),
            RigidGear("gear", "node_1", "node_2", teeth_a=10, teeth_b=60),
        ),
    )
    point = operating_point(lower(assemble(line)))
    turn = np.diag([1.0, 1.0, -1.0])
    inverse = turn @ np.linalg.inv(point.mass) @ turn
    lower_half = -np.hstack([inverse @ turn @ point.stiffness @ turn, inverse @ turn @ point.damping @ turn])
    expected = [
        [-400, 400, 0, -1.5, 1, 0],
        [3891.891891891891, -4108.108108108107, -1297.2972972972968, 9.729729729729728, -10.864864864864863, -0.8108108108108106],
        [0, -133.333333, -800, 0, -0.0833333333, -1.5],
    ]
    assert lower_half == pytest.approx(np.array(expected), abs=5e-7)
    assert np.diag(inverse) == pytest.approx([1, 9.72972973, 1], abs=5e-7)
    a = np.vstack([np.hstack([np.zeros((3, 3)), np.eye(3)]), lower_half])
    b = np.vstack([np.zeros((3, 3)), inverse])
    discrete = expm(1e-4 * np.block([[a, b], [np.zeros((3, 9))]]))
    row = [-0.0399772634, 0.0399761684, -6.57013549e-06, 0.999848061, 0.000101936618, -4.32450052e-09]
    assert discrete[3, :6] == pytest.approx(row, abs=5e-9)
    assert discrete[3, 6:] == pytest.approx([9.99924354e-05, 4.92768675e-08, -1.41886052e-13], abs=5e-9)


@pytest.mark.parametrize(
    ("mu", "tuning", "peak", "zeta"),
    # Den Hartog, Mechanical Vibrations, sec. 3.3: f = 1/(1 + mu), X/X_st = sqrt(1 + 2/mu), zeta^2 = 3 mu / (8 (1 + mu)^3).
    [(0.05, 0.952381, 6.4031242, 0.1272673), (0.1, 0.9090909, 4.5825757, 0.167852), (0.2, 0.8333333, 3.3166248, 0.2083333)],
)
def test_den_hartog_absorber(mu, tuning, peak, zeta) -> None:
    stiffness = mu * (1 / (1 + mu)) ** 2
    line = Driveline(
        "absorber", speed=1.0, reference="machine", bases={"shake": 1},
        elements=(
            Inertia("machine", inertia=1.0), Inertia("absorber", inertia=mu), GroundSpring("ground", "machine", stiffness=1.0),
            Shaft("spring", "machine", "absorber", stiffness=stiffness, damping="value", damping_coefficient=0.0),
            HarmonicTorque("force", "machine", cosine=[1.0], base="shake"),
        ),
    )  # fmt: skip
    model = lower(assemble(line))
    assert np.sqrt(stiffness / mu) == pytest.approx(tuning, rel=1e-6)

    def height(damping: float, speeds: object) -> np.ndarray:
        values = {"spring.damping_coefficient": 2 * damping * mu}
        return np.abs(forced(model, speeds, values, channels=["machine.angle_deviation"])["machine.angle_deviation"][:, 0])

    # The fixed points P and Q: there every damping gives the same height, and at this tuning both are equally high.
    root = np.sqrt(mu / (2 + mu))
    points = np.sqrt((1 + np.array([-root, root])) / (1 + mu))
    for damping in (0.03, zeta, 0.9):
        assert height(damping, points) == pytest.approx([peak, peak], rel=1e-7)
    # The formula for zeta is a mean of two: by the closed form of X/X_st the peak lies 0.33 % above the fixed points at mu = 0.2.
    largest = height(zeta, np.linspace(0.6, 1.3, 150)).max()
    assert peak <= largest <= peak * (1.003 if mu < 0.2 else 1.0035)


def test_wind_turbine_under_torque_harmonics() -> None:
    """OT, examples/forced_response.py (Sopanen et al.): modal damping 2 %, cogging and ripple orders of the rated torque.

    With modal damping the answer is a sum over modes, worked out here from the closed form of the three-disk line.
    """
    rated, orders = 2.9e6, [4, 6, 8, 10, 12, 14, 16]
    amplitudes = rated * np.array([0.0018, 0.0179, 0.0024, 0.0034, 0.0117 + 0.0176, 0.0018, 0.0011])
    inertias, stiffnesses = np.array([1e7, 5770.0, 97030.0]), [3.67e8, 5.496e9]
    line = Driveline(
        "windmill", speed="15 rpm", reference="disk_0", bases={"turn": 1},
        elements=(
            *chain(inertias.tolist(), stiffnesses, damping="modal", damping_ratio=0.02),
            HarmonicTorque("ripple", "disk_2", cosine=amplitudes.tolist(), orders=orders, base="turn"),
        ),
    )  # fmt: skip
    model = lower(assemble(line))
    critical = 58.3401619 / 6
    speeds = [5 * RPM, critical, 15 * RPM, 20 * RPM]
    speeds.sort()
    result = forced(model, speeds, channels=["shaft_0.torque", "shaft_1.twist"])
    k = np.array(
        [
            [stiffnesses[0], -stiffnesses[0], 0],
            [-stiffnesses[0], sum(stiffnesses), -stiffnesses[1]],
            [0, -stiffnesses[1], stiffnesses[1]],
        ]
    )
    squares, shapes = np.linalg.eigh(k / np.sqrt(np.outer(inertias, inertias)))
    shapes = shapes / np.sqrt(inertias)[:, None]
    natural = np.sqrt(np.maximum(squares, 0))
    omega = np.outer(speeds, orders)[..., None]
    zeta = np.array([0.0, 0.02, 0.02])
    modes = shapes[2] * amplitudes[:, None] / (squares * (natural > 1) - omega**2 + 2j * zeta * natural * omega)
    angles = modes @ shapes.T
    assert result["shaft_0.torque"] == pytest.approx(3.67e8 * (angles[..., 0] - angles[..., 1]), rel=1e-6)
    assert result["shaft_1.twist"] == pytest.approx(angles[..., 1] - angles[..., 2], rel=1e-6)
    # The sixth order in resonance is magnified by 1 / (2 zeta).
    at = int(np.argmin(np.abs(result.speeds - critical)))
    assert np.argmax(np.abs(result["shaft_0.torque"][at])) == 1
    crossings = campbell(model, np.linspace(1, 20, 20), operating="15 rpm")
    assert [each.speed for each in crossings.critical if each.line.order == 6] == pytest.approx([critical], rel=1e-9)


# OT, examples/ICE_data/pressure_data.csv and peak_data.csv, read off the figures of Mendes et al.: crank angle in degrees and
# cylinder pressure in MPa, engine speed in rpm and peak pressure in MPa.
PRESSURE = np.array(
    [
        (0, 0.266925), (28.04878, 0.266925), (50.609756, 0.282398), (71.341463, 0.266925),
        (94.512195, 0.266925), (112.195122, 0.266925), (135.97561, 0.282398), (160.365854, 0.282398),
        (179.878049, 0.282398), (208.536585, 0.313346), (234.146341, 0.359768), (248.170732, 0.40619),
        (262.804878, 0.499033), (276.829268, 0.638298), (292.073171, 0.916828), (301.219512, 1.288201),
        (309.146341, 1.566731), (314.634146, 1.922631), (318.292683, 2.294004), (322.560976, 2.851064),
        (325.609756, 3.39265), (328.658537, 3.934236), (332.317073, 4.50677), (336.585366, 5.404255),
        (337.804878, 6.270793), (340.853659, 6.967118), (343.902439, 8.12766), (345.731707, 9.148936),
        (348.170732, 10.185687), (350.609756, 10.974855), (357.317073, 12.259188), (359.146341, 13.141199),
        (360.97561, 13.775629), (362.804878, 14.301741), (364.634146, 14.781431), (367.682927, 15.199226),
        (371.341463, 14.65764), (373.780488, 14.17795), (375, 13.744681), (376.829268, 13.110251),
        (378.658537, 12.615087), (379.878049, 12.027079), (382.926829, 11.361702), (384.756098, 10.727273),
        (386.585366, 10.201161), (388.414634, 9.133462), (390.243902, 8.68472), (391.463415, 8.251451),
        (393.902439, 7.740812), (395.731707, 7.152805), (397.560976, 6.471954), (400.609756, 6.069632),
        (403.04878, 5.512573), (408.536585, 5.001934), (410.365854, 4.321083), (415.853659, 3.733075),
        (420.731707, 3.129594), (428.04878, 2.727273), (437.804878, 2.139265), (451.219512, 1.752418),
        (465.853659, 1.411992), (481.707317, 1.16441), (501.829268, 0.994197), (524.390244, 0.854932),
        (543.292683, 0.700193), (557.926829, 0.529981), (582.317073, 0.40619), (603.04878, 0.32882),
        (635.97561, 0.297872), (669.512195, 0.266925), (698.170732, 0.251451), (720, 0.251451),
    ]
)  # fmt: skip

PEAK = np.array(
    [
        (997.846881, 14.27833), (1097.21795, 14.27833), (1197.849382, 14.266402), (1296.005101, 14.063618),
        (1396.473986, 14.827038), (1495.845055, 14.827038), (1595.216125, 14.827038), (1693.301824, 14.95825),
        (1799.002213, 14.767396), (1898.373282, 14.767396), (1998.972205, 14.910537), (2097.087913, 14.898608),
        (2197.664328, 15.149105), (2298.64336, 13.479125), (2398.36453, 11.809145), (2550.550783, 5.880716),
    ]
)  # fmt: skip


def cylinder_torque(rpm: float) -> np.ndarray:
    """Torque of one cylinder at 500 crank angles from 0 to 720 degrees, both ends included, as OT samples it.

    Gas force on the piston (bore 105 mm) and inertia of the oscillating mass (2.521 kg, Fourier series of its acceleration),
    through rod (207 mm) and crank (stroke 137 mm).
    """
    degrees = np.linspace(0, 720, 500)
    pressure = np.interp(degrees, *PRESSURE.T) / 15.2 * np.interp(rpm, *PEAK.T) * 1e6
    alpha, crank, share = np.radians(degrees), 0.137 / 2, 0.137 / 2 / 0.207
    beta = np.arcsin(share * np.sin(alpha))
    waves = np.cos(alpha) + share * np.cos(2 * alpha) - share**3 / 4 * np.cos(4 * alpha) + 9 * share**5 * np.cos(6 * alpha) / 128
    force = pressure * np.pi * 0.105**2 / 4 - 2.521 * crank * waves * (rpm * RPM) ** 2
    return force * np.sin(alpha + beta) / np.cos(beta) * crank


def diesel() -> Driveline:
    """Six cylinders on disks 2 to 7, loss factor 0.035 in the shafts, drag 2 N*m*s/rad on the cylinders, a brake on the flywheel.

    Sampling both ends stretches the cycle: OT's orders are multiples of 499/1000 instead of 1/2. They are copied with its
    figures.
    """
    firing = [0, 4, 2, 5, 1, 3]
    cylinders = [
        HarmonicTorque(
            f"cylinder_{n + 1}", f"disk_{n + 2}", mean=1.0, sine=[0.0] * 24, cosine=[1.0] * 24, base="cycle",
            phase=turn * 2 / 3 * np.pi * 0.499,
        )
        for n, turn in enumerate(firing)
    ]  # fmt: skip
    shafts = {"damping": "loss_factor", "loss_factor": 0.035, "reference_frequency": 1000.0}
    return Driveline(
        "diesel",
        speed="2000 rpm",
        reference="disk_8",
        bases={"cycle": Fraction(499, 1000)},
        elements=(
            *chain(*DIESEL, **shafts),
            *(GroundDamper(f"drag_{n}", f"disk_{n}", damping=2.0) for n in range(2, 8)),
            *cylinders,
            HarmonicTorque("brake", "disk_8", mean=-1.0),
        ),
    ).balance("brake", may_drive=True)  # the published torques have no mean, the cylinders drag


def rows_at(speed: float) -> dict[str, object]:
    """Mean and rows of the cylinders at a speed [rad/s]."""
    torque = cylinder_torque(speed / RPM)
    series = np.fft.rfft(torque) / len(torque)
    values: dict[str, object] = {}
    for n in range(1, 7):
        values[f"cylinder_{n}.mean"] = float(series[0].real)
        values[f"cylinder_{n}.cosine"] = 2 * series[1:25].real
        values[f"cylinder_{n}.sine"] = -2 * series[1:25].imag
    return values


@pytest.fixture(scope="module")
def diesel_model():
    return lower(assemble(diesel()))


def vibratory_torques(model, rpm):
    """Sum over the orders of |k (theta_a - theta_b)| of each shaft (speeds, shafts), the measure of OT's vibratory_torque."""
    channels = [f"shaft_{n}.twist" for n in range(8)]
    result = forced(model, np.asarray(rpm) * RPM, rows_at, channels=channels, refine=False)
    return np.abs(result.amplitudes).sum(axis=2) * np.array(DIESEL[1])


def test_diesel_torques_at_four_speeds(diesel_model) -> None:
    # OT 0.3.2 (with a one-token fix), examples/ICE_example.py, and again by an independent program.
    expected = [
        [56.01, 85.315, 4106.411, 5302.518, 3789.96, 6244.437, 5925.215, 2825.914],
        [244.345, 370.507, 4832.325, 6246.126, 5124.9, 7765.867, 7499.062, 4401.032],
        [439.137, 665.294, 5303.82, 6965.863, 6174.943, 8857.202, 8650.605, 5959.822],
        [264.061, 398.837, 2701.669, 3318.802, 3006.115, 4187.901, 3972.878, 2458.647],
    ]
    assert vibratory_torques(diesel_model, [1000, 1500, 2000, 2500]) == pytest.approx(np.array(expected), rel=1e-5)


def test_diesel_peaks_over_the_speed_range(diesel_model) -> None:
    rpm = np.arange(1000, 2575, 25)
    torque = vibratory_torques(diesel_model, rpm)
    for shaft, peak in ((7, 9612.11), (0, 872.43)):
        assert rpm[torque[:, shaft].argmax()] == 2175
        assert torque[:, shaft].max() == pytest.approx(peak, rel=1e-5)


def test_a_diesel_that_misfires_shakes_in_its_minor_orders(diesel_model) -> None:
    """All firing, the orders below the third firing order nearly cancel in the flywheel; with one cylinder out they do not."""
    speed = [2000 * RPM]
    flywheel = ["disk_8.angle_deviation"]
    whole = np.abs(forced(diesel_model, speed, rows_at, channels=flywheel).amplitudes[0, 0])
    missing = np.abs(
        forced(diesel_model, speed, lambda s: {**rows_at(s), "cylinder_4.scale": 0.0}, channels=flywheel).amplitudes[0, 0]
    )
    assert missing[0] > 20 * whole[0]
    assert missing[5] == pytest.approx(5 / 6 * whole[5], rel=0.05)
