import math

import pytest

from modelgen.gears.involute import angle_of_involute, involute


@pytest.mark.parametrize("degrees", [0.5, 5, 14.5, 20, 25, 45, 80, 89])
def test_the_inverse_undoes_the_involute_function(degrees):
    assert math.degrees(angle_of_involute(float(involute(math.radians(degrees))))) == pytest.approx(degrees, rel=1e-9)


def test_zero_has_the_angle_zero():
    assert angle_of_involute(0.0) == 0.0
