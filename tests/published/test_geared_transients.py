"""Published drivelines with a gear and drag: state matrices, their discrete form, and a motion in time."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from modelgen.elements import GroundDamper, HarmonicTorque, Inertia, RigidGear, Shaft
from modelgen.equations import assemble
from modelgen.lowering import lower
from modelgen.model import Driveline
from modelgen.solvers.bound_model import operating_point


@pytest.fixture(scope="module")
def state_space():
    """A and B of four inertias with drag, two shafts and a 10/60 gear; the last angle counted as the source does."""
    inertia, drag = (1.0, 0.1, 0.1, 1.0), (0.5, 0.1, 0.1, 1.0)
    line = Driveline(
        "geared",
        [
            *(Inertia(f"node_{n}", inertia=each) for n, each in enumerate(inertia)),
            *(GroundDamper(f"drag_{n}", f"node_{n}", damping=each) for n, each in enumerate(drag)),
            Shaft("first", "node_0", "node_1", stiffness=400.0, damping="value", damping_coefficient=1.0),
            Shaft("second", "node_2", "node_3", stiffness=800.0, damping="value", damping_coefficient=0.5),
            RigidGear("gear", "node_1", "node_2", teeth_a=10, teeth_b=60),
        ],
    )
    point = operating_point(lower(assemble(line)))
    # The source counts both shafts of a gear pair in the same sense in space, we count each forward in its own.
    turn = np.diag([1.0, 1.0, -1.0])
    mass, damping, stiffness = (turn @ each @ turn for each in (point.mass, point.damping, point.stiffness))
    inverse = np.linalg.inv(mass)
    a = np.block([[np.zeros((3, 3)), np.eye(3)], [-inverse @ stiffness, -inverse @ damping]])
    return a, np.vstack([np.zeros((3, 3)), inverse])


# openTorsion, github.com/Aalto-Arotor/openTorsion at 88ab7893 (MIT), opentorsion/tests/tests.py, test_state_space and
# test_continuous_2_discrete: absolute 5e-7 on A and B, 5e-9 on the rows of the matrix exponential at 1e-4 s.
A_LOWER = [
    [-400, 400, 0, -1.5, 1, 0],
    [3891.891891891891, -4108.108108108107, -1297.2972972972968, 9.729729729729728, -10.864864864864863, -0.8108108108108106],
    [0, -133.333333, -800, 0, -0.0833333333, -1.5],
]
B_LOWER = [[1, 0, 0], [0, 9.72972973, 0], [0, 0, 1]]
AD_ROW_4 = [-0.0399772634, 0.0399761684, -6.57013549e-06, 0.999848061, 0.000101936618, -4.32450052e-09]
BD_ROW_4 = [9.99924354e-05, 4.92768675e-08, -1.41886052e-13]


def test_state_matrices_of_a_geared_line(state_space):
    a, b = state_space
    assert a[3:] == pytest.approx(np.array(A_LOWER), abs=5e-7)
    assert b[3:] == pytest.approx(np.array(B_LOWER), abs=5e-7)


def test_discrete_state_matrices_of_a_geared_line(state_space):
    a, b = state_space
    whole = expm(1e-4 * np.block([[a, b], [np.zeros((3, 9))]]))
    assert whole[3, :6] == pytest.approx(AD_ROW_4, abs=5e-9)
    assert whole[3, 6:] == pytest.approx(BD_ROW_4, abs=5e-9)


# Modelica Standard Library, Modelica/Mechanics/Rotational/Examples/First.mo at b756f9de (BSD-3-Clause); its equations integrated
# independently with SciPy's DOP853 at a relative tolerance of 1e-12. Columns: time, damper.phi_rel, damper.w_rel, inertia3.phi,
# inertia3.w; the damper's angle is that of ground less that of inertia2.
FIRST = """
    0.1  -0.022143254560156575 -0.4296162053217414   0.02289901652782712  0.4946853571066766
    0.2  -0.04231534955654752   0.0155604130947048   0.04259413702016311 -0.11821426921450764
    0.25 -0.04517161626939281  -0.1875704523505067   0.04365374076365107  0.24026863546894925
    0.3  -0.06175593770478095  -0.40743928061171336  0.061263358783368055 0.42968348964371833
    0.4  -0.07914540491808315   0.05374778622634765  0.07860947850356144 -0.07324030723233481
    0.5  -0.09581294218092162  -0.37199504891038065  0.09620025997584505  0.47206385747100804
    0.6  -0.11080585002669602   0.0693696118217668   0.1114451712534756  -0.1378115792028862
    0.7  -0.12550125377024796  -0.36476010602184916  0.12551572523441337  0.3670319568555627
    0.75 -0.1390333110284432   -0.12278284299762263  0.1412273504540093   0.15968581779099184
    0.8  -0.13858551330851412   0.09015841677109857  0.1378995893144237  -0.15197706591599552
    0.9  -0.15121676535593023  -0.3321818255125511   0.15102950655205943  0.43392408198293403
    1.0  -0.16232822702741645   0.1122493092037627   0.16286164287992744 -0.1381452799145175
"""
# The result that the library stores for comparison (Dymola 2020x, DASSL, 1e-6; MAP-LIB_ReferenceResults at d6a2b9b2).
FIRST_STORED = {0.5: (-0.09581282303087237, -0.37201687172752795, 0.0962001193484458, 0.47193077324544286)}


def test_motor_gear_spring_and_damper_from_rest():
    omega = 2 * np.pi * 5
    line = Driveline(
        "first",
        [
            Inertia("motor", inertia=0.1),
            Inertia("inertia2", inertia=2.0),
            Inertia("inertia3", inertia=2.0),
            RigidGear("gear", "motor", "inertia2", teeth_a=1, teeth_b=10),
            Shaft("spring", "inertia2", "inertia3", stiffness=1e4),
            GroundDamper("damper", "inertia2", damping=10.0),
            HarmonicTorque("torque", "motor", sine=(10.0,), base="cycle"),
        ],
        speed=omega,
        reference="motor",
        bases={"cycle": 1},
        drifts=True,
    )
    model = lower(assemble(line))
    p = model.parameters.vector()
    # States count from uniform rotation at the operating speed; the line starts from rest.
    start = np.zeros(4)
    start[model.state_index("motor.angle_deviation_rate")] = -omega
    rows = np.array(FIRST.split(), dtype=float).reshape(-1, 5)
    fast = model.fast_rhs(p)
    found = solve_ivp(lambda t, x: fast(t, x).copy(), (0, 1), start, "DOP853", rows[:, 0], rtol=1e-11, atol=1e-13)
    assert found.success
    channels = model.channels(found.t, found.y.T, p)
    assert abs(model.evaluate(0.0, start, p)["inertia3.speed"]) < 1e-14
    columns = [
        -channels["inertia2.angle"],
        -channels["inertia2.speed"],
        channels["inertia3.angle"],
        channels["inertia3.speed"],
    ]
    assert pytest.approx(rows[:, 1:], abs=1e-8) == np.array(columns).T
    for time, stored in FIRST_STORED.items():
        assert np.array(columns).T[rows[:, 0] == time][0] == pytest.approx(stored, abs=2e-4)
