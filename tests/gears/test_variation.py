import numpy as np
import pytest

from modelgen.gears import Gear, GearMesh, mesh_stiffness_series, stiffness_variation

# Smallest and largest of 20 000 samples in the reference truck's data set [N/m].
EXTREMES = {(26, 46): (1713887108.63, 2834336422.09), (24, 48): (1694796034.45, 2807125407.37)}


@pytest.mark.parametrize("teeth", EXTREMES)
def test_extremes_of_the_truck(teeth):
    variation = stiffness_variation(GearMesh(*(Gear(number, 0.007) for number in teeth), face_width=0.110))
    # The smallest value stands at a jump, which samples miss by half a step.
    assert (variation.minimum, variation.maximum) == pytest.approx(EXTREMES[teeth], rel=1e-5)
    assert variation.minimum < EXTREMES[teeth][0]
    assert variation.peak_to_peak == pytest.approx((variation.maximum - variation.minimum) / variation.mean)


def test_deviation_is_the_energy_of_all_harmonics():
    mesh = GearMesh(Gear(26, 0.007), Gear(46, 0.007), face_width=0.110)
    series = mesh_stiffness_series(mesh, 200)
    variation = stiffness_variation(mesh)
    assert variation.mean == pytest.approx(series.mean, rel=1e-13)
    # What is beyond order 200 falls like 1/200.
    assert variation.deviation**2 == pytest.approx(np.sum(series.cosine**2 + series.sine**2) / 2, rel=1e-2)
